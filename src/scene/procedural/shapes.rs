//! Scenes and parts of scenes that several cases use.

use crate::scene::{
    Camera, Face, Fresnel, Light, Material, Mesh, Notes, Polygon, ReadTime, RenderDefaults, Scene, Sphere,
};
use glam::DVec3;
use std::path::PathBuf;

/// A material whose own colour is all there is.
pub fn matte(diffuse: [f64; 3], ambient: f64) -> Material {
    Material {
        name: "matte".into(),
        diffuse: diffuse.into(),
        ambient,
        secondary: 0.0,
        fresnel: Fresnel::Constant(1.0),
        ior: 1.0,
        priority: 0,
        undrawn: None,
    }
}

/// A mirror: `secondary` of reflected light, the rest own colour.
pub fn mirror(secondary: f64, ambient: f64) -> Material {
    Material { name: "mirror".into(), secondary, ..matte([1.0; 3], ambient) }
}

/// Clear glass: all light reflected or refracted.
pub fn glass(ior: f64, fresnel: Fresnel) -> Material {
    Material { name: "glass".into(), secondary: 1.0, fresnel, ior, ..matte([1.0; 3], 0.0) }
}

/// A scene with no objects: 64x64 pixels, one sample, depth 1, seen from (0, 0, 5).
pub fn empty(materials: Vec<Material>) -> Scene {
    Scene {
        file: PathBuf::new(),
        read_time: ReadTime::default(),
        camera: Camera {
            look_from: DVec3::new(0.0, 0.0, 5.0),
            look_at: DVec3::ZERO,
            up: DVec3::Y,
            fov: 0.8,
            width: 64,
            height: 64,
        },
        render: RenderDefaults { samples: 1, depth: 1, background: DVec3::ZERO },
        lights: Vec::new(),
        materials,
        spheres: Vec::new(),
        polygons: Vec::new(),
        meshes: Vec::new(),
        notes: Notes::default(),
    }
}

/// A point light.
pub fn light(position: [f64; 3], intensity: f64) -> Light {
    Light { position: position.into(), intensity: DVec3::splat(intensity) }
}

/// A sphere.
pub fn sphere(center: [f64; 3], radius: f64, material: usize) -> Sphere {
    Sphere { center: center.into(), radius, material }
}

/// A planar polygon, its normal from the corners.
pub fn polygon(vertices: &[[f64; 3]], material: usize) -> Polygon {
    let vertices: Vec<DVec3> = vertices.iter().map(|v| DVec3::from(*v)).collect();
    let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]).normalize();
    Polygon::fan(vertices, normal, material)
}

/// A mesh without normals.
pub fn mesh(vertices: Vec<DVec3>, faces: &[[u32; 3]], material: usize) -> Mesh {
    let faces = faces.iter().map(|f| Face { vertices: *f, normals: None, material }).collect();
    Mesh { name: "mesh".into(), vertices, normals: Vec::new(), faces }
}

/// Twelve triangles around a box, normals outward.
pub fn cuboid(lo: DVec3, hi: DVec3, material: usize) -> Mesh {
    let corner = |i: usize| {
        DVec3::new(
            if i & 1 == 0 { lo.x } else { hi.x },
            if i & 2 == 0 { lo.y } else { hi.y },
            if i & 4 == 0 { lo.z } else { hi.z },
        )
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces: Vec<[u32; 3]> =
        quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    mesh((0..8).map(corner).collect(), &faces, material)
}

/// Moves and scales a whole scene: v * scale + offset; the light scales with its square.
pub fn moved(scene: &Scene, scale: f64, offset: DVec3) -> Scene {
    let mut s = scene.clone();
    let map = |v: &mut DVec3| *v = *v * scale + offset;
    map(&mut s.camera.look_from);
    map(&mut s.camera.look_at);
    s.lights.iter_mut().for_each(|l| {
        map(&mut l.position);
        l.intensity *= scale * scale;
    });
    s.spheres.iter_mut().for_each(|o| {
        map(&mut o.center);
        o.radius *= scale;
    });
    s.polygons.iter_mut().flat_map(|p| &mut p.vertices).for_each(map);
    s.meshes.iter_mut().flat_map(|m| &mut m.vertices).for_each(map);
    s
}

/// A room with everything in it: mirror wall, glass ball, mirror ball, a turned box, one light. The
/// report's scene in small.
pub fn room() -> Scene {
    let mut s = empty(vec![
        matte([0.8, 0.2, 0.2], 0.1),
        matte([0.2, 0.8, 0.2], 0.1),
        matte([0.8, 0.8, 0.8], 0.1),
        mirror(0.8, 0.1),
        Material { diffuse: DVec3::new(0.8, 0.9, 1.0), ..glass(1.5, Fresnel::Exact) },
    ]);
    let (l, h) = (-5.0, 5.0);
    s.polygons = vec![
        polygon(&[[l, l, l], [h, l, l], [h, h, l], [l, h, l]], 3),
        polygon(&[[l, l, h], [l, l, l], [l, h, l], [l, h, h]], 0),
        polygon(&[[h, l, l], [h, l, h], [h, h, h], [h, h, l]], 1),
        polygon(&[[l, l, h], [h, l, h], [h, l, l], [l, l, l]], 2),
        polygon(&[[l, h, l], [h, h, l], [h, h, h], [l, h, h]], 2),
    ];
    s.spheres = vec![sphere([2.0, -3.0, -1.0], 1.9, 4), sphere([-1.5, -4.0, 1.5], 0.9, 3)];
    s.meshes = vec![cuboid(DVec3::new(-3.6, -5.0, -3.3), DVec3::new(-1.3, -2.4, -1.0), 2)];
    s.lights = vec![light([0.0, 4.0, 1.0], 20.0)];
    s.camera.look_from = DVec3::new(0.0, 0.0, 14.0);
    s.render.depth = 4;
    s
}
