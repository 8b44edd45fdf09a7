//! Random buffers for one kernel: a scene and a queue of rays, with values that ordinary scenes never
//! bring together.

use crate::common::{Rng, queue_of};
use glam::{DVec3, Vec3};
use whitted::kernel::abi::*;
use whitted::kernel::table::Kernel;
use whitted::prepare::bvh::{self, Item, Wanted};
use whitted::reference::twin::single::Memory;
use whitted::reference::twin::single::lib::r#box::{sphere_box, triangle_box};
use whitted::scene::bounds::Bounds;
use whitted::settings::sampler::Sampler;

/// Scene and specialisation that kernels are tested with.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    workgroup: u32,
    bvh: bool,
    smooth: bool,
    media: u32,
    branching: bool,
    triangles: u32,
    spheres: u32,
    wide: bool,
    robust: bool,
    origin_fixed: bool,
    sampler: Sampler,
    replicates: u32,
    survey: bool,
    /// Triangles beside a hierarchy of spheres, read through texel views.
    outside: bool,
}

/// All features; few features; fast precision with fixed origins; triangles outside a hierarchy, read as texels.
pub fn variants() -> [(&'static str, Variant); 4] {
    [
        (
            "brute force, branching",
            Variant {
                workgroup: 64,
                bvh: false,
                smooth: true,
                media: 3,
                branching: true,
                triangles: 21,
                spheres: 7,
                wide: true,
                robust: true,
                origin_fixed: false,
                sampler: Sampler::Owen,
                replicates: 3,
                survey: true,
                outside: false,
            },
        ),
        (
            "hierarchy, mirrors only",
            Variant {
                workgroup: 32,
                bvh: true,
                smooth: false,
                media: 0,
                branching: false,
                triangles: 90,
                spheres: 40,
                wide: false,
                robust: true,
                origin_fixed: false,
                sampler: Sampler::Stratified,
                replicates: 5,
                survey: false,
                outside: false,
            },
        ),
        (
            "fast, fixed origins",
            Variant {
                workgroup: 128,
                bvh: false,
                smooth: false,
                media: 2,
                branching: true,
                triangles: 30,
                spheres: 9,
                wide: false,
                robust: false,
                origin_fixed: true,
                sampler: Sampler::Random,
                replicates: 2,
                survey: true,
                outside: false,
            },
        ),
        (
            "hierarchy of one kind, texels",
            Variant {
                workgroup: 64,
                bvh: true,
                smooth: true,
                media: 2,
                branching: true,
                triangles: 6,
                spheres: 60,
                // Wide spheres take their places after the hierarchy is built.
                wide: false,
                robust: true,
                origin_fixed: false,
                outside: true,
                sampler: Sampler::Owen,
                replicates: 1,
                survey: false,
            },
        ),
    ]
}

/// Rays in the queue: no multiple of any workgroup.
const RAYS: u32 = 1201;
const MATERIALS: u32 = 12;
const SOLIDS: u32 = 4;
const LIGHTS: u32 = 5;

pub struct State {
    pub spec: Specialisation,
    pub memory: Memory,
}

impl State {
    pub fn new(v: Variant, seed: u32) -> State {
        let mut rng = Rng::new(seed);
        let spec = Specialisation {
            workgroup: v.workgroup,
            triangle_count: v.triangles,
            sphere_count: v.spheres,
            light_count: LIGHTS,
            use_bvh: u32::from(v.bvh),
            smooth_normals: u32::from(v.smooth),
            media_capacity: v.media,
            extended_spheres_used: u32::from(v.wide),
            robust: u32::from(v.robust),
            origin_fixed: u32::from(v.origin_fixed),
            branching: u32::from(v.branching),
            loop_cap: 7500,
            sampler_kind: v.sampler.word(),
            replicates: v.replicates,
            parts: if v.survey && v.replicates == 1 { PARTS } else { 1 },
            survey: u32::from(v.survey),
            texels: u32::from(v.outside),
            triangles_outside: u32::from(v.outside),
            ..Specialisation::default()
        };
        let length = |buffer| match buffer {
            Buf::Media | Buf::NextMedia => (2 * RAYS * v.media) as usize,
            Buf::ChildCounts | Buf::ChildMasks | Buf::Offsets => 4224,
            Buf::DepthCounts => 4,
            Buf::Counters => (COUNTERS + TEST_WORDS * RAY_KINDS * 4) as usize,
            Buf::EyeMedia => v.media as usize,
            // Spare invocations of the last group walk too.
            Buf::Walks => (RAYS.next_multiple_of(WORKGROUP_MAX) * WALK_WORDS) as usize,
            Buf::Queue | Buf::NextQueue => 1,
            _ => 2 * RAYS as usize,
        };
        let mut m = Memory::poisoned(length);
        m.camera = vec![camera(&mut rng)];
        m.materials = (0..MATERIALS).map(|i| material(&mut rng, i)).collect();
        m.solid_iors = (0..=SOLIDS).map(|_| rng.pick(&[1.0, 1.5, 1.5, 2.4, 0.001, 1000.0])).collect();
        m.solid_priorities = (0..=SOLIDS).map(|_| rng.pick(&[0, 0, 1, -3, i32::MAX])).collect();
        m.lights = (0..LIGHTS)
            .map(|_| Light { position: rng.vector(), intensity: [1.0, 0.5, 3e4], pad: 0 })
            .collect();
        shapes(&mut m, &mut rng, v);
        for list in [&mut m.media, &mut m.eye_media] {
            list.iter_mut().for_each(|w| *w = rng.below(SOLIDS + 1));
        }
        m.rays[..RAYS as usize].iter_mut().enumerate().for_each(|(i, r)| r.sample_index = i as u32);
        let rays: Vec<Ray> = (0..RAYS).map(|i| ray(&m, &mut rng, i)).collect();
        m.rays[..RAYS as usize].copy_from_slice(&rays);
        // The last ray is the one that a group's spare invocations might do again.
        let last = &mut m.rays[RAYS as usize - 1];
        match seed % 2 {
            0 => last.origin[0] = f32::NAN,
            _ => *last = Ray { sample_index: last.sample_index, ..rays[1] },
        }
        m.queue = vec![queue_of(RAYS, v.workgroup)];
        m.words_mut(Buf::DepthCounts).fill(0);
        m.words_mut(Buf::Counters).fill(0);
        m.sample_radiance.iter_mut().for_each(|s| *s = rng.vector());
        m.pixels.iter_mut().for_each(|p| *p = rng.below(1 << 20));
        for buffer in [Buf::Paths, Buf::Marks] {
            m.words_mut(buffer).iter_mut().for_each(|w| *w = rng.below(1 << 30));
        }
        State { spec, memory: m }
    }

    pub fn count(&self) -> usize {
        RAYS as usize
    }

    pub fn push(&self) -> Push {
        Push { depth: 1, last_depth: 2, capacity: 2 * RAYS, items: RAYS, cutoff: 0.2, ..Push::default() }
    }

    /// Push constants of a `shadow` pass.
    pub fn lights(&self, light_begin: u32, light_end: u32) -> Push {
        Push { light_begin, light_end, ..self.push() }
    }

    /// The state after `intersect`; contributions hold something for a second `shadow` pass to add to.
    pub fn hit(&self) -> Memory {
        let mut m = self.memory.clone();
        m.run(Kernel::Intersect, &Specialisation { counting: 0, ..self.spec }, &self.push());
        m.words_mut(Buf::Counters).fill(0);
        m
    }

    /// Hits that no ray has: any primitive at any place, corners and beyond.
    pub fn spoil_hits(&self, m: &mut Memory, rng: &mut Rng) {
        let all = self.spec.triangle_count + self.spec.sphere_count;
        for h in m.hits[..RAYS as usize].iter_mut().step_by(3) {
            let edge = [0.0, -0.0, 1.0, 0.5, 1e-30, -1e-7, 2.0, f32::NAN];
            *h = Hit {
                t: rng.pick(&[1.0, 0.0, 1e-30, 1e30, -1.0, 1e-40]) * rng.unit(),
                u: rng.pick(&edge),
                v: rng.pick(&edge),
                primitive: rng.below(all),
            };
        }
    }

    /// Directions and ratios that a sound surface never has.
    pub fn spoil_surfaces(&self, m: &mut Memory, rng: &mut Rng) {
        for s in m.surfaces[..RAYS as usize].iter_mut().step_by(4).filter(|s| s.primitive != NONE) {
            s.normal = spicy(rng);
            s.offset = rng.vector().map(|c| c * rng.pick(&[0.0, -0.0, 1e-7, 1e-40, 1.0]));
            s.eta = rng.pick(&[1.0, 0.5, 2.0, 1e-3, 1e3, f32::NAN]);
            s.cosine = rng.pick(&[0.0, 1.0, 0.3, 1e-8]);
            s.share = rng.pick(&[0.0, 1.0, 0.25, -0.0]);
        }
    }

    /// Lights anywhere, on a surface, at the offset's distance from one, and very far.
    pub fn place_lights(&self, m: &mut Memory, rng: &mut Rng) {
        let struck: Vec<Surface> =
            m.surfaces[..RAYS as usize].iter().copied().filter(|s| s.primitive != NONE).collect();
        // The last one is also what spare invocations might do again.
        let (on, near) = (rng.pick(&struck), struck[struck.len() - 1]);
        let half = Vec3::from(near.position) + 0.5 * Vec3::from(near.offset);
        m.lights[0].position = on.position;
        m.lights[1].position = half.into();
        m.lights[2].position = rng.vector().map(|c| c * 1e12);
        for c in m.contributions.iter_mut() {
            c.light = rng.vector();
        }
    }
}

fn camera(rng: &mut Rng) -> Camera {
    Camera {
        origin: rng.vector(),
        forward: rng.direction(),
        right: rng.vector(),
        up: rng.vector().map(|c| c * 1e-3),
        advance: rng.unit() * 100.0,
        step_x: 2.0 / 640.0,
        step_y: 2.0 / 480.0,
        background_r: 0.1,
        background_g: 0.2,
        background_b: 0.7,
        origin_shift: 0.01,
    }
}

fn material(rng: &mut Rng, i: u32) -> Material {
    Material {
        diffuse: if i == 0 { [0.0; 3] } else { rng.vector().map(f32::abs) },
        ambient: rng.pick(&[0.0, 0.3, 1.0]),
        secondary: rng.pick(&[0.0, 1.0, 0.5, 0.5, 1e-30]),
        fresnel: rng.pick(&[0.0, 1.0, 0.4]),
        fresnel_kind: i % 3,
        ior: rng.pick(&[1.0, 1.5, 1e-3, 1e3]),
    }
}

/// A vector of any length, zero, along an axis, or no vector at all.
fn spicy(rng: &mut Rng) -> [f32; 3] {
    let scale = rng.pick(&[1.0, 1.0, 1e-20, 1e18, 1e-38]);
    match rng.below(8) {
        0 => [0.0, -0.0, 0.0],
        1 => [0.0, -scale, -0.0],
        2 => [f32::NAN, 0.0, 1.0],
        3 => [scale, scale, -scale],
        _ => rng.vector().map(|c| c * scale),
    }
}

fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Triangle {
    let [x, y, z] = [a, b, c].map(|v| v.as_dvec3());
    let n = (y - x).cross(z - x).normalize_or(DVec3::Z).as_vec3();
    Triangle {
        a: a.into(),
        normal_x: n.x,
        b: b.into(),
        normal_y: n.y,
        c: c.into(),
        normal_z: n.z,
        ..Triangle::default()
    }
}

/// Triangles and spheres of many sizes in leaf order, with their materials, normals and hierarchy.
fn shapes(m: &mut Memory, rng: &mut Rng, v: Variant) {
    let triangles = triangles(rng, v.triangles as usize);
    let spheres: Vec<Sphere> = (0..v.spheres)
        .map(|_| Sphere {
            center: rng.vector(),
            radius: rng.pick(&[0.2, 0.5, 1e-4, 30.0, 1e4]),
            ..Sphere::default()
        })
        .collect();
    let order = leaf_order(m, &triangles, &spheres, v);
    let (of_triangles, of_spheres) = order.split_at(triangles.len());
    m.triangles = of_triangles.iter().map(|i| triangles[*i as usize]).collect();
    m.spheres = of_spheres.iter().map(|i| spheres[*i as usize - triangles.len()]).collect();
    for (id, t) in of_triangles.iter().zip(&mut m.triangles) {
        (t.material, t.solid) = (rng.below(MATERIALS), rng.below(SOLIDS + 1));
        (t.id, t.inner_edges) = (*id, *id % 4);
    }
    for (id, s) in of_spheres.iter().zip(&mut m.spheres) {
        (s.material, s.solid) = (rng.below(MATERIALS), 1 + rng.below(SOLIDS));
        (s.id, s.wide) = (*id, NONE);
    }
    extend_spheres(m, rng, if v.wide { m.spheres.len() / 2 } else { 0 });
    m.flat_normals = (m.triangles.iter())
        .map(|t| FlatNormal { normal: [t.normal_x, t.normal_y, t.normal_z], pad: 0.0 })
        .collect();
    m.corner_normals = m.triangles.iter().map(|t| corner_normals(t, rng)).collect();
}

/// Triangles of many sizes, some sharing edges, some in the coordinate planes.
fn triangles(rng: &mut Rng, count: usize) -> Vec<Triangle> {
    let mut triangles: Vec<Triangle> = Vec::new();
    while triangles.len() < count {
        let scale = rng.pick(&[1.0, 0.3, 1e-3, 1e-6, 50.0]);
        let a = Vec3::from(rng.vector());
        let mut corner = || a + scale * Vec3::from(rng.vector());
        let (b, c) = (corner(), corner());
        match triangles.len() % 4 {
            // Two that share an edge, as a mesh's do.
            0 => {
                triangles.push(triangle(a, b, c));
                triangles.push(triangle(c, b, b + c - a));
            }
            // In a coordinate plane, with corners that f32 holds exactly.
            2 => {
                let z = 0.25 * rng.below(4) as f32;
                let corner = |x, y| Vec3::new(x, y, z);
                triangles.push(triangle(corner(-0.5, -0.5), corner(0.5, -0.5), corner(-0.5, 0.5)));
            }
            _ => triangles.push(triangle(a, b, c)),
        }
    }
    triangles.truncate(count);
    triangles
}

/// Order of the primitives in the leaves, triangles first. Builds the nodes if the variant has a hierarchy.
fn leaf_order(m: &mut Memory, triangles: &[Triangle], spheres: &[Sphere], v: Variant) -> Vec<u32> {
    let bounds = |(lo, hi): (Vec3, Vec3)| Bounds { lo: lo.as_dvec3(), hi: hi.as_dvec3() };
    let items: Vec<Item> = triangles
        .iter()
        .map(|t| Item { bounds: bounds(triangle_box(t)), is_sphere: false })
        .chain(spheres.iter().map(|s| Item { bounds: bounds(sphere_box(s)), is_sphere: true }))
        .collect();
    if !v.bvh {
        m.nodes = vec![Node::default()];
        return (0..items.len() as u32).collect();
    }
    let built = bvh::build(&items, &Wanted { outside: [v.outside, false], ..Wanted::default() });
    m.nodes = built.nodes.iter().map(Node::from).collect();
    // Equally many for every seed, so that one set of buffers serves all.
    m.nodes.resize(items.len(), Node::default());
    m.compressed_nodes = built.compressed.as_flattened().to_vec();
    m.compressed_nodes.resize(8 * items.len(), CompressedChild::default());
    built.order
}

/// Writes the first `count` spheres in double length, large or small, each with its box as the stand-in.
fn extend_spheres(m: &mut Memory, rng: &mut Rng, count: usize) {
    m.extended_spheres = (0..count)
        .map(|i| {
            let radius = rng.pick(&[1e-5, 1e-3, 1e4, 6e6, 1e9]);
            let normal = Vec3::from(rng.direction());
            let point = Vec3::from(rng.vector());
            let center = point - radius * normal;
            let stand_in =
                Sphere { center: center.into(), radius: -radius * 1.000_001 - 1e-6, ..m.spheres[i] };
            m.spheres[i] = Sphere { wide: i as u32, ..stand_in };
            let low = |v: Vec3, rng: &mut Rng| (3e-8 * v * Vec3::from(rng.vector())).to_array();
            ExtendedSphere {
                point: point.into(),
                point_low: low(point, rng),
                normal: normal.into(),
                normal_low: low(normal, rng),
                radius,
                radius_low: 2e-8 * radius * rng.signed(),
            }
        })
        .collect();
    if m.extended_spheres.is_empty() {
        m.extended_spheres = vec![ExtendedSphere::default()];
    }
}

/// Normals that lean from the triangle's own; none for some triangles, opposite ones for others.
fn corner_normals(t: &Triangle, rng: &mut Rng) -> CornerNormals {
    let n = Vec3::new(t.normal_x, t.normal_y, t.normal_z);
    let mut lean = || (n + 0.7 * Vec3::from(rng.vector())).normalize_or(n).to_array();
    let (a, b, c) = (lean(), lean(), lean());
    match t.id % 4 {
        0 => CornerNormals::default(),
        1 => CornerNormals { a, b: a.map(|x| -x), c },
        _ => CornerNormals { a, b, c },
    }
}

/// A sphere with its radius, also where that is written in double length.
fn real_sphere(m: &Memory, at: u32) -> Sphere {
    match m.extended_spheres.get(m.spheres[at as usize].wide as usize) {
        Some(w) => {
            let center = Vec3::from(w.point) - w.radius * Vec3::from(w.normal);
            Sphere { center: center.into(), radius: w.radius, ..m.spheres[at as usize] }
        }
        None => m.spheres[at as usize],
    }
}

/// A ray at or from something: corners, edges, rims, axes, and nonsense.
fn ray(m: &Memory, rng: &mut Rng, sample_index: u32) -> Ray {
    let t = m.triangles[rng.below(m.triangles.len() as u32) as usize];
    let s = real_sphere(m, rng.below(m.spheres.len() as u32));
    let [a, b, c] = [t.a, t.b, t.c].map(Vec3::from);
    let mut origin = 1.5 * Vec3::from(rng.vector());
    let (u, v) = (rng.unit(), rng.unit());
    let inside = a + 0.5 * u * (b - a) + 0.5 * v * (c - a);
    let mut target = inside;
    let mut skip = NONE;
    let axis = rng.pick(&[Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Z]);
    match sample_index % 12 {
        0 => target = a,
        1 => target = a + u * (b - a),
        // In the triangle's plane.
        2 => origin = a + (b - a) + (c - a),
        3 => target = Vec3::from(s.center) + s.radius * Vec3::from(rng.direction()),
        // Tangent: past the sphere at a distance of its radius.
        4 => {
            origin = Vec3::from(s.center) + s.radius * axis.any_orthogonal_vector() - 3.0 * axis;
            target = origin + axis;
        }
        // From within a sphere, and from its surface.
        5 => origin = Vec3::from(s.center) + 0.5 * s.radius * Vec3::from(rng.direction()),
        6 => {
            let at = rng.below(m.spheres.len() as u32);
            let s = real_sphere(m, at);
            origin = Vec3::from(s.center) + s.radius * Vec3::from(rng.direction());
            skip = m.triangles.len() as u32 + at;
        }
        // From a triangle's surface.
        7 => {
            let at = rng.below(m.triangles.len() as u32);
            let t = m.triangles[at as usize];
            origin = (Vec3::from(t.a) + Vec3::from(t.b) + Vec3::from(t.c)) / 3.0;
            skip = at;
        }
        // Along an axis, in or beside a coordinate plane; also with -0.
        8 => {
            origin = Vec3::new(0.25, rng.pick(&[0.25, 0.0, -0.0, 0.5]), 0.25 * rng.below(4) as f32) - axis;
            target = origin + axis;
        }
        _ => {}
    }
    let mut direction = (target - origin).normalize_or(axis);
    match sample_index % 50 {
        13 => direction = Vec3::from(spicy(rng)),
        14 => origin.y = f32::NAN,
        15 => origin.z = f32::INFINITY,
        16 => direction.x = f32::NEG_INFINITY,
        17 => origin *= 1e12,
        18 => direction *= 1e-12,
        _ => {}
    }
    Ray {
        origin: origin.into(),
        direction: direction.into(),
        throughput: rng.vector().map(f32::abs),
        sample_index,
        skip,
        kind: sample_index % 3,
    }
}
