//! MTL material files; what they mean is in [`meaning`].

mod meaning;

use super::Fresnel;
use super::error::{SceneError, Source, did_you_mean, list};
use super::material::{IOR_RANGE, IOR_RULE, SHARE_RULE, fresnel_word, is_share};
use super::notes::Reading;
use super::table::{NOT_NEGATIVE, within_f32};
use super::tokens::{Word, Words};
use glam::DVec3;
pub(super) use meaning::Textures;
use std::collections::HashMap;

const OWN: [&str; 3] = ["whitted_ambient", "whitted_secondary", "whitted_fresnel"];

/// A value and the byte where its statement starts.
type At<T> = Option<(T, usize)>;

/// What is written about one material.
#[derive(Default)]
pub(super) struct Written {
    /// Its name, in whatever encoding.
    pub name: Vec<u8>,
    /// Byte where its name is.
    at: usize,
    kd: At<DVec3>,
    ka: At<DVec3>,
    ks: At<DVec3>,
    ns: At<f64>,
    ni: At<f64>,
    d: At<f64>,
    tr: At<f64>,
    /// True if `Tr` is the last of the two.
    tr_last: bool,
    illum: At<f64>,
    ambient: Option<f64>,
    secondary: Option<f64>,
    fresnel: Option<Fresnel>,
    /// Statements that name textures: keyword, file, place.
    textures: Vec<(&'static str, Vec<u8>, usize)>,
}

/// Keywords whose operand is a texture.
const TEXTURES: [&str; 17] = [
    "map_Kd", "map_Ka", "map_Ks", "map_Ke", "map_Ns", "map_Ni", "map_d", "map_Tr", "map_Bump", "map_bump",
    "bump", "disp", "decal", "refl", "norm", "map_Pr", "map_Pm",
];

/// Reads all materials of an MTL text. `object` is what messages call it.
pub(super) fn read(source: Source, object: &str, reading: &mut Reading) -> Result<Vec<Written>, SceneError> {
    let mut words = Words::new(source, object.to_owned());
    let mut materials: Vec<Written> = Vec::new();
    let mut by_name: HashMap<&[u8], usize> = HashMap::new();
    // Where statements belong: the last of `materials`, or an earlier one of the same name.
    let mut current = None;
    while let Some(keyword) = words.keyword() {
        if keyword.bytes == b"newmtl" {
            let name = words.line();
            let (bytes, at) = name.map_or((&b""[..], keyword.offset), |name| (name.bytes, name.offset));
            if bytes.is_empty() {
                let (message, remedy) = ("`newmtl` without a name", "write `newmtl NAME`");
                reading.assume(source, at, &words.object, message, remedy)?;
            }
            words.object = format!("material `{}`", Word { bytes, offset: at }.text());
            let written = Written { name: bytes.to_owned(), at, ..Written::default() };
            current = Some(*by_name.entry(bytes).or_insert(materials.len()));
            match current {
                Some(earlier) if earlier < materials.len() => {
                    if reading.strict {
                        let remedy = "give each material its own name";
                        return Err(words.error(at, "defined twice", remedy));
                    }
                    reading.count(source, at, "of materials with the same name the last is used", 1);
                    materials[earlier] = written;
                }
                _ => materials.push(written),
            }
        } else {
            match current.and_then(|i| materials.get_mut(i)) {
                Some(material) => lenient(&mut words, keyword, material, reading)?,
                None if reading.strict => {
                    return Err(words.error(
                        keyword.offset,
                        format!("`{}` before the first `newmtl`", keyword.text()),
                        "start the file with `newmtl NAME`",
                    ));
                }
                None => reading.count(
                    source,
                    keyword.offset,
                    "statements before the first `newmtl` are skipped",
                    1,
                ),
            }
        }
        words.end_line();
    }
    Ok(materials)
}

/// Reads a statement; one with an impossible value is skipped with a note, unless the reading is strict.
fn lenient(
    words: &mut Words,
    keyword: Word,
    material: &mut Written,
    reading: &mut Reading,
) -> Result<(), SceneError> {
    let error = match statement(words, keyword, material, reading.strict) {
        Ok(()) => return Ok(()),
        Err(error) => error,
    };
    // What is ours, and colours of another kind, are meant as they are written.
    if reading.strict || keyword.bytes.starts_with(b"whitted_") || error.message.contains("not supported") {
        return Err(error);
    }
    let message = format!("`{}` without a possible value is skipped", keyword.text());
    reading.count(words.source, keyword.offset, &message, 1);
    Ok(())
}

/// Reads the statement that `keyword` opens into `m`.
fn statement(words: &mut Words, keyword: Word, m: &mut Written, strict: bool) -> Result<(), SceneError> {
    let name = keyword.text();
    let here = keyword.offset;
    let checked = |words: &mut Words, accept: &dyn Fn(f64) -> bool, rule| {
        number(words, keyword, |x| !strict || accept(x), rule)
    };
    match name.as_str() {
        "Kd" => m.kd = Some((color(words, keyword)?, here)),
        "Ka" => m.ka = Some((color(words, keyword)?, here)),
        "Ks" => m.ks = Some((color(words, keyword)?, here)),
        // Never asked for until now, so that nothing is wrong with it.
        "Ns" => m.ns = number(words, keyword, within_f32, NOT_NEGATIVE).ok().map(|n| (n, here)),
        "Ni" => m.ni = Some((checked(words, &|x| IOR_RANGE.contains(&x), IOR_RULE)?, here)),
        "d" => {
            m.d = Some((checked(words, &is_share, SHARE_RULE)?, here));
            m.tr_last = false;
        }
        "Tr" => {
            m.tr = Some((checked(words, &is_share, SHARE_RULE)?, here));
            m.tr_last = true;
        }
        "illum" => {
            let model = |x: f64| (0.0..=10.0).contains(&x) && x.fract() == 0.0;
            m.illum = Some((number(words, keyword, model, "a whole number from 0 to 10")?, here));
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
        _ => {
            if let Some(known) = TEXTURES.into_iter().find(|known| *known == name)
                && let Some(file) = texture_file(words)
            {
                m.textures.push((known, file, here));
            }
        }
    }
    Ok(())
}

/// The file that the rest of a texture's line names: what follows the options and their values.
fn texture_file(words: &mut Words) -> Option<Vec<u8>> {
    let line = words.line()?.bytes;
    let mut rest = line;
    loop {
        rest = rest.trim_ascii_start();
        if !rest.starts_with(b"-") {
            break;
        }
        let (option, after) = first_word(rest);
        let (least, most) = match option {
            b"-o" | b"-s" | b"-t" => (1, 3),
            b"-mm" => (2, 2),
            b"-blendu" | b"-blendv" | b"-boost" | b"-bm" | b"-cc" | b"-clamp" | b"-imfchan" | b"-texres"
            | b"-type" => (1, 1),
            // No option: a name that starts with a minus sign.
            _ => break,
        };
        rest = after;
        for i in 0..most {
            let (value, after) = first_word(rest.trim_ascii_start());
            let is_number = std::str::from_utf8(value).is_ok_and(|text| text.parse::<f64>().is_ok());
            if i >= least && !is_number {
                break;
            }
            rest = after;
        }
    }
    let file = rest.trim_ascii();
    (!file.is_empty()).then(|| file.to_owned())
}

fn first_word(text: &[u8]) -> (&[u8], &[u8]) {
    text.split_at(text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len()))
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

#[cfg(test)]
mod tests;
