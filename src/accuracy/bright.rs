//! Where an image may hold radiance above white, found from the scene before the first sample.
//!
//! No ray carries more than the scene's limit L ([`radiance_bound`](super::radiance_bound)), but most pixels can show
//! far less: own colour is at most `(1 - s) diffuse (ambient + sum_l I_l / d_l^2)`, which exceeds white near lights
//! only. The box of each surface is halved until its part is about equally bright, and parts above white are projected.
//! A pixel that none of them touches shows white at most, and one that they touch holds no more of them than the sum
//! of their projected areas there. Shadows and surfaces in front are not taken into account: they only darken, or show
//! what has a box of its own. A surface of weight s for secondary rays may show `(1 - s) own + s L` anywhere on it.

use super::radiance_bound::{RadianceLimit, Surface, surfaces};
use super::unseen::{Cap, Caps};
use crate::scene::Scene;
use crate::scene::bounds::Bounds;
use crate::settings::Settings;
use glam::DVec3;

/// Rounding of projected coordinates, pixels: f64 has more than enough digits, f32 rays do not.
const MARGIN: f64 = 1e-3;

/// Boxes are halved until their radiance is known within this factor...
const KNOWN: f64 = 1.25;
/// ...or they are smaller than this many pixels...
const SMALL: f64 = 1.0;
/// ...or this many are made of one surface.
const MOST_BOXES: usize = 4096;

/// The caps of the pixels of the region that `settings` renders.
pub fn caps(scene: &Scene, settings: &Settings, limit: &RadianceLimit) -> Caps {
    let most = limit.rgb.iter().fold(0.0, |m: f64, c| m.max(*c));
    if most <= 1.0 || scene.render.background.max_element() > 1.0 {
        return Caps::uniform(Cap { radiance: above(most), area: 1.0, mirrored: 0.0 });
    }
    let mut image = Projection::new(scene, settings);
    for surface in surfaces(scene) {
        let m = &scene.materials[surface.material];
        if m.secondary > 0.0 {
            let own = own_radiance(scene, &surface, &surface.bounds).min(most);
            let mirrored = (1.0 - m.secondary) * own + m.secondary * most;
            if mirrored > 1.0 {
                image.mark(&surface.bounds, above(mirrored), true);
            }
        }
        mark_bright(scene, &surface, most, &mut image);
    }
    image.caps()
}

/// The least f32 above.
fn above(x: f64) -> f32 {
    (x as f32).next_up()
}

/// Greatest own colour of the part of a surface in a box.
fn own_radiance(scene: &Scene, surface: &Surface, part: &Bounds) -> f64 {
    let m = &scene.materials[surface.material];
    let mut light = DVec3::splat(m.ambient);
    for (l, source) in scene.lights.iter().enumerate() {
        let d = outside(part, source.position).max(surface.nearest[l]);
        light = DVec3::select(source.intensity.cmpgt(DVec3::ZERO), light + source.intensity / (d * d), light);
    }
    let shown = |c: usize| if m.diffuse[c] > 0.0 { m.diffuse[c] * light[c] } else { 0.0 };
    (1.0 - m.secondary) * (0..3).map(shown).fold(0.0, f64::max)
}

/// Marks the parts of a surface whose own colour may exceed white: its box, halved until what is in it is about
/// equally bright.
fn mark_bright(scene: &Scene, surface: &Surface, most: f64, image: &mut Projection) {
    let m = &scene.materials[surface.material];
    let dimmest = |part: &Bounds| {
        let farthest = |p: DVec3| (part.hi - p).abs().max((part.lo - p).abs()).length_squared();
        let light = scene.lights.iter().map(|l| l.intensity / farthest(l.position)).sum::<DVec3>();
        (1.0 - m.secondary) * (m.diffuse * (DVec3::splat(m.ambient) + light)).max_element()
    };
    let mut work = vec![surface.bounds];
    let mut made = 1;
    while let Some(part) = work.pop() {
        let own = own_radiance(scene, surface, &part);
        if own <= 1.0 {
            continue;
        }
        let size = part.hi - part.lo;
        let fine = own <= KNOWN * dimmest(&part) || made >= MOST_BOXES || image.is_small(&part);
        if fine || size.max_element() <= 0.0 {
            image.mark(&part, above(own.min(most)), false);
            continue;
        }
        let axis = if size.x >= size.y.max(size.z) {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let middle = 0.5 * (part.lo[axis] + part.hi[axis]);
        let (mut low, mut high) = (part, part);
        (low.hi[axis], high.lo[axis]) = (middle, middle);
        work.extend([low, high]);
        made += 1;
    }
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
        let [right, up, forward] = c.axes();
        let half_height = (c.fov / 2.0).tan();
        let half_width = half_height * f64::from(settings.width) / f64::from(settings.height);
        let region = settings.region();
        let [x0, y0, x1, y1] = region;
        Projection {
            eye: c.look_from,
            forward,
            right: right / half_width,
            down: -up / half_height,
            size: [settings.width, settings.height].map(f64::from),
            region,
            pixels: vec![Cap { radiance: 1.0, area: 0.0, mirrored: 0.0 }; ((x1 - x0) * (y1 - y0)) as usize],
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

    /// True if the box is smaller than `SMALL` in the image, or not in it.
    fn is_small(&self, bounds: &Bounds) -> bool {
        self.rectangle(bounds).is_none_or(|[left, top, right, bottom]| {
            let beside = right < 0.0 || bottom < 0.0 || left > self.size[0] || top > self.size[1];
            beside || (right - left).max(bottom - top) <= SMALL + 2.0 * MARGIN
        })
    }

    /// Marks the pixels that may hold a part of the box; `mirrored`: in mirrors and glass.
    fn mark(&mut self, bounds: &Bounds, radiance: f32, mirrored: bool) {
        let Some([left, top, right, bottom]) = self.rectangle(bounds) else { return };
        let [x0, y0, x1, y1] = self.region;
        // Pixels of the region that the range touches, from its start.
        let range = |lo: f64, hi: f64, first: u32, end: u32| {
            let within = |x: f64| x.clamp(f64::from(first), f64::from(end));
            within(lo).floor() as u32..within(hi).ceil() as u32
        };
        for y in range(top, bottom, y0, y1) {
            let rows = bottom.min(f64::from(y + 1)) - top.max(f64::from(y));
            for x in range(left, right, x0, x1) {
                let columns = right.min(f64::from(x + 1)) - left.max(f64::from(x));
                let cap = &mut self.pixels[((y - y0) * (x1 - x0) + x - x0) as usize];
                if mirrored {
                    cap.mirrored = cap.mirrored.max(radiance);
                    continue;
                }
                cap.radiance = cap.radiance.max(radiance);
                cap.area = (cap.area + (rows * columns) as f32 * 1.001).min(1.0);
            }
        }
    }

    /// A pixel that holds nothing bright may hold anything up to white.
    fn caps(self) -> Caps {
        let cap = |c: Cap| if c.area > 0.0 { c } else { Cap { mirrored: c.mirrored, ..Cap::WHITE } };
        Caps::new(self.pixels.into_iter().map(cap))
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
                    let cap = caps.of(p);
                    let limit = f64::from(cap.radiance.max(cap.mirrored));
                    assert!(most <= limit, "pixel {p}: {most} {cap:?}");
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
        assert!(caps.of(pixel).radiance > 30.0 && caps.of(pixel).radiance < 36.0);
    }

    #[test]
    fn dark_scenes_have_their_own_limit() {
        let caps = caps_of(&scene(FLOOR));
        assert!(caps.of(7).radiance < 0.1, "{:?}", caps.of(7));
    }
}
