//! Pixels that may hold something smaller than a pixel, found from the scene's geometry alone.
//!
//! A truth needs far more samples there: of a dot that covers 1e-4 of a pixel, a thousand samples mostly see nothing. The
//! pixels must not be chosen by what samples saw, or the truth would be biased: dots that were missed would stay missing.

use crate::scene::Scene;
use glam::DVec3;

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

/// Row * width + column of the pixels, in ascending order.
pub(super) fn pixels(scene: &Scene, width: u32, height: u32) -> Vec<u32> {
    let view = Projection::new(scene, width, height);
    let mut found = Vec::new();
    let mut add = |low: [f64; 2], high: [f64; 2]| {
        let clip = |x: f64, most: u32| x.floor().clamp(0.0, f64::from(most)) as u32;
        for y in clip(low[1], height)..clip(high[1] + 1.0, height) {
            found.extend((clip(low[0], width)..clip(high[0] + 1.0, width)).map(|x| y * width + x));
        }
    };
    for sphere in &scene.spheres {
        let Some(([x, y], scale)) = view.place(sphere.center) else { continue };
        // Off the axis the outline is longer than the radius, by up to the secant of the angle; twice is plenty.
        let reach = 2.0 * sphere.radius * scale;
        if sphere.radius * scale <= SMALL {
            add([x - reach, y - reach], [x + reach, y + reach]);
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
            add(low, high);
        }
    }
    for light in &scene.lights {
        let planes = scene.polygons.iter().filter_map(|polygon| {
            let foot =
                light.position - polygon.normal * (light.position - polygon.vertices[0]).dot(polygon.normal);
            polygon.triangles().any(|t| holds(&t, polygon.normal, foot)).then_some(foot)
        });
        let balls = scene.spheres.iter().filter_map(|sphere| {
            let away = (light.position - sphere.center).try_normalize()?;
            Some(sphere.center + away * sphere.radius)
        });
        for foot in planes.chain(balls) {
            let Some(([x, y], scale)) = view.place(foot) else { continue };
            if foot.distance(light.position) * scale <= CLOSE {
                add([x - AROUND, y - AROUND], [x + AROUND, y + AROUND]);
            }
        }
    }
    found.sort_unstable();
    found.dedup();
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
        let found = pixels(&scene, 40, 40);
        let spot = (9..=11).flat_map(|y| (28..=30).map(move |x| y * 40 + x));
        assert_eq!(found, std::iter::once(0).chain(spot).collect::<Vec<u32>>());
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
