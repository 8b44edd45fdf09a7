//! Scenes built by hand.

use glam::DVec3;
use whitted::reference::oracle::{Oracle, Sample};
use whitted::scene::{
    Camera, Face, Fresnel, Light, Material, Mesh, Notes, Polygon, ReadTime, RenderDefaults, Scene, Sphere,
};
use whitted::settings::Settings;

pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A white surface without ambient light or secondary rays.
pub fn matte() -> Material {
    Material {
        name: "matte".into(),
        diffuse: DVec3::ONE,
        ambient: 0.0,
        secondary: 0.0,
        fresnel: Fresnel::Constant(1.0),
        ior: 1.0,
        priority: 0,
        undrawn: None,
    }
}

/// Own colour of a lamp: ambient light alone.
pub fn glowing(light: f64) -> Material {
    Material { ambient: light, ..matte() }
}

pub fn mirror(secondary: f64) -> Material {
    Material { secondary, ..matte() }
}

pub fn glass(ior: f64, fresnel: Fresnel) -> Material {
    Material { secondary: 1.0, fresnel, ior, ..matte() }
}

/// Glass that reflects nothing except by total internal reflection.
pub fn clear(ior: f64) -> Material {
    glass(ior, Fresnel::Constant(0.0))
}

/// An empty scene: one pixel that looks from the origin along +z.
pub fn scene() -> Scene {
    Scene {
        file: "".into(),
        read_time: ReadTime::default(),
        camera: Camera {
            look_from: DVec3::ZERO,
            look_at: DVec3::Z,
            up: DVec3::Y,
            fov: 0.5,
            width: 1,
            height: 1,
        },
        render: RenderDefaults { samples: 1, depth: 1, background: DVec3::ZERO },
        lights: vec![],
        materials: vec![],
        spheres: vec![],
        polygons: vec![],
        meshes: vec![],
        notes: Notes::default(),
    }
}

/// What changes a scene in place, for readable set-ups.
pub trait Add {
    fn material(&mut self, material: Material) -> usize;
    fn sphere(&mut self, center: DVec3, radius: f64, material: usize);
    fn polygon(&mut self, vertices: &[DVec3], material: usize);
    /// A rectangle through `middle` with half sides `s` and `t`.
    fn rectangle(&mut self, middle: DVec3, s: DVec3, t: DVec3, material: usize);
    /// An axis-aligned box as a mesh.
    fn cuboid(&mut self, low: DVec3, high: DVec3, material: usize);
    fn light(&mut self, position: DVec3, intensity: DVec3);
    fn look(&mut self, from: DVec3, at: DVec3);
}

impl Add for Scene {
    fn material(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    fn sphere(&mut self, center: DVec3, radius: f64, material: usize) {
        self.spheres.push(Sphere { center, radius, material });
    }

    fn polygon(&mut self, vertices: &[DVec3], material: usize) {
        let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]).normalize();
        self.polygons.push(Polygon::fan(vertices.to_vec(), normal, material));
    }

    fn rectangle(&mut self, middle: DVec3, s: DVec3, t: DVec3, material: usize) {
        self.polygon(&[middle - s - t, middle + s - t, middle + s + t, middle - s + t], material);
    }

    fn cuboid(&mut self, low: DVec3, high: DVec3, material: usize) {
        let corner = |i: usize| {
            let pick = |bit: usize, l: f64, h: f64| if i & bit == 0 { l } else { h };
            v(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        self.meshes.push(Mesh {
            name: "box".into(),
            vertices: (0..8).map(corner).collect(),
            normals: vec![],
            faces: faces.map(|vertices| Face { vertices, normals: None, material }).collect(),
        });
    }

    fn light(&mut self, position: DVec3, intensity: DVec3) {
        self.lights.push(Light { position, intensity });
    }

    fn look(&mut self, from: DVec3, at: DVec3) {
        self.camera.look_from = from;
        self.camera.look_at = at;
        let forward = (at - from).normalize();
        self.camera.up = if forward.y.abs() > 0.9 { DVec3::X } else { DVec3::Y };
    }
}

/// The ray from `from` to `at`, the middle of a one-pixel image.
pub fn probe(scene: &Scene, from: DVec3, at: DVec3, depth: u32) -> Sample {
    let mut scene = scene.clone();
    scene.look(from, at);
    let settings = Settings { width: 1, height: 1, samples: 1, depth, ..Settings::of(&scene) };
    Oracle::new(&scene).sample(0, 0, 0, &settings)
}

/// A scene of every kind of thing, 32 x 24 pixels.
pub fn everything() -> Scene {
    let mut s = scene();
    let floor = s.material(Material { diffuse: v(0.8, 0.7, 0.6), ..glowing(0.1) });
    let silver = s.material(mirror(0.9));
    let ball = s.material(glass(1.5, Fresnel::Exact));
    let ice =
        s.material(Material { diffuse: v(0.5, 0.8, 1.0), secondary: 0.7, ..glass(1.3, Fresnel::Schlick) });
    let pane = s.material(glass(1.5, Fresnel::Constant(0.25)));
    s.rectangle(v(0.0, -1.0, 6.0), DVec3::Z * 6.0, DVec3::X * 6.0, floor);
    s.rectangle(v(0.0, 3.0, 12.0), DVec3::X * 6.0, DVec3::Y * 4.0, silver);
    s.rectangle(v(-1.5, 0.0, 3.5), v(0.5, 0.0, 0.2), DVec3::Y * 0.8, pane);
    s.cuboid(v(0.6, -0.9, 4.0), v(1.9, 0.4, 5.1), ice);
    s.sphere(v(-0.6, 0.0, 5.0), 0.9, ball);
    s.sphere(v(-0.6, 0.1, 5.0), 0.4, ice);
    s.sphere(v(1.2, 1.2, 5.0), 0.5, silver);
    s.light(v(-3.0, 4.0, 2.0), DVec3::splat(9.0));
    s.light(v(3.0, 5.0, 4.0), v(9.0, 4.0, 2.0));
    s.render = RenderDefaults { samples: 3, depth: 5, background: v(0.1, 0.2, 0.3) };
    s.camera = Camera {
        look_from: v(0.1, 0.7, -1.0),
        look_at: v(0.0, 0.1, 5.0),
        fov: 0.8,
        width: 32,
        height: 24,
        ..s.camera
    };
    s
}

pub fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} within {tolerance:e}");
}
