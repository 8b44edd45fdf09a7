//! Lights of KHR_lights_punctual as point lights, and cameras.
//!
//! A surface of base colour c that receives the irradiance E has the radiance c E / pi; here it has `diffuse * intensity *
//! cos(a) / d^2`. A point light of I candela gives E = I cos(a) / d^2, so its `intensity` is I / pi. A spot light is the same
//! inside its cone, and here outside as well.
//!
//! A directional light of E lux from the direction w is a point light far away: at the distance D = 1000 R from the centre of the
//! model, whose bounding sphere has the radius R, with `intensity` E D^2 / pi. Within the model its irradiance is then off by
//! at most 1 - (1 - R/D)^-2, 0.2 %, and its direction by asin(R/D), 0.06 degrees.

use super::json::{self, Root};
use super::nodes::Visit;
use crate::scene::bounds::Bounds;
use crate::scene::error::SceneError;
use crate::scene::model_file::ModelFile;
use crate::scene::notes::Reading;
use crate::scene::table::{MAX_LENGTH, unit, within_f32};
use crate::scene::{Camera, Light, Transform};
use glam::DVec3;
use std::f64::consts::PI;

/// Distance of a directional light, in radii of the model.
const FAR: f64 = 1000.0;

/// Height of a camera's picture, pixels, and its width where it has no aspect ratio: those of `[camera]`.
const HEIGHT: f64 = 500.0;
const WIDTH: f64 = 600.0;

/// Reads the lights and cameras of `visits` in a scene whose shapes have the box `bounds`.
pub struct Punctual<'a, 'r> {
    pub file: ModelFile<'a>,
    pub root: &'r Root,
    pub place: Transform,
    pub bounds: Bounds,
}

impl Punctual<'_, '_> {
    /// All lights of `visits`, as the nearest point lights.
    pub fn lights(&self, visits: &[Visit], reading: &mut Reading) -> Result<Vec<Light>, SceneError> {
        let mut lights = Vec::new();
        let [mut directional, mut spots, mut odd] = [0; 3];
        let all = &self.root.extensions.lights.lights;
        for visit in visits.iter().filter(|v| v.wanted) {
            let Some(named) = &self.root.nodes[visit.node].extensions.light else { continue };
            let light = all
                .get(named.light)
                .ok_or_else(|| super::buffers::missing(self.file, "light", named.light, all.len()))?;
            let (position, intensity) = match light.kind.as_str() {
                "directional" => {
                    directional += 1;
                    self.directional(visit, light)
                }
                "point" | "spot" => {
                    spots += usize::from(light.kind == "spot");
                    (self.point(visit, DVec3::ZERO), light.intensity / PI)
                }
                _ => (DVec3::NAN, 0.0),
            };
            let intensity = DVec3::from_array(light.color) * intensity;
            let sound = position.abs().max_element() <= MAX_LENGTH && position.is_finite();
            if sound && intensity.to_array().into_iter().all(within_f32) {
                lights.push(Light { position, intensity });
            } else {
                odd += 1;
            }
        }
        let remedy = "write the lights into the scene, as `[[light]]`";
        let message = "a directional light becomes a point light at 1000 radii of the model";
        self.file.assume(reading, directional, message, remedy)?;
        let message = "a spot light becomes a point light: it shines outside its cone as well";
        self.file.assume(reading, spots, message, remedy)?;
        let message = "lights of an unknown type, or out of range, are left out";
        self.file.assume(reading, odd, message, remedy)?;
        Ok(lights)
    }

    /// The perspective cameras of `visits`.
    pub fn cameras(&self, visits: &[Visit], reading: &mut Reading) -> Result<Vec<Camera>, SceneError> {
        let mut cameras = Vec::new();
        let mut left_out = 0;
        for visit in visits.iter().filter(|v| v.wanted) {
            let Some(index) = self.root.nodes[visit.node].camera else { continue };
            let camera = self.root.cameras.get(index).ok_or_else(|| {
                super::buffers::missing(self.file, "camera", index, self.root.cameras.len())
            })?;
            match self.camera(visit, camera) {
                Some(camera) => cameras.push(camera),
                None => left_out += 1,
            }
        }
        let message = "orthographic cameras, and those with impossible angles, are left out";
        self.file.assume(reading, left_out, message, "write a `[camera]`")?;
        Ok(cameras)
    }

    /// Where a point of the node's space is in the scene.
    fn point(&self, visit: &Visit, point: DVec3) -> DVec3 {
        self.place.point(visit.world.transform_point3(point))
    }

    /// A direction of the node's space in the scene.
    fn direction(&self, visit: &Visit, direction: DVec3) -> Option<DVec3> {
        Some(self.point(visit, direction) - self.point(visit, DVec3::ZERO))
            .filter(|d| d.is_finite())
            .and_then(unit)
    }

    /// A directional light shines along the node's -z.
    fn directional(&self, visit: &Visit, light: &json::Light) -> (DVec3, f64) {
        let Some(along) = self.direction(visit, DVec3::NEG_Z) else { return (DVec3::NAN, 0.0) };
        let (center, radius) = match self.bounds.is_empty() {
            true => (self.point(visit, DVec3::ZERO), 1.0),
            false => {
                let center = self.bounds.lo * 0.5 + self.bounds.hi * 0.5;
                (center, center.distance(self.bounds.hi))
            }
        };
        let distance = FAR * if radius > 0.0 { radius } else { 1.0 };
        (center - distance * along, light.intensity * distance * distance / PI)
    }

    /// A camera looks along its node's -z, with y up.
    fn camera(&self, visit: &Visit, camera: &json::Camera) -> Option<Camera> {
        // As for `[camera]`: what is parallel up to this has no right side.
        const LEAST_SINE: f64 = 1e-6;
        let perspective = camera.perspective.as_ref().filter(|_| camera.kind == "perspective")?;
        let fov = perspective.yfov;
        let look_from = self.point(visit, DVec3::ZERO);
        let forward = self.direction(visit, DVec3::NEG_Z)?;
        let up = self.direction(visit, DVec3::Y)?;
        // Any point on the axis serves; one as far as the model is easy to read in a scene file.
        let center = self.bounds.lo * 0.5 + self.bounds.hi * 0.5;
        let distance = if self.bounds.is_empty() { 1.0 } else { (center - look_from).dot(forward) };
        let look_at = look_from + forward * if distance > 0.0 { distance } else { 1.0 };
        let possible = fov < PI && (fov / 2.0).tan() > 0.0;
        let sound = look_from.abs().max_element() <= MAX_LENGTH && look_at.abs().max_element() <= MAX_LENGTH;
        if !possible || !sound || look_at == look_from || up.cross(forward).length() < LEAST_SINE {
            return None;
        }
        let ratio = perspective.aspect_ratio.filter(|ratio| *ratio > 0.0 && ratio.is_finite());
        let width = ratio.map_or(WIDTH, |ratio| (HEIGHT * ratio).round().clamp(1.0, 65_535.0));
        Some(Camera { look_from, look_at, up, fov, width: width as u32, height: HEIGHT as u32 })
    }
}
