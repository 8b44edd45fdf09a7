//! What is in a scene or a model.

use super::{line, some};
use crate::scene::bounds::Bounds;
use crate::scene::{Fresnel, Material, Scene};
use crate::units::{grouped, number, plural};
use serde::Serialize;
use std::path::Path;

/// A scene, or the one around a model. Lengths in its own unit, angles in degrees, linear RGB.
#[derive(Serialize)]
pub(super) struct SceneFile {
    pub file: String,
    /// Of meshes and polygons.
    triangles: u64,
    /// Of meshes.
    vertices: u64,
    meshes: u64,
    polygons: u64,
    spheres: u64,
    /// Corners of the box around all shapes; null if there are none.
    bounds: Option<[[f64; 3]; 2]>,
    camera: CameraInfo,
    background: [f64; 3],
    lights: Vec<LightInfo>,
    materials: Vec<MaterialInfo>,
    /// What was assumed in reading it.
    notes: Vec<String>,
}

#[derive(Serialize)]
struct CameraInfo {
    look_from: [f64; 3],
    look_at: [f64; 3],
    up: [f64; 3],
    fov: f64,
    width: u32,
    height: u32,
}

#[derive(Serialize)]
struct LightInfo {
    position: [f64; 3],
    intensity: [f64; 3],
}

#[derive(Serialize)]
struct MaterialInfo {
    name: String,
    /// Triangles, polygons and spheres of it.
    uses: u64,
    diffuse: [f64; 3],
    ambient: f64,
    secondary: f64,
    /// A share, or the name of a law.
    fresnel: String,
    ior: f64,
    priority: i32,
}

impl SceneFile {
    pub(super) fn of(file: &Path, scene: &Scene) -> SceneFile {
        let mut uses = vec![0; scene.materials.len()];
        let faces = scene.meshes.iter().flat_map(|mesh| &mesh.faces).map(|face| face.material);
        let polygons = scene.polygons.iter().map(|polygon| polygon.material);
        let spheres = scene.spheres.iter().map(|sphere| sphere.material);
        faces.chain(polygons).chain(spheres).for_each(|material| uses[material] += 1);
        let bounds = bounds(scene);
        let camera = &scene.camera;
        SceneFile {
            file: file.display().to_string(),
            triangles: scene.triangle_count() as u64,
            vertices: scene.meshes.iter().map(|mesh| mesh.vertices.len() as u64).sum(),
            meshes: scene.meshes.len() as u64,
            polygons: scene.polygons.len() as u64,
            spheres: scene.spheres.len() as u64,
            bounds: (!bounds.is_empty()).then(|| [bounds.lo.to_array(), bounds.hi.to_array()]),
            camera: CameraInfo {
                look_from: camera.look_from.to_array(),
                look_at: camera.look_at.to_array(),
                up: camera.up.to_array(),
                fov: camera.fov.to_degrees(),
                width: camera.width,
                height: camera.height,
            },
            background: scene.render.background.to_array(),
            lights: (scene.lights.iter())
                .map(|l| LightInfo { position: l.position.to_array(), intensity: l.intensity.to_array() })
                .collect(),
            materials: scene.materials.iter().zip(uses).map(|(m, uses)| MaterialInfo::of(m, uses)).collect(),
            notes: scene.notes.lines(),
        }
    }

    pub(super) fn text(&self) -> String {
        let counts = [
            some(self.triangles as usize, "triangle"),
            some(self.spheres as usize, "sphere"),
            some(self.polygons as usize, "polygon"),
        ];
        let mut shapes = counts.into_iter().flatten().collect::<Vec<_>>().join(", ");
        if self.meshes > 0 {
            shapes += &format!("; {} with {}", mesh_count(self.meshes), vertex_count(self.vertices));
        }
        let mut text = line("shapes", if shapes.is_empty() { "none" } else { &shapes });
        if let Some([lo, hi]) = self.bounds {
            text += &line("bounds", &format!("{} to {}", place(lo), place(hi)));
        }
        let camera = &self.camera;
        text += &line(
            "camera",
            &format!(
                "at {} to {}, {} degrees, {}x{} pixels",
                place(camera.look_from),
                place(camera.look_at),
                number(camera.fov),
                camera.width,
                camera.height
            ),
        );
        for light in &self.lights {
            text += &line(
                "light",
                &format!("at {}, intensity {}", place(light.position), color(light.intensity)),
            );
        }
        for material in &self.materials {
            text += &line("material", &material.text());
        }
        self.notes.iter().for_each(|note| text += &line("assumed", note));
        text
    }
}

fn mesh_count(count: u64) -> String {
    if count == 1 { "1 mesh".into() } else { format!("{} meshes", grouped(count)) }
}

fn vertex_count(count: u64) -> String {
    if count == 1 { "1 vertex".into() } else { format!("{} vertices", grouped(count)) }
}

impl MaterialInfo {
    fn of(material: &Material, uses: u64) -> MaterialInfo {
        MaterialInfo {
            name: material.name.clone(),
            uses,
            diffuse: material.diffuse.to_array(),
            ambient: material.ambient,
            secondary: material.secondary,
            fresnel: match material.fresnel {
                Fresnel::Constant(share) => number(share),
                Fresnel::Schlick => "schlick".into(),
                Fresnel::Exact => "exact".into(),
            },
            ior: material.ior,
            priority: material.priority,
        }
    }

    fn text(&self) -> String {
        let MaterialInfo { name, uses, diffuse, ambient, secondary, fresnel, ior, .. } = self;
        let shapes = plural(*uses, "shape");
        let mut text = format!(
            "`{}`: {shapes}, diffuse {}, ambient {}",
            name.escape_debug(),
            color(*diffuse),
            number(*ambient)
        );
        if *secondary > 0.0 {
            let secondary = number(*secondary);
            text += &match fresnel.as_str() {
                "1" => format!(", mirror {secondary}"),
                law => format!(", mirror and glass {secondary}, fresnel {law}, ior {}", number(*ior)),
            };
        }
        text
    }
}

fn bounds(scene: &Scene) -> Bounds {
    let meshes = scene.meshes.iter().map(|mesh| mesh.bounds());
    let spheres = scene.spheres.iter().map(|s| Bounds::of_sphere(s.center, s.radius));
    let corners = scene.polygons.iter().flat_map(|polygon| &polygon.vertices);
    let polygons = corners.fold(Bounds::EMPTY, |bounds, corner| bounds.with(*corner));
    meshes.chain(spheres).fold(polygons, Bounds::union)
}

fn place(v: [f64; 3]) -> String {
    let [x, y, z] = v.map(number);
    format!("({x}, {y}, {z})")
}

/// One number for grey.
fn color([r, g, b]: [f64; 3]) -> String {
    if r == g && r == b { number(r) } else { place([r, g, b]) }
}
