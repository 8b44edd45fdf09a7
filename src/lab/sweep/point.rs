//! One setting of everything that a sweep can vary.

use crate::scene::procedural::displaced_sphere;
use crate::scene::{Face, Fresnel, Mesh, Scene, Sphere};
use crate::settings::sampler::Sampler;
use crate::settings::{Origin, Precision, Settings};
use serde::{Deserialize, Serialize};

/// The Fresnel law of the materials that refract.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Each material's own.
    Scene,
    /// This one for all.
    Forced(Fresnel),
}

impl Law {
    /// Its name on the command line and in rows.
    pub fn name(self) -> String {
        match self {
            Law::Scene => "scene".into(),
            Law::Forced(Fresnel::Exact) => "exact".into(),
            Law::Forced(Fresnel::Schlick) => "schlick".into(),
            Law::Forced(Fresnel::Constant(share)) => format!("constant:{share}"),
        }
    }
}

/// How the scene's spheres are represented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spheres {
    /// As spheres.
    Analytic,
    /// As geodesic meshes of this frequency: 20 n^2 triangles with smooth normals.
    Mesh(u32),
}

impl Spheres {
    /// Its name on the command line and in rows.
    pub fn name(self) -> String {
        match self {
            Spheres::Analytic => "analytic".into(),
            Spheres::Mesh(n) => format!("mesh:{n}"),
        }
    }
}

/// One point of the grid. Size and scheduling are the same for the whole sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Samples per pixel.
    pub samples: u32,
    /// Sampler.
    pub sampler: Sampler,
    /// Rays in the longest path.
    pub depth: u32,
    /// Rays with a smaller throughput are not spawned.
    pub cutoff: f32,
    /// Arithmetic.
    pub precision: Precision,
    /// Where secondary rays start.
    pub origin: Origin,
    /// Seed of the sampler.
    pub seed: u32,
    /// Fresnel law.
    pub fresnel: Law,
    /// Representation of spheres.
    pub spheres: Spheres,
}

/// A [`Point`] in words, for files.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Words {
    /// Samples per pixel.
    pub samples: u32,
    /// `random`, `stratified` or `owen`.
    pub sampler: String,
    /// Rays in the longest path.
    pub depth: u32,
    /// Rays with a smaller throughput are not spawned.
    pub cutoff: f32,
    /// `fast`, `robust` or `f64`.
    pub precision: String,
    /// `bound` or `fixed:X`.
    pub origin: String,
    /// Seed of the sampler.
    pub seed: u32,
    /// `scene`, `exact`, `schlick` or `constant:F`.
    pub fresnel: String,
    /// `analytic` or `mesh:N`.
    pub spheres: String,
}

impl Point {
    /// The scene's own settings, in f32.
    pub fn of(scene: &Scene) -> Point {
        let own = Settings::of(scene);
        Point {
            samples: own.samples,
            sampler: own.sampler,
            depth: own.depth,
            cutoff: own.cutoff,
            precision: Precision::Robust,
            origin: own.origin,
            seed: own.seed,
            fresnel: Law::Scene,
            spheres: Spheres::Analytic,
        }
    }

    /// `base` with this point's values.
    pub fn settings(&self, base: &Settings) -> Settings {
        Settings {
            samples: self.samples,
            sampler: self.sampler,
            depth: self.depth,
            cutoff: self.cutoff,
            precision: self.precision,
            origin: self.origin,
            seed: self.seed,
            ..base.clone()
        }
    }

    /// `scene` with this point's Fresnel law and spheres.
    pub fn scene(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        if let Law::Forced(law) = self.fresnel {
            scene.materials.iter_mut().filter(|m| m.refracts()).for_each(|m| m.fresnel = law);
        }
        if let Spheres::Mesh(n) = self.spheres {
            scene.meshes.extend(scene.spheres.iter().map(|s| meshed(s, n)));
            scene.spheres.clear();
        }
        scene
    }

    /// In words.
    pub fn words(&self) -> Words {
        Words {
            samples: self.samples,
            sampler: self.sampler.name().into(),
            depth: self.depth,
            cutoff: self.cutoff,
            precision: self.precision.name().into(),
            origin: self.origin.name(),
            seed: self.seed,
            fresnel: self.fresnel.name(),
            spheres: self.spheres.name(),
        }
    }
}

impl Words {
    /// Without samples, sampler and seed: the settings that determine the bias.
    pub fn limit(&self) -> Words {
        Words { samples: 0, sampler: String::new(), seed: 0, ..self.clone() }
    }

    /// Without samples and seed: settings that lie on one line of error against samples.
    pub fn line(&self) -> Words {
        Words { samples: 0, seed: 0, ..self.clone() }
    }

    /// The value on an axis, as it is written.
    pub fn value(&self, axis: &str) -> String {
        match axis {
            "samples" => self.samples.to_string(),
            "sampler" => self.sampler.clone(),
            "depth" => self.depth.to_string(),
            "cutoff" => self.cutoff.to_string(),
            "precision" => self.precision.clone(),
            "origin" => self.origin.clone(),
            "seed" => self.seed.to_string(),
            "fresnel" => self.fresnel.clone(),
            "spheres" => self.spheres.clone(),
            _ => String::new(),
        }
    }
}

fn meshed(sphere: &Sphere, frequency: u32) -> Mesh {
    let unit = displaced_sphere(frequency, 0.0, 0);
    let face =
        |corners: [u32; 3]| Face { vertices: corners, normals: Some(corners), material: sphere.material };
    Mesh {
        name: format!("sphere of {} triangles", unit.faces.len()),
        vertices: unit.vertices.iter().map(|v| sphere.center + *v * sphere.radius).collect(),
        faces: unit.faces.iter().map(|f| face(f.vertices)).collect(),
        normals: unit.vertices,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_meshed_sphere_is_inscribed_and_its_normals_are_radii() {
        let sphere = Sphere { center: DVec3::new(1.0, -2.0, 3.0), radius: 0.5, material: 4 };
        let mesh = meshed(&sphere, 3);
        assert_eq!((mesh.faces.len(), mesh.vertices.len()), (180, 92));
        for (v, n) in mesh.vertices.iter().zip(&mesh.normals) {
            assert!((v.distance(sphere.center) - 0.5).abs() < 1e-14);
            assert!((*n * 0.5 + sphere.center).distance(*v) < 1e-14);
        }
        assert!(mesh.faces.iter().all(|f| f.material == 4 && f.normals == Some(f.vertices)));
    }
}
