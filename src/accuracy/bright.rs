//! Where an image may hold radiance above white, found from the scene before the first sample.
//!
//! No ray carries more than the scene's limit L ([`radiance_bound`](super::radiance_bound)). Most pixels can show
//! far less: a surface of weight s for secondary rays shows (1 - s) own + s L at most, and own colour
//! `diffuse (ambient + sum_l I_l / d_l^2)` exceeds white only near lights: with n lights one of them must give
//! more than (1 - diffuse ambient)/n, so the surface lies within `sqrt(n diffuse I_l / (1 - diffuse ambient))` of
//! it. The boxes of such parts of the scene are projected; a pixel none of them touches shows white at most, and one
//! that they touch holds no more of them than the sum of their projected areas there. Shadows and surfaces in front
//! are not taken into account: they only darken, or show what has a box of its own. Mirrors and glass are taken to
//! show the brightest of the scene anywhere on them.

use super::radiance_bound::{RadianceLimit, Surface, surfaces};
use super::unseen::{Cap, Caps};
use crate::scene::Scene;
use crate::scene::bounds::Bounds;
use crate::settings::Settings;
use glam::DVec3;

/// Rounding of projected coordinates, pixels: f64 has more than enough digits, f32 rays do not.
const MARGIN: f64 = 1e-3;

/// The caps of the pixels of the region that `settings` renders.
pub fn caps(scene: &Scene, settings: &Settings, limit: &RadianceLimit) -> Caps {
    let most = limit.rgb.iter().fold(0.0, |m: f64, c| m.max(*c));
    if most <= 1.0 || scene.render.background.max_element() > 1.0 {
        return Caps::uniform(Cap { radiance: above(most), area: 1.0 });
    }
    let mut image = Projection::new(scene, settings);
    for surface in surfaces(scene) {
        for (bounds, radiance) in bright_parts(scene, &surface, most) {
            image.mark(&bounds, above(radiance));
        }
    }
    image.caps()
}

/// The least f32 above.
fn above(x: f64) -> f32 {
    (x as f32).next_up()
}

/// Boxes around the parts of a surface that may exceed white, and their greatest radiance.
fn bright_parts(scene: &Scene, surface: &Surface, most: f64) -> Vec<(Bounds, f64)> {
    let m = &scene.materials[surface.material];
    let own = |bounds: &Bounds| -> f64 {
        let light = scene.lights.iter().fold(DVec3::splat(m.ambient), |sum, l| {
            let d = outside(bounds, l.position);
            DVec3::select(l.intensity.cmpgt(DVec3::ZERO), sum + l.intensity / (d * d), sum)
        });
        let shown = |c: usize| if m.diffuse[c] > 0.0 { m.diffuse[c] * light[c] } else { 0.0 };
        (0..3).map(shown).fold(0.0, f64::max).min(most)
    };
    let whole = (1.0 - m.secondary) * own(&surface.bounds) + m.secondary * most;
    if whole <= 1.0 {
        return Vec::new();
    }
    let dark = m.diffuse.max_element() * m.ambient;
    if m.secondary > 0.0 || dark >= 1.0 {
        return vec![(surface.bounds, whole)];
    }
    let count = scene.lights.len() as f64;
    let near = |light: &crate::scene::Light| {
        let brightest = (m.diffuse * light.intensity).max_element();
        let reach = (count * brightest.max(0.0) / (1.0 - dark)).sqrt();
        let ball = Bounds::of_sphere(light.position, reach);
        let part = Bounds { lo: ball.lo.max(surface.bounds.lo), hi: ball.hi.min(surface.bounds.hi) };
        (!part.is_empty() && outside(&surface.bounds, light.position) <= reach).then(|| (part, own(&part)))
    };
    scene.lights.iter().filter_map(near).collect()
}

/// Distance of a point from a box.
fn outside(bounds: &Bounds, p: DVec3) -> f64 {
    (bounds.lo - p).max(p - bounds.hi).max(DVec3::ZERO).length()
}

/// An image into which boxes are projected.
struct Projection {
    eye: DVec3,
    /// View direction, and image axes divided by half the image's size at distance 1.
    forward: DVec3,
    right: DVec3,
    down: DVec3,
    size: [f64; 2],
    region: [u32; 4],
    pixels: Vec<Cap>,
}

impl Projection {
    fn new(scene: &Scene, settings: &Settings) -> Projection {
        let c = &scene.camera;
        let forward = (c.look_at - c.look_from).normalize();
        let right = forward.cross(c.up).normalize();
        let half_height = (c.fov / 2.0).tan();
        let half_width = half_height * f64::from(settings.width) / f64::from(settings.height);
        let region = settings.region();
        let [x0, y0, x1, y1] = region;
        Projection {
            eye: c.look_from,
            forward,
            right: right / half_width,
            down: -right.cross(forward) / half_height,
            size: [settings.width, settings.height].map(f64::from),
            region,
            pixels: vec![Cap { radiance: 1.0, area: 0.0 }; ((x1 - x0) * (y1 - y0)) as usize],
        }
    }

    /// The rectangle of the image that holds a box, pixels; `None` if the box is behind the eye, everything if it is
    /// on both sides.
    fn rectangle(&self, bounds: &Bounds) -> Option<[f64; 4]> {
        let [width, height] = self.size;
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut before, mut behind) = (false, false);
        for corner in bounds.corners() {
            let v = corner - self.eye;
            let z = v.dot(self.forward);
            if z <= 1e-9 * v.length() {
                behind = true;
                continue;
            }
            before = true;
            let at =
                [(v.dot(self.right) / z + 1.0) * 0.5 * width, (v.dot(self.down) / z + 1.0) * 0.5 * height];
            for i in 0..2 {
                (lo[i], hi[i]) = (lo[i].min(at[i]), hi[i].max(at[i]));
            }
        }
        match (before, behind) {
            (false, _) => None,
            (true, true) => Some([0.0, 0.0, width, height]),
            (true, false) => Some([lo[0] - MARGIN, lo[1] - MARGIN, hi[0] + MARGIN, hi[1] + MARGIN]),
        }
    }

    /// Marks the pixels that may hold a part of the box.
    fn mark(&mut self, bounds: &Bounds, radiance: f32) {
        let Some([left, top, right, bottom]) = self.rectangle(bounds) else { return };
        let [x0, y0, x1, y1] = self.region;
        // Pixels of the region that the range touches, from its start.
        let range = |lo: f64, hi: f64, first: u32, end: u32| {
            let within = |x: f64| x.clamp(f64::from(first), f64::from(end));
            within(lo).floor() as u32..within(hi).ceil() as u32
        };
        // A rectangle that no 1 % of a pixel is left out of may be any part of it: a sphere's rim, a thin triangle.
        for y in range(top, bottom, y0, y1) {
            let rows = bottom.min(f64::from(y + 1)) - top.max(f64::from(y));
            for x in range(left, right, x0, x1) {
                let columns = right.min(f64::from(x + 1)) - left.max(f64::from(x));
                let cap = &mut self.pixels[((y - y0) * (x1 - x0) + x - x0) as usize];
                cap.radiance = cap.radiance.max(radiance);
                cap.area = (cap.area + (rows * columns) as f32 * 1.001).min(1.0);
            }
        }
    }

    /// A pixel that holds nothing bright may hold anything up to white.
    fn caps(self) -> Caps {
        Caps::new(self.pixels.into_iter().map(|c| if c.area > 0.0 { c } else { Cap::WHITE }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::radiance_bound::radiance_limit;
    use super::*;
    use crate::reference::oracle::Oracle;

    fn scene(body: &str) -> Scene {
        let text = format!(
            "[camera]\nlook_from = [0.0, 0.0, 5.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 60.0\nwidth = 40\nheight = 30\n\
             [material.paint]\ndiffuse = [0.9, 0.9, 0.9]\n[material.lamp]\ndiffuse = [1.0, 1.0, 1.0]\nambient = 30.0\n\
             [material.mirror]\ndiffuse = [0.5, 0.5, 0.5]\nsecondary = 0.8\n{body}"
        );
        Scene::parse(&text, "bright.toml").expect("a scene")
    }

    fn caps_of(scene: &Scene) -> Caps {
        caps(scene, &Settings::of(scene), &radiance_limit(scene))
    }

    const FLOOR: &str = "[[polygon]]\nmaterial = \"paint\"\n\
        vertices = [[-3.0, -1.0, 3.0], [3.0, -1.0, 3.0], [3.0, -1.0, -3.0], [-3.0, -1.0, -3.0]]\n";

    /// No sample of the oracle that exceeds white lies in a pixel whose cap is white; a defect that is planted:
    /// the radius around lights halved.
    #[test]
    fn what_is_brighter_than_white_is_where_it_is_said() {
        let lamp = "[[light]]\nposition = [0.5, -0.6, 0.0]\nintensity = [2.0, 2.0, 2.0]\n";
        let ball = "[[sphere]]\ncenter = [-1.0, 0.5, 0.0]\nradius = 0.4\nmaterial = \"mirror\"\n";
        for body in [format!("{FLOOR}{lamp}"), format!("{FLOOR}{lamp}{ball}")] {
            let scene = scene(&body);
            let caps = caps_of(&scene);
            let settings = Settings { samples: 16, ..Settings::of(&scene) };
            let oracle = Oracle::new(&scene);
            let (mut bright, mut white) = (0, 0);
            for p in 0..1200 {
                white += u32::from(caps.of(p).radiance <= 1.0);
                for k in 0..16 {
                    let radiance = oracle.sample(p as u32 % 40, p as u32 / 40, k, &settings).radiance;
                    let most = (0..3).map(|c| radiance[c]).fold(0.0, f64::max);
                    bright += u32::from(most > 1.0);
                    assert!(most <= f64::from(caps.of(p).radiance), "pixel {p}: {most} {:?}", caps.of(p));
                }
            }
            assert!(bright > 100 && white > 100, "{bright} bright samples, {white} pixels of at most white");
        }
    }

    #[test]
    fn a_small_lamp_has_the_area_of_its_box() {
        let dot = "[[sphere]]\ncenter = [0.1, 0.1, 0.0]\nradius = 0.005\nmaterial = \"lamp\"\n";
        let caps = caps_of(&scene(&format!("{FLOOR}{dot}")));
        let marked: Vec<usize> = (0..1200).filter(|p| caps.of(*p).radiance > 1.0).collect();
        // Pixels are 0.192 wide there, the sphere 0.01: 0.0027 of one.
        let [pixel] = marked[..] else { panic!("{marked:?}") };
        assert!((0.0027..=1.0 / 128.0).contains(&caps.of(pixel).area), "{:?}", caps.of(pixel));
        assert!(caps.of(pixel).radiance > 30.0 && caps.of(pixel).radiance < 30.1);
    }

    #[test]
    fn dark_scenes_have_their_own_limit() {
        let caps = caps_of(&scene(FLOOR));
        assert_eq!(caps.group(7), 0);
        assert!(caps.of(7).radiance < 0.1, "{:?}", caps.of(7));
    }
}
