//! Origins of secondary rays: no ray hits the surface it left, and none passes through a
//! neighbouring one.

use super::case::{Case, Figure, Harness, Random};
use super::pixels::{blur, lit, sphere_hit, wrong_pixels};
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::procedural::shapes::{cuboid, empty, light, matte, mesh, mirror, moved, polygon, sphere};
use crate::scene::{Face, Mesh, Scene};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "acne",
        does: "a floor of 128 triangles and a sphere under each of three lights, at world offsets 0 to 10^6, and in a corner of a scene of 10^4 times their size",
        stands_for: "self-shadowing: shadow acne, often averaged away by anti-aliasing",
        bound: "exact against the lit region in closed form, except within 0.02 pixels and the ray offset of edges (numerics.md, Spawn origins)",
        run: acne,
    },
    Case {
        name: "triangle-reintersect",
        does: "rays that leave pairs of triangles with vertices at 10^U(-8,8), on and off their common edge, down to grazing",
        stands_for: "self-intersection of flat surfaces: pbrt's Triangle.Reintersect",
        bound: "exact: a ray hits neither its own triangle nor one that it rises above (numerics.md, Spawn origins)",
        run: reintersect,
    },
    Case {
        name: "mirror-box",
        does: "a closed, rotated mirror box at offsets 0, 10^4 and 10^6: paths of 60 bounces",
        stands_for: "light that leaks from closed rooms: 0.5 % with an epsilon of 1e-4, 95 % in world coordinates at 10^6",
        bound: "exact: no path escapes (numerics.md, Spawn origins)",
        run: mirror_box,
    },
    Case {
        name: "below-surface",
        does: "a coarse sphere with smooth normals: a mirror at all angles, and matte with the light at the camera",
        stands_for: "the shadow terminator: black edges, reflected rays that enter the surface",
        bound: "exact: no reflected ray below the triangle, no black pixel visible from the light (numerics.md, Shading)",
        run: below_surface,
    },
];

/// 2 n^2 triangles over the square of half size `l` at y = 0, normal up.
fn floor(n: u32, l: f64) -> Mesh {
    let at = |i: u32| (f64::from(i) / f64::from(n) * 2.0 - 1.0) * l;
    let vertices = (0..=n).flat_map(|i| (0..=n).map(move |j| DVec3::new(at(i), 0.0, at(j)))).collect();
    let v = |i, j| i * (n + 1) + j;
    let faces: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| [[v(i, j), v(i, j + 1), v(i + 1, j + 1)], [v(i, j), v(i + 1, j + 1), v(i + 1, j)]])
        .collect();
    mesh(vertices, &faces, 0)
}

/// Class of a point on the floor y = 0 of half size `l` or on the sphere: lit or not.
fn lit_here(scene: &Scene, corner: DVec3, l: f64, o: DVec3, d: DVec3) -> u8 {
    let (s, position) = (scene.spheres[0], scene.lights[0].position);
    let t = (corner.y - o.y) / d.y;
    let p = o + t * d;
    let on_floor = t > 0.0 && (p.x - corner.x).abs() < l && (p.z - corner.z).abs() < l;
    let on_ball = sphere_hit(o, d, s.center, s.radius).filter(|b| !on_floor || *b < t);
    if let Some(t) = on_ball {
        let p = o + t * d;
        return u8::from((p - s.center).dot(position - p) > 0.0);
    }
    let free = |to: DVec3| sphere_hit(p, to.normalize(), s.center, s.radius).is_none();
    u8::from(on_floor && free(position - p))
}

fn acne(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let l = 4.0;
    let mut base = empty(vec![matte([1.0; 3], 0.0)]);
    base.meshes = vec![floor(8, l)];
    base.spheres = vec![sphere([0.3, 0.7, 0.2], 0.7, 0)];
    base.camera.look_from = DVec3::new(1.0, 3.0, 5.0);
    base.camera.look_at = DVec3::new(0.3, 0.2, 0.2);
    let (mut wrong, mut judged) = (0, 0);
    for position in [[3.0, 4.0, 1.0], [-0.5, 6.0, 1.5], [0.3, 0.2, 5.0]] {
        base.lights = vec![light(position, 10.0)];
        for far in [0.0, 1e3, 1e5, 1e6] {
            let corner = DVec3::new(far, -far / 2.0, far);
            let scene = moved(&base, 1.0, corner);
            let blur = blur(h, &scene, 4.0 / 64.0);
            let picture = h.picture(&scene)?;
            // In f64 the world coordinates have a negligible error, 2^-53 of their size.
            let r = wrong_pixels(&scene, &picture, blur, |o, d| lit_here(&scene, corner, l, o, d), lit);
            (wrong, judged) = (wrong + r.0, judged + r.1);
        }
        let scene = crowded_corner(&base);
        let blur = blur(h, &scene, 4.0 / 64.0);
        let picture = h.picture(&scene)?;
        let corner = DVec3::new(9e3, 0.0, 9e3);
        let r = wrong_pixels(&scene, &picture, blur, |o, d| lit_here(&scene, corner, 1e9, o, d), lit);
        (wrong, judged) = (wrong + r.0, judged + r.1);
    }
    Ok(Figure::count(wrong, judged, "pixels wrong"))
}

/// The same sphere far from the middle of a floor of size 2 10^4: local coordinates are large
/// compared with it.
fn crowded_corner(base: &Scene) -> Scene {
    let mut scene = moved(base, 1.0, DVec3::new(9e3, 0.0, 9e3));
    scene.meshes = vec![floor(8, 1e4)];
    scene
}

/// Two triangles on the corners of a parallelogram, coplanar except for rounding. No slivers, which
/// rounding folds by u over their height.
fn pair(random: &mut Random) -> Scene {
    let mut far = || 10f64.powf(random.range(-8.0, 8.0)) * if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let mut point = || DVec3::new(far(), far(), far());
    let (a, b, d) = loop {
        let (a, b, d) = (point(), point(), point());
        let longest = (b - a).length().max((d - a).length());
        if (b - a).cross(d - a).length() > 1e-3 * longest * longest {
            break (a, b, d);
        }
    };
    let mut scene = empty(vec![mirror(1.0, 0.0)]);
    scene.meshes = vec![mesh(vec![a, b, b + (d - a), d], &[[0, 1, 2], [0, 2, 3]], 0)];
    scene.camera.look_from = (a + b + d) * 2.0 + DVec3::splat(1e-7);
    scene.camera.look_at = a;
    scene
}

fn reintersect(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut random = Random::new(30);
    let (mut wrong, mut count) = (0, 0);
    for _ in 0..60 {
        let scene = pair(&mut random);
        let corners: Vec<DVec3> = scene.meshes[0].vertices.iter().map(|v| h.local(&scene, *v)).collect();
        let normal = |i: usize| {
            let f = scene.meshes[0].faces[i].vertices.map(|v| corners[v as usize]);
            (f[1] - f[0]).cross(f[2] - f[0]).normalize_or_zero()
        };
        let normals = [normal(0), normal(1)];
        let rays: Vec<ProbeRay> = (0..150)
            .map(|i| {
                let [s, t] = [random.unit(), random.unit()];
                // On the common edge from corner 0 to 2, anywhere, at a corner.
                let target = match i % 3 {
                    0 => corners[0] * (1.0 - s) + corners[2] * s,
                    1 => corners[0] + s * (corners[1] - corners[0]) + t * (corners[3] - corners[0]),
                    _ => corners[2],
                };
                let origin = h.round(random.direction());
                ProbeRay::new(origin, h.round((target - origin).normalize()))
            })
            .collect();
        let probed = h.probe(&scene, &rays)?;
        let mut next = Vec::new();
        for child in &probed.children {
            let Some(hit) = probed.hits[child.parent] else { continue };
            let side = hit.normal;
            let tangent = side.cross(random.direction()).normalize();
            for k in [0, 4, 9, 14, 20] {
                let d = h.round((tangent + side * 2f64.powi(-k)).normalize());
                let from = |origin| ProbeRay { skip: child.skip, ..ProbeRay::new(origin, d) };
                next.push((hit, true, from(child.origin)));
                next.push((hit, false, from(hit.position)));
            }
        }
        let again: Vec<ProbeRay> = next.iter().map(|n| n.2).collect();
        let hits = h.probe(&scene, &again)?.hits;
        for ((left, spawned, ray), hit) in next.iter().zip(hits) {
            let Some(hit) = hit else { continue };
            // Rises above the other triangle on its own side.
            let other = normals[hit.id as usize];
            let rises = ray.direction.dot(other * other.dot(left.normal).signum()) > 0.0;
            wrong += usize::from(hit.id == left.id || (*spawned && rises));
        }
        count += again.len();
    }
    Ok(Figure::count(wrong, count, "rays hit the surface they left"))
}

/// A mirror box with edges 2, 1.5, 1 around the origin, rotated about two axes.
pub fn turned_box() -> Scene {
    let mut scene = empty(vec![mirror(1.0, 0.0)]);
    let mut walls = cuboid(DVec3::new(-1.0, -0.75, -0.5), DVec3::new(1.0, 0.75, 0.5), 0);
    for v in &mut walls.vertices {
        let w = DVec3::new(0.6 * v.x - 0.8 * v.y, 0.8 * v.x + 0.6 * v.y, v.z);
        *v = DVec3::new(w.x, 0.28 * w.y - 0.96 * w.z, 0.96 * w.y + 0.28 * w.z);
    }
    scene.meshes = vec![walls];
    scene.camera.look_from = DVec3::new(0.1, 0.2, 0.05);
    scene
}

/// Number of rays that escape within `bounces` reflections.
pub fn escapes(
    h: &mut Harness<'_>,
    scene: &Scene,
    mut rays: Vec<ProbeRay>,
    bounces: usize,
) -> Result<usize, RenderError> {
    let mut escaped = 0;
    for _ in 0..bounces {
        let probed = h.probe(scene, &rays)?;
        escaped += probed.hits.iter().filter(|h| h.is_none()).count();
        rays = probed
            .children
            .iter()
            .map(|c| ProbeRay { skip: c.skip, ..ProbeRay::new(c.origin, c.direction) })
            .collect();
    }
    Ok(escaped)
}

fn mirror_box(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (paths, bounces) = (1000, 60);
    let mut random = Random::new(31);
    let mut escaped = 0;
    for far in [0.0, 1e4, 1e6] {
        let offset = DVec3::new(far, -far, far);
        let scene = moved(&turned_box(), 1.0, offset);
        let rays = (0..paths)
            .map(|_| {
                let start = random.direction() * 0.4 + offset;
                ProbeRay::new(h.local(&scene, start), h.round(random.direction()))
            })
            .collect();
        escaped += escapes(h, &scene, rays, bounces)?;
    }
    Ok(Figure::count(escaped, 3 * paths, &format!("paths of {bounces} bounces escaped")))
}

/// A sphere of n x 2n quads with smooth normals.
fn smooth_ball(n: usize, material: usize) -> Mesh {
    let mut normals = Vec::new();
    for i in 0..=n {
        for j in 0..2 * n {
            let (theta, phi) =
                (std::f64::consts::PI * i as f64 / n as f64, std::f64::consts::PI * j as f64 / n as f64);
            normals.push(DVec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()));
        }
    }
    let at = |i: usize, j: usize| (i * 2 * n + if i == 0 || i == n { 0 } else { j % (2 * n) }) as u32;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..2 * n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.extend(
                [[a, b, c], [a, c, d]].into_iter().filter(|f| f[0] != f[1] && f[1] != f[2] && f[0] != f[2]),
            );
        }
    }
    let faces = faces.iter().map(|f| Face { vertices: *f, normals: Some(*f), material }).collect();
    Mesh { name: "ball".into(), vertices: normals.clone(), normals, faces }
}

fn below_surface(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let below = mirrored_below(h)?;
    let black = black_pixels(h)?;
    Ok(Figure::none(below + black, "reflected rays below the surface, or black pixels"))
}

fn mirrored_below(h: &mut Harness<'_>) -> Result<usize, RenderError> {
    let mut scene = empty(vec![mirror(1.0, 0.0)]);
    scene.meshes = vec![smooth_ball(6, 0)];
    let corners: Vec<DVec3> = scene.meshes[0].vertices.iter().map(|v| h.local(&scene, *v)).collect();
    let mut random = Random::new(32);
    let rays: Vec<ProbeRay> = (0..30_000)
        .map(|_| {
            // Past a point of the sphere, most of them nearly tangential.
            let n = random.direction();
            let side = n.cross(random.direction()).normalize();
            let d = (side - n * random.unit().powi(4)).normalize();
            let p = h.local_frame(&scene).point(n * 0.97);
            ProbeRay::new(h.round(p - d * 1.5), h.round(d))
        })
        .collect();
    let probed = h.probe(&scene, &rays)?;
    let below = |c: &&crate::lab::probe::ProbeChild| {
        let Some(hit) = probed.hits[c.parent] else { return false };
        let f = scene.meshes[0].faces[hit.id as usize].vertices.map(|v| corners[v as usize]);
        let n = (f[1] - f[0]).cross(f[2] - f[0]);
        let side = if rays[c.parent].direction.dot(n) < 0.0 { n } else { -n };
        let rise = c.direction.dot(side);
        rise.is_nan() || rise <= 0.0
    };
    Ok(probed.children.iter().filter(below).count())
}

/// Number of black pixels on a matte sphere lit from the camera.
fn black_pixels(h: &mut Harness<'_>) -> Result<usize, RenderError> {
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    scene.meshes = vec![smooth_ball(6, 0)];
    scene.camera.fov = 0.5;
    let there = h.picture(&scene)?.linear;
    scene.materials[0].ambient = 0.0;
    scene.lights = vec![light(scene.camera.look_from.to_array(), 10.0)];
    let seen = h.picture(&scene)?.linear;
    Ok(there.iter().zip(&seen).filter(|(a, b)| lit(**a) == 1 && lit(**b) != 1).count())
}

/// The polygon y = `height` over the square of half size `l`, normal up.
pub fn plate(l: f64, height: f64, material: usize) -> crate::scene::Polygon {
    polygon(&[[-l, height, -l], [-l, height, l], [l, height, l], [l, height, -l]], material)
}
