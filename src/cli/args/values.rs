//! Values of options, checked as they are read.

use crate::image::Format;
use crate::scene::{MAX_DEPTH, MAX_SAMPLES, is_name};
use crate::settings::DeviceChoice;
use clap::builder::{PathBufValueParser, RangedU64ValueParser, TypedValueParser};
use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

/// Where the image goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Output {
    /// A PNG on standard output.
    Stdout,
    /// A file; its extension gave the format.
    File(PathBuf, Format),
    /// A share of an image, for `merge`.
    Share(PathBuf),
}

/// `WxH`, each from 1 to [`Size::MAX`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// `x0,y0,x1,y1` with `x0 < x1` and `y0 < y1`, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crop(pub [u32; 4]);

impl Size {
    /// Largest side: the number of pixels then fits 32 bits.
    pub const MAX: u32 = 65535;
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (width, height) =
            text.split_once(['x', 'X']).ok_or("give width and height in pixels, such as 600x500")?;
        let side = |text: &str| match text.parse() {
            Ok(side @ 1..=Size::MAX) => Ok(side),
            _ => Err(format!("width and height are whole numbers from 1 to {}", Size::MAX)),
        };
        Ok(Size { width: side(width)?, height: side(height)? })
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        let Some([x0, y0, x1, y1]) = numbers.ok().and_then(|n| <[u32; 4]>::try_from(n).ok()) else {
            return Err("give four whole numbers in pixels, such as 0,0,300,250".into());
        };
        if x0 >= x1 || y0 >= y1 {
            return Err("the crop is empty: x0 < x1 and y0 < y1 must hold".into());
        }
        Ok(Crop([x0, y0, x1, y1]))
    }
}

/// A parser of [`Output`].
pub(super) fn output() -> impl TypedValueParser<Value = Output> {
    PathBufValueParser::new().try_map(|path| {
        if path.as_os_str() == "-" {
            return Ok(Output::Stdout);
        }
        match Format::of(&path) {
            Some(format) => Ok(Output::File(path, format)),
            None if path.extension().is_some_and(|e| e == "share") => Ok(Output::Share(path)),
            None => Err(format!(
                "the extension must be {}, .share with --share, or the name `-` for a PNG on standard output",
                Format::EXTENSIONS
            )),
        }
    })
}

/// A parser of names of image files.
pub(super) fn image() -> impl TypedValueParser<Value = (PathBuf, Format)> {
    PathBufValueParser::new().try_map(|path| match Format::of(&path) {
        Some(format) => Ok((path, format)),
        None => Err(format!("the extension must be {}", Format::EXTENSIONS)),
    })
}

/// A parser of names of PNG files.
pub(super) fn png() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match Format::of(&path) {
        Some(Format::Png(_)) => Ok(path),
        _ => Err("the extension must be .png"),
    })
}

/// A parser of names of HTML files.
pub(super) fn html() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("html") => Ok(path),
        _ => Err("the extension must be .html"),
    })
}

/// A parser of whole numbers from 1.
pub(super) fn positive() -> RangedU64ValueParser<u32> {
    RangedU64ValueParser::new().range(1..)
}

/// A parser of samples per pixel, as in a scene text.
pub(super) fn samples() -> RangedU64ValueParser<u32> {
    RangedU64ValueParser::new().range(1..=u64::from(MAX_SAMPLES))
}

/// A parser of depths, as in a scene text.
pub(super) fn depth() -> RangedU64ValueParser<u32> {
    RangedU64ValueParser::new().range(1..=u64::from(MAX_DEPTH))
}

/// A parser of whole numbers from 2.
pub(super) fn two_or_more() -> RangedU64ValueParser<u32> {
    RangedU64ValueParser::new().range(2..=1 << 16)
}

/// A factor in (0, 1].
pub(super) fn scale(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(scale) if scale > 0.0 && scale <= 1.0 => Ok(scale),
        _ => Err("the factor must be above 0 and at most 1".into()),
    }
}

/// A finite number from 0.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x >= 0.0 => Ok(x),
        _ => Err("write a number from 0".into()),
    }
}

/// A finite number above 0.
pub(super) fn above_zero(text: &str) -> Result<f64, String> {
    not_negative(text).ok().filter(|x| *x > 0.0).ok_or_else(|| "write a number above 0".into())
}

/// `NAME=VALUE`, on one line.
pub(super) fn variable(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, _)) if !is_name(name) => Err(format!("`{name}` is no name: use letters, digits and `_`")),
        Some((_, value)) if value.contains(char::is_control) => Err("the value must be on one line".into()),
        Some((name, value)) => Ok((name.into(), value.into())),
        None => Err("write NAME=VALUE".into()),
    }
}

/// A probability in (0, 1).
pub(super) fn confidence(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("the confidence must be above 0 and below 1: 0.95 is nineteen times in twenty".into()),
    }
}

/// A probability in (0, 1).
pub(super) fn significance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("the significance must be above 0 and below 1: 0.01 is one false alarm in a hundred".into()),
    }
}

/// An empty text (an empty environment variable) leaves the choice open.
pub(super) fn device(text: &str) -> Result<DeviceChoice, Infallible> {
    if text.is_empty() { Ok(DeviceChoice::Best) } else { text.parse() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sizes() {
        assert_eq!("600x500".parse(), Ok(Size { width: 600, height: 500 }));
        assert_eq!("1X65535".parse(), Ok(Size { width: 1, height: 65535 }));
        for bad in ["", "600", "0x5", "5x0", "-1x5", "1.5x2", "5x65536", "5x5x5", "x"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }

    #[test]
    fn crops() {
        assert_eq!("0,0,3, 2".parse(), Ok(Crop([0, 0, 3, 2])));
        for bad in ["", "1,2,3", "0,0,0,2", "3,0,2,1", "0,0,1,1,1", "-1,0,1,1", "a,b,c,d"] {
            assert!(bad.parse::<Crop>().is_err(), "{bad}");
        }
    }

    #[test]
    fn scales() {
        assert_eq!(scale("0.25"), Ok(0.25));
        for bad in ["0", "-1", "1.01", "NaN", "inf", ""] {
            assert!(scale(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn variables() {
        assert_eq!(variable("a_1=x=y"), Ok(("a_1".into(), "x=y".into())));
        assert_eq!(variable("a="), Ok(("a".into(), String::new())));
        for bad in ["", "a", "=1", "1a=1", "a b=1", "a=1\n2"] {
            assert!(variable(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn confidences() {
        assert_eq!((confidence("0.5"), confidence("0.999")), (Ok(0.5), Ok(0.999)));
        for bad in ["0", "1", "95", "-0.1", "NaN", ""] {
            assert!(confidence(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn significances() {
        assert_eq!((significance("0.01"), significance("1e-9")), (Ok(0.01), Ok(1e-9)));
        for bad in ["0", "1", "5", "-0.1", "NaN", ""] {
            assert!(significance(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn thresholds() {
        assert_eq!((not_negative("0"), not_negative("1e-3"), above_zero("2")), (Ok(0.0), Ok(1e-3), Ok(2.0)));
        for bad in ["-1", "NaN", "inf", "", "x"] {
            assert!(not_negative(bad).is_err() && above_zero(bad).is_err(), "{bad}");
        }
        assert!(above_zero("0").is_err());
    }

    proptest! {
        #[test]
        fn good_sizes_and_crops_come_back(a in 1u32..=Size::MAX, b in 1u32..=Size::MAX, x in 0u32..9, y in 0u32..9) {
            prop_assert_eq!(format!("{a}x{b}").parse(), Ok(Size { width: a, height: b }));
            let crop = [x, y, x + a, y + b];
            prop_assert_eq!(format!("{},{}, {},{}", crop[0], crop[1], crop[2], crop[3]).parse(), Ok(Crop(crop)));
            let empty = format!("{},{},{},{}", x + a, y, x, y + b).parse::<Crop>();
            prop_assert!(empty.is_err());
        }

        #[test]
        fn whatever_is_read_holds_what_it_promises(text in "[-+0-9xX,. ]{0,24}", any in ".{0,12}") {
            for text in [&text, &any] {
                if let Ok(Size { width, height }) = text.parse() {
                    prop_assert!((1..=Size::MAX).contains(&width) && (1..=Size::MAX).contains(&height));
                }
                if let Ok(Crop([x0, y0, x1, y1])) = text.parse() {
                    prop_assert!(x0 < x1 && y0 < y1);
                }
                if let Ok(scale) = scale(text) {
                    prop_assert!(scale > 0.0 && scale <= 1.0);
                }
            }
        }
    }
}
