//! MTL material files.
//!
//! | MTL | here |
//! |---|---|
//! | `Kd` | `diffuse` (0.8 grey if absent) |
//! | `Ka` | `ambient` = mean of `Ka` / mean of `Kd`, at most 1; 0.1 if absent |
//! | `illum` 3, 5, 8 | a mirror: `secondary` = mean of `Ks` (0 if absent), `fresnel` = 1 |
//! | `illum` 4, 6, 7, 9 | glass: `fresnel` = exact, `secondary` = the larger of the mean of `Ks` and 1 - `d` (or `Tr`); 1 if neither is given |
//! | other `illum` or none | `secondary` = 0 |
//! | `Ni` | `ior` (1.5 if absent) |
//! | `whitted_ambient`, `whitted_secondary`, `whitted_fresnel` | our own: the value as in a scene |
//!
//! Textures and everything else are ignored.

use super::error::{SceneError, Source, did_you_mean, list};
use super::material::{AMBIENT, IOR, IOR_RANGE, IOR_RULE, SHARE_RULE, fresnel_word, is_share};
use super::table::{NOT_NEGATIVE, within_f32};
use super::tokens::{Word, Words};
use super::{Fresnel, Material};
use glam::DVec3;

/// Diffuse grey where `Kd` is absent, as most exporters write it.
const GREY: f64 = 0.8;

const OWN: [&str; 3] = ["whitted_ambient", "whitted_secondary", "whitted_fresnel"];

/// What is written about one material.
#[derive(Default)]
struct Written {
    name: String,
    kd: Option<DVec3>,
    ka: Option<DVec3>,
    ks: Option<DVec3>,
    ni: Option<f64>,
    opacity: Option<f64>,
    illum: Option<f64>,
    ambient: Option<f64>,
    secondary: Option<f64>,
    fresnel: Option<Fresnel>,
}

/// Reads all materials of an MTL text.
pub(super) fn read(source: Source) -> Result<Vec<Material>, SceneError> {
    let name = source.file.file_name().unwrap_or_default().to_string_lossy();
    let file_object = format!("material file `{name}`");
    let mut words = Words::new(source, file_object);
    let mut materials: Vec<Written> = Vec::new();
    while let Some(keyword) = words.keyword() {
        if keyword.bytes == b"newmtl" {
            let Some(name) = words.rest() else {
                return Err(words.error(keyword.offset, "`newmtl` without a name", "write `newmtl NAME`"));
            };
            words.object = format!("material `{}`", name.text());
            if materials.iter().any(|m| m.name.as_bytes() == name.bytes) {
                return Err(words.error(name.offset, "defined twice", "give each material its own name"));
            }
            materials.push(Written { name: name.text(), ..Written::default() });
        } else {
            statement(&mut words, keyword, materials.last_mut())?;
        }
        words.end_line();
    }
    Ok(materials.into_iter().map(Written::material).collect())
}

/// Reads the statement that `keyword` opens into `material`.
fn statement(words: &mut Words, keyword: Word, material: Option<&mut Written>) -> Result<(), SceneError> {
    let name = keyword.text();
    let Some(m) = material else {
        return Err(words.error(
            keyword.offset,
            format!("`{name}` before the first `newmtl`"),
            "start the file with `newmtl NAME`",
        ));
    };
    match name.as_str() {
        "Kd" => m.kd = Some(color(words, keyword)?),
        "Ka" => m.ka = Some(color(words, keyword)?),
        "Ks" => m.ks = Some(color(words, keyword)?),
        "Ni" => m.ni = Some(number(words, keyword, |x| IOR_RANGE.contains(&x), IOR_RULE)?),
        "d" => m.opacity = Some(number(words, keyword, is_share, SHARE_RULE)?),
        "Tr" => m.opacity = Some(1.0 - number(words, keyword, is_share, SHARE_RULE)?),
        "illum" => {
            let model = |x: f64| (0.0..=10.0).contains(&x) && x.fract() == 0.0;
            m.illum = Some(number(words, keyword, model, "a whole number from 0 to 10")?);
        }
        "whitted_ambient" => m.ambient = Some(number(words, keyword, within_f32, NOT_NEGATIVE)?),
        "whitted_secondary" => m.secondary = Some(number(words, keyword, is_share, SHARE_RULE)?),
        "whitted_fresnel" => {
            let word = operand(words, keyword)?;
            m.fresnel = Some(match fresnel_word(&word.text()) {
                Some(law) => law,
                None => Fresnel::Constant(share(words, word)?),
            });
        }
        _ if name.starts_with("whitted_") => {
            let near = did_you_mean(&name, OWN);
            return Err(words.error(
                keyword.offset,
                format!("unknown key `{name}`{near}"),
                format!("use one of {}", list(OWN)),
            ));
        }
        _ => {}
    }
    Ok(())
}

/// The word after `keyword`.
fn operand<'a>(words: &mut Words<'a>, keyword: Word) -> Result<Word<'a>, SceneError> {
    let name = keyword.text();
    words.word().ok_or_else(|| {
        words.error(keyword.offset, format!("`{name}` without a value"), format!("write it as `{name} 1`"))
    })
}

fn number(
    words: &mut Words,
    keyword: Word,
    accept: impl Fn(f64) -> bool,
    rule: &str,
) -> Result<f64, SceneError> {
    let mut word = operand(words, keyword)?;
    if word.bytes == b"-halo" {
        word = operand(words, keyword)?;
    }
    let number = words.number(word)?;
    if accept(number) {
        return Ok(number);
    }
    Err(words.error(
        word.offset,
        format!("`{}` is {number}; it must be {rule}", keyword.text()),
        format!("write a number that is {rule}"),
    ))
}

fn share(words: &Words, word: Word) -> Result<f64, SceneError> {
    words.number(word).ok().filter(|x| is_share(*x)).ok_or_else(|| {
        words.error(
            word.offset,
            format!("`whitted_fresnel` is `{}`", word.text()),
            "write a number from 0 to 1, `schlick` or `exact`",
        )
    })
}

/// `r g b`, or one number for all three.
fn color(words: &mut Words, keyword: Word) -> Result<DVec3, SceneError> {
    let mut channels = Vec::with_capacity(3);
    let mut offset = keyword.offset;
    while let (true, Some(word)) = (channels.len() < 3, words.word()) {
        offset = word.offset;
        if matches!(word.bytes, b"spectral" | b"xyz") {
            return Err(words.error(
                offset,
                format!("`{} {}` is not supported", keyword.text(), word.text()),
                format!("write the colour as linear RGB, `{} 0.8 0.8 0.8`", keyword.text()),
            ));
        }
        let channel = words.number(word)?;
        if !within_f32(channel) {
            return Err(words.error(
                offset,
                format!("`{}` is {channel}; it must be {NOT_NEGATIVE}", keyword.text()),
                format!("write a number that is {NOT_NEGATIVE}"),
            ));
        }
        channels.push(channel);
    }
    match channels[..] {
        [grey] => Ok(DVec3::splat(grey)),
        [r, g, b] => Ok(DVec3::new(r, g, b)),
        _ => Err(words.error(
            offset,
            format!("`{}` has {} numbers", keyword.text(), channels.len()),
            format!("write it as `{} 0.8 0.8 0.8`", keyword.text()),
        )),
    }
}

impl Written {
    /// The mapping of the table above.
    fn material(self) -> Material {
        let mean = |c: DVec3| c.element_sum() / 3.0;
        let diffuse = self.kd.unwrap_or(DVec3::splat(GREY));
        let ambient = match self.ka {
            Some(ka) if mean(diffuse) > 0.0 => (mean(ka) / mean(diffuse)).min(1.0),
            _ => AMBIENT,
        };
        let shine = self.ks.map(|ks| mean(ks).min(1.0));
        let clear = self.opacity.map(|d| 1.0 - d);
        let (secondary, fresnel) = match self.illum.map(|illum| illum as u32) {
            Some(3 | 5 | 8) => (shine.unwrap_or(0.0), Fresnel::Constant(1.0)),
            Some(4 | 6 | 7 | 9) => {
                let weight = shine.into_iter().chain(clear).reduce(f64::max);
                (weight.unwrap_or(1.0), Fresnel::Exact)
            }
            _ => (0.0, Fresnel::Constant(1.0)),
        };
        Material {
            name: self.name,
            diffuse,
            ambient: self.ambient.unwrap_or(ambient),
            secondary: self.secondary.unwrap_or(secondary),
            fresnel: self.fresnel.unwrap_or(fresnel),
            ior: self.ni.unwrap_or(IOR),
            priority: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn read(text: &str) -> Result<Vec<Material>, SceneError> {
        super::read(Source { file: Path::new("a/m.mtl"), text: text.as_bytes() })
    }

    #[test]
    fn plain_mirror_glass_and_own_keys() {
        let text = "newmtl plain\nKd .2 .4 .6\nKa .1 .1 .1\nKs 1 1 1\nillum 2\nmap_Kd x.png\n\
            newmtl mirror\nKs 0.5\nillum 3\nnewmtl glass\nTr 0.75\nNi 1.33\nillum 7\n\
            newmtl own\nwhitted_ambient 0\nwhitted_secondary 0.8\nwhitted_fresnel schlick";
        let m = read(text).unwrap();
        assert_eq!(m[0].diffuse, DVec3::new(0.2, 0.4, 0.6));
        assert!((m[0].ambient - 0.25).abs() < 1e-15);
        assert_eq!((m[0].secondary, m[0].ior), (0.0, 1.5));
        assert_eq!((m[1].secondary, m[1].fresnel), (0.5, Fresnel::Constant(1.0)));
        assert_eq!((m[2].secondary, m[2].fresnel, m[2].ior), (0.75, Fresnel::Exact, 1.33));
        assert_eq!((m[3].ambient, m[3].secondary, m[3].fresnel), (0.0, 0.8, Fresnel::Schlick));
    }

    #[test]
    fn errors_have_places() {
        for (text, line, column, part) in [
            ("Kd 1 1 1", 1, 1, "before the first `newmtl`"),
            ("newmtl", 1, 1, "without a name"),
            ("newmtl a\n\nnewmtl a", 3, 8, "defined twice"),
            ("newmtl a\nKd 1 1", 2, 6, "has 2 numbers"),
            ("newmtl a\nKd 1 -1 1", 2, 6, "`Kd` is -1"),
            ("newmtl a\n  Kd spectral x", 2, 6, "not supported"),
            ("newmtl a\nNi 0", 2, 4, "`Ni` is 0"),
            ("newmtl a\nd 1.5", 2, 3, "`d` is 1.5"),
            ("newmtl a\nillum 11", 2, 7, "`illum` is 11"),
            ("newmtl a\nNi", 2, 1, "without a value"),
            ("newmtl a\nwhitted_fresnel snell", 2, 17, "`snell`"),
            ("newmtl a\nwhitted_secundary 1", 2, 1, "did you mean `whitted_secondary`?"),
            ("newmtl a\nNi x", 2, 4, "`x` is no finite number"),
        ] {
            let error = read(text).unwrap_err();
            assert_eq!((error.line, error.column), (line, column), "{error}");
            assert!(error.message.contains(part), "{error}");
        }
    }
}
