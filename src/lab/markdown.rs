//! Tables and numbers as Markdown.

use crate::report::table::Align;

/// A table; a bar inside a cell stays a bar.
pub(crate) fn table<const N: usize>(columns: &[(&str, Align); N], rows: &[[String; N]]) -> String {
    let line = |cells: [String; N]| format!("| {} |\n", cells.join(" | "));
    let mut text = line(columns.map(|(name, _)| name.replace('|', "\\|")));
    let rule = columns.map(|(_, align)| if align == Align::Right { "---:" } else { "---" });
    text += &format!("|{}|\n", rule.join("|"));
    rows.iter().for_each(|row| text += &line(row.clone().map(|cell| cell.replace('|', "\\|"))));
    text
}

/// Whole counts plainly, other numbers with three digits.
pub(crate) fn number(x: f64) -> String {
    match x {
        x if !x.is_finite() => format!("{x}"),
        x if x.fract() == 0.0 && x.abs() < 1e9 => format!("{x}"),
        x if (0.01..1000.0).contains(&x.abs()) => {
            let decimals = (2.0 - x.abs().log10().floor()).clamp(0.0, 4.0) as usize;
            format!("{x:.decimals$}")
        }
        x => format!("{x:.2e}"),
    }
}

/// `3.2 %`; small shares keep their digits.
pub(crate) fn percent(part: u64, whole: u64) -> String {
    let share = 100.0 * part as f64 / whole.max(1) as f64;
    if part == 0 {
        "0".into()
    } else if share < 0.1 {
        format!("{share:.4} %")
    } else {
        format!("{share:.2} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_rule_and_escapes_bars() {
        let rows = [["a|b".to_owned(), "1".to_owned()]];
        let text = table(&[("name", Align::Left), ("count", Align::Right)], &rows);
        assert_eq!(text, "| name | count |\n|---|---:|\n| a\\|b | 1 |\n");
        // Every line has as many columns as the heading, or the rest is dropped from view.
        for line in text.lines() {
            assert_eq!(line.replace("\\|", "").matches('|').count(), 3, "{line}");
        }
    }

    #[test]
    fn numbers_keep_three_digits() {
        let cases = [0.0, 12_345.0, 0.5, 1.23456, 99.951, 12.3456, 4.5e-7, 123_456.7, f64::NAN];
        let texts = ["0", "12345", "0.500", "1.23", "100.0", "12.3", "4.50e-7", "1.23e5", "NaN"];
        assert_eq!(cases.map(number), texts);
    }

    #[test]
    fn a_small_share_is_not_called_none() {
        assert_eq!(percent(1, 65_536), "0.0015 %");
        assert_eq!(
            (percent(0, 5), percent(1, 3), percent(3, 3)),
            ("0".into(), "33.33 %".into(), "100.00 %".into())
        );
    }
}
