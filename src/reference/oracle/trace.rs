//! Light at a hit: own colour, then the reflected and the refracted ray.

use super::geometry::Ray;
use super::media::Media;
use super::optics::{cos_incident, keep_side, reflect, reflectance, refract};
use super::world::{Boundary, Hit};
use super::{Oracle, depth_row};
use crate::report::RayInfo;
use crate::scene::Material;
use glam::DVec3;

/// The path tree of one sample.
pub(super) struct Path<'a> {
    pub oracle: &'a Oracle,
    /// Rays in the longest path.
    pub depth: u32,
    pub rays: &'a mut RayInfo,
}

/// How the secondary weight divides at a hit.
struct Split {
    /// Share of reflection.
    reflected: f64,
    /// Where the rest goes, and through which solids.
    refracted: Option<(DVec3, Media)>,
}

impl Path<'_> {
    /// Colour of `hit`, met by the `depth`-th ray of a path inside `media`.
    pub fn shade(&mut self, ray: &Ray, hit: &Hit, media: &Media, depth: u32) -> DVec3 {
        let oracle = self.oracle;
        let material = &oracle.materials[hit.material];
        if let Boundary::Solid(solid) = hit.boundary
            && material.refracts()
            && media.hides(solid, material.priority)
        {
            return self.pass(ray, hit, &media.across(solid, material), depth);
        }
        let own_weight = 1.0 - material.secondary;
        let mut colour = DVec3::ZERO;
        if own_weight > 0.0 {
            colour += self.own(hit, material, depth) * own_weight;
        }
        if !material.has_secondary() || depth >= self.depth {
            return colour;
        }
        let split = split(ray, hit, material, media);
        if split.reflected > 0.0 {
            let direction = keep_side(reflect(ray.direction, hit.shading), hit.side);
            self.rays.reflection += 1;
            depth_row(self.rays, depth + 1).reflection += 1;
            let light = self.follow(hit, direction, media, depth + 1);
            colour += light * (material.secondary * split.reflected);
        }
        if let Some((direction, beyond)) = split.refracted {
            self.rays.refraction += 1;
            depth_row(self.rays, depth + 1).refraction += 1;
            let light = self.follow(hit, direction, &beyond, depth + 1);
            colour += light * (material.secondary * (1.0 - split.reflected));
        }
        colour
    }

    /// Through a surface that another solid's matter hides: on unchanged, into `beyond`.
    fn pass(&mut self, ray: &Ray, hit: &Hit, beyond: &Media, depth: u32) -> DVec3 {
        if depth >= self.depth {
            return DVec3::ZERO;
        }
        self.rays.refraction += 1;
        depth_row(self.rays, depth + 1).refraction += 1;
        self.follow(hit, ray.direction, beyond, depth + 1)
    }

    /// What a ray that leaves `hit` toward `direction` sees.
    fn follow(&mut self, hit: &Hit, direction: DVec3, media: &Media, depth: u32) -> DVec3 {
        depth_row(self.rays, depth).traced += 1;
        let ray = Ray { origin: hit.origin_toward(direction), direction, from: Some(hit.id) };
        match self.oracle.world.closest(&ray) {
            Some(next) => self.shade(&ray, &next, media, depth),
            None => self.oracle.background,
        }
    }

    /// `ambient * diffuse` and Lambert's term of every light that is not blocked.
    fn own(&mut self, hit: &Hit, material: &Material, depth: u32) -> DVec3 {
        let oracle = self.oracle;
        let mut light = DVec3::splat(material.ambient);
        if material.diffuse == DVec3::ZERO {
            return DVec3::ZERO;
        }
        for source in &oracle.lights {
            let to_light = source.position - hit.point;
            let along = hit.shading.dot(to_light);
            if along <= 0.0 {
                continue;
            }
            self.rays.shadow += 1;
            depth_row(self.rays, depth).shadow += 1;
            let origin = hit.origin_toward(to_light);
            let shadow = Ray { origin, direction: source.position - origin, from: Some(hit.id) };
            if !oracle.world.blocked(&shadow) {
                // Nearer than the surface is known, the distance is not: a light on it stays finite.
                let distance = to_light.length().max(hit.error);
                light += source.intensity * (along / (distance * distance * distance));
            }
        }
        material.diffuse * light
    }
}

fn split(ray: &Ray, hit: &Hit, material: &Material, media: &Media) -> Split {
    if !material.refracts() {
        return Split { reflected: 1.0, refracted: None };
    }
    let cos_i = cos_incident(ray.direction, hit.shading);
    let n1 = media.ior();
    let (reflected, refracted) = match hit.boundary {
        Boundary::Sheet => {
            let share = reflectance(material.fresnel, cos_i, n1, material.ior);
            (share, Some((ray.direction, media.clone())))
        }
        Boundary::Solid(solid) => {
            let beyond = media.across(solid, material);
            let n2 = beyond.ior();
            match refract(ray.direction, hit.shading, n1, n2) {
                None => (1.0, None),
                Some(bent) => {
                    let direction = if n1 == n2 { bent } else { keep_side(bent, -hit.side) };
                    (reflectance(material.fresnel, cos_i, n1, n2), Some((direction, beyond)))
                }
            }
        }
    };
    Split { reflected, refracted: refracted.filter(|_| reflected < 1.0) }
}
