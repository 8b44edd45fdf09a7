//! Pieces of HTML: text, numbers, tables, embedded files.

use std::fmt::Write;

/// An error with three significant digits, or `-` if it is unknown.
pub(crate) fn error(x: Option<f64>) -> String {
    match x {
        None => "-".into(),
        Some(x) if x == 0.0 || !x.is_finite() => format!("{x}"),
        Some(x) if x.abs() < 1e-3 => format!("{x:.2e}"),
        Some(x) => {
            let decimals = (2.0 - x.abs().log10().floor()).clamp(0.0, 5.0) as usize;
            format!("{x:.decimals$}")
        }
    }
}

/// Text that is no markup.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A section: heading, a note on how to read it (HTML), and a table whose first `words` columns are
/// flush left. Empty if there are no rows.
pub(crate) fn section<const N: usize>(
    title: &str,
    note: &str,
    (words, heads): (usize, &[&str; N]),
    rows: impl Iterator<Item = [String; N]>,
) -> String {
    let line = |tag: &str, cells: &[String]| {
        let mut line = String::from("<tr>");
        for (i, cell) in cells.iter().enumerate() {
            let class = if i < words { " class=\"l\"" } else { "" };
            let _ = write!(line, "<{tag}{class}>{}</{tag}>", escaped(cell));
        }
        line + "</tr>\n"
    };
    let body: String = rows.map(|row| line("td", &row)).collect();
    if body.is_empty() {
        return String::new();
    }
    let id = title.to_lowercase().replace(' ', "-");
    let heads = line("th", &heads.map(String::from));
    format!(
        "<h2 id=\"{id}\">{title}</h2>\n<p>{note}</p>\n<div class=\"scroll\"><table><thead>{heads}</thead><tbody>\n{body}</tbody></table></div>\n"
    )
}

/// Names and their values (HTML), one line each.
pub(crate) fn facts(list: &[(&str, String)]) -> String {
    let items: Vec<String> =
        list.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{value}</dd>")).collect();
    format!("<dl class=\"facts\">{}</dl>\n", items.join("\n"))
}

/// A PNG file as the address of an image.
pub(crate) fn data_url(png: &[u8]) -> String {
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

    #[test]
    fn errors_have_three_digits() {
        let cases = [Some(0.0), Some(0.012_345), Some(0.0098), Some(1.5), Some(123.4), Some(4.321e-5), None];
        assert_eq!(cases.map(error), ["0", "0.0123", "0.00980", "1.50", "123", "4.32e-5", "-"]);
    }

    #[test]
    fn columns_of_words_are_flush_left() {
        let text = section("A b", "", (1, &["word", "x"]), [["<i>".into(), "2".into()]].into_iter());
        assert!(
            text.contains("<h2 id=\"a-b\">") && text.contains("<td class=\"l\">&lt;i&gt;</td><td>2</td>"),
            "{text}"
        );
        assert!(section("A b", "", (1, &["word"]), std::iter::empty()).is_empty());
    }
}
