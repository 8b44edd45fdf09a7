//! Whole images: crops, threads, scale, counts.

use crate::build::{Add, everything, glowing, mirror, probe, scene, v};
use glam::DVec3;
use whitted::reference::oracle::{Oracle, OracleImage};
use whitted::scene::{Fresnel, Scene};
use whitted::settings::Settings;

fn render(scene: &Scene) -> OracleImage {
    Oracle::new(scene).render(&Settings::of(scene))
}

#[test]
fn a_crop_equals_its_part_of_the_whole() {
    let s = everything();
    let whole = render(&s);
    let crop = [5, 3, 29, 20];
    let part = Oracle::new(&s).render(&Settings { crop: Some(crop), ..Settings::of(&s) });
    assert_eq!((part.width, part.height), (24, 17));
    for y in 0..17 {
        for x in 0..24 {
            let (i, j) = (y * 24 + x, (y + 3) * 32 + x + 5);
            assert_eq!(part.linear[i], whole.linear[j]);
            assert_eq!(part.first_hit[3 * i..3 * i + 3], whole.first_hit[3 * j..3 * j + 3]);
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let s = everything();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&s))
    };
    let (one, three) = (with(1), with(3));
    assert_eq!((one.linear, one.first_hit), (three.linear, three.first_hit));
    assert_eq!(one.rays.total(), three.rays.total());
}

#[test]
fn render_is_the_mean_of_the_samples() {
    let s = everything();
    let (oracle, settings) = (Oracle::new(&s), Settings::of(&s));
    let image = oracle.render(&settings);
    let samples = [0, 1, 2].map(|k| oracle.sample(17, 11, k, &settings));
    let at = 11 * 32 + 17;
    assert_eq!(image.linear[at], (samples[0].radiance + samples[1].radiance + samples[2].radiance) / 3.0);
    assert_eq!(image.first_hit[3 * at..3 * at + 3], samples.map(|s| s.first_hit));
}

#[test]
fn a_scene_scaled_by_a_power_of_two_keeps_every_bit() {
    let s = everything();
    let image = render(&s);
    for k in [-60, -1, 60] {
        let scale = 2f64.powi(k);
        let mut t = s.clone();
        t.camera.look_from *= scale;
        t.camera.look_at *= scale;
        t.lights.iter_mut().for_each(|l| (l.position *= scale, l.intensity *= scale * scale).0);
        t.spheres.iter_mut().for_each(|b| (b.center *= scale, b.radius *= scale).0);
        t.polygons.iter_mut().flat_map(|p| &mut p.vertices).for_each(|p| *p *= scale);
        t.meshes.iter_mut().flat_map(|m| &mut m.vertices).for_each(|p| *p *= scale);
        assert_eq!(render(&t).linear, image.linear, "2^{k}");
    }
}

#[test]
fn the_first_depth_knows_no_mirrors() {
    let mut s = everything();
    s.render.depth = 1;
    let image = render(&s);
    assert_eq!((image.rays.reflection, image.rays.refraction), (0, 0));
    for m in &mut s.materials {
        m.fresnel = Fresnel::Constant(1.0);
        m.ior = 3.0;
    }
    assert_eq!(render(&s).linear, image.linear);
}

#[test]
fn primitives_are_numbered_triangles_first() {
    let mut s = scene();
    let lamp = s.material(glowing(1.0));
    s.sphere(v(0.0, 0.0, 9.0), 1.0, lamp);
    s.cuboid(v(2.0, -1.0, 8.0), v(4.0, 1.0, 9.0), lamp);
    s.polygon(
        &[v(-1.0, 2.0, 8.0), v(1.0, 2.0, 8.0), v(2.0, 3.0, 8.0), v(0.0, 5.0, 8.0), v(-2.0, 3.0, 8.0)],
        lamp,
    );
    let id = |x: f64, y: f64, z: f64| probe(&s, DVec3::ZERO, v(x, y, z), 1).first_hit;
    // Five corners make three triangles (0 to 2), the box twelve (3 to 14), the ball comes last.
    assert_eq!(id(1.0, 2.4, 8.0), Some(0));
    assert_eq!(id(0.5, 4.0, 8.0), Some(1));
    assert_eq!(id(-1.0, 3.0, 8.0), Some(2));
    assert!(matches!(id(3.0, 0.2, 8.0), Some(3..=14)));
    assert_eq!(id(0.0, 0.0, 1.0), Some(15));
    assert_eq!(id(9.0, 9.0, 1.0), None);
}

#[test]
fn of_coincident_surfaces_the_first_is_seen() {
    let mut s = scene();
    for light in [0.25, 0.5, 1.0] {
        let lamp = s.material(glowing(light));
        s.polygon(&[v(-1.0, -1.0, 3.0), v(1.0, -1.0, 3.0), v(0.0, 2.0, 3.0)], lamp);
    }
    let sample = probe(&s, DVec3::ZERO, v(0.03, 0.1, 3.0), 1);
    assert_eq!((sample.first_hit, sample.radiance.x), (Some(0), 0.25));
    s.polygons.clear();
    s.sphere(v(0.0, 0.0, 5.0), 1.0, 1);
    s.sphere(v(0.0, 0.0, 5.0), 1.0, 2);
    s.sphere(v(0.0, 0.0, 6.0), 2.0, 0);
    assert_eq!(probe(&s, DVec3::ZERO, DVec3::Z, 1).radiance.x, 0.5);
    // A ball that touches a sheet: the sheet's number is smaller.
    s.rectangle(v(0.0, 0.0, 4.0), DVec3::X, DVec3::Y, 0);
    assert_eq!(probe(&s, DVec3::ZERO, DVec3::Z, 1).radiance.x, 0.25);
}

#[test]
fn a_triangle_without_area_keeps_its_number_and_is_never_hit() {
    let mut s = scene();
    let lamp = s.material(glowing(1.0));
    s.cuboid(v(-1.0, -1.0, 3.0), v(1.0, 1.0, 4.0), lamp);
    let before = probe(&s, DVec3::ZERO, v(0.1, 0.3, 3.0), 1).first_hit.unwrap();
    let mut flat = s.meshes[0].faces[0];
    flat.vertices[2] = flat.vertices[1];
    s.meshes[0].faces.insert(0, flat);
    assert_eq!(probe(&s, DVec3::ZERO, v(0.1, 0.3, 3.0), 1).first_hit, Some(before + 1));
}

#[test]
fn rays_are_counted_by_kind_and_depth() {
    let mut s = scene();
    let silver = s.material(mirror(0.5));
    s.rectangle(v(0.0, 0.0, -1.0), DVec3::X * 50.0, DVec3::Y * 50.0, silver);
    s.rectangle(v(0.0, 0.0, 1.0), DVec3::X * 50.0, DVec3::Y * 50.0, silver);
    s.light(v(0.0, 0.0, 0.5), DVec3::ONE);
    s.light(v(0.0, 0.0, 2.0), DVec3::ONE);
    s.camera = whitted::scene::Camera { width: 4, height: 4, look_at: v(0.1, 0.1, 1.0), ..s.camera };
    s.render.depth = 3;
    let rays = render(&s).rays;
    assert_eq!((rays.primary, rays.reflection, rays.refraction), (16, 32, 0));
    // The wall at z = 1 has the second light behind it, the one at z = -1 has both before it.
    assert_eq!(rays.shadow, 16 * (1 + 2 + 1));
    let rows: Vec<_> = rays.by_depth.iter().map(|r| (r.depth, r.traced, r.shadow)).collect();
    assert_eq!(rows, [(1, 16, 16), (2, 16, 32), (3, 16, 16)]);
    // Weightless children and black surfaces cost nothing.
    s.materials[silver].secondary = 1.0;
    assert_eq!(render(&s).rays.shadow, 0);
    s.materials[silver].secondary = 0.5;
    s.materials[silver].diffuse = DVec3::ZERO;
    assert_eq!(render(&s).rays.shadow, 0);
    s.materials[silver].fresnel = Fresnel::Constant(0.0);
    let rays = render(&s).rays;
    assert_eq!((rays.reflection, rays.refraction), (0, 16));
}

#[test]
fn pixels_lie_where_the_camera_says() {
    // A square that fills exactly the upper right quarter of the image.
    let mut s = scene();
    let lamp = s.material(glowing(1.0));
    s.camera.fov = std::f64::consts::FRAC_PI_2;
    s.camera.width = 8;
    s.camera.height = 4;
    // The camera looks along +z with +y up: its right is -x.
    s.polygon(&[v(0.0, 0.0, 1.0), v(-2.0, 0.0, 1.0), v(-2.0, 1.0, 1.0), v(0.0, 1.0, 1.0)], lamp);
    let image = render(&s);
    for y in 0..4 {
        for x in 0..8 {
            assert_eq!(image.linear[y * 8 + x].x == 1.0, y < 2 && x >= 4, "{x} {y}");
        }
    }
}
