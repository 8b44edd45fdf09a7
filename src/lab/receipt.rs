//! Compares a render with its plan, and measures the cost of each feature that the scene does not
//! use: a part of the image is rendered with the feature switched on and without it, in turn.

use crate::plan::{HEAP_EIGHTHS, Purpose};
use crate::render::{Prepared, Quiet, RenderError, Renderer, Trial};
use crate::report::explain::ExplainedPlan;
use crate::report::receipt::{Absent, Part, Receipt};
use crate::report::{PassInfo, Report};
use crate::scene::Scene;
use crate::settings::forced_features::Feature;
use crate::stats::{Quartiles, quartiles};
use crate::units::bytes;

/// Paired runs per feature: one with it, one without.
const PAIRS: usize = 5;
/// Upper limit on one run, device seconds; longer runs trace fewer bands of the image.
const RUN_SECONDS: f64 = 0.05;

/// Why there is no receipt.
#[derive(Debug, thiserror::Error)]
pub enum ReceiptError {
    /// A trial render failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Stopped by the user.
    #[error("interrupted")]
    Interrupted,
}

/// Number of pixels whose bits differ. Pixels that only one picture has count as different.
pub fn differing(a: &[[f32; 3]], b: &[[f32; 3]]) -> u64 {
    let bits = |p: &[f32; 3]| p.map(f32::to_bits);
    let unequal = a.iter().zip(b).filter(|(a, b)| bits(a) != bits(b)).count();
    (unequal + a.len().abs_diff(b.len())) as u64
}

/// Compares `report` with `outline`, and measures the price of each feature that the kernels of
/// `prepared` do not have. `say` gets the name of each part before it is measured; `stop` ends the
/// work.
///
/// # Errors
/// As [`Renderer::render`]; also if stopped.
pub fn measure(
    renderer: &mut Renderer,
    scene: &Scene,
    prepared: &mut Prepared,
    outline: ExplainedPlan,
    report: &Report,
    say: &mut dyn FnMut(&str),
    stop: &dyn Fn() -> bool,
) -> Result<Receipt, ReceiptError> {
    let (plan, settings) = (prepared.plan().clone(), prepared.settings().clone());
    let bytes_taken = prepared.bytes_taken();
    let mut own = Trial::new(prepared);
    let first = own.run(&mut Quiet)?;
    own.keep_bands((RUN_SECONDS / first.device().max(1e-9) * first.bands.len() as f64) as usize);
    let expected = own.run(&mut Quiet)?;
    // Both variants need their buffers at the same time.
    let why = (plan.bytes() > renderer.device().limits().heap / 16 * HEAP_EIGHTHS).then(|| {
        format!(
            "it needs twice {} of device memory, which is too much; render a smaller image",
            bytes(plan.bytes())
        )
    });
    let mut rows = Vec::new();
    for feature in Feature::ALL.iter().filter(|_| why.is_none()) {
        if stop() {
            return Err(ReceiptError::Interrupted);
        }
        let mut with_feature = settings.clone();
        with_feature.schedule.forced_features = settings.schedule.forced_features.with(*feature);
        let built = renderer.build(scene, &with_feature, Purpose::Image)?;
        // A plan that is the same has the feature; one that does not fit has no price.
        let Ok(other) = built.planned.plan() else { continue };
        if other.specialisation == plan.specialisation && other.last_depth == plan.last_depth {
            continue;
        }
        say(&format!("the price of {}", feature.name()));
        let mut other = renderer.prepare_built(scene, built)?;
        rows.push(price(*feature, &mut other, &mut own, &expected.linear)?);
    }
    let predicted = outline.time.as_ref().map(|t| t.render).filter(|t| *t > 0.0);
    let rays = outline.time.as_ref().map(|t| t.rays as f64).filter(|r| *r > 0.0);
    Ok(Receipt {
        parts: parts(&report.passes),
        render: report.time.render,
        over_predicted: predicted.map(|t| report.time.render / t),
        rays_over_predicted: rays.map(|r| report.rays.total() as f64 / r),
        bytes_planned: plan.bytes(),
        bytes_taken,
        absent: rows,
        absent_unknown_why: why,
        samples: expected.report.rays.primary,
        pairs: PAIRS,
        outline,
    })
}

/// The price of `feature`: device time and bytes of `other`, whose kernels have it, over those of
/// `own`.
fn price(
    feature: Feature,
    other: &mut Prepared,
    own: &mut Trial<'_>,
    expected: &[[f32; 3]],
) -> Result<Absent, RenderError> {
    let prepare = other.seconds();
    let mut other = Trial::new(other);
    other.take_bands(own);
    let warm = other.run(&mut Quiet)?;
    let mut ratios = Vec::with_capacity(PAIRS);
    for _ in 0..PAIRS {
        let (without, with) = (own.run(&mut Quiet)?.device(), other.run(&mut Quiet)?.device());
        ratios.push(with / without.max(f64::MIN_POSITIVE));
    }
    let none = Quartiles { lower: 1.0, median: 1.0, upper: 1.0 };
    let bytes = |t: &Trial<'_>| t.prepared().plan().bytes() as i64;
    Ok(Absent {
        feature: feature.name(),
        what: feature.what(),
        ratio: quartiles(&ratios).unwrap_or(none),
        prepare,
        bytes: bytes(&other) - bytes(own),
        pixels_differ: differing(&warm.linear, expected),
    })
}

fn parts(passes: &[PassInfo]) -> Vec<Part> {
    let total: f64 = passes.iter().map(|p| p.seconds).sum();
    let mut all: Vec<Part> = Vec::new();
    for kernel in crate::plan::passes::all().map(|p| p.kernel.name()) {
        let mine = || passes.iter().filter(|p| p.name == kernel);
        let seconds: f64 = mine().map(|p| p.seconds).sum();
        let launches = mine().map(|p| p.launches).sum();
        if launches > 0 {
            let share = if total > 0.0 { seconds / total } else { 0.0 };
            all.push(Part { name: kernel.into(), launches, seconds, share });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_bit_is_a_changed_pixel() {
        let a = vec![[0.5, 0.0, 1.0]; 3];
        let mut b = a.clone();
        assert_eq!(differing(&a, &b), 0);
        b[1][2] = f32::from_bits(1.0f32.to_bits() + 1);
        assert_eq!(differing(&a, &b), 1);
        // Zeros of opposite sign have different bits.
        b[0][1] = -0.0;
        assert_eq!(differing(&a, &b), 2);
        assert_eq!(differing(&a, &a[..1]), 2);
    }

    #[test]
    fn parts_are_sums_over_depths() {
        let pass = |name: &str, depth, seconds| PassInfo {
            name: name.into(),
            depth,
            launches: 2,
            seconds,
            items: 7,
        };
        let all = parts(&[pass("generate", 0, 1.0), pass("shade", 1, 2.0), pass("shade", 2, 1.0)]);
        let found: Vec<_> = all.iter().map(|p| (p.name.as_str(), p.launches, p.seconds, p.share)).collect();
        assert_eq!(found, [("generate", 2, 1.0, 0.25), ("shade", 4, 3.0, 0.75)]);
    }
}
