//! Typed reading of TOML tables with exact places for the errors.

use super::error::{SceneError, Source, did_you_mean, list};
use super::notes::Reading;
use glam::DVec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The largest coordinate or length, metres: products of four lengths (the squared length of a cross
/// product) stay finite in f64, as 1e75^4 = 1e300 < 1.8e308.
pub(super) const MAX_LENGTH: f64 = 1e75;
/// Least size of anything: its square and fourth power stay normal as well.
pub(super) const MIN_LENGTH: f64 = 1e-75;

/// A TOML table that describes one object.
pub(super) struct Table<'a> {
    pub source: Source<'a>,
    /// "sphere 3", for messages.
    pub object: String,
    /// Byte offset of its header.
    pub offset: usize,
    pub entries: &'a DeTable<'a>,
}

impl<'a> Table<'a> {
    /// An error at the table's header.
    pub fn error(&self, message: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        self.source.error(self.offset, &self.object, message, remedy)
    }

    /// Refuses the first key (in the text's order) that is not among `known`.
    pub fn only(&self, known: &[&str]) -> Result<(), SceneError> {
        let unknown = self.entries.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let name = key.get_ref();
        let near = did_you_mean(name, known.iter().copied());
        Err(self.source.error(
            key.span().start,
            &self.object,
            format!("unknown key `{name}`{near}"),
            format!("remove it, or use one of {}", list(known.iter().copied())),
        ))
    }

    /// The value of `key`, if written.
    pub fn get(&'a self, key: &'a str) -> Option<Value<'a>> {
        let (_, value) = self.entries.iter().find(|(k, _)| k.get_ref() == key)?;
        Some(Value { source: self.source, object: &self.object, key, value })
    }

    /// The value of `key`; `example` shows how to write it if it is missing.
    pub fn need(&'a self, key: &'a str, example: &str) -> Result<Value<'a>, SceneError> {
        self.get(key).ok_or_else(|| {
            self.error(format!("`{key}` is missing"), format!("add a line such as `{key} = {example}`"))
        })
    }
}

/// One value with its place.
#[derive(Clone, Copy)]
pub(super) struct Value<'a> {
    pub source: Source<'a>,
    pub object: &'a str,
    pub key: &'a str,
    pub value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Value<'a> {
    /// An error at this value.
    pub fn error(&self, message: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        self.source.error(self.value.span().start, self.object, message, remedy)
    }

    /// Notes `message` here, or fails with it if the reading is strict.
    pub fn assume(&self, reading: &mut Reading, message: &str, remedy: &str) -> Result<(), SceneError> {
        reading.assume(self.source, self.value.span().start, self.object, message, remedy)
    }

    fn wrong_type(&self, wanted: &str, example: &str) -> SceneError {
        let found = match self.value.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        };
        self.error(
            format!("`{}` is {found} where {wanted} is wanted", self.key),
            format!("write it as `{example}`"),
        )
    }

    /// True for an integer or a float.
    pub fn is_number(&self) -> bool {
        matches!(self.value.get_ref(), DeValue::Integer(_) | DeValue::Float(_))
    }

    /// True for a string.
    pub fn is_text(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// A finite number; an integer counts as one.
    pub fn number(&self) -> Result<f64, SceneError> {
        let number = match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            DeValue::Integer(integer) => {
                u128::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64)
            }
            _ => return Err(self.wrong_type("a number", "1.5")),
        };
        number.filter(|x: &f64| x.is_finite()).ok_or_else(|| {
            self.error(format!("`{}` holds a number that is not finite", self.key), "write a finite number")
        })
    }

    /// A number that `accept` accepts; `rule` says which do ("greater than 0").
    pub fn number_where(&self, accept: impl Fn(f64) -> bool, rule: &str) -> Result<f64, SceneError> {
        let number = self.number()?;
        if accept(number) { Ok(number) } else { Err(self.out_of_range(number, rule)) }
    }

    /// This value lies outside its range.
    pub fn out_of_range(&self, number: impl std::fmt::Display, rule: &str) -> SceneError {
        self.error(
            format!("`{}` is {number}; it must be {rule}", self.key),
            format!("write a number that is {rule}"),
        )
    }

    /// A whole number in 1..=max.
    pub fn count(&self, max: u32) -> Result<u32, SceneError> {
        let rule = format!("a whole number from 1 to {max}");
        let number = self.number()?;
        let whole = number >= 1.0 && number <= f64::from(max) && number.fract() == 0.0;
        if whole { Ok(number as u32) } else { Err(self.out_of_range(number, &rule)) }
    }

    /// A string.
    pub fn text(&self, example: &str) -> Result<&'a str, SceneError> {
        match self.value.get_ref() {
            DeValue::String(text) => Ok(text.as_ref()),
            _ => Err(self.wrong_type("a string", example)),
        }
    }

    /// The items of a list.
    pub fn items(&self, wanted: &str, example: &str) -> Result<Vec<Value<'a>>, SceneError> {
        match self.value.get_ref() {
            DeValue::Array(items) => Ok(items.iter().map(|value| Value { value, ..*self }).collect()),
            _ => Err(self.wrong_type(wanted, example)),
        }
    }

    /// Three finite numbers.
    pub fn vector(&self) -> Result<DVec3, SceneError> {
        let items = self.items("a list of three numbers", "[0, 1, 0]")?;
        let [x, y, z] = items.as_slice() else {
            return Err(self.error(
                format!("`{}` has {} numbers; three are wanted", self.key, items.len()),
                "write it as `[0, 1, 0]`",
            ));
        };
        Ok(DVec3::new(x.number()?, y.number()?, z.number()?))
    }

    /// A position: three numbers within [`MAX_LENGTH`].
    pub fn position(&self) -> Result<DVec3, SceneError> {
        let position = self.vector()?;
        match position.abs().max_element() {
            largest if largest <= MAX_LENGTH => Ok(position),
            largest => Err(self.out_of_range(largest, &format!("at most {MAX_LENGTH:e} in size"))),
        }
    }

    /// A direction: three numbers, not all 0; returned as a unit vector.
    pub fn direction(&self) -> Result<DVec3, SceneError> {
        unit(self.vector()?).ok_or_else(|| {
            self.error(
                format!("`{}` has length 0, so it points nowhere", self.key),
                "write a direction such as `[0, 1, 0]`",
            )
        })
    }

    /// A colour: three numbers, none negative, all within f32, which the kernels hold.
    pub fn color(&self) -> Result<DVec3, SceneError> {
        let color = self.vector()?;
        let items = self.items("a list of three numbers", "[1, 1, 1]")?;
        for (item, channel) in items.iter().zip(color.to_array()) {
            if !within_f32(channel) {
                return Err(item.out_of_range(channel, NOT_NEGATIVE));
            }
        }
        Ok(color)
    }

    /// A number for all three channels, or a colour.
    pub fn grey_or_color(&self) -> Result<DVec3, SceneError> {
        if self.is_number() {
            self.number_where(within_f32, NOT_NEGATIVE).map(DVec3::splat)
        } else {
            self.color()
        }
    }
}

/// The rule that [`within_f32`] tests.
pub(super) const NOT_NEGATIVE: &str = "0 or more (and within single precision)";

/// True for what the kernels can hold as a weight or a colour.
pub(super) fn within_f32(x: f64) -> bool {
    (0.0..=f64::from(f32::MAX)).contains(&x)
}

/// `v` as a unit vector, whatever its scale; `None` if it is zero. A unit vector, up to rounding, stays as it is: what is
/// written to a file and read again keeps its bits.
pub(super) fn unit(v: DVec3) -> Option<DVec3> {
    // Three squares, each within 2u after normalize(), and their sum: 4 epsilon cover all.
    if (v.length_squared() - 1.0).abs() <= 4.0 * f64::EPSILON {
        return Some(v);
    }
    // Scaled first, so that no square over- or underflows.
    let largest = v.abs().max_element();
    (largest > 0.0).then(|| (v / largest).normalize())
}
