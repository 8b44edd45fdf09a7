//! What a render took beside what was planned, and what each feature that the scene lacks would have cost:
//! measured by switching it on for a share of the image, in turn with the kernels as they are.

use crate::plan::{HEAP_EIGHTHS, Plan};
use crate::render::{Observer, Quiet, RenderError, Renderer, Share};
use crate::report::explain::Outline;
use crate::report::receipt::{Absent, Part, Receipt};
use crate::report::{PassInfo, Report};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::forced_features::Feature;
use crate::stats::{Quartiles, quartiles};
use crate::units::bytes;

/// Runs of each variant, in turn with the render's own.
const PAIRS: usize = 5;
/// Device seconds of one run at most: a share of the bands is left out beyond.
const RUN_SECONDS: f64 = 0.15;

/// Why nothing, or not all, could be measured.
#[derive(Debug, thiserror::Error)]
pub enum ReceiptError {
    /// A render of the share failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Stopped by the user.
    #[error("interrupted; nothing is told of a part")]
    Interrupted,
}

/// Pixels whose bits differ; pictures of unequal sizes differ in all.
pub fn differing(a: &[[f32; 3]], b: &[[f32; 3]]) -> u64 {
    let bits = |p: &[f32; 3]| p.map(f32::to_bits);
    let unequal = a.iter().zip(b).filter(|(a, b)| bits(a) != bits(b)).count();
    (unequal + a.len().abs_diff(b.len())) as u64
}

/// Features whose code or buffers the planned kernels lack: with each, what the kernels are then made for.
fn absent(renderer: &Renderer, scene: &Scene, settings: &Settings, plan: &Plan) -> Vec<(Feature, Settings)> {
    let limits = renderer.device().limits();
    let with = |f: &Feature| {
        let mut s = settings.clone();
        s.schedule.general = s.schedule.general.with(*f);
        s
    };
    Feature::ALL
        .iter()
        .map(|f| (*f, with(f)))
        .filter(|(_, s)| {
            let packed = renderer.pack(scene, s, false);
            let other = Plan::new(&packed, s, &limits);
            other.is_ok_and(|p| p.specialisation != plan.specialisation || p.last_depth != plan.last_depth)
        })
        .collect()
}

/// Sets `report` beside `outline`, and measures what is absent.
///
/// # Errors
/// As [`Renderer::render`]; also if the observer cancels.
pub fn measure(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    outline: Outline,
    report: &Report,
    observer: &mut dyn Observer,
) -> Result<Receipt, ReceiptError> {
    let mut own = Share::new(renderer, scene, settings)?;
    let first = own.run(&mut Quiet)?;
    let bands = (RUN_SECONDS / first.device().max(1e-9) * first.bands.len() as f64) as usize;
    own.keep_bands(bands);
    let expected = own.run(&mut Quiet)?;
    let (settings, _) = renderer.trusted(settings);
    let mut subjects = absent(renderer, scene, &settings, own.plan());
    // Both variants have their buffers at once.
    let limits = renderer.device().limits();
    let mut why = None;
    if !subjects.is_empty() && own.plan().bytes() > limits.heap / 16 * HEAP_EIGHTHS {
        why = Some(format!(
            "two plans of {} do not fit the device beside each other; take a smaller image to see",
            bytes(own.plan().bytes())
        ));
        subjects.clear();
    }
    let mut rows = Vec::with_capacity(subjects.len());
    for (i, (feature, general)) in subjects.iter().enumerate() {
        observer.progress(i as u64, subjects.len() as u64);
        if observer.cancelled() {
            return Err(ReceiptError::Interrupted);
        }
        rows.push(price(renderer, scene, *feature, general, &mut own, &expected.linear)?);
    }
    let predicted = outline.time.as_ref().map(|t| t.render).filter(|t| *t > 0.0);
    let rays = outline.time.as_ref().map(|t| t.rays as f64).filter(|r| *r > 0.0);
    Ok(Receipt {
        parts: parts(&report.passes),
        render: report.time.render,
        over_predicted: predicted.map(|t| report.time.render / t),
        rays_over_predicted: rays.map(|r| report.rays.total() as f64 / r),
        bytes_planned: own.plan().bytes(),
        bytes_taken: own.bytes_taken(),
        absent: rows,
        absent_unknown_why: why,
        samples: expected.report.rays.primary,
        pairs: PAIRS,
        outline,
    })
}

fn price(
    renderer: &mut Renderer,
    scene: &Scene,
    feature: Feature,
    general: &Settings,
    own: &mut Share,
    expected: &[[f32; 3]],
) -> Result<Absent, RenderError> {
    let mut other = Share::new(renderer, scene, general)?;
    other.take_bands(own);
    let warm = other.run(&mut Quiet)?;
    let mut ratios = Vec::with_capacity(PAIRS);
    for _ in 0..PAIRS {
        let (without, with) = (own.run(&mut Quiet)?.device(), other.run(&mut Quiet)?.device());
        ratios.push(with / without.max(f64::MIN_POSITIVE));
    }
    let none = Quartiles { lower: 1.0, median: 1.0, upper: 1.0 };
    Ok(Absent {
        feature: feature.name(),
        what: feature.what(),
        ratio: quartiles(&ratios).unwrap_or(none),
        prepare: other.prepared.as_secs_f64(),
        bytes: other.plan().bytes() as i64 - own.plan().bytes() as i64,
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
        // Zeros of either sign are other bits.
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
        let told: Vec<_> = all.iter().map(|p| (p.name.as_str(), p.launches, p.seconds, p.share)).collect();
        assert_eq!(told, [("generate", 2, 1.0, 0.25), ("shade", 4, 3.0, 0.75)]);
    }
}
