//! The page of two folders of pictures: a table of all pairs, the worst first, and the pictures of each pair with
//! their difference.

mod page;

pub use page::page;

use crate::compare::metrics::Metrics;
use crate::image::Picture;
use crate::lab::page::pictures;
use std::io;

/// Wider pictures are shrunk by a whole factor.
const WIDEST: u32 = 800;

/// Two folders, compared picture by picture.
#[derive(Debug, Clone, Default)]
pub struct Suite {
    /// The folders as given.
    pub folders: [String; 2],
    /// How the pairs were judged, in words.
    pub criterion: String,
    /// The command line.
    pub command: String,
    /// All pairs, the worst first.
    pub entries: Vec<Entry>,
}

/// A picture, or the lack of it, in both folders.
#[derive(Debug, Clone, Default)]
pub struct Entry {
    /// Path in its folder.
    pub name: String,
    /// Result.
    pub outcome: Outcome,
    /// None if the pictures cannot be compared.
    pub measured: Option<Measured>,
    /// None if the pictures cannot be compared.
    pub shown: Option<Shown>,
}

/// The result of a pair.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Outcome {
    /// There was nothing to keep: no threshold and no test.
    #[default]
    Measured,
    /// Within the threshold, or no significant difference.
    Passed,
    /// Not accepted, and why.
    Failed(String),
}

/// The figures of a pair.
#[derive(Debug, Clone, Copy, Default)]
pub struct Measured {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// All but FLIP.
    pub metrics: Metrics,
    /// Mean LDR-FLIP, 0 to 1.
    pub flip: f64,
    /// Largest |z| of a block, standard errors; None without a statistical test.
    pub z: Option<f64>,
}

/// The pictures of a pair as PNG.
#[derive(Debug, Clone)]
pub struct Shown {
    /// Width and height, shrunk; pixels.
    size: [u32; 2],
    a: Vec<u8>,
    /// The other picture and the difference; None if the pictures are equal.
    other: Option<[Vec<u8>; 2]>,
}

impl Shown {
    /// Two pictures of one size.
    ///
    /// # Errors
    /// If a PNG cannot be encoded.
    pub fn of(a: &Picture, b: &Picture) -> io::Result<Shown> {
        let whole = [a.width, a.height];
        let png = |picture: &Picture| pictures::picture(&picture.linear, whole, WIDEST);
        let other = match a.linear == b.linear {
            true => None,
            false => Some([png(b)?, pictures::difference(&a.linear, &b.linear, whole, WIDEST)?]),
        };
        Ok(Shown { size: pictures::fitted(whole, WIDEST).1, a: png(a)?, other })
    }
}
