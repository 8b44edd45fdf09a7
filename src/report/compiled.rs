//! Compiled kernels as their driver describes them. Names and units are the driver's.

use crate::report::DeviceInfo;
use serde::Serialize;
use std::fmt;

/// The kernels of one scene on one device.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompiledKernels {
    /// The device.
    pub device: DeviceInfo,
    /// The scene's file, as given.
    pub scene: String,
    /// Invocations per workgroup.
    pub workgroup: u32,
    /// Words of a ray's traversal stack.
    pub stack: u32,
    /// In the order in which they run.
    pub kernels: Vec<CompiledKernel>,
}

/// One kernel in one form.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompiledKernel {
    /// Its name.
    pub kernel: String,
    /// `f32`, `packet` or `f64`.
    pub form: String,
    /// True if it runs only where a walk does not end in one dispatch.
    pub in_parts: bool,
    /// What the driver made of it; usually one.
    pub executables: Vec<Executable>,
}

/// One piece of machine code.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Executable {
    /// The driver's name for it.
    pub name: String,
    /// Invocations that run together.
    pub subgroup: u32,
    /// The driver's statistics, in its order.
    #[serde(rename = "statistics")]
    pub figures: Vec<Figure>,
    /// Intermediate and machine code, if asked for.
    #[serde(rename = "code", skip_serializing_if = "Vec::is_empty")]
    pub texts: Vec<Text>,
}

impl Executable {
    /// The statistic whose name the driver gives as `name`.
    pub fn figure(&self, name: &str) -> Option<Value> {
        self.figures.iter().find(|f| f.name == name).map(|f| f.value)
    }
}

/// A statistic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// The driver's name for it.
    pub name: String,
    /// The driver's description.
    #[serde(rename = "description")]
    pub meaning: String,
    /// What it counts.
    pub value: Value,
}

/// The value of a statistic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// Yes or no.
    Truth(bool),
    /// A whole number that may be negative.
    Signed(i64),
    /// A whole number.
    Whole(u64),
    /// A number.
    Real(f64),
}

impl fmt::Display for Value {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Truth(yes) => out.write_str(if *yes { "yes" } else { "no" }),
            Value::Signed(n) => write!(out, "{n}"),
            Value::Whole(n) => write!(out, "{n}"),
            Value::Real(x) => write!(out, "{x:.3}"),
        }
    }
}

/// A kernel in some language of the driver.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Text {
    /// The driver's name for the language.
    pub name: String,
    /// The code.
    pub text: String,
}
