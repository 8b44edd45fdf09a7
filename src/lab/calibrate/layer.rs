//! The layer of `--aov sampling` against the true errors of the pixels.

use super::coverage::Coverage;
use super::judge::{Reference, Shown};
use serde::{Deserialize, Serialize};

/// Standard errors of the truth within which a pixel is left out.
const DOUBT: f64 = 2.0;

/// How well a layer tells the errors of one image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerTrial {
    /// Edge pixels (whose samples took different paths) whose error is within the half-width.
    pub edges: Coverage,
    /// All pixels whose error is within the half-width.
    pub all: Coverage,
    /// Pixels left out of both counts: the truth is not exact enough to say.
    pub undecided: u64,
    /// Spearman's rank correlation of half-width and error; missing if either is constant.
    pub correlation: Option<f64>,
}

impl LayerTrial {
    /// Judges `half_widths`. The error of a pixel is that of its worst channel, as shown.
    pub fn of(half_widths: &[f64], edges: &[bool], image: &Shown, truth: &Reference) -> LayerTrial {
        let mut trial = LayerTrial::default();
        let mut errors = Vec::with_capacity(half_widths.len());
        for (at, half) in half_widths.iter().enumerate() {
            let (pixel, exact, variance) = (image.0[at], truth.pixels.0[at], truth.variance[at]);
            let worst = (0..3)
                .max_by(|a, b| (pixel[*a] - exact[*a]).abs().total_cmp(&(pixel[*b] - exact[*b]).abs()))
                .unwrap_or(0);
            let error = (pixel[worst] - exact[worst]).abs();
            errors.push(error);
            let doubt = DOUBT * variance[worst].sqrt() + truth.hidden;
            if doubt > 0.0 && (error - half).abs() <= doubt {
                trial.undecided += 1;
                continue;
            }
            let held = Coverage::of([error <= *half]);
            trial.all = trial.all.plus(held);
            if edges[at] {
                trial.edges = trial.edges.plus(held);
            }
        }
        trial.correlation = spearman(half_widths, &errors);
        trial
    }
}

/// Spearman's rank correlation (American Journal of Psychology 15, 1904), ties at their mean rank. `None` if a list is
/// constant or holds something that is not a number.
pub fn spearman(a: &[f64], b: &[f64]) -> Option<f64> {
    let (a, b) = (ranks(a)?, ranks(b)?);
    let middle = (a.len() as f64 - 1.0) / 2.0;
    let product =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - middle) * (y - middle)).sum::<f64>();
    let scale = (product(&a, &a) * product(&b, &b)).sqrt();
    (scale > 0.0).then(|| product(&a, &b) / scale)
}

fn ranks(values: &[f64]) -> Option<Vec<f64>> {
    if values.iter().any(|x| x.is_nan()) {
        return None;
    }
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut from = 0;
    for tied in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let rank = from as f64 + (tied.len() as f64 - 1.0) / 2.0;
        tied.iter().for_each(|at| ranks[*at] = rank);
        from += tied.len();
    }
    Some(ranks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rank_correlations_are_those_of_textbooks() {
        let close = |x: Option<f64>, want: f64| (x.unwrap() - want).abs() < 1e-12;
        assert!(close(spearman(&[1.0, 2.0, 30.0], &[0.1, 0.2, 0.3]), 1.0));
        assert!(close(spearman(&[1.0, 2.0, 3.0], &[3.0, 2.0, 1.0]), -1.0));
        // One swap of neighbours among four: 1 - 6 * 2 / (4 * 15).
        assert!(close(spearman(&[1.0, 2.0, 3.0, 4.0], &[1.0, 3.0, 2.0, 4.0]), 0.8));
        // Ties: ranks 0.5, 0.5, 2 against 0, 1, 2.
        assert!(close(spearman(&[5.0, 5.0, 7.0], &[1.0, 2.0, 3.0]), 1.5 / (1.5f64 * 2.0).sqrt()));
        assert_eq!((spearman(&[1.0, 1.0], &[1.0, 2.0]), spearman(&[f64::NAN], &[1.0])), (None, None));
    }

    #[test]
    fn pixels_are_counted_where_the_truth_can_tell() {
        let image = Shown(vec![[0.5; 3], [0.5, 0.6, 0.5], [0.5; 3]]);
        let truth = Reference {
            pixels: Shown(vec![[0.5; 3]; 3]),
            variance: vec![[0.0; 3], [0.0; 3], [1e-4; 3]],
            seeds: 4,
            hidden: 0.0,
        };
        let trial = LayerTrial::of(&[0.0, 0.05, 0.01], &[false, true, true], &image, &truth);
        assert_eq!((trial.all, trial.edges), (Coverage { kept: 1, of: 2 }, Coverage { kept: 0, of: 1 }));
        assert_eq!(trial.undecided, 1);
    }
}
