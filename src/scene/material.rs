//! `[material.NAME]` tables, and the defaults that MTL files share.

use super::error::SceneError;
use super::table::{NOT_NEGATIVE, Table, Value, within_f32};
use super::{Fresnel, Material};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Ambient share where none is written: the report's.
pub(super) const AMBIENT: f64 = 0.1;
/// Index of refraction where none is written: crown glass.
pub(super) const IOR: f64 = 1.5;
/// Indices outside would overflow the kernels' single-precision Fresnel terms in squares of ratios.
pub(super) const IOR_RANGE: RangeInclusive<f64> = 1e-3..=1e3;
/// The rule that [`IOR_RANGE`] makes.
pub(super) const IOR_RULE: &str = "from 0.001 to 1000 (air 1, water 1.33, glass 1.5)";
/// The rule for shares and weights.
pub(super) const SHARE_RULE: &str = "from 0 to 1";

/// The rule for priorities.
pub(super) const PRIORITY_RULE: &str = "a whole number from -1000 to 1000";

/// True for a priority.
fn is_priority(x: f64) -> bool {
    x.fract() == 0.0 && (-1000.0..=1000.0).contains(&x)
}

/// True for a share or weight.
pub(super) fn is_share(x: f64) -> bool {
    (0.0..=1.0).contains(&x)
}

/// Reads the table of material `name`. All but `diffuse` have defaults: `ambient` 0.1, `secondary` 0,
/// `fresnel` 1 (a mirror), `ior` 1.5, `priority` 0.
pub(super) fn material(name: &str, table: &Table) -> Result<Material, SceneError> {
    table.only(&["diffuse", "ambient", "secondary", "fresnel", "ior", "priority"])?;
    let or = |key, default, accept: fn(f64) -> bool, rule| match table.get(key) {
        Some(value) => value.number_where(accept, rule),
        None => Ok(default),
    };
    Ok(Material {
        name: name.to_owned(),
        diffuse: table.need("diffuse", "[0.8, 0.8, 0.8]")?.color()?,
        ambient: or("ambient", AMBIENT, within_f32, NOT_NEGATIVE)?,
        secondary: or("secondary", 0.0, is_share, SHARE_RULE)?,
        fresnel: table.get("fresnel").map_or(Ok(Fresnel::Constant(1.0)), |value| fresnel(&value))?,
        priority: or("priority", 0.0, is_priority, PRIORITY_RULE)? as i32,
        ior: or("ior", IOR, |x| IOR_RANGE.contains(&x), IOR_RULE)?,
        undrawn: None,
    })
}

fn fresnel(value: &Value) -> Result<Fresnel, SceneError> {
    const RULE: &str = "a number from 0 to 1, \"schlick\" or \"exact\"";
    if value.is_number() {
        return value.number_where(is_share, RULE).map(Fresnel::Constant);
    }
    if !value.is_text() {
        return Err(value.error(format!("`fresnel` is not {RULE}"), "write it as `fresnel = \"exact\"`"));
    }
    let word = value.text("\"exact\"")?;
    fresnel_word(word).ok_or_else(|| value.out_of_range(format!("\"{word}\""), RULE))
}

/// The Fresnel law with that name.
pub(super) fn fresnel_word(word: &str) -> Option<Fresnel> {
    match word {
        "schlick" => Some(Fresnel::Schlick),
        "exact" => Some(Fresnel::Exact),
        _ => None,
    }
}

/// The material of what has none: grey of 0.8, as most programs show it.
pub(super) fn plain(name: &str) -> Material {
    Material {
        name: name.to_owned(),
        diffuse: DVec3::splat(0.8),
        ambient: AMBIENT,
        secondary: 0.0,
        fresnel: Fresnel::Constant(1.0),
        ior: IOR,
        priority: 0,
        undrawn: None,
    }
}
