//! What is said of a number that was measured more than once: median and interquartile range, never
//! the mean alone.

/// The quarters of a sample.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Quartiles {
    /// A quarter of the values lies below.
    pub lower: f64,
    /// Half of them.
    pub median: f64,
    /// Three quarters.
    pub upper: f64,
}

impl Quartiles {
    /// Width of the middle half: the interquartile range.
    pub fn range(&self) -> f64 {
        self.upper - self.lower
    }
}

/// The quartiles of `values` in any order, linear between neighbours (type 7 of Hyndman and Fan, The
/// American Statistician 50(4), 1996). `None` if there are none, or one is not a number.
pub fn quartiles(values: &[f64]) -> Option<Quartiles> {
    let mut sorted = values.to_vec();
    if sorted.is_empty() || sorted.iter().any(|v| v.is_nan()) {
        return None;
    }
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let place = share * (sorted.len() - 1) as f64;
        let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
        // Equal neighbours first: infinity less infinity is no number.
        if low == high { low } else { low + (high - low) * place.fract() }
    };
    Some(Quartiles { lower: at(0.25), median: at(0.5), upper: at(0.75) })
}

/// The middle value; `None` as for [`quartiles`].
pub fn median(values: &[f64]) -> Option<f64> {
    quartiles(values).map(|q| q.median)
}

/// The mean of factors: the n-th root of their product. `None` if there are none, or one is not
/// greater than zero and finite.
pub fn geometric_mean(factors: &[f64]) -> Option<f64> {
    if factors.is_empty() || factors.iter().any(|f| !f.is_finite() || *f <= 0.0) {
        return None;
    }
    Some((factors.iter().map(|f| f.ln()).sum::<f64>() / factors.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answer, and what each planted mistake would give instead.
    #[test]
    fn quartiles_are_those_of_the_definition() {
        let values = [9.0, 1.0, 4.0, 100.0];
        let q = quartiles(&values).unwrap();
        assert_eq!((q.lower, q.median, q.upper, q.range()), (3.25, 6.5, 31.75, 28.5));
        let unsorted = (values[1] + values[2]) / 2.0;
        let (upper_middle, mean) = (9.0, values.iter().sum::<f64>() / 4.0);
        assert!([unsorted, upper_middle, mean].iter().all(|wrong| *wrong != q.median));
        assert_eq!(quartiles(&[5.0, 1.0, 3.0, 2.0, 4.0]).unwrap().range(), 2.0);
    }

    #[test]
    fn one_late_run_moves_the_mean_and_not_the_median() {
        let calm = [1.0, 1.0, 1.0, 1.0, 1.0];
        let late = [1.0, 1.0, 50.0, 1.0, 1.0];
        assert_eq!(quartiles(&calm), quartiles(&late));
    }

    #[test]
    fn order_does_not_matter() {
        assert_eq!(quartiles(&[3.0, -1.0, 2.0]), quartiles(&[2.0, 3.0, -1.0]));
        assert_eq!(median(&[3.0, -1.0, 2.0]), Some(2.0));
    }

    #[test]
    fn what_is_no_number_is_not_hidden() {
        assert_eq!((quartiles(&[]), quartiles(&[1.0, f64::NAN])), (None, None));
        assert_eq!(quartiles(&[7.0]).unwrap().range(), 0.0);
        assert_eq!(median(&[1.0, f64::INFINITY, f64::INFINITY]), Some(f64::INFINITY));
    }

    #[test]
    fn factors_are_averaged_as_factors() {
        // Halved and doubled is unchanged; the arithmetic mean says 1.25.
        assert!((geometric_mean(&[0.5, 2.0]).unwrap() - 1.0).abs() < 1e-15);
        assert_eq!((geometric_mean(&[]), geometric_mean(&[1.0, 0.0])), (None, None));
    }
}
