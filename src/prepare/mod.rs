//! Scene to flat arrays: everything the kernels see, in the local frame, rounded to f32 once.

pub mod bvh;
pub mod coincident_solids;
mod cut;
pub mod local_frame;
pub mod max_depth;
pub mod near;
mod recipe;
mod rounding;
pub mod scene_features;
mod solids;
mod spheres;
mod triangles;
mod view;
pub mod winding_number;

use crate::kernel::abi::{self, double};
use crate::prepare::bvh::{Bvh, Cache, CompressedNode, Forms, Prim, Wanted};
use crate::prepare::local_frame::{LocalFrame, times_power_of_two};
use crate::prepare::max_depth::MaxDepth;
use crate::prepare::scene_features::SceneFeatures;
use crate::scene::bounds::Bounds;
use crate::scene::{Fresnel, Scene};
use crate::settings::forced_features::Feature;
use crate::settings::{Origin, Precision, Settings};
use glam::DVec3;
pub(crate) use recipe::Recipe;
use rounding::Rounding;
pub(crate) use rounding::SINGLE_RADII;
use solids::media;
use spheres::Spheres;
use triangles::{Kept, Triangles};

/// Solids a ray can be in at once, at most.
pub const MEDIA_MAX: u32 = 8;
/// Primitives of one kind, beside more of the other, that are tested one by one: a handful, so that the
/// tests cost less than a second kind of leaf does at every step.
const OUTSIDE_MAX: usize = 8;
/// Lights farther than 2^40 scene radii are drawn in to that distance along their direction, with
/// the intensity that gives the same light: the direction turns by less than 2^-40.
const LIGHT_FAR: f64 = 1_099_511_627_776.0;

/// A scene as the kernels see it.
#[derive(Debug, Clone)]
pub struct Packed {
    /// Local frame of all positions.
    pub local_frame: LocalFrame,
    /// Triangles in leaf order.
    pub triangles: Vec<double::Triangle>,
    /// Parallel to `triangles`.
    pub flat_normals: Vec<double::FlatNormal>,
    /// Parallel to `triangles`; empty unless some mesh is smooth.
    pub corner_normals: Vec<double::CornerNormals>,
    /// Spheres in leaf order.
    pub spheres: Vec<double::Sphere>,
    /// Very large and very small spheres.
    pub extended_spheres: Vec<double::ExtendedSphere>,
    /// The hierarchy's nodes; one unused node for brute force, empty where rays walk in packets alone.
    pub nodes: Vec<double::Node>,
    /// The same as packets of rays read them; empty for brute force, and where no packets walk.
    pub compressed_nodes: Vec<CompressedNode>,
    /// Triangles, spheres are outside the hierarchy.
    pub outside: [bool; 2],
    /// Levels of the hierarchy; 0 for brute force.
    pub bvh_depth: usize,
    /// Entries that a packet's stack may take; 0 where no packets walk.
    pub packet_stack: usize,
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
    /// Greatest number of primitives that would all be tested.
    pub brute_force_max: usize,
    /// What the scene has, stand-ins apart.
    pub scene_features: SceneFeatures,
    /// Greatest depth of its rays.
    pub max_depth: MaxDepth,
    /// Some hit spawns two rays, or that is switched on.
    pub branching: bool,
    /// Triangles without area, dropped.
    pub degenerate_triangles: u64,
}

/// Packs `scene` for kernels of a precision, whichever way rays will walk. Up to `brute_force_max` primitives there
/// is no hierarchy (`plan::brute_force_max`).
pub fn pack(scene: &Scene, settings: &Settings, brute_force_max: usize) -> Packed {
    pack_forms(scene, settings, brute_force_max, Forms::Both)
}

/// The same with `forms` of the hierarchy's nodes (`plan::Limits::forms` knows which a device needs).
pub fn pack_forms(scene: &Scene, settings: &Settings, brute_force_max: usize, forms: Forms) -> Packed {
    pack_by(Recipe::of(scene), scene, settings, brute_force_max, forms)
}

/// The same by a recipe made for `scene`.
pub(crate) fn pack_by(
    recipe: Recipe,
    scene: &Scene,
    settings: &Settings,
    brute_force_max: usize,
    forms: Forms,
) -> Packed {
    let precision = settings.precision;
    let on = |f: Feature| settings.schedule.forced_features.has(f);
    let Recipe { local_frame, eye, padding, degenerate_normal, single_radii, cut, shape: _ } = recipe;
    let scene = cut.as_ref().unwrap_or(scene);
    let round = Rounding { precision, padding };
    let mut solids = Vec::new();
    let triangles = Triangles::new(scene, &local_frame, round, degenerate_normal, eye, &mut solids);
    let Kept { mut prims, degenerate, mut exact } = triangles.kept();
    let (count, flat_count) = (prims.len(), triangles.len() as u32);

    let made = Spheres::new(scene, &local_frame, round, eye, &single_radii, flat_count, &mut solids);
    let Spheres { shapes: mut spheres, extended: extended_spheres, prims: sphere_prims, exact: same } = made;
    prims.extend(sphere_prims);
    exact &= same;
    let sphere_bounds = |s: &double::Sphere| spheres::bounds(s, round);

    let mut features = SceneFeatures {
        triangles: count as u64,
        spheres: spheres.len() as u64,
        extended_spheres: extended_spheres.len() as u64,
        smooth_normals: triangles.any_smooth,
        lights: scene.lights.len() as u64,
        solids: solids.len() as u64,
        ..SceneFeatures::default()
    };
    let brute = prims.len() <= brute_force_max;
    if spheres.is_empty() && (on(Feature::Spheres) || on(Feature::ExtendedSpheres)) {
        let stand_in = scene_features::sphere(flat_count);
        prims.push(Prim::of(flat_count, &sphere_bounds(&stand_in), true).0);
        exact = false;
        spheres.push(stand_in);
    }
    let stand_in = (count == 0 && on(Feature::Triangles))
        .then(|| scene_features::triangle(flat_count + spheres.len() as u32));
    let stand_in_bounds = |t: &double::Triangle| {
        let bounds = [t.a, t.b, t.c].iter().fold(Bounds::EMPTY, |b, c| b.with(DVec3::from_array(*c)));
        round.padded(bounds.lo, bounds.hi)
    };
    if let Some((shape, _)) = &stand_in {
        // Triangles come first.
        prims.insert(0, Prim::of(shape.id, &stand_in_bounds(shape), false).0);
        exact = false;
    }
    let count = count + usize::from(stand_in.is_some());

    // A few of one kind beside many of the other: the walk then has code for one kind only.
    let few = |count: usize, others: usize| {
        count <= OUTSIDE_MAX && others > OUTSIDE_MAX && !on(Feature::MixedLeaves)
    };
    let outside = [few(count, spheres.len()), few(spheres.len(), count)];
    let of_sphere = |id: u32| (id - flat_count) as usize;
    let bounds = |id: u32| match &stand_in {
        Some((shape, _)) if shape.id == id => stand_in_bounds(shape),
        _ if id < flat_count => triangles.bounds(id),
        _ => sphere_bounds(&spheres[of_sphere(id)]),
    };
    let bvh = if brute {
        unsorted(&prims)
    } else {
        let cache = Cache::of_user();
        let forms = if precision == Precision::Double { Forms::Nodes } else { forms };
        let wanted = Wanted { outside, quality: settings.schedule.hierarchy, forms, cache: cache.as_ref() };
        bvh::build_prims(prims, &wanted, if exact { None } else { Some(&bounds) })
    };
    let (triangle_order, sphere_order) = bvh.order.split_at(count);
    let (packed_triangles, flat_normals) = match stand_in {
        Some((shape, normal)) => (vec![shape], vec![normal]),
        None => triangles.packed(triangle_order),
    };
    let corner_normals = match triangles.any_smooth || on(Feature::SmoothNormals) {
        true if stand_in.is_some() => vec![double::CornerNormals::default()],
        true => triangles.corner_normals(triangle_order),
        false => Vec::new(),
    };
    let (at_once, mut eye_media) = media(&solids);
    let least = if on(Feature::NestedMedia) { 2 } else { u32::from(on(Feature::Refraction)) };
    let media_capacity = at_once.max(least);
    eye_media.resize(media_capacity as usize, 0);
    let eye_in = solids.iter().filter(|s| s.contains_eye).count();
    let used = || scene.materials.iter().zip(&triangles.used).filter_map(|(m, used)| used.then_some(m));
    let branching = used().any(branches);
    let mirrors = used().any(|m| m.has_secondary() && m.fresnel != Fresnel::Constant(0.0));
    features = SceneFeatures { mirrors, solids_at_once: at_once, branching, ..features };
    let max_depth = match on(Feature::Secondary) {
        true => MaxDepth::unlimited(branching),
        false => MaxDepth::new(used(), at_once > 1, branching),
    };
    Packed {
        local_frame,
        triangles: packed_triangles,
        flat_normals,
        corner_normals,
        spheres: sphere_order.iter().map(|id| spheres[of_sphere(*id)]).collect(),
        extended_spheres,
        nodes: bvh.nodes,
        compressed_nodes: bvh.compressed,
        outside: outside.map(|l| l && !brute),
        bvh_depth: bvh.depth,
        packet_stack: bvh.packet_stack,
        materials: scene.materials.iter().map(material).collect(),
        lights: lights(scene, &local_frame, on(Feature::Lights)),
        solid_iors: std::iter::once(1.0).chain(solids.iter().map(|s| s.ior as f32)).collect(),
        solid_priorities: std::iter::once(i32::MIN).chain(solids.iter().map(|s| s.priority)).collect(),
        media_capacity,
        eye_media,
        eye_media_dropped: eye_in.saturating_sub(media_capacity as usize) as u64,
        brute_force_max,
        scene_features: features,
        max_depth,
        branching: branching || on(Feature::Branching),
        degenerate_triangles: degenerate,
    }
}

/// No hierarchy: primitives in the scene's order.
fn unsorted(prims: &[Prim]) -> Bvh {
    Bvh {
        nodes: vec![double::Node::default()],
        order: prims.iter().map(|p| p.index).collect(),
        ..Bvh::default()
    }
}

/// The scene's lights; `several`: at least two, those that are added give no light.
fn lights(scene: &Scene, frame: &LocalFrame, several: bool) -> Vec<double::Light> {
    let mut lights: Vec<double::Light> = scene.lights.iter().map(|l| light(l, frame)).collect();
    while several && lights.len() < 2 {
        lights.push(scene_features::light(lights.first()));
    }
    lights
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
    let local = |c: f64| times_power_of_two(c / (far * far), 2 * frame.scale_log2) as f32;
    double::Light {
        position: (position / far).to_array(),
        intensity: l.intensity.to_array().map(local),
        pad: 0,
    }
}

impl Packed {
    /// The camera of `scene` under `settings`.
    pub fn camera(&self, scene: &Scene, settings: &Settings) -> double::Camera {
        let c = &scene.camera;
        let [right, up, forward] = c.axes();
        let aspect = f64::from(settings.width) / f64::from(settings.height);
        let (eye, advance) = self.local_frame.eye(scene, forward, aspect);
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
                Origin::Fixed(x) => self.local_frame.length(x) as f32,
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
            ("triangles", self.scene_features.triangles > 0),
            ("smooth normals", self.scene_features.smooth_normals),
            ("spheres", self.scene_features.spheres > 0),
            ("spheres beyond single precision", self.scene_features.extended_spheres > 0),
            ("bvh", self.bvh_depth > 0),
            ("lights", self.scene_features.lights > 0),
            ("mirror", self.scene_features.mirrors),
            ("refraction", self.scene_features.solids_at_once > 0),
            ("nested media", self.scene_features.solids_at_once > 1),
            ("branching", self.scene_features.branching),
        ]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect()
    }
}
