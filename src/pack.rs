//! Scene to flat arrays: everything the kernels see, in the local frame, rounded to f32 once.

use crate::abi::{self, double};
use crate::bvh::{self, Bvh, Item};
use crate::defect::Defect;
use crate::found::{self, Found};
use crate::frame::{Bounds, LocalFrame};
use crate::general::Feature;
use crate::inside;
use crate::reach::Reach;
use crate::scene::{Fresnel, Scene};
use crate::settings::{Origin, Precision, Settings};
use glam::DVec3;
use std::collections::HashMap;

/// Solids a ray can be in at once, at most.
pub const MEDIA_MAX: u32 = 8;
/// Scenes with no more primitives than this test every one of them: measured on lavapipe, the walk
/// over a hierarchy pays from here on (ARCHITECTURE.md, "Figures").
pub const BRUTE_FORCE_MAX: usize = 32;
/// Primitives of one kind, beside more of the other, that are tested one by one: a handful, so that the
/// tests cost less than a second kind of leaf does at every step.
const LOOSE_MAX: usize = 8;
/// Lights farther than 2^40 scene radii are drawn in to that distance along their direction, with
/// the intensity that gives the same light: the direction turns by less than 2^-40.
const LIGHT_FAR: f64 = 1_099_511_627_776.0;

/// A scene as the kernels see it.
#[derive(Debug, Clone)]
pub struct Packed {
    /// Local frame of all positions.
    pub frame: LocalFrame,
    /// Triangles in leaf order.
    pub triangles: Vec<double::Triangle>,
    /// Parallel to `triangles`.
    pub triangle_infos: Vec<double::TriangleInfo>,
    /// Parallel to `triangles`; empty unless some mesh is smooth.
    pub corner_normals: Vec<double::CornerNormals>,
    /// Spheres in leaf order.
    pub spheres: Vec<double::Sphere>,
    /// Very large and very small spheres.
    pub wide_spheres: Vec<double::WideSphere>,
    /// Parallel to `spheres`.
    pub sphere_infos: Vec<double::SphereInfo>,
    /// The hierarchy's nodes; one unused node for brute force.
    pub nodes: Vec<double::Node>,
    /// Triangles, spheres are outside the hierarchy.
    pub loose: [bool; 2],
    /// Levels of the hierarchy; 0 for brute force.
    pub bvh_depth: usize,
    /// Materials.
    pub materials: Vec<double::Material>,
    /// Lights.
    pub lights: Vec<double::Light>,
    /// Index of refraction of the surrounding space, then of each solid.
    pub solid_iors: Vec<f32>,
    /// Priority of the surrounding space, then of each solid.
    pub solid_priorities: Vec<i32>,
    /// Solids a ray of this scene can be in at once; 0 if nothing refracts.
    pub media_capacity: u32,
    /// Solids the eye is in, outermost first, padded with 0 to `media_capacity`.
    pub eye_media: Vec<u32>,
    /// Solids the eye is in beyond those.
    pub eye_media_dropped: u64,
    /// What the scene has, stand-ins apart.
    pub found: Found,
    /// How deep its light can travel.
    pub reach: Reach,
    /// Some hit spawns two rays, or that is switched on.
    pub branching: bool,
    /// Triangles without area, dropped.
    pub degenerate_triangles: u64,
}

/// A closed surface that light passes.
struct Solid {
    bounds: Bounds,
    ior: f64,
    priority: i32,
    contains_eye: bool,
}

struct FlatTriangle {
    corners: [DVec3; 3],
    normal: Option<DVec3>,
    smooth: Option<[DVec3; 3]>,
    material: usize,
    solid: u32,
    inner_edges: u32,
}

/// Packs `scene` for kernels of a precision. `brute_force` overrides the choice between brute force
/// and hierarchy.
pub fn pack(scene: &Scene, settings: &Settings, brute_force: Option<bool>) -> Packed {
    let precision = settings.precision;
    let planted = |d: Defect| settings.planted == Some(d);
    let on = |f: Feature| settings.schedule.general.has(f);
    let mut frame = LocalFrame::of(scene);
    if planted(Defect::WorldFrame) {
        frame = LocalFrame::world(&frame);
    }
    let eye = frame.point(scene.camera.look_from);
    let mut solids = Vec::new();
    let flat = flatten(scene, &frame, eye, &mut solids);
    let flat_count = flat.len() as u32;
    let round = Rounding { precision, padding: if planted(Defect::TightBoxes) { 0.0 } else { bvh::PADDING } };

    let mut triangles = Vec::with_capacity(flat.len());
    let mut infos = Vec::with_capacity(flat.len());
    let mut smooth = Vec::new();
    let mut items = Vec::with_capacity(flat.len() + scene.spheres.len());
    let found_smooth = flat.iter().any(|t| t.smooth.is_some());
    let any_smooth = found_smooth || on(Feature::SmoothNormals);
    let mut degenerate_triangles = 0;
    let mut piles = Piles::default();
    for (id, t) in flat.iter().enumerate() {
        let corners = t.corners.map(|c| round.point(c));
        // From the rounded corners, in f64, where products of f32 numbers are exact and the rest is
        // good to 2^-52: zero means no area (numerics.md, Local frame).
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let kept = planted(Defect::KeepDegenerate).then_some(DVec3::Y);
        let Some(geometric) = normalized(cross).or(kept) else {
            degenerate_triangles += 1;
            continue;
        };
        if piles.is_buried(&corners) {
            continue;
        }
        let normal = t.normal.map_or(geometric, |n| if n.dot(geometric) < 0.0 { -n } else { n });
        let [a, b, c] = corners.map(|c| c.to_array());
        let [normal_x, normal_y, normal_z] = geometric.to_array();
        triangles.push(double::Triangle { a, normal_x, b, normal_y, c, normal_z });
        infos.push(double::TriangleInfo {
            normal: normal.to_array(),
            pad: 0.0,
            material: t.material as u32,
            solid: t.solid,
            id: id as u32,
            inner_edges: t.inner_edges,
        });
        if any_smooth {
            let [a, b, c] = t.smooth.map_or([[0.0; 3]; 3], |n| n.map(|n| n.to_array()));
            smooth.push(double::CornerNormals { a, b, c });
        }
        let bounds = corners.iter().fold(Bounds::EMPTY, |b, c| b.with(*c));
        items.push(Item { bounds: round.padded(bounds.lo, bounds.hi), is_sphere: false });
    }
    let mut found = Found { triangles: triangles.len() as u64, ..Found::default() };
    if triangles.is_empty() && on(Feature::Triangles) {
        let (shape, info, corners) = found::triangle(flat_count + scene.spheres.len() as u32);
        let bounds = corners.iter().fold(Bounds::EMPTY, |b, c| b.with(*c));
        items.push(Item { bounds: round.padded(bounds.lo, bounds.hi), is_sphere: false });
        triangles.push(shape);
        infos.push(info);
        smooth.extend(any_smooth.then(double::CornerNormals::default));
    }
    let mut spheres = Vec::with_capacity(scene.spheres.len());
    let mut wide_spheres = Vec::new();
    let mut sphere_infos = Vec::with_capacity(scene.spheres.len());
    for (i, s) in scene.spheres.iter().enumerate() {
        let (center, radius) = (frame.point(s.center), frame.length(s.radius));
        let material = &scene.materials[s.material];
        let solid = if material.refracts() {
            solids.push(Solid {
                bounds: Bounds::of_sphere(center, radius),
                ior: material.ior,
                priority: material.priority,
                contains_eye: eye.distance(center) < radius,
            });
            solids.len() as u32
        } else {
            0
        };
        let rounded = round.point(center);
        let is_wide =
            precision != Precision::Fast && !planted(Defect::NoWide) && !WIDE_RADII.contains(&radius);
        let (packed, wide) = if is_wide {
            wide_spheres.push(wide_sphere(center, radius, round));
            // Used for its box alone, so it must hold the exact sphere: a relative 2^-20 covers the
            // roundings of centre and radius.
            let box_radius = round.number((radius + rounded.abs().max_element()) * 2f64.powi(-20) + radius);
            (
                double::Sphere { center: rounded.to_array(), radius: -box_radius },
                wide_spheres.len() as u32 - 1,
            )
        } else {
            (double::Sphere { center: rounded.to_array(), radius: round.number(radius) }, abi::NONE)
        };
        spheres.push(packed);
        sphere_infos.push(double::SphereInfo {
            material: s.material as u32,
            solid,
            id: flat_count + i as u32,
            wide,
        });
        items.push(Item { bounds: round.sphere_box(rounded, packed.radius.abs()), is_sphere: true });
    }

    found = Found {
        spheres: spheres.len() as u64,
        wide_spheres: wide_spheres.len() as u64,
        smooth_normals: found_smooth,
        lights: scene.lights.len() as u64,
        solids: solids.len() as u64,
        ..found
    };
    if spheres.is_empty() && (on(Feature::Spheres) || on(Feature::WideSpheres)) {
        let (shape, info) = found::sphere(flat_count + 1);
        items.push(Item {
            bounds: round.sphere_box(DVec3::from_array(shape.center), shape.radius),
            is_sphere: true,
        });
        spheres.push(shape);
        sphere_infos.push(info);
    }

    // A few of one kind beside many of the other: the walk then has code for one kind only.
    let few =
        |count: usize, others: usize| count <= LOOSE_MAX && others > LOOSE_MAX && !on(Feature::MixedLeaves);
    let loose = [few(triangles.len(), spheres.len()), few(spheres.len(), triangles.len())];
    let brute =
        brute_force.unwrap_or(found.primitives() <= BRUTE_FORCE_MAX as u64 && !on(Feature::Hierarchy));
    let bvh = if brute {
        Bvh {
            nodes: vec![double::Node::default()],
            order: (0..items.len() as u32).collect(),
            depth: 0,
            stack: 0,
        }
    } else {
        bvh::build(&items, loose)
    };
    let count = triangles.len();
    let (tri_order, sphere_order) = bvh.order.split_at(count);
    let pick = |i: &u32| *i as usize;
    let pick_sphere = |i: &u32| *i as usize - count;
    let (at_once, mut eye_media) = media(&solids);
    let least = if on(Feature::NestedMedia) { 2 } else { u32::from(on(Feature::Refraction)) };
    let media_capacity = at_once.max(least);
    eye_media.resize(media_capacity as usize, 0);
    let eye_in = solids.iter().filter(|s| s.contains_eye).count();
    if planted(Defect::EyeInAir) {
        eye_media.fill(0);
    }
    let used = used_materials(scene);
    let branching = used.iter().any(|m| branches(m));
    let mirrors = used.iter().any(|m| m.has_secondary() && m.fresnel != Fresnel::Constant(0.0));
    found = Found { mirrors, solids_at_once: at_once, branching, ..found };
    let reach = match on(Feature::Secondary) {
        true => Reach::unlimited(branching),
        false => Reach::new(used.iter().copied(), at_once > 1, branching),
    };
    let mut lights: Vec<double::Light> = scene.lights.iter().map(|l| light(l, &frame)).collect();
    while on(Feature::Lights) && lights.len() < 2 {
        lights.push(found::light(lights.first()));
    }
    Packed {
        frame,
        triangles: tri_order.iter().map(|i| triangles[pick(i)]).collect(),
        triangle_infos: tri_order.iter().map(|i| infos[pick(i)]).collect(),
        corner_normals: if any_smooth {
            tri_order.iter().map(|i| smooth[pick(i)]).collect()
        } else {
            Vec::new()
        },
        spheres: sphere_order.iter().map(|i| spheres[pick_sphere(i)]).collect(),
        wide_spheres,
        sphere_infos: sphere_order.iter().map(|i| sphere_infos[pick_sphere(i)]).collect(),
        nodes: bvh.nodes,
        loose: loose.map(|l| l && !brute),
        bvh_depth: bvh.depth,
        materials: scene.materials.iter().map(material).collect(),
        lights,
        solid_iors: std::iter::once(1.0).chain(solids.iter().map(|s| s.ior as f32)).collect(),
        solid_priorities: std::iter::once(i32::MIN).chain(solids.iter().map(|s| s.priority)).collect(),
        media_capacity,
        eye_media,
        eye_media_dropped: eye_in.saturating_sub(media_capacity as usize) as u64,
        found,
        reach,
        branching: branching || on(Feature::Branching),
        degenerate_triangles,
    }
}

/// Triangles kept of one pile, all with the same corners in the same order.
const PILE: u8 = 16;

/// Of triangles with the same corners the first in the scene's order is hit, whatever the rest are: t
/// is the same bits, and ties go to the smallest id. A ray would test them all the same, and so many
/// that it came near the loop cap.
#[derive(Default)]
struct Piles(HashMap<u64, u8>);

impl Piles {
    /// True if PILE triangles with these corners came before. Corners are told by 64 bits mixed from
    /// theirs: a false burial would take 16 collisions at once.
    fn is_buried(&mut self, corners: &[DVec3; 3]) -> bool {
        let words = corners.iter().flat_map(|c| c.to_array()).map(f64::to_bits);
        // The multiplier of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
        let key = words.fold(0u64, |h, w| (h ^ w).wrapping_mul(0xbf58_476d_1ce4_e5b9).rotate_left(29));
        let count = self.0.entry(key).or_default();
        let buried = *count == PILE;
        *count += u8::from(!buried);
        buried
    }
}

/// Radii that single numbers serve: outside, a ratio of distance to radius above 2^15 leaves f32 no
/// silhouette (numerics.md, Spheres: f32 holds to 1e5), and a surface too far from its centre no position.
pub(crate) const WIDE_RADII: std::ops::RangeInclusive<f64> = (1.0 / 16_384.0)..=4096.0;

/// Materials that some surface has.
fn used_materials(scene: &Scene) -> Vec<&crate::scene::Material> {
    let mut used = vec![false; scene.materials.len()];
    let faces = scene.meshes.iter().flat_map(|m| m.faces.iter().map(|f| f.material));
    let others = scene.polygons.iter().map(|p| p.material).chain(scene.spheres.iter().map(|s| s.material));
    faces.chain(others).for_each(|m| used[m] = true);
    scene.materials.iter().zip(used).filter_map(|(m, used)| used.then_some(m)).collect()
}

/// A number as a sum of two, each rounded as the kernels round.
fn wide_sphere(center: DVec3, radius: f64, round: Rounding) -> double::WideSphere {
    // The surface point nearest the origin; for a centre at the origin, any. Its distance is the
    // difference of two numbers that may be near equal, a planet's radius and its centre's distance,
    // so it comes from the difference of their squares, error-free (Dekker's product by fma).
    let normal = normalized(-center).unwrap_or(DVec3::Y);
    let scale = 2f64.powi(radius.max(center.abs().max_element()).log2().floor() as i32);
    let (r, c) = (radius / scale, center / scale);
    let products =
        [(r, r), (-c.x, c.x), (-c.y, c.y), (-c.z, c.z)].map(|(x, y)| (x * y, x.mul_add(y, -(x * y))));
    let (mut sum, mut error) = (0.0, 0.0);
    for (p, e) in products {
        let s: f64 = sum + p;
        let b = s - sum;
        error += (sum - (s - b)) + (p - b) + e;
        sum = s;
    }
    let point = normal * (scale * ((sum + error) / (r + c.length())));
    let split = |v: DVec3| {
        let high = round.point(v);
        (high.to_array(), round.point(v - high).to_array())
    };
    let ((point, point_low), (normal, normal_low)) = (split(point), split(normal));
    let high = round.number(radius);
    double::WideSphere {
        point,
        point_low,
        normal,
        normal_low,
        radius: high,
        radius_low: round.number(radius - high),
    }
}

/// How the kernels of a precision round.
#[derive(Clone, Copy)]
struct Rounding {
    precision: Precision,
    padding: f64,
}

impl Rounding {
    fn number(self, x: f64) -> f64 {
        if self.precision == Precision::Double { x } else { f64::from(x as f32) }
    }

    fn point(self, p: DVec3) -> DVec3 {
        DVec3::new(self.number(p.x), self.number(p.y), self.number(p.z))
    }

    /// `pad_down` and `pad_up` of glsl/lib/box.glsl, operation by operation in the kernels' precision.
    fn padded(self, lo: DVec3, hi: DVec3) -> Bounds {
        let pad = |x: f64| self.number(self.padding * x.abs().max(1.0));
        let axis = |f: &dyn Fn(usize) -> f64| DVec3::new(f(0), f(1), f(2));
        Bounds {
            lo: axis(&|a| self.number(lo[a] - pad(lo[a]))),
            hi: axis(&|a| self.number(hi[a] + pad(hi[a]))),
        }
    }

    /// `sphere_box` of the same file.
    fn sphere_box(self, center: DVec3, radius: f64) -> Bounds {
        let r = DVec3::splat(radius);
        self.padded(self.point(center - r), self.point(center + r))
    }
}

/// All triangles in the scene's order: polygons, then meshes.
fn flatten(scene: &Scene, frame: &LocalFrame, eye: DVec3, solids: &mut Vec<Solid>) -> Vec<FlatTriangle> {
    let mut flat = Vec::with_capacity(scene.triangle_count());
    for p in &scene.polygons {
        let corners: Vec<DVec3> = p.vertices.iter().map(|v| frame.point(*v)).collect();
        for i in 1..corners.len() - 1 {
            flat.push(FlatTriangle {
                corners: [corners[0], corners[i], corners[i + 1]],
                normal: Some(p.normal),
                smooth: None,
                material: p.material,
                solid: 0,
                inner_edges: if i > 1 { abi::INNER_AB } else { 0 }
                    | if i + 2 < corners.len() { abi::INNER_CA } else { 0 },
            });
        }
    }
    for mesh in &scene.meshes {
        let vertices: Vec<DVec3> = mesh.vertices.iter().map(|v| frame.point(*v)).collect();
        let refracting = mesh.faces.iter().find(|f| scene.materials[f.material].refracts());
        let solid = refracting.map_or(0, |face| {
            let shell = || mesh.faces.iter().map(|f| f.vertices.map(|v| vertices[v as usize]));
            solids.push(Solid {
                bounds: shell().flatten().fold(Bounds::EMPTY, Bounds::with),
                ior: scene.materials[face.material].ior,
                priority: scene.materials[face.material].priority,
                contains_eye: inside::contains(shell(), eye),
            });
            solids.len() as u32
        });
        for face in &mesh.faces {
            flat.push(FlatTriangle {
                corners: face.vertices.map(|v| vertices[v as usize]),
                normal: None,
                smooth: face.normals.map(|n| n.map(|n| mesh.normals[n as usize])),
                material: face.material,
                solid: if scene.materials[face.material].refracts() { solid } else { 0 },
                inner_edges: 0,
            });
        }
    }
    flat
}

/// Unit vector, or `None` for exactly zero; safe for lengths whose squares leave f64.
fn normalized(v: DVec3) -> Option<DVec3> {
    let m = v.abs().max_element();
    (m > 0.0).then(|| (v / m).normalize())
}

fn branches(m: &crate::scene::Material) -> bool {
    m.refracts() && !matches!(m.fresnel, Fresnel::Constant(f) if f <= 0.0)
}

fn material(m: &crate::scene::Material) -> double::Material {
    let (fresnel_kind, fresnel) = match m.fresnel {
        Fresnel::Constant(f) => (abi::FRESNEL_CONSTANT, f as f32),
        Fresnel::Schlick => (abi::FRESNEL_SCHLICK, 0.0),
        Fresnel::Exact => (abi::FRESNEL_EXACT, 0.0),
    };
    double::Material {
        diffuse: m.diffuse.as_vec3().into(),
        ambient: m.ambient as f32,
        secondary: m.secondary as f32,
        fresnel,
        fresnel_kind,
        ior: m.ior as f32,
    }
}

fn light(l: &crate::scene::Light, frame: &LocalFrame) -> double::Light {
    let position = frame.point(l.position);
    let far = (position.length() / LIGHT_FAR).max(1.0);
    let local = |c: f64| crate::frame::times_power_of_two(c / (far * far), 2 * frame.scale_log2) as f32;
    double::Light {
        position: (position / far).to_array(),
        intensity: l.intensity.to_array().map(local),
        pad: 0,
    }
}

/// How many solids a ray can be in at once, and those the eye is in, outermost (largest) first.
fn media(solids: &[Solid]) -> (u32, Vec<u32>) {
    if solids.is_empty() {
        return (0, Vec::new());
    }
    // A ray is at once only in solids that all touch one of them. Past this size the quadratic
    // search costs more than the words it saves.
    let at_once = if solids.len() <= 4096 {
        let touching = |s: &Solid| solids.iter().filter(|o| o.bounds.touches(&s.bounds)).count() as u32;
        solids.iter().map(touching).max().unwrap_or(1)
    } else {
        MEDIA_MAX
    };
    let capacity = at_once.min(MEDIA_MAX);
    let mut holding: Vec<usize> = (0..solids.len()).filter(|i| solids[*i].contains_eye).collect();
    let size = |i: usize| (solids[i].bounds.hi - solids[i].bounds.lo).length();
    holding.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
    let mut eye: Vec<u32> = holding.iter().map(|i| *i as u32 + 1).take(capacity as usize).collect();
    eye.resize(capacity as usize, 0);
    (capacity, eye)
}

impl Packed {
    /// The camera of `scene` under `settings`.
    pub fn camera(&self, scene: &Scene, settings: &Settings) -> double::Camera {
        let c = &scene.camera;
        let forward = (c.look_at - c.look_from).normalize();
        let right = forward.cross(c.up).normalize();
        let up = right.cross(forward);
        let (eye, mut advance) = self.frame.eye(c, forward);
        if settings.planted == Some(Defect::EyeOrigin) {
            advance = 0.0;
        }
        let half_height = (c.fov / 2.0).tan();
        let half_width = half_height * f64::from(settings.width) / f64::from(settings.height);
        let background = scene.render.background.as_vec3();
        double::Camera {
            origin: (eye + advance * forward).to_array(),
            forward: forward.to_array(),
            right: (half_width * right).to_array(),
            up: (half_height * up).to_array(),
            advance,
            step_x: 2.0 / f64::from(settings.width),
            step_y: 2.0 / f64::from(settings.height),
            background_r: background.x,
            background_g: background.y,
            background_b: background.z,
            origin_shift: match settings.origin {
                Origin::Bound => 0.0,
                Origin::Fixed(x) => self.frame.length(x) as f32,
            },
        }
    }

    /// Triangles and spheres.
    pub fn primitive_count(&self) -> usize {
        self.triangles.len() + self.spheres.len()
    }

    /// What the scene requires, in plain words.
    pub fn features(&self) -> Vec<&'static str> {
        [
            ("triangles", self.found.triangles > 0),
            ("smooth normals", self.found.smooth_normals),
            ("spheres", self.found.spheres > 0),
            ("spheres beyond single precision", self.found.wide_spheres > 0),
            ("bvh", self.bvh_depth > 0),
            ("lights", self.found.lights > 0),
            ("mirror", self.found.mirrors),
            ("refraction", self.found.solids_at_once > 0),
            ("nested media", self.found.solids_at_once > 1),
            ("branching", self.found.branching),
        ]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect()
    }
}
