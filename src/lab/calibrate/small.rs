//! Pixels that may hold something smaller than a pixel, found from the scene's geometry alone.
//!
//! A truth needs far more samples there: of a dot that covers 1e-4 of a pixel, a thousand samples mostly see nothing. The
//! pixels must not be chosen by what samples saw, or the truth would be biased: dots that were missed would stay missing.
//! Where even those samples meet a thing a few times only, their spread says little about the truth's own error: that
//! follows from the thing's area and radiance instead ([`Small::variance`]).

use crate::scene::Scene;
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Largest radius of a small sphere, and half of the largest width of a small polygon, pixels.
const SMALL: f64 = 1.5;
/// A light is close to a surface if its distance is less than this many pixels.
const CLOSE: f64 = 1.0;
/// Pixels around the spot under a close light that are taken as well.
const AROUND: f64 = 1.0;

/// The camera's axes, scaled to pixels.
struct Projection {
    from: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per unit at distance 1.
    scale: f64,
    size: [f64; 2],
}

impl Projection {
    fn new(scene: &Scene, width: u32, height: u32) -> Projection {
        let camera = &scene.camera;
        let [right, up, forward] = camera.axes();
        Projection {
            from: camera.look_from,
            right,
            up,
            forward,
            scale: f64::from(height) / (2.0 * (camera.fov / 2.0).tan()),
            size: [f64::from(width), f64::from(height)],
        }
    }

    /// Column and row, and pixels per unit there; `None` behind the eye.
    fn place(&self, point: DVec3) -> Option<([f64; 2], f64)> {
        let to = point - self.from;
        let depth = to.dot(self.forward);
        let scale = self.scale / depth;
        let [width, height] = self.size;
        (depth > 0.0).then(|| {
            ([width / 2.0 + to.dot(self.right) * scale, height / 2.0 - to.dot(self.up) * scale], scale)
        })
    }
}

/// Expected number of samples that meet a thing from which on their spread is trusted.
const FEW: f64 = 30.0;

/// A thing smaller than a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Small {
    /// Its area, pixels.
    area: f64,
    /// Mean of its squared radiance, greatest channel.
    square: f64,
}

impl Small {
    /// Variance of the mean of `samples` samples of a pixel that holds it, as shown, if they are too few to tell: a share
    /// a of radiance L has a L^2 / n.
    pub(super) fn variance(&self, samples: f64) -> f64 {
        match self.area * samples < FEW {
            true => (self.area * self.square / samples).min(1.0),
            false => 0.0,
        }
    }
}

/// Radiance of a surface's own colour, greatest channel, where its lights are at the distances that `at` has from them.
fn radiance(scene: &Scene, material: usize, at: DVec3) -> f64 {
    let m = &scene.materials[material];
    let light = |sum: DVec3, l: &crate::scene::Light| sum + l.intensity / l.position.distance_squared(at);
    ((1.0 - m.secondary) * m.diffuse * scene.lights.iter().fold(DVec3::splat(m.ambient), light)).max_element()
}

/// Row * width + column of the pixels, each with what it may hold.
pub(super) fn pixels(scene: &Scene, width: u32, height: u32) -> BTreeMap<u32, Vec<Small>> {
    let view = Projection::new(scene, width, height);
    let mut found: BTreeMap<u32, Vec<Small>> = BTreeMap::new();
    let mut add = |low: [f64; 2], high: [f64; 2], small: Small| {
        let clip = |x: f64, most: u32| x.floor().clamp(0.0, f64::from(most)) as u32;
        for y in clip(low[1], height)..clip(high[1] + 1.0, height) {
            for x in clip(low[0], width)..clip(high[0] + 1.0, width) {
                found.entry(y * width + x).or_default().push(small);
            }
        }
    };
    for sphere in &scene.spheres {
        let Some(([x, y], scale)) = view.place(sphere.center) else { continue };
        // Off the axis the outline is longer than the radius, by up to the secant of the angle; twice is plenty.
        let reach = 2.0 * sphere.radius * scale;
        if sphere.radius * scale <= SMALL {
            let shown = radiance(scene, sphere.material, sphere.center);
            let area = (PI * (sphere.radius * scale).powi(2)).min(1.0);
            add([x - reach, y - reach], [x + reach, y + reach], Small { area, square: shown * shown });
        }
    }
    for polygon in &scene.polygons {
        let places: Option<Vec<[f64; 2]>> =
            polygon.vertices.iter().map(|v| view.place(*v).map(|(place, _)| place)).collect();
        let Some(places) = places else { continue };
        let end = |from: f64, pick: fn(f64, f64) -> f64| {
            [0, 1].map(|axis| places.iter().fold(from, |m, p| pick(m, p[axis])))
        };
        let (low, high) = (end(f64::INFINITY, f64::min), end(f64::NEG_INFINITY, f64::max));
        if (0..2).all(|axis| high[axis] - low[axis] <= 2.0 * SMALL) {
            let around = |i: usize| (places[i], places[(i + 1) % places.len()]);
            let twice = (0..places.len()).map(around).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>();
            let middle = polygon.vertices.iter().sum::<DVec3>() / polygon.vertices.len() as f64;
            let shown = radiance(scene, polygon.material, middle);
            add(low, high, Small { area: (twice.abs() / 2.0).min(1.0), square: shown * shown });
        }
    }
    for light in &scene.lights {
        let planes = scene.polygons.iter().filter_map(|polygon| {
            let foot =
                light.position - polygon.normal * (light.position - polygon.vertices[0]).dot(polygon.normal);
            let mut triangles = polygon.triangles();
            triangles.any(|t| holds(&t, polygon.normal, foot)).then_some((foot, polygon.material))
        });
        let balls = scene.spheres.iter().filter_map(|sphere| {
            let away = (light.position - sphere.center).try_normalize()?;
            Some((sphere.center + away * sphere.radius, sphere.material))
        });
        for (foot, material) in planes.chain(balls) {
            let Some(([x, y], scale)) = view.place(foot) else { continue };
            let height = foot.distance(light.position);
            if height * scale <= CLOSE {
                // The light's spot, I h / (h^2 + r^2)^(3/2), has half of its peak's square within about this area.
                let area = (PI * (0.5 * height * scale).powi(2)).min(1.0);
                let shown = radiance(scene, material, foot);
                add(
                    [x - AROUND, y - AROUND],
                    [x + AROUND, y + AROUND],
                    Small { area, square: shown * shown },
                );
            }
        }
    }
    found
}

/// True if a point of the plane lies in the triangle, whose corners are counter-clockwise about `normal`.
fn holds(corners: &[DVec3; 3], normal: DVec3, point: DVec3) -> bool {
    (0..corners.len()).all(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        (b - a).cross(point - a).dot(normal) >= 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural::families::Family;

    const SCENE: &str = r#"
        [camera]
        look_from = [0, 0, 4]
        look_at = [0, 0, 0]
        fov = 53.13010235415598
        width = 40
        height = 40
        [[light]]
        position = [0.95, 0.95, 0.01]
        intensity = 1
        [material.m]
        diffuse = [1, 1, 1]
        [[polygon]]
        vertices = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]
        material = "m"
        [[sphere]]
        center = [-1.95, 1.95, 0]
        radius = 0.001
        material = "m"
    "#;

    /// Ten pixels a unit: the dot is in the top left pixel, the spot under the light in column 29, row 10.
    #[test]
    fn dots_and_spots_under_lights_are_found_and_large_things_are_not() {
        let scene = Scene::parse(SCENE, "small.toml").unwrap();
        let small = pixels(&scene, 40, 40);
        let found: Vec<u32> = small.keys().copied().collect();
        let spot = (9..=11).flat_map(|y| (28..=30).map(move |x| y * 40 + x));
        assert_eq!(found, std::iter::once(0).chain(spot).collect::<Vec<u32>>());
        // A dot of 3e-4 pixels, lit by the light at distance 3.07 and by the ambient share of 0.1.
        let dot = small[&0][0];
        assert!((dot.area - PI * 1e-4).abs() < 2e-6 && (dot.square.sqrt() - 0.206).abs() < 0.01, "{dot:?}");
        assert_eq!((dot.variance(1e6), dot.variance(10.0)), (0.0, dot.area * dot.square / 10.0));
    }

    #[test]
    fn scenes_of_dots_have_such_pixels_and_corridors_have_few() {
        let count = |family: Family| {
            (0..10).map(|n| pixels(&family.scene(n, 1, [96, 72]).unwrap(), 96, 72).len()).sum::<usize>()
        };
        let [dots, corridor] = [Family::BrightDots, Family::Corridor].map(count);
        assert!(dots > 4 * corridor, "{dots} {corridor}");
    }
}
