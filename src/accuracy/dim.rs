//! What the pixels may hold at most where that is less than white, found from the scene before the first sample.
//!
//! A surface shows at most `own + s L`: its own colour under all lights, none of them hidden, at the least distance to
//! each; s its weight for secondary rays, L the scene's limit. A pixel shows the surfaces that project to it, and
//! the background. Boxes are halved as in [`bright`](super::bright), but only as far as it pays, and the image is
//! divided into blocks: what is said of a pixel is said of its block.

use super::bright::{dimmest, own_radiance};
use super::projection::{Projection, halves};
use super::radiance_bound::{ROUNDED_UP, Surface};
use crate::scene::Scene;

/// Blocks along the longer side of the image.
const BLOCKS: u32 = 128;
/// Boxes are halved until their radiance is known within this factor.
const KNOWN: f64 = 1.5;
/// Radiance below which no difference is made.
const LEAST: f64 = 1.0 / 64.0;
/// Boxes of all surfaces together...
const ALL_BOXES: usize = 1 << 16;
/// ...and of one.
const MOST_BOXES: usize = 1 << 10;

/// The greatest radiance of each block, at most 1.
pub struct Dim {
    side: u32,
    columns: u32,
    blocks: Vec<f32>,
    /// Left and top of the region.
    corner: [u32; 2],
}

impl Dim {
    /// Of the region that `image` has; `most` is the scene's limit.
    pub fn new(scene: &Scene, surfaces: &[Surface], most: f64, image: &Projection) -> Dim {
        let [x0, y0, x1, y1] = image.region;
        let side = (x1 - x0).max(y1 - y0).div_ceil(BLOCKS).max(1);
        let (columns, rows) = ((x1 - x0).div_ceil(side), (y1 - y0).div_ceil(side));
        let background = scene.render.background.max_element().clamp(LEAST, 1.0);
        let blocks = vec![background as f32; columns as usize * rows as usize];
        let mut dim = Dim { side, columns, blocks, corner: [x0, y0] };
        let boxes = (ALL_BOXES / surfaces.len().max(1)).clamp(1, MOST_BOXES);
        for surface in surfaces {
            // Nothing is shown of an unbounded limit where nothing is mirrored.
            let share = scene.materials[surface.material].secondary;
            let secondary = if share > 0.0 { share * most } else { 0.0 };
            let mut work = vec![surface.bounds];
            let mut made = 1;
            while let Some(part) = work.pop() {
                let Some(rectangle) = image.rectangle(&part) else { continue };
                let own = own_radiance(scene, surface, &part);
                let known = own <= (KNOWN * dimmest(scene, surface, &part)).max(LEAST) || secondary >= 1.0;
                let small = rectangle[2] - rectangle[0] <= f64::from(side)
                    && rectangle[3] - rectangle[1] <= f64::from(side);
                // What is known well may still be seen in less of the image than its box.
                let fits = made < boxes && !small && (part.hi - part.lo).max_element() > 0.0;
                // A box that reaches behind the eye has everything for its rectangle, which tells nothing.
                let wide = own + secondary > LEAST && rectangle == [0.0, 0.0, image.size[0], image.size[1]];
                if fits && (!known || wide) {
                    work.extend(halves(&part));
                    made += 1;
                } else {
                    dim.mark(rectangle, own + secondary, image);
                }
            }
        }
        dim
    }

    fn mark(&mut self, [left, top, right, bottom]: [f64; 4], radiance: f64, image: &Projection) {
        let radiance = ((radiance * ROUNDED_UP).min(1.0) as f32).next_up().min(1.0);
        let [x0, y0, x1, y1] = image.region;
        let blocks = |lo: f64, hi: f64, first: u32, end: u32| {
            let within = |x: f64| x.clamp(f64::from(first), f64::from(end));
            let (lo, hi) = (within(lo).floor() as u32, within(hi).ceil() as u32);
            (lo - first) / self.side..(hi - first).div_ceil(self.side)
        };
        let (columns, rows) = (blocks(left, right, x0, x1), blocks(top, bottom, y0, y1));
        for y in rows {
            for x in columns.clone() {
                let block = &mut self.blocks[(y * self.columns + x) as usize];
                *block = block.max(radiance);
            }
        }
    }

    /// Of a pixel of the image.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        let (x, y) = ((x - self.corner[0]) / self.side, (y - self.corner[1]) / self.side);
        self.blocks[(y * self.columns + x) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::super::radiance_bound::surfaces;
    use super::*;
    use crate::reference::oracle::Oracle;
    use crate::settings::Settings;

    const CAMERA: &str = "[camera]\nlook_from = [0.0, 0.4, 5.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 60.0\nwidth = 40\n\
        height = 30\n[material.paint]\ndiffuse = [0.9, 0.5, 0.3]\nambient = 0.05\n[material.mirror]\n\
        diffuse = [0.5, 0.5, 0.5]\nsecondary = 0.5\n[[light]]\nposition = [0.5, 1.0, 0.0]\nintensity = [0.6, 0.6, 0.6]\n";
    /// It reaches behind the eye.
    const FLOOR: &str = "[[polygon]]\nmaterial = \"paint\"\n\
        vertices = [[-9.0, -1.0, 9.0], [9.0, -1.0, 9.0], [9.0, -1.0, -9.0], [-9.0, -1.0, -9.0]]\n";
    const BALLS: &str = "[[sphere]]\ncenter = [-1.0, 0.5, 0.0]\nradius = 0.4\nmaterial = \"mirror\"\n\
        [[sphere]]\ncenter = [1.0, 0.2, -1.0]\nradius = 0.3\nmaterial = \"paint\"\n";

    /// No sample of the oracle is brighter than its pixel may be; a limit of half as much does not hold.
    #[test]
    fn no_sample_is_brighter_than_its_pixel_may_be() {
        let scene = Scene::parse(&format!("{CAMERA}{FLOOR}{BALLS}"), "dim.toml").expect("a scene");
        for crop in [None, Some([7, 5, 33, 29])] {
            let settings = Settings { samples: 16, depth: 6, crop, ..Settings::of(&scene) };
            let oracle = Oracle::new(&scene);
            let image = Projection::new(&scene, &settings);
            let most =
                super::super::radiance_bound::radiance_limit(&scene).rgb.into_iter().fold(0.0, f64::max);
            let dim = Dim::new(&scene, &surfaces(&scene), most, &image);
            let [x0, y0, x1, y1] = image.region;
            let (mut above_half, mut below_half) = (0, 0);
            for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                let limit = f64::from(dim.at(x, y));
                below_half += u32::from(limit < 0.5);
                for k in 0..16 {
                    let shown = oracle.sample(x, y, k, &settings).radiance;
                    let shown = (0..3).map(|c| shown[c]).fold(0.0, f64::max);
                    assert!(shown <= limit || limit == 1.0, "{x} {y}: {shown} {limit}");
                    above_half += u32::from(shown > 0.5 * limit);
                }
            }
            let pixels = (x1 - x0) * (y1 - y0);
            assert!(above_half > 0, "half the limit holds, too");
            assert!(below_half > pixels / 3, "{below_half} of {pixels} pixels are known to be dim");
        }
    }
}
