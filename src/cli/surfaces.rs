//! Alpha and layers of the first surfaces, from arguments to channels and pictures.

use super::args::RenderArgs;
use super::failure::Failure;
use super::progress::{Progress, Style};
use crate::accuracy::promise::Layer;
use crate::image::{Format, Metadata};
use crate::lab::surface_pictures::{self, SurfacePicture};
use crate::render::{Rendered, Renderer, SurfaceLayer, Surfaces};
use crate::report::{Report, SettingsInfo};
use crate::scene::Scene;
use crate::settings::Schedule;
use anyhow::Context;
use std::io;

/// What was found of them, and what is behind.
#[derive(Default)]
pub(crate) struct FirstSurfaces {
    pub(crate) found: Surfaces,
    /// Radiance of what meets nothing, linear RGB.
    background: [f32; 3],
}

/// Checks, before the work starts, that `format` has room for what is asked for.
pub(crate) fn check(args: &RenderArgs, format: Format) -> Result<(), Failure> {
    match args.alpha && !format.holds_alpha() {
        true => Err(Failure::Usage("--alpha needs a PNG or an EXR: the other formats hold no alpha".into())),
        false => Ok(()),
    }
}

impl FirstSurfaces {
    /// Traces what `args` ask for, with the samples of the picture of `report`; `None` if interrupted.
    pub(crate) fn trace(
        args: &RenderArgs,
        scene: &Scene,
        report: &Report,
        renderer: &mut Renderer,
        style: Style,
    ) -> Result<Option<FirstSurfaces>, Failure> {
        if !args.alpha && args.layers.is_empty() {
            return Ok(Some(FirstSurfaces::default()));
        }
        let schedule = Schedule { share: Default::default(), ..args.schedule.schedule() };
        // A picture of --time may have less than one sample per pixel.
        let chosen = SettingsInfo { samples: report.settings.samples.max(1), ..report.settings.clone() };
        let settings = chosen.to_settings(schedule).map_err(|why| anyhow::anyhow!(why))?;
        let mut progress = Progress::new(style, "first surfaces");
        let found = renderer.surfaces(scene, &settings, args.alpha, &args.layers, &mut progress)?;
        let background = scene.render.background.as_vec3().to_array();
        Ok(found.map(|found| FirstSurfaces { found, background }))
    }

    /// The light of what covers each pixel, multiplied by how much of it that is; `None` without alpha.
    pub(crate) fn without_background(&self, linear: &[[f32; 3]]) -> Option<Vec<[f32; 3]>> {
        let alpha = self.found.alpha.as_ref()?;
        let left = |(pixel, a): (&[f32; 3], &f32)| {
            // Rounding may leave less than nothing of a pixel that only an edge covers.
            std::array::from_fn(|c| (pixel[c] - (1.0 - a) * self.background[c]).max(0.0))
        };
        Some(linear.iter().zip(alpha).map(left).collect())
    }

    /// The layers as pictures.
    pub(crate) fn pictures(
        &self,
        rendered: &Rendered,
    ) -> Result<Vec<(SurfaceLayer, SurfacePicture)>, Failure> {
        let metadata = Metadata::of(&rendered.report, rendered.done);
        let paint = |(layer, values): &(SurfaceLayer, Vec<[f32; 3]>)| {
            Ok((*layer, surface_pictures::paint(*layer, values, rendered.width, &metadata)?))
        };
        let painted: io::Result<Vec<_>> = self.found.layers.iter().map(paint).collect();
        Ok(painted.context("cannot encode a layer")?)
    }
}

/// All layers as channels of an OpenEXR file, named as other programs expect them: `Z`, `NAME.X` to `.Z` of directions,
/// `NAME.R` to `.B` of colours, `NAME.Y` of other numbers.
pub(crate) fn channels(layers: &[(Layer, Vec<f64>)], surfaces: &Surfaces) -> Vec<(String, Vec<f32>)> {
    let numbers = |(layer, values): &(Layer, Vec<f64>)| {
        (format!("{}.Y", layer.name()), values.iter().map(|x| *x as f32).collect::<Vec<_>>())
    };
    let mut channels: Vec<_> = layers.iter().map(numbers).collect();
    for (layer, values) in &surfaces.layers {
        let names: &[&str] = match layer {
            SurfaceLayer::Z => &["Z"],
            SurfaceLayer::Normal => &["normal.X", "normal.Y", "normal.Z"],
            SurfaceLayer::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            SurfaceLayer::Object => &["object.Y"],
            SurfaceLayer::Material => &["material.Y"],
        };
        for (c, name) in names.iter().enumerate() {
            channels.push(((*name).to_owned(), values.iter().map(|v| v[c]).collect()));
        }
    }
    channels
}
