//! The oracle: the scene's meaning, word for word, in `f64` and the user's units. It tries every
//! primitive for every ray and recurses along the path tree (Whitted, CACM 23(6), 1980). Nothing but
//! [`crate::settings::sampler`] is shared with the kernels that it judges.

mod geometry;
mod media;
mod optics;
mod trace;
mod world;

use crate::report::{DepthInfo, RayInfo};
use crate::scene::{Camera, Light, Material, Scene};
use crate::settings::Settings;
use crate::settings::sampler;
use geometry::Ray;
use glam::DVec3;
use media::Media;
use rayon::prelude::*;
use world::World;

/// A scene made ready to be judged by.
#[derive(Debug)]
pub struct Oracle {
    camera: Camera,
    background: DVec3,
    lights: Vec<Light>,
    materials: Vec<Material>,
    world: World,
    /// The solids around the eye.
    start: Media,
}

/// One sample of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Linear RGB, unclamped.
    pub radiance: DVec3,
    /// The primitive its primary ray hits: triangles are numbered first (polygons fanned from their first
    /// corner, then the meshes' faces, degenerate ones included), then spheres.
    pub first_hit: Option<u32>,
}

/// What [`Oracle::render`] gives back.
#[derive(Debug, Clone)]
pub struct OracleImage {
    /// Pixels of the region.
    pub width: u32,
    /// Pixels of the region.
    pub height: u32,
    /// Mean of each pixel's samples, linear RGB, unclamped, row by row from the top left.
    pub linear: Vec<DVec3>,
    /// [`Sample::first_hit`] of every sample; a pixel's samples lie side by side.
    pub first_hit: Vec<Option<u32>>,
    /// The rays that were traced; `by_depth` ends with the last depth that was reached.
    pub rays: RayInfo,
}

impl Oracle {
    /// Numbers the primitives and finds the solids the eye is in.
    pub fn new(scene: &Scene) -> Oracle {
        let world = World::new(scene);
        let start = Media::around(scene.camera.look_from, &world, &scene.materials);
        Oracle {
            camera: scene.camera,
            background: scene.render.background,
            lights: scene.lights.clone(),
            materials: scene.materials.clone(),
            world,
            start,
        }
    }

    /// Sample `k` of pixel (x, y) of the whole image.
    pub fn sample(&self, x: u32, y: u32, k: u32, settings: &Settings) -> Sample {
        self.sample_counted(x, y, k, settings, &mut RayInfo::default())
    }

    /// Renders the settings' region; the same bits whatever the number of threads.
    pub fn render(&self, settings: &Settings) -> OracleImage {
        let [x0, y0, x1, y1] = settings.region();
        let rows: Vec<_> = (y0..y1).into_par_iter().map(|y| self.render_row(y, x0..x1, settings)).collect();
        let mut image = OracleImage {
            width: x1 - x0,
            height: y1 - y0,
            linear: Vec::new(),
            first_hit: Vec::new(),
            rays: RayInfo::default(),
        };
        for (linear, first_hit, rays) in rows {
            image.linear.extend(linear);
            image.first_hit.extend(first_hit);
            add_rays(&mut image.rays, &rays);
        }
        image
    }

    fn render_row(
        &self,
        y: u32,
        columns: std::ops::Range<u32>,
        settings: &Settings,
    ) -> (Vec<DVec3>, Vec<Option<u32>>, RayInfo) {
        let mut rays = RayInfo::default();
        let mut first_hit = Vec::new();
        let linear = columns
            .map(|x| {
                let mut sum = DVec3::ZERO;
                for k in 0..settings.samples {
                    let sample = self.sample_counted(x, y, k, settings, &mut rays);
                    sum += sample.radiance;
                    first_hit.push(sample.first_hit);
                }
                sum / f64::from(settings.samples)
            })
            .collect();
        (linear, first_hit, rays)
    }

    fn sample_counted(&self, x: u32, y: u32, k: u32, settings: &Settings, rays: &mut RayInfo) -> Sample {
        let Settings { sampler, replicates, seed, samples, .. } = *settings;
        let offset = sampler::offset(sampler, replicates, seed, x, y, k, samples).map(f64::from);
        let ray = self.primary(f64::from(x) + offset[0], f64::from(y) + offset[1], settings);
        rays.primary += 1;
        let row = depth_row(rays, 1);
        (row.traced, row.primary) = (row.traced + 1, row.primary + 1);
        let hit = self.world.closest(&ray);
        let radiance = match &hit {
            Some(hit) => {
                trace::Path { oracle: self, depth: settings.depth, rays }.shade(&ray, hit, &self.start, 1)
            }
            None => self.background,
        };
        Sample { radiance, first_hit: hit.map(|hit| hit.id) }
    }

    /// The ray through image position (x, y), in pixels.
    fn primary(&self, x: f64, y: f64, settings: &Settings) -> Ray {
        let Camera { look_from, look_at, up, fov, .. } = self.camera;
        let (width, height) = (f64::from(settings.width), f64::from(settings.height));
        let forward = (look_at - look_from).normalize();
        let right = forward.cross(up).normalize();
        let upward = right.cross(forward);
        let half = (fov / 2.0).tan();
        let sx = (2.0 * x / width - 1.0) * half * width / height;
        let sy = (1.0 - 2.0 * y / height) * half;
        let direction = (forward + right * sx + upward * sy).normalize();
        Ray { origin: look_from, direction, from: None }
    }
}

/// The row of `depth`, counted from 1.
fn depth_row(rays: &mut RayInfo, depth: u32) -> &mut DepthInfo {
    let known = rays.by_depth.len() as u32;
    rays.by_depth.extend((known..depth).map(|d| DepthInfo { depth: d + 1, ..DepthInfo::default() }));
    &mut rays.by_depth[depth as usize - 1]
}

fn add_rays(sum: &mut RayInfo, part: &RayInfo) {
    sum.primary += part.primary;
    sum.reflection += part.reflection;
    sum.refraction += part.refraction;
    sum.shadow += part.shadow;
    for row in &part.by_depth {
        let total = depth_row(sum, row.depth);
        total.traced += row.traced;
        total.primary += row.primary;
        total.reflection += row.reflection;
        total.refraction += row.refraction;
        total.shadow += row.shadow;
    }
}
