//! The sphereflake of Haines' Standard Procedural Databases, as NFF: the rays that the program counts are those that a
//! plain recursion in f64 counts. At 513 x 513 with 7,381 spheres the SPD's text publishes 263,169 eye rays, 175,095
//! reflected and 954,368 shadow rays.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use std::path::Path;
use whitted::{DeviceChoice, Renderer, Scene, Settings};

const LIGHTS: [DVec3; 3] =
    [DVec3::new(4.0, 3.0, 2.0), DVec3::new(1.0, -4.0, 4.0), DVec3::new(-3.0, 1.0, 5.0)];
const DEPTH: u32 = 5;

/// Eye, reflected and shadow rays.
type Counts = [u64; 3];

/// Spheres as centre and radius, from the lines `s x y z r`.
fn spheres(nff: &str) -> Vec<(DVec3, f64)> {
    let numbers = |line: &str| line.split(' ').map(|n| n.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let lines = nff.lines().filter_map(|line| line.strip_prefix("s ")).map(numbers);
    lines.map(|n| (DVec3::new(n[0], n[1], n[2]), n[3])).collect()
}

/// Follows a ray: a shadow ray to every light that the surface faces, and the reflected ray off a sphere.
fn follow(spheres: &[(DVec3, f64)], from: DVec3, way: DVec3, depth: u32, counts: &mut Counts) {
    let mut nearest = (f64::INFINITY, None);
    for (center, radius) in spheres {
        let to = *center - from;
        let (along, square) = (to.dot(way), radius * radius - to.length_squared() + to.dot(way).powi(2));
        let ends = [along - square.max(0.0).sqrt(), along + square.max(0.0).sqrt()];
        if let Some(t) = ends.into_iter().find(|t| square > 0.0 && *t > 1e-9).filter(|t| *t < nearest.0) {
            nearest = (t, Some(center));
        }
    }
    let floor = (-0.5 - from.z) / way.z;
    let on_floor = (from + way * floor).abs();
    if floor > 1e-9 && floor < nearest.0 && on_floor.x <= 12.0 && on_floor.y <= 12.0 {
        nearest = (floor, None);
    }
    let (t, sphere) = nearest;
    if !t.is_finite() {
        return;
    }
    let point = from + way * t;
    let normal = sphere.map_or(DVec3::Z, |center| (point - *center).normalize());
    let normal = if normal.dot(way) > 0.0 { -normal } else { normal };
    counts[2] += LIGHTS.iter().filter(|light| (**light - point).dot(normal) > 0.0).count() as u64;
    if sphere.is_some() && depth < DEPTH {
        counts[1] += 1;
        follow(spheres, point, way - 2.0 * way.dot(normal) * normal, depth + 1, counts);
    }
}

/// One ray through the middle of each pixel.
fn counted(spheres: &[(DVec3, f64)], side: u32) -> Counts {
    let eye = DVec3::new(2.1, 1.3, 1.7);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let half = 22.5f64.to_radians().tan();
    let mut counts = [0; 3];
    for i in 0..side * side {
        let at = |i: u32| (f64::from(2 * i + 1) / f64::from(side) - 1.0) * half;
        counts[0] += 1;
        let way = forward + right * at(i % side) - up * at(i / side);
        follow(spheres, eye, way.normalize(), 1, &mut counts);
    }
    counts
}

#[test]
fn rays_of_each_kind_are_those_of_a_plain_recursion() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str| {
        let file = folder.path().join(name);
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_whitted"));
        command.args(["generate", "sphereflake", "--level", "2", "-o"]).arg(&file).assert().success();
        file
    };
    let (nff, toml) = (write("balls.nff"), write("balls.toml"));
    let side = 65;
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let mut rays = |file: &Path| {
        let scene = Scene::load(file).unwrap();
        let settings =
            Settings { width: side, height: side, samples: 1, depth: DEPTH, ..Settings::of(&scene) };
        let rays = renderer.render(&scene, &settings).unwrap().report.rays;
        assert_eq!(rays.refraction, 0);
        [rays.primary, rays.reflection, rays.shadow]
    };
    let found = rays(&nff);
    let spheres = spheres(&std::fs::read_to_string(&nff).unwrap());
    assert_eq!(spheres.len(), 91);
    let want = counted(&spheres, side);
    assert_eq!(found[0], want[0]);
    for (found, want) in found.iter().zip(&want) {
        // A ray in a thousand passes an edge so closely that single precision may decide otherwise.
        assert!(found.abs_diff(*want) * 1000 <= *want, "{found} {want}");
    }
    // The same shapes as a scene's text.
    assert_eq!(rays(&toml), found);
    // A sphere less is noticed.
    let fewer = counted(&spheres[..81], side);
    assert!(found[1].abs_diff(fewer[1]) * 1000 > found[1], "{found:?} {fewer:?}");
}
