//! Scene to flat arrays: everything the kernels see, in the local frame, rounded to f32 once.

use crate::abi;
use crate::bvh::{self, Bvh, Item};
use crate::frame::{Bounds, LocalFrame};
use crate::inside;
use crate::scene::{Fresnel, Scene};
use glam::DVec3;

/// Solids a ray can be in at once, at most.
pub const MEDIA_MAX: u32 = 8;
/// Scenes with no more primitives than this test every one of them: measured on lavapipe, the walk
/// over a hierarchy pays from here on (ARCHITECTURE.md, "Figures").
pub const BRUTE_FORCE_MAX: usize = 32;
/// Lights farther than 2^40 scene radii are drawn in to that distance along their direction, with
/// the intensity that gives the same light: the direction turns by less than 2^-40.
const LIGHT_FAR: f64 = 1_099_511_627_776.0;

/// A scene as the kernels see it.
#[derive(Debug, Clone)]
pub struct Packed {
    /// Local frame of all positions.
    pub frame: LocalFrame,
    /// Triangles in leaf order.
    pub triangles: Vec<abi::Triangle>,
    /// Parallel to `triangles`.
    pub triangle_infos: Vec<abi::TriangleInfo>,
    /// Parallel to `triangles`; empty unless some mesh is smooth.
    pub corner_normals: Vec<abi::CornerNormals>,
    /// Spheres in leaf order.
    pub spheres: Vec<abi::Sphere>,
    /// Parallel to `spheres`.
    pub sphere_infos: Vec<abi::SphereInfo>,
    /// The hierarchy's nodes; one unused node for brute force.
    pub nodes: Vec<abi::Node>,
    /// Levels of the hierarchy; 0 for brute force.
    pub bvh_depth: usize,
    /// Materials.
    pub materials: Vec<abi::Material>,
    /// Lights.
    pub lights: Vec<abi::Light>,
    /// Index of refraction of the surrounding space, then of each solid.
    pub solid_iors: Vec<f32>,
    /// Solids a ray of this scene can be in at once; 0 if nothing refracts.
    pub media_capacity: u32,
    /// Solids the eye is in, outermost first, padded with 0 to `media_capacity`.
    pub eye_media: Vec<u32>,
    /// Some hit spawns two rays.
    pub branching: bool,
    /// Triangles without area, dropped.
    pub degenerate_triangles: u64,
}

/// A closed surface that light passes.
struct Solid {
    bounds: Bounds,
    ior: f64,
    contains_eye: bool,
}

struct FlatTriangle {
    corners: [DVec3; 3],
    normal: Option<DVec3>,
    smooth: Option<[DVec3; 3]>,
    material: usize,
    solid: u32,
}

/// Packs `scene`. `brute_force` overrides the choice between brute force and hierarchy.
pub fn pack(scene: &Scene, brute_force: Option<bool>) -> Packed {
    let frame = LocalFrame::of(scene);
    let eye = frame.point(scene.camera.look_from);
    let mut solids = Vec::new();
    let flat = flatten(scene, &frame, eye, &mut solids);
    let flat_count = flat.len() as u32;

    let mut triangles = Vec::with_capacity(flat.len());
    let mut infos = Vec::with_capacity(flat.len());
    let mut smooth = Vec::new();
    let mut items = Vec::with_capacity(flat.len() + scene.spheres.len());
    let any_smooth = flat.iter().any(|t| t.smooth.is_some());
    let mut degenerate_triangles = 0;
    for (id, t) in flat.iter().enumerate() {
        let corners = t.corners.map(|c| c.as_vec3());
        let exact = corners.map(|c| c.as_dvec3());
        // From the rounded corners, in f64: two products of 24 bits each are exact, so zero means
        // exactly no area (numerics 1, scene load).
        let cross = (exact[1] - exact[0]).cross(exact[2] - exact[0]);
        let Some(geometric) = normalized(cross) else {
            degenerate_triangles += 1;
            continue;
        };
        let normal = t.normal.map_or(geometric, |n| if n.dot(geometric) < 0.0 { -n } else { n });
        triangles.push(abi::Triangle {
            a: corners[0].into(),
            b: corners[1].into(),
            c: corners[2].into(),
        });
        infos.push(abi::TriangleInfo {
            normal: normal.as_vec3().into(),
            geometric: geometric.as_vec3().into(),
            material: t.material as u32,
            solid: t.solid,
            id: id as u32,
        });
        if any_smooth {
            let n = t.smooth.map_or([[0.0; 3]; 3], |n| n.map(|n| n.as_vec3().into()));
            smooth.push(abi::CornerNormals { a: n[0], b: n[1], c: n[2] });
        }
        items.push(Item {
            bounds: exact.iter().fold(Bounds::EMPTY, |b, c| b.with(*c)),
            is_sphere: false,
        });
    }
    let mut spheres = Vec::with_capacity(scene.spheres.len());
    let mut sphere_infos = Vec::with_capacity(scene.spheres.len());
    for (i, s) in scene.spheres.iter().enumerate() {
        let (center, radius) = (frame.point(s.center), frame.length(s.radius));
        let material = &scene.materials[s.material];
        let solid = if material.refracts() {
            solids.push(Solid {
                bounds: Bounds::of_sphere(center, radius),
                ior: material.ior,
                contains_eye: eye.distance(center) < radius,
            });
            solids.len() as u32
        } else {
            0
        };
        let packed = abi::Sphere { center: center.as_vec3().into(), radius: radius as f32 };
        spheres.push(packed);
        sphere_infos.push(abi::SphereInfo { material: s.material as u32, solid, id: flat_count + i as u32 });
        let rounded = glam::Vec3::from(packed.center).as_dvec3();
        items.push(Item { bounds: Bounds::of_sphere(rounded, f64::from(packed.radius)), is_sphere: true });
    }

    let brute = brute_force.unwrap_or(items.len() <= BRUTE_FORCE_MAX);
    let bvh = if brute {
        Bvh { nodes: vec![abi::Node::default()], order: (0..items.len() as u32).collect(), depth: 0 }
    } else {
        bvh::build(&items)
    };
    let count = triangles.len();
    let reorder = |i: &u32| *i as usize;
    let (tri_order, sphere_order) = bvh.order.split_at(count);
    let sphere_order: Vec<usize> = sphere_order.iter().map(|i| reorder(i) - count).collect();
    let (media_capacity, eye_media) = media(&solids);
    Packed {
        frame,
        triangles: tri_order.iter().map(|i| triangles[reorder(i)]).collect(),
        triangle_infos: tri_order.iter().map(|i| infos[reorder(i)]).collect(),
        corner_normals: if any_smooth { tri_order.iter().map(|i| smooth[reorder(i)]).collect() } else { Vec::new() },
        spheres: sphere_order.iter().map(|i| spheres[*i]).collect(),
        sphere_infos: sphere_order.iter().map(|i| sphere_infos[*i]).collect(),
        nodes: bvh.nodes,
        bvh_depth: bvh.depth,
        materials: scene.materials.iter().map(material).collect(),
        lights: scene.lights.iter().map(|l| light(l, &frame)).collect(),
        solid_iors: std::iter::once(1.0).chain(solids.iter().map(|s| s.ior as f32)).collect(),
        media_capacity,
        eye_media,
        branching: scene.materials.iter().any(branches),
        degenerate_triangles,
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

fn material(m: &crate::scene::Material) -> abi::Material {
    let (fresnel_kind, fresnel) = match m.fresnel {
        Fresnel::Constant(f) => (abi::FRESNEL_CONSTANT, f as f32),
        Fresnel::Schlick => (abi::FRESNEL_SCHLICK, 0.0),
        Fresnel::Exact => (abi::FRESNEL_EXACT, 0.0),
    };
    abi::Material {
        diffuse: m.diffuse.as_vec3().into(),
        ambient: m.ambient as f32,
        secondary: m.secondary as f32,
        fresnel,
        fresnel_kind,
        ior: m.ior as f32,
    }
}

fn light(l: &crate::scene::Light, frame: &LocalFrame) -> abi::Light {
    let position = frame.point(l.position);
    let far = (position.length() / LIGHT_FAR).max(1.0);
    let local = |c: f64| crate::frame::times_power_of_two(c / (far * far), 2 * frame.scale_log2) as f32;
    abi::Light { position: (position / far).as_vec3().into(), intensity: l.intensity.to_array().map(local) }
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
    /// The camera for an image of `width` x `height` pixels.
    pub fn camera(&self, scene: &Scene, width: u32, height: u32) -> abi::Camera {
        let c = &scene.camera;
        let forward = (c.look_at - c.look_from).normalize();
        let right = forward.cross(c.up).normalize();
        let up = right.cross(forward);
        let (eye, advance) = self.frame.eye(c, forward);
        let half_height = (c.fov / 2.0).tan();
        let half_width = half_height * f64::from(width) / f64::from(height);
        let background = scene.render.background.as_vec3();
        abi::Camera {
            origin: (eye + advance * forward).as_vec3().into(),
            forward: forward.as_vec3().into(),
            right: (half_width * right).as_vec3().into(),
            up: (half_height * up).as_vec3().into(),
            advance: advance as f32,
            step_x: (2.0 / f64::from(width)) as f32,
            step_y: (2.0 / f64::from(height)) as f32,
            background_r: background.x,
            background_g: background.y,
            background_b: background.z,
        }
    }

    /// Triangles and spheres.
    pub fn primitive_count(&self) -> usize {
        self.triangles.len() + self.spheres.len()
    }

    /// What the scene requires, in plain words.
    pub fn features(&self) -> Vec<&'static str> {
        let mirror = self.materials.iter().any(|m| {
            m.secondary > 0.0 && !(m.fresnel_kind == abi::FRESNEL_CONSTANT && m.fresnel == 0.0)
        });
        [
            ("triangles", !self.triangles.is_empty()),
            ("smooth normals", !self.corner_normals.is_empty()),
            ("spheres", !self.spheres.is_empty()),
            ("bvh", self.bvh_depth > 0),
            ("lights", !self.lights.is_empty()),
            ("mirror", mirror),
            ("refraction", self.media_capacity > 0),
            ("nested media", self.media_capacity > 1),
            ("branching", self.branching),
        ]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect()
    }
}
