//! Numbers for people: three digits and a unit, whatever their size.

/// `1 sample`, `20 samples`.
pub fn plural(count: u64, noun: &str) -> String {
    format!("{} {noun}{}", grouped(count), if count == 1 { "" } else { "s" })
}

/// `12,345,678`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `512 B`, `61.5 MiB`, `2.00 GiB`.
pub fn bytes(bytes: u64) -> String {
    if bytes < 1024 {
        return format!("{bytes} B");
    }
    let scaled = |power: i32| bytes as f64 / 1024f64.powi(power);
    // 1023.5 and above would read as 1024 of the unit.
    let power = (1..=5).find(|&power| scaled(power) < 1023.5).unwrap_or(6);
    let unit = ["KiB", "MiB", "GiB", "TiB", "PiB", "EiB"][power as usize - 1];
    format!("{} {unit}", three_digits(scaled(power)))
}

/// Three digits and a factor: `12.3 M`; no factor below 1000.
pub fn short(count: f64) -> String {
    let count = rounded(count, 3);
    let (value, factor) = match count {
        c if c >= 1e15 => (c / 1e15, " P"),
        c if c >= 1e12 => (c / 1e12, " T"),
        c if c >= 1e9 => (c / 1e9, " G"),
        c if c >= 1e6 => (c / 1e6, " M"),
        c if c >= 1e3 => (c / 1e3, " k"),
        c => return format!("{c:.0}"),
    };
    format!("{}{factor}", three_digits(value))
}

/// Three digits and a unit: `1.23 s`, `45.6 ms`, `7.00 us`; from a minute on `1 min 23 s`, from an
/// hour on `2 h 5 min`.
pub fn seconds(time: f64) -> String {
    let whole = time.round();
    if whole >= 3600.0 {
        let minutes = (time / 60.0).round();
        return format!("{} h {} min", grouped((minutes / 60.0).floor() as u64), minutes % 60.0);
    }
    if whole >= 60.0 {
        return format!("{} min {} s", (whole / 60.0).floor(), whole % 60.0);
    }
    let (value, unit) = match rounded(time, 3) {
        t if t >= 1.0 || t == 0.0 => (t, "s"),
        t if t >= 1e-3 => (t * 1e3, "ms"),
        t if t >= 1e-6 => (t * 1e6, "us"),
        t => (t * 1e9, "ns"),
    };
    format!("{} {unit}", three_digits(value))
}

/// A plain number of at most six digits, with an exponent where it is very large or small.
pub fn number(value: f64) -> String {
    let value = rounded(value, 6);
    if value == 0.0 {
        "0".into()
    } else if (1e-4..1e9).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A measured value or an error: three significant digits, with an exponent below 0.001.
pub fn figure(value: f64) -> String {
    let rounded = rounded(value, 3);
    if rounded != 0.0 && rounded.abs() < 1e-3 { format!("{rounded:e}") } else { number(rounded) }
}

/// Rounds to a number of significant digits, so that 999.9 becomes 1000 before a unit is chosen.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

fn three_digits(value: f64) -> String {
    let decimals = match value {
        v if v >= 99.95 => 0,
        v if v >= 9.995 => 1,
        _ => 2,
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts() {
        assert_eq!([0, 999, 1000, 12_345_678].map(grouped), ["0", "999", "1,000", "12,345,678"]);
        assert_eq!([0.0, 999.0, 1234.0, 12.34e6, 5e9].map(short), ["0", "999", "1.23 k", "12.3 M", "5.00 G"]);
        assert_eq!([999.7, 999_999.0, 4e13, 7e17].map(short), ["1.00 k", "1.00 M", "40.0 T", "700 P"]);
        assert_eq!((plural(1, "light"), plural(0, "light")), ("1 light".into(), "0 lights".into()));
    }

    #[test]
    fn times() {
        let cases = [
            (0.0, "0.00 s"),
            (1.5, "1.50 s"),
            (0.25, "250 ms"),
            (0.9996, "1.00 s"),
            (42e-6, "42.0 us"),
            (3e-9, "3.00 ns"),
            (59.4, "59.4 s"),
            (59.6, "1 min 0 s"),
            (123.4, "2 min 3 s"),
            (3599.7, "1 h 0 min"),
            (86_400.0, "24 h 0 min"),
        ];
        for (time, text) in cases {
            assert_eq!(seconds(time), text);
        }
    }

    #[test]
    fn sizes() {
        let mib = 1 << 20;
        let cases = [0, 1023, 1024, mib - 1, 123 * mib / 2, 2048 * mib, u64::MAX].map(bytes);
        assert_eq!(cases, ["0 B", "1023 B", "1.00 KiB", "1.00 MiB", "61.5 MiB", "2.00 GiB", "16.0 EiB"]);
    }

    #[test]
    fn figures() {
        let cases = [0.0, 0.012_345, 1.5, 4.321e-5, 0.000_999_9, 12_345.0].map(figure);
        assert_eq!(cases, ["0", "0.0123", "1.5", "4.32e-5", "0.001", "12300"]);
    }

    #[test]
    fn plain_numbers() {
        let cases = [0.0, -0.0, 5.0, 0.1 + 0.2, -123.456_789, 1e75, 1e-30].map(number);
        assert_eq!(cases, ["0", "0", "5", "0.3", "-123.457", "1e75", "1e-30"]);
    }
}
