//! Pieces of HTML: text, numbers, tables, embedded files.

use crate::units::figure;
use std::fmt::Write;

/// A figure, or `-` if it is unknown.
pub(super) fn error(x: Option<f64>) -> String {
    x.map_or("-".into(), figure)
}

/// Text that is no markup.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A section: heading, a sentence on how to read it, and a table whose first column is text. Empty if there
/// are no rows. Cells but the first are HTML.
pub(super) fn section<const N: usize>(
    title: &str,
    note: &str,
    heads: &[&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> String {
    let mut body = String::new();
    for row in rows {
        for (i, cell) in row.iter().enumerate() {
            let _ = match i {
                0 => write!(body, "<tr><td class=\"l\">{}</td>", escaped(cell)),
                _ => write!(body, "<td>{cell}</td>"),
            };
        }
        body += "</tr>\n";
    }
    if body.is_empty() {
        return String::new();
    }
    let id = title.to_lowercase().replace(' ', "-");
    let heads: Vec<String> = heads.iter().map(|h| format!("<th>{}</th>", escaped(h))).collect();
    let heads = heads.concat().replacen("<th>", "<th class=\"l\">", 1);
    format!(
        "<h2 id=\"{id}\">{title}</h2>\n<p>{note}</p>\n<div class=\"scroll\"><table><thead><tr>{heads}</tr></thead><tbody>\n{body}</tbody></table></div>\n"
    )
}

/// A PNG file as the address of an image.
pub(super) fn data_url(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64(png))
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let word = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= three.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors of RFC 4648, section 10.
    #[test]
    fn base64_is_the_standards() {
        for (text, want) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
        ] {
            assert_eq!(base64(text.as_bytes()), want);
        }
    }

}
