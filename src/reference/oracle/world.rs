//! The scene as numbered primitives, searched one by one.

use super::geometry::{Corners, Ray, Shear, chord, cross_sphere, cross_triangle, origin_error};
use crate::scene::Scene;
use glam::DVec3;

/// What lies behind a refracting surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Boundary {
    /// The surface of the solid of this number: meshes first, then spheres.
    Solid(usize),
    /// Nothing: a polygon is a thin sheet.
    Sheet,
}

#[derive(Debug, Clone, Copy)]
enum Normals {
    /// One shading normal (a polygon's own).
    Flat(DVec3),
    /// The geometric normal serves.
    Geometric,
    /// Interpolated between the corners.
    Smooth([DVec3; 3]),
}

#[derive(Debug)]
pub(super) struct Triangle {
    id: u32,
    pub corners: Corners,
    geometric: DVec3,
    extent: f64,
    normals: Normals,
    pub material: usize,
    pub boundary: Boundary,
}

#[derive(Debug)]
pub(super) struct Ball {
    id: u32,
    pub center: DVec3,
    pub radius: f64,
    pub material: usize,
    pub solid: usize,
}

/// All primitives: triangles (polygons fanned from their first corner, then faces), then spheres.
#[derive(Debug)]
pub(super) struct World {
    pub triangles: Vec<Triangle>,
    pub balls: Vec<Ball>,
}

/// The surface a ray meets first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub id: u32,
    pub point: DVec3,
    /// Unit normal for shading.
    pub shading: DVec3,
    /// Unit normal that tells the two sides apart, turned toward the ray.
    pub side: DVec3,
    /// Unit normal of the surface itself.
    geometric: DVec3,
    /// Distance within which `point` lies on the surface.
    pub error: f64,
    pub material: usize,
    pub boundary: Boundary,
}

impl Hit {
    /// The origin of a ray that leaves toward `direction`.
    pub fn origin_toward(&self, direction: DVec3) -> DVec3 {
        self.point + toward(self.geometric, direction) * self.error
    }
}

/// `normal` or its opposite, whichever points along `direction`.
fn toward(normal: DVec3, direction: DVec3) -> DVec3 {
    if normal.dot(direction) < 0.0 { -normal } else { normal }
}

impl Triangle {
    /// `None` if it has no area: such a triangle is never hit, but keeps its number.
    fn new(
        id: usize,
        corners: Corners,
        normals: Normals,
        material: usize,
        boundary: Boundary,
    ) -> Option<Triangle> {
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        let extent = (b - a).length().max((c - b).length()).max((a - c).length());
        let geometric = cross.try_normalize()?;
        Some(Triangle { id: id as u32, corners, geometric, extent, normals, material, boundary })
    }

    fn hit(&self, ray: &Ray, weights: [f64; 3]) -> Hit {
        let [a, b, c] = self.corners;
        let point = ((b - a) * weights[1] + (c - a) * weights[2]) + a;
        let back = -ray.direction;
        let (shading, side) = match self.normals {
            Normals::Flat(n) => (toward(n, back), toward(n, back)),
            Normals::Geometric => (toward(self.geometric, back), toward(self.geometric, back)),
            Normals::Smooth([na, nb, nc]) => {
                let side = toward(self.geometric, back);
                let n = na * weights[0] + nb * weights[1] + nc * weights[2];
                (toward(n.try_normalize().unwrap_or(side), side), side)
            }
        };
        let error = self.error_at(point);
        let Triangle { id, geometric, material, boundary, .. } = *self;
        Hit { id, point, shading, side, geometric, error, material, boundary }
    }

    fn error_at(&self, point: DVec3) -> f64 {
        origin_error(self.geometric, point, self.extent)
    }
}

impl Ball {
    fn cross(&self, ray: &Ray) -> Option<f64> {
        if ray.from == Some(self.id) {
            chord(self.center, ray)
        } else {
            cross_sphere(self.center, self.radius, ray)
        }
    }

    fn hit(&self, ray: &Ray, t: f64) -> Hit {
        let geometric = (ray.at(t) - self.center).normalize();
        let side = toward(geometric, -ray.direction);
        Hit {
            id: self.id,
            point: self.center + geometric * self.radius,
            shading: side,
            side,
            geometric,
            error: origin_error(geometric, self.center, self.radius),
            material: self.material,
            boundary: Boundary::Solid(self.solid),
        }
    }
}

impl World {
    pub fn new(scene: &Scene) -> World {
        let polygons = scene
            .polygons
            .iter()
            .flat_map(|p| p.triangles().map(|t| (t, Normals::Flat(p.normal), p.material, Boundary::Sheet)));
        let faces = scene.meshes.iter().enumerate().flat_map(|(solid, mesh)| {
            mesh.faces.iter().map(move |face| {
                let corners = face.vertices.map(|i| mesh.vertices[i as usize]);
                let normals = face
                    .normals
                    .map_or(Normals::Geometric, |n| Normals::Smooth(n.map(|i| mesh.normals[i as usize])));
                (corners, normals, face.material, Boundary::Solid(solid))
            })
        });
        let triangles = polygons
            .chain(faces)
            .enumerate()
            .filter_map(|(id, (corners, normals, material, boundary))| {
                Triangle::new(id, corners, normals, material, boundary)
            })
            .collect();
        let first = scene.triangle_count();
        let balls = scene.spheres.iter().enumerate().map(|(i, s)| Ball {
            id: (first + i) as u32,
            center: s.center,
            radius: s.radius,
            material: s.material,
            solid: scene.meshes.len() + i,
        });
        World { triangles, balls: balls.collect() }
    }

    /// The surface with the smallest t > 0; of equal ones that with the smallest number.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let shear = Shear::of(ray.direction);
        let mut best = f64::INFINITY;
        let mut triangle = None;
        for candidate in self.triangles.iter().filter(|c| ray.from != Some(c.id)) {
            if let Some(crossing) = cross_triangle(&candidate.corners, ray.origin, &shear)
                && crossing.t < best
            {
                best = crossing.t;
                triangle = Some((candidate, crossing.weights));
            }
        }
        let mut ball = None;
        for candidate in &self.balls {
            if let Some(t) = candidate.cross(ray)
                && t < best
            {
                best = t;
                ball = Some(candidate);
            }
        }
        match (ball, triangle) {
            (Some(ball), _) => Some(ball.hit(ray, best)),
            (None, Some((triangle, weights))) => Some(triangle.hit(ray, weights)),
            (None, None) => None,
        }
    }

    /// True if a surface lies strictly between the ray's origin and its end at t = 1. A light within
    /// rounding of a surface lies on it and is not blocked by it.
    pub fn blocked(&self, ray: &Ray) -> bool {
        let shear = Shear::of(ray.direction);
        let light = ray.at(1.0);
        let before = |t: f64, normal: DVec3, error: f64| (1.0 - t) * ray.direction.dot(normal).abs() > error;
        self.triangles.iter().filter(|c| ray.from != Some(c.id)).any(|c| {
            cross_triangle(&c.corners, ray.origin, &shear)
                .is_some_and(|x| before(x.t, c.geometric, c.error_at(light)))
        }) || self.balls.iter().any(|c| {
            c.cross(ray).is_some_and(|t| {
                let hit = c.hit(ray, t);
                before(t, hit.geometric, hit.error)
            })
        })
    }
}
