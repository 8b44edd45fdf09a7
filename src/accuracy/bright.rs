//! Where an image may hold radiance above white, found from the scene before the first sample.
//!
//! No ray carries more than the scene's limit L ([`radiance_bound`](super::radiance_bound)), but most pixels can show
//! far less: own colour is at most `(1 - s) diffuse (ambient + sum_l I_l / d_l^2)`, which exceeds white near lights
//! only. The box of each surface is halved until its part is about equally bright, and parts above white are projected.
//! A pixel that none of them touches shows white at most, and one that they touch holds no more of them than the sum
//! of their projected areas there. Shadows and surfaces in front are not taken into account: they only darken, or show
//! what has a box of its own. A surface of weight s for secondary rays may show `(1 - s) own + s L` anywhere on it.

use super::dim::Dim;
use super::projection::{MARGIN, Projection, halves};
use super::radiance_bound::{RadianceLimit, Surface, surfaces};
use super::unseen::{Cap, Caps};
use crate::scene::Scene;
use crate::scene::bounds::Bounds;
use crate::settings::Settings;
use glam::DVec3;

/// Boxes are halved until their radiance is known within this factor...
const KNOWN: f64 = 1.25;
/// ...or they are smaller than this many pixels...
const SMALL: f64 = 1.0;
/// ...or this many are made of one surface.
const MOST_BOXES: usize = 4096;

/// The caps of the pixels of the region that `settings` renders.
pub fn caps(scene: &Scene, settings: &Settings, limit: &RadianceLimit) -> Caps {
    let most = limit.rgb.iter().fold(0.0, |m: f64, c| m.max(*c));
    if scene.render.background.max_element() > 1.0 {
        return Caps::uniform(Cap { radiance: above(most), area: 1.0, mirrored: 0.0 });
    }
    let surfaces = surfaces(scene);
    let mut image = Marked::new(scene, settings);
    let dim = Dim::new(scene, &surfaces, most, &image.projection);
    for surface in &surfaces {
        let m = &scene.materials[surface.material];
        if m.secondary > 0.0 {
            let own = own_radiance(scene, surface, &surface.bounds).min(most);
            let mirrored = (1.0 - m.secondary) * own + m.secondary * most;
            if mirrored > 1.0 {
                image.mark(&surface.bounds, above(mirrored), true);
            }
        }
        mark_bright(scene, surface, most, &mut image);
    }
    image.caps(&dim)
}

/// The least f32 above.
fn above(x: f64) -> f32 {
    (x as f32).next_up()
}

/// Greatest own colour of the part of a surface in a box.
pub(super) fn own_radiance(scene: &Scene, surface: &Surface, part: &Bounds) -> f64 {
    let m = &scene.materials[surface.material];
    let mut light = DVec3::splat(m.ambient);
    for (l, source) in scene.lights.iter().enumerate() {
        let d = outside(part, source.position).max(surface.nearest[l]);
        light = DVec3::select(source.intensity.cmpgt(DVec3::ZERO), light + source.intensity / (d * d), light);
    }
    let shown = |c: usize| if m.diffuse[c] > 0.0 { m.diffuse[c] * light[c] } else { 0.0 };
    (1.0 - m.secondary) * (0..3).map(shown).fold(0.0, f64::max)
}

/// Own colour of that part where all lights are as far away as from any point of the box.
pub(super) fn dimmest(scene: &Scene, surface: &Surface, part: &Bounds) -> f64 {
    let m = &scene.materials[surface.material];
    let farthest = |p: DVec3| (part.hi - p).abs().max((part.lo - p).abs()).length_squared();
    let light = scene.lights.iter().map(|l| l.intensity / farthest(l.position)).sum::<DVec3>();
    (1.0 - m.secondary) * (m.diffuse * (DVec3::splat(m.ambient) + light)).max_element()
}

/// Marks the parts of a surface whose own colour may exceed white: its box, halved until what is in it is about
/// equally bright.
fn mark_bright(scene: &Scene, surface: &Surface, most: f64, image: &mut Marked) {
    let mut work = vec![surface.bounds];
    let mut made = 1;
    while let Some(part) = work.pop() {
        let own = own_radiance(scene, surface, &part);
        if own <= 1.0 {
            continue;
        }
        let size = part.hi - part.lo;
        let fine =
            own <= KNOWN * dimmest(scene, surface, &part) || made >= MOST_BOXES || image.is_small(&part);
        if fine || size.max_element() <= 0.0 {
            image.mark(&part, above(own.min(most)), false);
            continue;
        }
        work.extend(halves(&part));
        made += 1;
    }
}

/// Distance of a point from a box.
fn outside(bounds: &Bounds, p: DVec3) -> f64 {
    (bounds.lo - p).max(p - bounds.hi).max(DVec3::ZERO).length()
}

/// An image into which boxes are projected.
struct Marked {
    projection: Projection,
    pixels: Vec<Cap>,
}

impl Marked {
    fn new(scene: &Scene, settings: &Settings) -> Marked {
        let projection = Projection::new(scene, settings);
        let [x0, y0, x1, y1] = projection.region;
        let pixels = ((x1 - x0) * (y1 - y0)) as usize;
        Marked { projection, pixels: vec![Cap { radiance: 1.0, area: 0.0, mirrored: 0.0 }; pixels] }
    }

    /// True if the box is smaller than `SMALL` in the image, or not in it.
    fn is_small(&self, bounds: &Bounds) -> bool {
        self.projection.rectangle(bounds).is_none_or(|[left, top, right, bottom]| {
            let beside = right < 0.0
                || bottom < 0.0
                || left > self.projection.size[0]
                || top > self.projection.size[1];
            beside || (right - left).max(bottom - top) <= SMALL + 2.0 * MARGIN
        })
    }

    /// Marks the pixels that may hold a part of the box; `mirrored`: in mirrors and glass.
    fn mark(&mut self, bounds: &Bounds, radiance: f32, mirrored: bool) {
        let Some([left, top, right, bottom]) = self.projection.rectangle(bounds) else { return };
        let [x0, y0, x1, y1] = self.projection.region;
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

    /// A pixel that holds nothing bright may hold what `dim` says.
    fn caps(self, dim: &Dim) -> Caps {
        let [x0, y0, x1, _] = self.projection.region;
        let width = (x1 - x0) as usize;
        let cap = |(at, c): (usize, Cap)| match c.area > 0.0 {
            true => c,
            false => {
                let radiance = dim.at(x0 + (at % width) as u32, y0 + (at / width) as u32);
                Cap { radiance, area: 1.0, mirrored: c.mirrored }
            }
        };
        Caps::new(self.pixels.into_iter().enumerate().map(cap))
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
