//! glTF's metallic-roughness materials as Whitted's: a diffuse own colour, a mirror or glass.
//!
//! | glTF | here |
//! |---|---|
//! | base colour: factor * mean of the texture * mean of the vertices' colours | `diffuse` |
//! | metallic m, roughness r | `secondary` = m (1 - r) * mean of the base colour, `fresnel` = 1 |
//! | transmission t | `secondary` = t (1 - m), `fresnel` = exact, `ior` |
//! | alpha a, mode BLEND | `secondary` = 1 - a, `fresnel` = 0, `ior` = 1: what is behind shows, not bent |
//! | emission e | `ambient` = 0.1 + e / diffuse |
//! | unlit | own colour = base colour |
//!
//! A metal of colour c and roughness 0 reflects c of the light in the mirror's direction and nothing else. Rays have one
//! weight for all channels, hence the mean. A rough metal spreads it, as a diffuse surface does: that share stays own colour.

use super::accessors::Accessors;
use super::json::{self, TextureInfo};
use super::textures::Textures;
use crate::scene::error::SceneError;
use crate::scene::library::Library;
use crate::scene::material::{self, AMBIENT, IOR, IOR_RANGE};
use crate::scene::mean_color::TextureMean;
use crate::scene::model_file::{ModelFile, some};
use crate::scene::notes::Reading;
use crate::scene::{Fresnel, Material};
use glam::DVec3;
use std::collections::HashMap;

/// Mirrors weaker than one part in fifty are left out: at most 2 % of a surface's colour, for a second ray at each hit.
const LEAST_MIRROR: f64 = 0.02;

/// A surface that shines by itself and reflects next to nothing: a thousandth of its colour, a thousand times.
const GLOW: f64 = 1000.0;

/// The materials in use, and what became of them.
pub struct Materials {
    /// The scene's material for everything, if it gives one.
    whole: Option<usize>,
    /// By glTF material (None: the default one) and the bits of the vertices' mean colour.
    known: HashMap<(Option<usize>, [u64; 3]), usize>,
    textures: Textures,
    /// Kinds of mapping with the names of materials; true if the picture may differ for it.
    kinds: Vec<(&'static str, bool, Vec<String>)>,
    without: usize,
}

impl Materials {
    /// None is in use yet.
    pub fn new(whole: Option<usize>) -> Materials {
        Materials {
            whole,
            known: HashMap::new(),
            textures: Textures::default(),
            kinds: Vec::new(),
            without: 0,
        }
    }

    /// True if the scene gives the material.
    pub fn is_given(&self) -> bool {
        self.whole.is_some()
    }

    /// Index in `library` of the file's material `index`, or of the default one, for a primitive whose vertices have the
    /// mean colour `tint`.
    pub fn index(
        &mut self,
        accessors: &mut Accessors,
        library: &mut Library,
        index: Option<usize>,
        tint: DVec3,
    ) -> Result<usize, SceneError> {
        if let Some(whole) = self.whole {
            return Ok(whole);
        }
        let key = (index, tint.to_array().map(f64::to_bits));
        if let Some(&known) = self.known.get(&key) {
            self.without += usize::from(index.is_none());
            return Ok(known);
        }
        let root = accessors.root;
        let material = match index {
            None => {
                self.without += 1;
                let plain = material::plain("default");
                Material { diffuse: plain.diffuse * tint, ..plain }
            }
            Some(index) => {
                let written = root.materials.get(index).ok_or_else(|| {
                    super::buffers::missing(accessors.file, "material", index, root.materials.len())
                })?;
                let name = written.name.clone().unwrap_or_else(|| format!("material {index}"));
                self.material(accessors, written, name, tint)
            }
        };
        if tint != DVec3::ONE {
            self.kind("the colours of vertices become their mean", true, &material.name);
        }
        library.materials.push(material);
        self.known.insert(key, library.materials.len() - 1);
        Ok(library.materials.len() - 1)
    }

    /// Notes what was made of the materials.
    pub fn report(&self, file: ModelFile, reading: &mut Reading) -> Result<(), SceneError> {
        let remedy = "give `material` in the scene's [[mesh]]";
        let message = "primitives without a material get the default one, diffuse 0.8";
        file.assume(reading, self.without, message, remedy)?;
        for (kind, differs, names) in &self.kinds {
            let message = format!("{kind}: {}", some(names));
            if *differs {
                file.assume(reading, 1, &message, remedy)?;
            } else {
                file.inform(reading, &message);
            }
        }
        if let Some(first) = self.textures.failures.first() {
            let count = self.textures.failures.len();
            let message = format!("textures that cannot be read count as white ({first})");
            file.assume(reading, count, &message, "take PNG or JPEG pictures")?;
        }
        Ok(())
    }

    fn kind(&mut self, kind: &'static str, differs: bool, name: &str) {
        match self.kinds.iter_mut().find(|(known, ..)| *known == kind) {
            Some((_, _, names)) if names.iter().any(|n| n == name) => {}
            Some((_, _, names)) => names.push(name.to_owned()),
            None => self.kinds.push((kind, differs, vec![name.to_owned()])),
        }
    }

    fn mean(&mut self, accessors: &mut Accessors, texture: Option<TextureInfo>) -> Option<TextureMean> {
        self.textures.mean(accessors, texture?.index)
    }

    fn material(
        &mut self,
        accessors: &mut Accessors,
        m: &json::Material,
        name: String,
        tint: DVec3,
    ) -> Material {
        let pbr = &m.pbr_metallic_roughness;
        let gloss = m.extensions.specular_glossiness.as_ref();
        let (factor, texture) = match gloss {
            Some(gloss) => (gloss.diffuse_factor, gloss.diffuse_texture),
            None => (pbr.base_color_factor, pbr.base_color_texture),
        };
        let blend = m.alpha_mode.as_deref() == Some("BLEND");
        let opaque = !blend && m.alpha_mode.as_deref() != Some("MASK");
        let mean = self.mean(accessors, texture);
        let picture = mean.map_or(DVec3::ONE, |mean| if opaque { mean.color } else { mean.covered });
        let base = color(DVec3::new(factor[0], factor[1], factor[2]) * picture * tint);
        let alpha = if blend { share(factor[3] * mean.map_or(1.0, |mean| mean.alpha)) } else { 1.0 };

        let data = self.mean(accessors, pbr.metallic_roughness_texture.filter(|_| gloss.is_none()));
        let data = data.map_or(DVec3::ONE, |mean| mean.stored);
        let metallic = if gloss.is_some() { 0.0 } else { share(pbr.metallic_factor * data.z) };
        let roughness = share(pbr.roughness_factor * data.y);
        let clear = m.extensions.transmission.as_ref().map_or(0.0, |transmission| {
            let mean = self.mean(accessors, transmission.transmission_texture);
            share(transmission.transmission_factor * mean.map_or(1.0, |mean| mean.stored.x))
                * (1.0 - metallic)
        });
        let mirror = metallic * (1.0 - roughness) * base.element_sum().min(3.0) / 3.0;

        let glow = m.extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength).unwrap_or(1.0);
        let mut emission = color(DVec3::from_array(m.emissive_factor) * glow);
        if emission != DVec3::ZERO {
            emission *= self.mean(accessors, m.emissive_texture).map_or(DVec3::ONE, |mean| mean.color);
        }
        let unlit = m.extensions.unlit.is_some();
        let (diffuse, ambient, exact) = own(base, if unlit { DVec3::ZERO } else { emission }, unlit);
        let (secondary, fresnel, ior) = if unlit {
            (0.0, Fresnel::Constant(1.0), IOR)
        } else if clear > 0.0 {
            let ior = m.extensions.ior.as_ref().and_then(|i| i.ior).filter(|i| IOR_RANGE.contains(i));
            (clear, Fresnel::Exact, ior.unwrap_or(IOR))
        } else if alpha < 1.0 {
            (1.0 - alpha, Fresnel::Constant(0.0), 1.0)
        } else if mirror >= LEAST_MIRROR {
            (mirror, Fresnel::Constant(1.0), IOR)
        } else {
            (0.0, Fresnel::Constant(1.0), IOR)
        };
        let made = Material { name, diffuse, ambient, secondary, fresnel, ior, priority: 0, undrawn: None };
        self.say(m, &made, [base, emission], roughness, exact);
        made
    }

    /// Notes how `made` came from `m`.
    fn say(
        &mut self,
        m: &json::Material,
        made: &Material,
        [base, emission]: [DVec3; 2],
        roughness: f64,
        exact: bool,
    ) {
        let name = &made.name;
        let pbr = &m.pbr_metallic_roughness;
        let gloss = m.extensions.specular_glossiness.as_ref();
        let textured = match gloss {
            Some(gloss) => gloss.diffuse_texture.is_some(),
            None => pbr.base_color_texture.is_some() || pbr.metallic_roughness_texture.is_some(),
        };
        if textured || m.emissive_texture.is_some() {
            self.kind("textures become their mean", true, name);
        }
        if m.normal_texture.is_some() {
            self.kind("normal maps are left out", true, name);
        }
        if gloss.is_some() {
            self.kind("specular-glossiness materials become their diffuse colour", true, name);
        }
        if m.alpha_mode.as_deref() == Some("MASK") {
            self.kind("alpha masks are left out, so these are opaque", true, name);
        }
        match made.fresnel {
            _ if m.extensions.unlit.is_some() => {
                self.kind("unlit materials show their base colour", false, name)
            }
            Fresnel::Exact if made.secondary > 0.0 => {
                self.kind("transmission becomes clear glass of the same index", false, name);
                if m.extensions.volume.as_ref().is_none_or(|volume| volume.thickness_factor <= 0.0) {
                    self.kind("transmission without a volume becomes solid glass as well", true, name);
                }
                let absorbs = m.extensions.volume.as_ref().is_some_and(|v| v.attenuation_distance.is_some());
                if base.min_element() < 0.99 || absorbs || roughness > 0.1 {
                    self.kind("the colour and roughness of glass are left out", true, name);
                }
            }
            Fresnel::Constant(0.0) => {
                self.kind("blended materials let through one minus their alpha, straight on", false, name);
            }
            _ if made.secondary > 0.0 => {
                self.kind("metals become mirrors, less for their roughness", false, name);
            }
            _ => {}
        }
        if emission != DVec3::ZERO && m.extensions.unlit.is_none() {
            match exact {
                true => self.kind("emission becomes `ambient`; it lights nothing else", false, name),
                false => self.kind("emission becomes `ambient` in the base colour's hue", true, name),
            }
        }
    }
}

/// Diffuse colour and ambient share whose own colour is 0.1 `base` + `emission` in the dark and follows light as `base` does;
/// and whether that is so, or only for the means over the channels.
fn own(base: DVec3, emission: DVec3, unlit: bool) -> (DVec3, f64, bool) {
    // How far channels of emission / base may differ from each other: what eight bits do at mid grey.
    const SAME: f64 = 0.01;
    if unlit {
        return (base / GLOW, GLOW, true);
    }
    if emission == DVec3::ZERO {
        return (base, AMBIENT, true);
    }
    if base.max_element() * GLOW <= emission.max_element() {
        return (emission / GLOW, GLOW, true);
    }
    let ratio = emission.element_sum() / base.element_sum();
    let off = (emission - ratio * base).abs().max_element();
    (base, AMBIENT + ratio, off <= SAME * emission.max_element())
}

/// A colour within what kernels can hold.
fn color(color: DVec3) -> DVec3 {
    color.max(DVec3::ZERO).min(DVec3::splat(f64::from(f32::MAX)))
}

/// A share within [0, 1].
fn share(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Own colour in the dark, and its growth with light, from the meaning of `diffuse` and `ambient`.
    fn shown(base: DVec3, emission: DVec3, unlit: bool) -> [DVec3; 2] {
        let (diffuse, ambient, _) = own(base, emission, unlit);
        [ambient * diffuse, diffuse]
    }

    #[test]
    fn emission_and_unlit_colours_are_own_colours() {
        let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() < 1e-12;
        let (base, glow) = (DVec3::new(0.5, 0.25, 1.0), DVec3::new(1.0, 0.5, 2.0));
        let [dark, growth] = shown(base, glow, false);
        assert!(near(dark, 0.1 * base + glow) && growth == base);
        let [dark, growth] = shown(DVec3::ZERO, glow, false);
        assert!(near(dark, glow) && near(growth, glow / 1000.0));
        let [dark, growth] = shown(base, DVec3::ZERO, true);
        assert!(near(dark, base) && near(growth, base / 1000.0));
        assert!(own(base, glow, false).2);
        assert!(!own(base, DVec3::X, false).2);
    }
}
