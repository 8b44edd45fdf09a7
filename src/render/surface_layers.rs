//! What the first surfaces are: layers for compositing. Each is a render of its own, of the same samples but without
//! secondary and shadow rays, through the kernels of the picture; a picture without layers pays nothing for them.

use super::{Observer, RenderError, Rendered, Renderer};
use crate::scene::{Material, Scene};
use crate::settings::{Settings, SurfaceSums};
use glam::DVec3;
use std::collections::BTreeMap;
use std::str::FromStr;

/// A layer: numbers of the first surface behind each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SurfaceLayer {
    /// Distance along the view, metres: mean over the samples that meet a surface; infinite where none does.
    Z,
    /// Shading normal in the scene's space, on the side of the eye: mean over the samples that meet a surface; not of length
    /// 1 at edges. Zeros where none does.
    Normal,
    /// Diffuse colour, linear RGB: mean over all samples. A sample that meets no surface counts as black.
    Albedo,
    /// Number of the object at the pixel's centre, from 1: polygons, then spheres, then meshes, in the scene's order. 0 for
    /// nothing.
    Object,
    /// Number of the material at the pixel's centre, from 1 in the scene's order. 0 for nothing.
    Material,
}

impl SurfaceLayer {
    /// All of them.
    pub const ALL: [SurfaceLayer; 5] = [
        SurfaceLayer::Z,
        SurfaceLayer::Normal,
        SurfaceLayer::Albedo,
        SurfaceLayer::Object,
        SurfaceLayer::Material,
    ];

    /// Its name on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            SurfaceLayer::Z => "z",
            SurfaceLayer::Normal => "normal",
            SurfaceLayer::Albedo => "albedo",
            SurfaceLayer::Object => "object",
            SurfaceLayer::Material => "material",
        }
    }
}

impl FromStr for SurfaceLayer {
    type Err = String;

    fn from_str(text: &str) -> Result<SurfaceLayer, String> {
        let names = || SurfaceLayer::ALL.map(SurfaceLayer::name).join(", ");
        SurfaceLayer::ALL.into_iter().find(|l| l.name() == text).ok_or_else(|| format!("one of {}", names()))
    }
}

/// Layers of an image, rows from the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surfaces {
    /// Share of the samples that meet a surface, in [0, 1]; none unless asked for.
    pub alpha: Option<Vec<f32>>,
    /// The layers asked for, in the order of [`SurfaceLayer::ALL`]. Those of one number have it in all three channels.
    pub layers: Vec<(SurfaceLayer, Vec<[f32; 3]>)>,
}

impl Renderer {
    /// Alpha and layers of the picture of `settings`, whose precision is settled; `None` if cancelled.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn surfaces(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        alpha: bool,
        layers: &[SurfaceLayer],
        observer: &mut dyn Observer,
    ) -> Result<Option<Surfaces>, RenderError> {
        let mut first = First { renderer: self, settings, observer };
        let bare = bare(scene);
        let wants = |layer| layers.contains(&layer);
        let mut found = Surfaces::default();

        if alpha || wants(SurfaceLayer::Z) || wants(SurfaceLayer::Normal) {
            let Some(Rendered { linear: places, report, .. }) =
                first.render(&bare, Some(SurfaceSums::Place), settings.samples)?
            else {
                return Ok(None);
            };
            found.alpha = alpha.then(|| places.iter().map(|p| p[1]).collect());
            if wants(SurfaceLayer::Z) {
                let metre = 2f64.powi(-report.scene.local_frame.scale_log2);
                let z = |p: &[f32; 3]| {
                    [if p[1] > 0.0 { (f64::from(p[0] / p[1]) * metre) as f32 } else { f32::INFINITY }; 3]
                };
                found.layers.push((SurfaceLayer::Z, places.iter().map(z).collect()));
            }
            if wants(SurfaceLayer::Normal) {
                let Some(sums) = first.sums(&bare, Some(SurfaceSums::Normal), settings.samples)? else {
                    return Ok(None);
                };
                let normal =
                    |(n, p): (&[f32; 3], &[f32; 3])| if p[1] > 0.0 { n.map(|x| x / p[1]) } else { [0.0; 3] };
                found.layers.push((SurfaceLayer::Normal, sums.iter().zip(&places).map(normal).collect()));
            }
        }
        if wants(SurfaceLayer::Albedo) {
            let Some(albedo) = first.sums(&bare, None, settings.samples)? else { return Ok(None) };
            found.layers.push((SurfaceLayer::Albedo, albedo));
        }
        if wants(SurfaceLayer::Object) || wants(SurfaceLayer::Material) {
            let (marked, pairs) = marked(&bare);
            // One sample is at the centre.
            let Some(places) = first.sums(&marked, Some(SurfaceSums::Place), 1)? else { return Ok(None) };
            let number = |layer: SurfaceLayer, pair: &[usize; 2]| match layer {
                SurfaceLayer::Object => pair[0] + 1,
                _ => pair[1] + 1,
            };
            for layer in [SurfaceLayer::Object, SurfaceLayer::Material].into_iter().filter(|l| wants(*l)) {
                let of = |p: &[f32; 3]| {
                    [if p[1] > 0.0 { number(layer, &pairs[p[2] as usize]) as f32 } else { 0.0 }; 3]
                };
                found.layers.push((layer, places.iter().map(of).collect()));
            }
        }
        Ok(Some(found))
    }
}

/// Renders of first surfaces.
struct First<'a> {
    renderer: &'a mut Renderer,
    settings: &'a Settings,
    observer: &'a mut dyn Observer,
}

impl First<'_> {
    /// The settings of the picture, for first surfaces alone.
    fn settings(&self, sums: Option<SurfaceSums>, samples: u32) -> Settings {
        let mut settings =
            Settings { samples, depth: 1, cutoff: 0.0, replicates: 1, ..self.settings.clone() };
        settings.schedule.surface_layer = sums;
        settings.schedule.count_tests = false;
        settings
    }

    /// Means over the samples of each pixel; `None` if cancelled.
    fn sums(
        &mut self,
        scene: &Scene,
        sums: Option<SurfaceSums>,
        samples: u32,
    ) -> Result<Option<Vec<[f32; 3]>>, RenderError> {
        Ok(self.render(scene, sums, samples)?.map(|rendered| rendered.linear))
    }

    fn render(
        &mut self,
        scene: &Scene,
        sums: Option<SurfaceSums>,
        samples: u32,
    ) -> Result<Option<Rendered>, RenderError> {
        let settings = self.settings(sums, samples);
        let rendered = self.renderer.render_with(scene, &settings, self.observer)?;
        Ok((rendered.done == 1.0).then_some(rendered))
    }
}

/// The scene without light: each surface shows its diffuse colour, and nothing is mirrored or refracted.
fn bare(scene: &Scene) -> Scene {
    let plain = |m: &Material| Material { ambient: 1.0, secondary: 0.0, priority: 0, ..m.clone() };
    let mut bare = scene.clone();
    bare.lights.clear();
    bare.render.background = DVec3::ZERO;
    bare.materials = scene.materials.iter().map(plain).collect();
    bare
}

/// The scene with a material of its own for each pair of an object and a material, and those pairs.
fn marked(scene: &Scene) -> (Scene, Vec<[usize; 2]>) {
    let mut marked = scene.clone();
    let mut pairs = Vec::new();
    let mut numbers: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    let mut mark = |object: usize, material: &mut usize| {
        *material = *numbers.entry([object, *material]).or_insert_with(|| {
            pairs.push([object, *material]);
            pairs.len() - 1
        });
    };
    let (polygons, spheres) = (marked.polygons.len(), marked.spheres.len());
    marked.polygons.iter_mut().enumerate().for_each(|(i, p)| mark(i, &mut p.material));
    marked.spheres.iter_mut().enumerate().for_each(|(i, s)| mark(polygons + i, &mut s.material));
    for (i, mesh) in marked.meshes.iter_mut().enumerate() {
        mesh.faces.iter_mut().for_each(|face| mark(polygons + spheres + i, &mut face.material));
    }
    marked.materials = pairs.iter().map(|[_, material]| scene.materials[*material].clone()).collect();
    (marked, pairs)
}
