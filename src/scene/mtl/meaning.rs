//! What the statements of an MTL material mean here.
//!
//! | MTL | here |
//! |---|---|
//! | `Kd` | `diffuse` (grey of 0.8 if absent; 1 under a `map_Kd`); whole numbers of which some are above 1 and none above 255 are 255ths |
//! | `map_Kd` | its mean linear colour times `Kd` |
//! | `Ka` | nothing: exporters write it as a constant |
//! | `illum` 3, 5, 8 | a mirror: `secondary` = mean of `Ks` (0 if absent), `fresnel` = 1 |
//! | `illum` 4, 6, 7, 9 with `d` below 1, or with neither `d` nor `Ks` | glass: `fresnel` = exact, `secondary` = the larger of the mean of `Ks` and 1 - `d`; 1 if neither is given |
//! | `illum` 4, 6, 7, 9 otherwise | opaque |
//! | other `illum` or none, with `d` below 1 | blended: `secondary` = 1 - `d`, all of it straight on (`fresnel` 0, `ior` 1) |
//! | other `illum` or none | `secondary` = 0 |
//! | `Tr` | `d` = 1 - `Tr`, if there is no `d`; values outside 0 to 1 of either are skipped |
//! | `Ni` | `ior` (1.5 if absent or impossible) |
//! | `whitted_ambient`, `whitted_secondary`, `whitted_fresnel` | our own: the value as in a scene |
//! | `Ks`, `Ns`, textures | kept in [`Undrawn`] |
//!
//! A strict reading follows the letter of the format: `Kd` as it is, `ambient` = mean of `Ka` / mean of `Kd`, at most 1, and
//! `d` only where `illum` says glass.

use super::{At, Written};
use crate::scene::error::{SceneError, Source};
use crate::scene::material::{AMBIENT, IOR, IOR_RANGE, is_share};
use crate::scene::notes::Reading;
use crate::scene::{Fresnel, Material, TextureFile, Undrawn, beside, mean_color, tokens};
use glam::DVec3;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Diffuse grey where `Kd` is absent, as most exporters write it.
const GREY: f64 = 0.8;

/// Mean colours of the textures met so far; none of files that cannot be read.
#[derive(Default)]
pub(in crate::scene) struct Textures(HashMap<PathBuf, Option<DVec3>>);

impl Textures {
    fn mean(&mut self, path: &Path) -> Option<DVec3> {
        let read = || mean_color::of_file(path).ok().map(|mean| mean.color);
        *self.0.entry(path.to_owned()).or_insert_with(read)
    }
}

fn mean(c: DVec3) -> f64 {
    c.element_sum() / 3.0
}

fn value<T: Copy>(at: At<T>) -> Option<T> {
    at.map(|(value, _)| value)
}

/// What a material does with light that it does not scatter.
struct Optics {
    secondary: f64,
    fresnel: Fresnel,
    ior: f64,
}

impl Written {
    /// The mapping of the table above. `source` is the text it was read from.
    ///
    /// # Errors
    /// None, unless the reading is strict.
    pub fn material(
        &self,
        source: Source,
        textures: &mut Textures,
        reading: &mut Reading,
    ) -> Result<Material, SceneError> {
        let optics = if reading.strict { self.optics_to_the_letter() } else { self.optics(source, reading) };
        let undrawn = self.undrawn(source, reading);
        let diffuse = self.diffuse(source, undrawn.as_deref(), textures, reading)?;
        Ok(Material {
            name: tokens::name(&self.name),
            diffuse,
            ambient: self.ambient.unwrap_or_else(|| self.ambient_of_ka(diffuse, source, reading)),
            secondary: self.secondary.unwrap_or(optics.secondary),
            fresnel: self.fresnel.unwrap_or(optics.fresnel),
            ior: optics.ior,
            priority: 0,
            undrawn,
        })
    }

    fn diffuse(
        &self,
        source: Source,
        undrawn: Option<&Undrawn>,
        textures: &mut Textures,
        reading: &mut Reading,
    ) -> Result<DVec3, SceneError> {
        let kd = self.kd.map(|(kd, at)| {
            let bytes = kd.max_element() > 1.0 && kd.max_element() <= 255.0 && kd == kd.trunc();
            if bytes && !reading.strict {
                reading.count(source, at, "`Kd` in whole numbers above 1 is taken as 255ths", 1);
                return kd / 255.0;
            }
            kd
        });
        let grey = DVec3::splat(GREY);
        let Some((_, name, at)) = self.textures.iter().find(|(keyword, ..)| *keyword == "map_Kd") else {
            return Ok(kd.unwrap_or(grey));
        };
        if reading.strict {
            return Ok(kd.unwrap_or(grey));
        }
        let file = undrawn.and_then(|u| u.textures.iter().find(|t| t.role == "map_Kd"));
        if let Some(mean) = file.and_then(|t| textures.mean(&t.file)) {
            let message = "`map_Kd`: textures are not drawn yet; the mean colour of each stands for it";
            reading.count(source, *at, message, 1);
            return Ok(mean * kd.unwrap_or(DVec3::ONE));
        }
        let object = format!("texture `{}`", tokens::name(name));
        let message = "`map_Kd` names a file that is missing or cannot be read; `Kd` alone is used";
        reading.assume(
            source,
            *at,
            &object,
            message,
            "correct the path; it starts at the MTL file's folder",
        )?;
        Ok(kd.unwrap_or(grey))
    }

    /// `Ka` to the letter if the reading is strict; the default otherwise, with a note where that differs.
    fn ambient_of_ka(&self, diffuse: DVec3, source: Source, reading: &mut Reading) -> f64 {
        let Some((ka, at)) = self.ka.filter(|_| mean(diffuse) > 0.0) else { return AMBIENT };
        let ambient = (mean(ka) / mean(diffuse)).min(1.0);
        if reading.strict {
            return ambient;
        }
        // Ka is written with a few digits.
        if (ambient - AMBIENT).abs() > 1e-3 {
            reading.count(source, at, "`Ka` is not used: ambient is 0.1 (`whitted_ambient` sets it)", 1);
        }
        AMBIENT
    }

    /// 1 - transparency, where it is written and possible.
    fn opacity(&self, source: Source, reading: &mut Reading) -> At<f64> {
        let d = self.d;
        let tr = self.tr.map(|(tr, at)| (1.0 - tr, at));
        let mut possible = |written: At<f64>| {
            let (share, at) = written?;
            if !is_share(share) {
                reading.count(source, at, "`d` and `Tr` outside 0 to 1 are skipped", 1);
                return None;
            }
            written
        };
        let (d, tr) = (possible(d), possible(tr));
        if let (Some((d, at)), Some((tr, _))) = (d, tr)
            && (d - tr).abs() > 1e-3
        {
            reading.count(source, at, "`d` and `Tr` say different things; `d` is followed", 1);
        }
        d.or(tr)
    }

    fn optics(&self, source: Source, reading: &mut Reading) -> Optics {
        let shine = value(self.ks).map(|ks| mean(ks).min(1.0));
        let opacity = self.opacity(source, reading);
        let opaque =
            Optics { secondary: 0.0, fresnel: Fresnel::Constant(1.0), ior: value(self.ni).unwrap_or(IOR) };
        // Where the scene's own keys say what to do with light, nothing is mapped.
        let own = self.secondary.is_some() && self.fresnel.is_some();
        let glass_models = |illum: f64| [4.0, 6.0, 7.0, 9.0].contains(&illum);
        let mut optics = match value(self.illum) {
            Some(3.0 | 5.0 | 8.0) => Optics { secondary: shine.unwrap_or(0.0), ..opaque },
            Some(illum) if glass_models(illum) => {
                let clear = opacity.map(|(d, _)| 1.0 - d).filter(|clear| *clear > 0.0);
                let unsaid = opacity.is_none() && shine.is_none();
                if clear.is_some() || unsaid {
                    let weight = shine.into_iter().chain(clear).reduce(f64::max);
                    Optics { secondary: weight.unwrap_or(1.0), fresnel: Fresnel::Exact, ..opaque }
                } else {
                    if !own {
                        let message = "`illum` 4, 6, 7 or 9 without a `d` below 1: opaque, as viewers show it (glass: `d 0`)";
                        reading.count(source, self.illum.map_or(self.at, |(_, at)| at), message, 1);
                    }
                    opaque
                }
            }
            _ => match opacity {
                Some((d, at)) if d < 1.0 => {
                    if !own {
                        let message = "`d` below 1 without `illum` 4, 6, 7 or 9: 1 - `d` passes straight on, as viewers blend it";
                        reading.count(source, at, message, 1);
                    }
                    Optics { secondary: 1.0 - d, fresnel: Fresnel::Constant(0.0), ior: 1.0 }
                }
                _ => opaque,
            },
        };
        if !IOR_RANGE.contains(&optics.ior) {
            let refracts = self.secondary.unwrap_or(optics.secondary) > 0.0
                && self.fresnel.unwrap_or(optics.fresnel).transmits();
            if let (true, Some((_, at))) = (refracts, self.ni) {
                reading.count(source, at, "`Ni` outside 0.001 to 1000 is taken as 1.5", 1);
            }
            optics.ior = IOR;
        }
        // A law of our own is meant for the index that is written.
        if self.fresnel.is_some() && optics.ior == 1.0 {
            optics.ior = value(self.ni).filter(|ni| IOR_RANGE.contains(ni)).unwrap_or(IOR);
        }
        optics
    }

    /// As the format's text says, whatever viewers do.
    fn optics_to_the_letter(&self) -> Optics {
        let shine = value(self.ks).map(|ks| mean(ks).min(1.0));
        let clear = match (self.tr_last, value(self.d), value(self.tr)) {
            (true, _, Some(tr)) => Some(tr),
            (_, Some(d), _) => Some(1.0 - d),
            _ => None,
        };
        let (secondary, fresnel) = match value(self.illum) {
            Some(3.0 | 5.0 | 8.0) => (shine.unwrap_or(0.0), Fresnel::Constant(1.0)),
            Some(4.0 | 6.0 | 7.0 | 9.0) => {
                (shine.into_iter().chain(clear).reduce(f64::max).unwrap_or(1.0), Fresnel::Exact)
            }
            _ => (0.0, Fresnel::Constant(1.0)),
        };
        Optics { secondary, fresnel, ior: value(self.ni).unwrap_or(IOR) }
    }

    /// Highlights and textures, with a note for each kind.
    fn undrawn(&self, source: Source, reading: &mut Reading) -> Option<Box<Undrawn>> {
        let folder = source.file.parent().unwrap_or(Path::new(""));
        let mut textures = Vec::new();
        for (role, name, at) in &self.textures {
            let found = beside::find(folder, name, !reading.strict);
            let file = found.map_or_else(|| folder.join(tokens::name(name)), |(path, _)| path);
            textures.push(TextureFile { role, file });
            if *role != "map_Kd" || reading.strict {
                reading.count(source, *at, &format!("`{role}` is kept but not drawn"), 1);
            }
        }
        // A mirror's Ks is its weight, not a highlight.
        let mirrors = matches!(value(self.illum), Some(3.0..=9.0));
        let specular = value(self.ks).filter(|ks| *ks != DVec3::ZERO && !mirrors);
        if let (Some(_), Some((_, at))) = (specular, self.ks) {
            reading.count(source, at, "`Ks` and `Ns` are kept; highlights are not drawn", 1);
        }
        let shininess = value(self.ns);
        let nothing = specular.is_none() && shininess.is_none() && textures.is_empty();
        (!nothing).then(|| Box::new(Undrawn { specular, shininess, textures }))
    }
}
