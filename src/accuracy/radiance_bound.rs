//! The greatest radiance any ray of a scene can carry, known before anything is traced.
//!
//! The colour at a hit is `(1 - s) own + s (share reflected + (1 - share) refracted)`, s in [0, 1]: a mean of its
//! parts. So no ray carries more than L, the greatest of the background and of the own colours,
//! by induction over depth (docs/numerics.md; Hall and Greenberg, IEEE CG&A 3(8), 1983, cut by the same
//! weights). Own colour is `diffuse (ambient + sum_l I_l cos / d_l^2)`: at most that with cos = 1 and d_l the
//! least distance from light l to any surface of the material, on whichever side of it: which side a
//! ray meets is not known beforehand. Nor is a surface between a light and another taken into account.

use crate::prepare::local_frame::{LocalFrame, times_power_of_two};
use crate::scene::bounds::Bounds;
use crate::scene::{Light, Scene};
use glam::DVec3;
use rayon::prelude::*;

/// Radiance that no ray exceeds.
#[derive(Debug, Clone, PartialEq)]
pub struct RadianceLimit {
    /// Linear RGB; infinite in a channel that has no limit.
    pub rgb: [f64; 3],
    /// Why there is none, where there is none.
    pub unbounded: Option<String>,
}

/// What rounding adds: the kernels add a few hundred terms in f32, of relative error 2^-24 each.
pub(super) const ROUNDED_UP: f64 = 1.0 + 1.0 / 16_384.0;

/// Triangles of one box.
const BUNCH: usize = 128;

/// A part of the scene's surface, of one material.
pub struct Surface {
    /// Its box.
    pub bounds: Bounds,
    /// Index into the scene's materials.
    pub material: usize,
    /// Least distance from each light.
    pub nearest: Vec<f64>,
}

/// All surfaces of the scene, triangles in bunches.
pub fn surfaces(scene: &Scene) -> Vec<Surface> {
    let balls = scene.spheres.iter().map(|s| Surface {
        bounds: Bounds::of_sphere(s.center, s.radius),
        material: s.material,
        nearest: scene.lights.iter().map(|l| (s.center.distance(l.position) - s.radius).abs()).collect(),
    });
    let part = |b: Bunch| {
        let shown = scene.materials[b.material].diffuse;
        let nearest = |l: &Light| {
            // Far lights are not worth the distance of each triangle.
            let box_distance =
                (b.bounds.lo - l.position).max(l.position - b.bounds.hi).max(DVec3::ZERO).length();
            let most = (shown * l.intensity).max_element() / (box_distance * box_distance);
            if most * scene.lights.len() as f64 <= 0.1 {
                return box_distance;
            }
            b.triangles.iter().map(|t| triangle_distance(t, l.position)).fold(f64::INFINITY, f64::min)
        };
        Surface {
            bounds: b.bounds,
            material: b.material,
            nearest: scene.lights.iter().map(nearest).collect(),
        }
    };
    let bunches: Vec<Surface> = bunches(scene).into_par_iter().map(part).collect();
    balls.chain(bunches).collect()
}

/// Consecutive triangles of one object and material.
struct Bunch {
    bounds: Bounds,
    triangles: Vec<[DVec3; 3]>,
    material: usize,
    object: Object,
}

#[derive(Debug, Clone, Copy)]
enum Object {
    Polygon(usize),
    Mesh(usize),
    Sphere(usize),
}

/// The limit of a scene. A light nearer to a surface than the kernels resolve is taken to touch it.
pub fn radiance_limit(scene: &Scene) -> RadianceLimit {
    limit_by(scene, triangle_distance, 1.0)
}

/// As [`radiance_limit`], with the distance to a triangle and the greatest cosine given.
fn limit_by(scene: &Scene, distance: fn(&[DVec3; 3], DVec3) -> f64, cosine: f64) -> RadianceLimit {
    let (frame, mut bunches) = (LocalFrame::of(scene), bunches(scene));
    bunches.retain(|b| carried(scene, b.material));
    let nearest: Vec<Vec<(f64, Object)>> =
        scene.lights.par_iter().map(|l| nearest(scene, &bunches, l.position, distance)).collect();
    let mut limit = RadianceLimit { rgb: scene.render.background.to_array(), unbounded: None };
    let mut used = vec![false; scene.materials.len()];
    scene
        .spheres
        .iter()
        .map(|s| s.material)
        .chain(bunches.iter().map(|b| b.material))
        .for_each(|m| used[m] = true);
    for (m, material) in scene.materials.iter().enumerate() {
        if !used[m] || !carried(scene, m) {
            continue;
        }
        let mut light = DVec3::splat(material.ambient);
        for (l, source) in scene.lights.iter().enumerate() {
            let (reach, object) = nearest[l][m];
            let lights_up = (material.diffuse * source.intensity).cmpgt(DVec3::ZERO);
            if reach.is_infinite() || !lights_up.any() {
                continue;
            }
            let clear = reach - unresolved(&frame, source.position);
            if clear <= 0.0 {
                limit.unbounded.get_or_insert_with(|| touches(scene, l, m, object));
                light = DVec3::select(lights_up, DVec3::INFINITY, light);
            } else {
                light += source.intensity * (cosine / (clear * clear));
            }
        }
        for c in 0..3 {
            // Black stays black in any light: zero times infinity would be no number.
            let own = if material.diffuse[c] > 0.0 { material.diffuse[c] * light[c] } else { 0.0 };
            limit.rgb[c] = limit.rgb[c].max(own);
        }
    }
    limit.rgb = limit.rgb.map(|c| c * ROUNDED_UP);
    if limit.unbounded.is_none() && limit.rgb.iter().any(|c| !c.is_finite()) {
        limit.unbounded = Some("the light at some surface overflows".to_owned());
    }
    limit
}

/// True if the material has a colour of its own.
fn carried(scene: &Scene, material: usize) -> bool {
    let m = &scene.materials[material];
    m.secondary < 1.0 && m.diffuse.max_element() > 0.0
}

/// Distances below this are not resolved between a light and a surface: twice the offset of a spawned
/// ray, in a frame where the scene has radius 1 (`before_light` in glsl/shadow.comp). World units.
fn unresolved(frame: &LocalFrame, light: DVec3) -> f64 {
    let local = frame.point(light).abs().max_element();
    times_power_of_two(64.0 * 2f64.powi(-24) * local.max(1.0), -frame.scale_log2)
}

fn touches(scene: &Scene, light: usize, material: usize, object: Object) -> String {
    let at = scene.lights[light].position;
    let what = match object {
        Object::Polygon(i) => format!("polygon {}", i + 1),
        Object::Mesh(i) => format!("mesh \"{}\"", scene.meshes[i].name),
        Object::Sphere(i) => format!("sphere {}", i + 1),
    };
    format!(
        "light {} at ({}, {}, {}) touches {what} of material \"{}\": brightness there is unbounded; move the light \
         off the surface",
        light + 1,
        at.x,
        at.y,
        at.z,
        scene.materials[material].name
    )
}

fn bunches(scene: &Scene) -> Vec<Bunch> {
    let bunch = |triangles: Vec<[DVec3; 3]>, material, object| {
        let bounds = triangles.iter().flatten().fold(Bounds::EMPTY, |b, p| b.with(*p));
        Bunch { bounds, triangles, material, object }
    };
    let polygons = scene
        .polygons
        .iter()
        .enumerate()
        .map(|(i, p)| bunch(p.triangles().collect(), p.material, Object::Polygon(i)));
    let meshes = scene.meshes.par_iter().enumerate().flat_map(|(i, mesh)| {
        mesh.faces.par_chunks(BUNCH).flat_map_iter(move |faces| {
            faces.chunk_by(|a, b| a.material == b.material).map(move |same| {
                let corners = same.iter().map(|f| f.vertices.map(|v| mesh.vertices[v as usize]));
                bunch(corners.collect(), same[0].material, Object::Mesh(i))
            })
        })
    });
    let mut all: Vec<Bunch> = polygons.collect();
    all.par_extend(meshes);
    all
}

/// For each material the least distance of its surfaces from `light`, and the object; infinite if it has none.
fn nearest(
    scene: &Scene,
    bunches: &[Bunch],
    light: DVec3,
    distance: fn(&[DVec3; 3], DVec3) -> f64,
) -> Vec<(f64, Object)> {
    let mut best = vec![(f64::INFINITY, Object::Sphere(0)); scene.materials.len()];
    for (i, s) in scene.spheres.iter().enumerate() {
        let d = (s.center.distance(light) - s.radius).abs();
        if d < best[s.material].0 {
            best[s.material] = (d, Object::Sphere(i));
        }
    }
    for b in bunches {
        let outside = (b.bounds.lo - light).max(light - b.bounds.hi).max(DVec3::ZERO).length();
        if outside >= best[b.material].0 {
            continue;
        }
        for t in &b.triangles {
            let d = distance(t, light);
            if d < best[b.material].0 {
                best[b.material] = (d, b.object);
            }
        }
    }
    best
}

/// Distance of `p` from a triangle; infinite if it has no area, for then no ray meets it. The
/// Voronoi regions of Ericson, *Real-Time Collision Detection*, 5.1.5, taken as the least of the face and
/// the three edges, which stays right where rounding picks the wrong region of a sliver.
fn triangle_distance(&[a, b, c]: &[DVec3; 3], p: DVec3) -> f64 {
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return f64::INFINITY };
    let edges = [(a, b), (b, c), (c, a)];
    let within = edges.iter().all(|(from, to)| (*to - *from).cross(p - *from).dot(normal) >= 0.0);
    let face = if within { normal.dot(p - a).abs() } else { f64::INFINITY };
    edges.iter().map(|&(from, to)| segment_distance(from, to, p)).fold(face, f64::min)
}

/// Ericson, 5.1.2.
fn segment_distance(a: DVec3, b: DVec3, p: DVec3) -> f64 {
    let along = b - a;
    let length = along.length_squared();
    let t = if length > 0.0 { ((p - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (a + along * t).distance(p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::oracle::Oracle;
    use crate::scene::{Light, Scene};
    use crate::settings::Settings;

    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(state: &mut u64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * random(state) - 1.0))
    }

    #[test]
    fn distance_to_a_triangle_is_the_least_over_its_points() {
        let mut s = 5;
        for _ in 0..400 {
            let t = [vector(&mut s), vector(&mut s), vector(&mut s)];
            let p = vector(&mut s) * 2.0;
            let d = triangle_distance(&t, p);
            let n = 60;
            let mut least = f64::INFINITY;
            for i in 0..=n {
                for j in 0..=n - i {
                    let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    least = least.min((t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v).distance(p));
                }
            }
            // The grid is at most one cell, 4/60, coarse.
            assert!(d <= least + 1e-12 && least - d < 0.07, "{d} {least}");
        }
        let flat = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert_eq!(triangle_distance(&flat, DVec3::Y), f64::INFINITY);
    }

    /// A scene of random mirrors, glass and paint around the eye, each light near some surface.
    fn scene(state: &mut u64) -> Scene {
        let text = "[camera]\nlook_from = [0.0, 0.0, 5.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 60.0\nwidth = 24\nheight = 24\n\
             [render]\nbackground = [0.02, 0.03, 0.05]\n\
             [material.paint]\ndiffuse = [0.9, 0.5, 0.2]\n\
             [material.mirror]\ndiffuse = [0.3, 0.9, 0.4]\nsecondary = 0.7\n\
             [material.glass]\ndiffuse = [0.1, 0.2, 0.9]\nsecondary = 0.9\nfresnel = \"exact\"\nior = 1.5\n";
        let mut scene = Scene::parse(text, "random.toml").expect("a scene");
        for material in 0..3 {
            let corners: Vec<DVec3> = (0..3).map(|_| vector(state) * 2.0).collect();
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            scene.polygons.push(crate::scene::Polygon::fan(corners, normal, material));
            let radius = 0.3 + random(state);
            scene.spheres.push(crate::scene::Sphere { center: vector(state) * 2.0, radius, material });
        }
        for _ in 0..3 {
            let polygon = &scene.polygons[(random(state) * 3.0) as usize];
            let [u, v] = [0.6 * random(state), 0.4 * random(state)];
            let corner = |i: usize| polygon.vertices[i];
            let on = corner(0) + (corner(1) - corner(0)) * u + (corner(2) - corner(0)) * v;
            let side = polygon.normal.dot(scene.camera.look_from - on).signum();
            let position = on + polygon.normal * (side * (0.05 + 0.1 * random(state)));
            scene.lights.push(Light { position, intensity: DVec3::splat(0.5 + random(state)) });
        }
        scene
    }

    /// How often the oracle's samples exceed a limit, over random scenes.
    fn exceeded(limit: impl Fn(&Scene) -> RadianceLimit) -> (u32, f64) {
        let mut state = 11;
        let (mut times, mut nearest) = (0, 0.0f64);
        for _ in 0..60 {
            let scene = scene(&mut state);
            let limit = limit(&scene);
            let oracle = Oracle::new(&scene);
            let settings = Settings { samples: 4, depth: 6, ..Settings::of(&scene) };
            for p in 0..24 * 24 {
                for k in 0..4 {
                    let radiance = oracle.sample(p % 24, p / 24, k, &settings).radiance;
                    for c in 0..3 {
                        times += u32::from(radiance[c] > limit.rgb[c]);
                        nearest = nearest.max(radiance[c] / limit.rgb[c]);
                    }
                }
            }
        }
        (times, nearest)
    }

    #[test]
    fn no_sample_exceeds_the_limit() {
        let (times, nearest) = exceeded(radiance_limit);
        println!("nearest to the limit: {nearest:.3}");
        assert_eq!(times, 0);
        assert!(nearest > 0.1, "a limit that nothing comes near proves nothing: {nearest}");
        // Planted defects: the distance to the middle of the triangle; half the greatest cosine.
        let middle = |t: &[DVec3; 3], p: DVec3| ((t[0] + t[1] + t[2]) / 3.0).distance(p);
        assert!(exceeded(|s| limit_by(s, middle, 1.0)).0 > 0);
        assert!(exceeded(|s| limit_by(s, triangle_distance, 0.5)).0 > 0);
    }

    #[test]
    fn a_light_on_a_surface_has_no_limit_and_says_where() {
        let mut scene = scene(&mut 3);
        assert_eq!(radiance_limit(&scene).unbounded, None);
        let ball = scene.spheres[0];
        scene.lights[1].position = ball.center + DVec3::X * ball.radius;
        let limit = radiance_limit(&scene);
        assert_eq!(limit.rgb, [f64::INFINITY; 3]);
        let why = limit.unbounded.unwrap();
        assert!(why.starts_with("light 2 at") && why.contains("sphere 1 of material \"paint\""), "{why}");
        // A light that lights nothing, or a surface with no colour of its own, changes nothing.
        scene.lights[1].intensity = DVec3::ZERO;
        assert_eq!(radiance_limit(&scene).unbounded, None);
        scene.lights[1].intensity = DVec3::ONE;
        scene.materials[0].secondary = 1.0;
        assert_eq!(radiance_limit(&scene).unbounded, None);
    }

    #[test]
    fn one_sphere_and_one_light_by_hand() {
        let mut scene = scene(&mut 3);
        scene.polygons.clear();
        scene.spheres.truncate(1);
        let ball = scene.spheres[0];
        scene.lights.truncate(1);
        scene.lights[0].position = ball.center + DVec3::Y * (ball.radius + 2.0);
        scene.lights[0].intensity = DVec3::splat(8.0);
        let limit = radiance_limit(&scene);
        let by_hand = [0.9, 0.5, 0.2].map(|d| d * (0.1 + 8.0 / 4.0));
        for c in 0..3 {
            assert!(limit.rgb[c] >= by_hand[c] && limit.rgb[c] < by_hand[c] * 1.0002, "{limit:?}");
        }
    }

    /// Boxes leave out only what is farther: the same as asking every triangle.
    #[test]
    fn boxes_change_no_distance() {
        let mut state = 17;
        let mut scene = scene(&mut state);
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for i in 0..30_000u32 {
            let at = vector(&mut state) * 3.0;
            vertices.extend((0..3).map(|_| at + vector(&mut state) * 0.05));
            // Runs of one material, some short.
            let material = (i / 37 % 3) as usize;
            faces.push(crate::scene::Face {
                vertices: [3 * i, 3 * i + 1, 3 * i + 2],
                normals: None,
                material,
            });
        }
        scene.meshes.push(crate::scene::Mesh {
            name: "dust".to_owned(),
            vertices,
            normals: Vec::new(),
            faces,
        });
        let bunches = bunches(&scene);
        assert!(bunches.iter().all(|b| b.triangles.len() <= BUNCH));
        for light in (0..20).map(|_| vector(&mut state) * 4.0) {
            let found = nearest(&scene, &bunches, light, triangle_distance);
            for (m, (d, _)) in found.iter().enumerate() {
                let mesh = &scene.meshes[0];
                let mesh_triangles = mesh.faces.iter().filter(|f| f.material == m);
                let of_mesh = mesh_triangles.map(|f| f.vertices.map(|v| mesh.vertices[v as usize]));
                let polygon = &scene.polygons[m].vertices;
                let all = of_mesh.chain([[polygon[0], polygon[1], polygon[2]]]);
                let ball = &scene.spheres[m];
                let shell = (ball.center.distance(light) - ball.radius).abs();
                assert_eq!(*d, all.map(|t| triangle_distance(&t, light)).fold(shell, f64::min));
            }
        }
    }
}
