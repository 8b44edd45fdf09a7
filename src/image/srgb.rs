//! sRGB codes by comparison with exact thresholds: the same on every host and device, whatever
//! their `pow` does near a boundary.

use std::sync::LazyLock;

/// `thresholds(max)[k - 1]` = smallest `f32` whose sRGB encoding rounds to at least `k` of `max`.
fn thresholds(max: u16) -> Vec<f32> {
    (1..=max)
        .map(|k| {
            let edge = f64::from(k) - 0.5;
            let reaches = |x: f32| f64::from(max) * encode(f64::from(x)) >= edge;
            // A guess within an ulp or two, then walked to the exact boundary.
            let mut x = decode(edge / f64::from(max)) as f32;
            while !reaches(x) {
                x = x.next_up();
            }
            while reaches(x.next_down()) {
                x = x.next_down();
            }
            x
        })
        .collect()
}

/// IEC 61966-2-1, linear to encoded.
fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// IEC 61966-2-1, encoded to linear.
fn decode(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// `decoded(max)[k]` = linear value of code `k` of `max`.
fn decoded(max: u16) -> Vec<f32> {
    (0..=max).map(|k| decode(f64::from(k) / f64::from(max)) as f32).collect()
}

static EIGHT: LazyLock<Vec<f32>> = LazyLock::new(|| thresholds(u8::MAX.into()));
static SIXTEEN: LazyLock<Vec<f32>> = LazyLock::new(|| thresholds(u16::MAX));
static LINEAR_EIGHT: LazyLock<Vec<f32>> = LazyLock::new(|| decoded(u8::MAX.into()));
static LINEAR_SIXTEEN: LazyLock<Vec<f32>> = LazyLock::new(|| decoded(u16::MAX));

/// Number of thresholds at or below `x`: NaN and negative values give 0, +infinity the last code.
fn code(thresholds: &[f32], x: f32) -> usize {
    thresholds.partition_point(|&t| t <= x)
}

/// 8-bit sRGB code of a linear value, clamped to [0, 1].
pub fn code8(linear: f32) -> u8 {
    code(&EIGHT, linear) as u8
}

/// 16-bit sRGB code of a linear value, clamped to [0, 1].
pub fn code16(linear: f32) -> u16 {
    code(&SIXTEEN, linear) as u16
}

/// Linear value of an 8-bit sRGB code; [`code8`] gives the code back.
pub fn linear8(code: u8) -> f32 {
    LINEAR_EIGHT[usize::from(code)]
}

/// Linear value of a 16-bit sRGB code; [`code16`] gives the code back.
pub fn linear16(code: u16) -> f32 {
    LINEAR_SIXTEEN[usize::from(code)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The textbook encoder, kept as the judge.
    fn plain(x: f32, max: f64) -> f64 {
        (max * encode(f64::from(x))).round()
    }

    /// Each threshold gives its code, its predecessor the code before.
    fn holds(table: &[f32], code: impl Fn(f32) -> u32) -> bool {
        table.iter().zip(1u32..).all(|(&t, k)| code(t) == k && code(t.next_down()) == k - 1)
    }

    #[test]
    fn each_threshold_is_the_first_float_of_its_code() {
        let plain8 = |x: f32| plain(x, 255.0) as u32;
        assert_eq!(EIGHT.len(), 255);
        assert!(holds(&EIGHT, |x| code8(x).into()) && holds(&EIGHT, plain8));
        assert_eq!(SIXTEEN.len(), 65535);
        assert!(holds(&SIXTEEN, |x| code16(x).into()) && holds(&SIXTEEN, |x| plain(x, 65535.0) as u32));

        // Planted defects: one threshold off by one ulp either way is caught by the judge.
        for k in [0, 9, 127, 254] {
            for wrong in [EIGHT[k].next_up(), EIGHT[k].next_down()] {
                let mut table = EIGHT.clone();
                table[k] = wrong;
                assert!(!holds(&table, plain8), "threshold {k}");
            }
        }
    }

    #[test]
    fn codes_come_back() {
        assert!((0..=u8::MAX).all(|k| code8(linear8(k)) == k));
        assert!((0..=u16::MAX).all(|k| code16(linear16(k)) == k));
        assert_eq!((linear8(0), linear8(255), linear16(0), linear16(65535)), (0.0, 1.0, 0.0, 1.0));
        assert!((linear8(188) - 0.502_886).abs() < 1e-6, "mid grey of light");
    }

    #[test]
    fn odd_values_have_a_code() {
        for (x, code) in [(f32::NAN, 0), (-1.0, 0), (f32::NEG_INFINITY, 0), (-0.0, 0), (f32::MIN_POSITIVE, 0)]
        {
            assert_eq!((code8(x), code16(x)), (code, code.into()), "{x}");
        }
        for x in [f32::INFINITY, f32::MAX, 1.0, 1.5] {
            assert_eq!((code8(x), code16(x)), (255, 65535), "{x}");
        }
        assert_eq!(code8(0.214_041_14), 128, "mid grey: 0.5 encoded rounds up");
    }
}
