//! Line-based texts as files hold them: which encoding, and which line ends.

use super::error::{SceneError, Source};
use std::borrow::Cow;

/// The text with line feeds as line ends, of the same length, so that places in it stay. Zero bytes at its end are cut off.
///
/// # Errors
/// The text is UTF-16.
pub(super) fn lines<'a>(source: Source<'a>, object: &str) -> Result<Cow<'a, [u8]>, SceneError> {
    let encoding = match source.text {
        [0xff, 0xfe, ..] => Some("UTF-16 (little-endian)"),
        [0xfe, 0xff, ..] => Some("UTF-16 (big-endian)"),
        // Text starts with characters of ASCII.
        [a, 0, b, 0, ..] if *a != 0 && *b != 0 => Some("UTF-16 (little-endian)"),
        [0, a, 0, b, ..] if *a != 0 && *b != 0 => Some("UTF-16 (big-endian)"),
        _ => None,
    };
    if let Some(encoding) = encoding {
        return Err(source.error(
            0,
            object,
            format!("the text is in {encoding}"),
            "save the file as UTF-8, or convert it, as by `iconv -f UTF-16 -t UTF-8`",
        ));
    }
    let end = source.text.iter().rposition(|b| *b != 0).map_or(0, |at| at + 1);
    let text = &source.text[..end];
    // Carriage returns alone end lines where there are no line feeds.
    if !text.contains(&b'\n') && text.contains(&b'\r') {
        return Ok(text.iter().map(|b| if *b == b'\r' { b'\n' } else { *b }).collect());
    }
    Ok(Cow::Borrowed(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn read(text: &[u8]) -> Result<Vec<u8>, String> {
        let source = Source { file: Path::new("t"), text };
        lines(source, "mesh").map(Cow::into_owned).map_err(|e| e.message)
    }

    #[test]
    fn line_ends_and_zeros() {
        assert_eq!(read(b"a\rb\r").unwrap(), b"a\nb\n");
        assert_eq!(read(b"a\r\nb\r").unwrap(), b"a\r\nb\r");
        assert_eq!(read(b"a\n\0\0").unwrap(), b"a\n");
        assert_eq!(read(b"\0\0").unwrap(), b"");
    }

    #[test]
    fn utf_16_is_named() {
        for (text, part) in [
            (&b"\xff\xfev\0 \0"[..], "little"),
            (b"\xfe\xff\0v\0 ", "big"),
            (b"v\0 \0", "little"),
            (b"\0v\0 ", "big"),
        ] {
            assert!(read(text).unwrap_err().contains(part));
        }
    }
}
