//! Compares a render with its plan, and measures the cost of each feature that the scene does not use: a part of
//! the image is rendered with the feature switched on and without it, in turn.

use crate::plan::{HEAP_EIGHTHS, Plan};
use crate::render::{Observer, Quiet, RenderError, Renderer, Share};
use crate::report::explain::{self, Outline};
use crate::report::table::{Align, Table};
use crate::report::{PassInfo, Report};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::forced_features::Feature;
use crate::stats::{Quartiles, quartiles};
use crate::units::{bytes, grouped, plural, seconds};
use serde::Serialize;

/// Paired runs per feature: one with it, one without.
const PAIRS: usize = 5;
/// Upper limit on one run, device seconds; longer runs trace fewer bands of the image.
const RUN_SECONDS: f64 = 0.15;

/// A render next to its plan.
#[derive(Debug, Clone, Serialize)]
pub struct Receipt {
    /// The plan with the predicted time.
    pub outline: Outline,
    /// Cost of each kernel, summed over depths, in the order of dispatch.
    pub parts: Vec<Part>,
    /// Measured render time, seconds.
    pub render: f64,
    /// Measured render time / predicted; null without a prediction.
    pub over_predicted: Option<f64>,
    /// Rays traced / predicted; null without a prediction.
    pub rays_over_predicted: Option<f64>,
    /// Device bytes planned.
    pub bytes_planned: u64,
    /// Bytes allocated on device and host: planned bytes, alignment and staging buffer.
    pub bytes_taken: u64,
    /// Features that the scene does not use and the kernels leave out.
    pub absent: Vec<Absent>,
    /// Why `absent` is empty although some feature is left out.
    pub absent_unknown_why: Option<String>,
    /// Samples traced by each run that measured `absent`.
    pub samples: u64,
}

/// Cost of one kernel in a render.
#[derive(Debug, Clone, Serialize)]
pub struct Part {
    /// The kernel.
    pub name: String,
    /// Number of dispatches.
    pub launches: u64,
    /// Device time, seconds.
    pub seconds: f64,
    /// Share of the device time of all kernels, 0 to 1.
    pub share: f64,
}

/// A feature left out of the kernels, with its cost if it were not.
#[derive(Debug, Clone, Serialize)]
pub struct Absent {
    /// Its name in `--general`.
    pub feature: &'static str,
    /// What switching it on adds.
    pub what: &'static str,
    /// Device time with it / without it, over the paired runs.
    pub ratio: Quartiles,
    /// Seconds to create its pipelines; short if the driver has them cached.
    pub prepare: f64,
    /// Device bytes with it - without it.
    pub bytes: i64,
    /// Pixels whose bits differ from those without it; anything but 0 is a bug.
    pub pixels_differ: u64,
}

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

/// Features left out of the planned kernels, each with the settings that switch it on.
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

impl Receipt {
    /// Compares `report` with `outline`, and measures the features that are left out.
    ///
    /// # Errors
    /// As [`Renderer::render`]; also if the observer cancels.
    pub fn new(
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
        // Both variants need their buffers at the same time.
        let limits = renderer.device().limits();
        let mut why = None;
        if !subjects.is_empty() && own.plan().bytes() > limits.heap / 16 * HEAP_EIGHTHS {
            why = Some(format!(
                "it needs twice {} of device memory, which is too much; render a smaller image",
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
            outline,
        })
    }

    /// Features that change the image, which is a bug.
    pub fn wrong(&self) -> Vec<&'static str> {
        self.absent.iter().filter(|a| a.pixels_differ > 0).map(|a| a.feature).collect()
    }
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

/// The receipt for people: the plan, then the measurements.
pub fn text(r: &Receipt) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[("kernel", Left), ("dispatches", Right), ("time", Right), ("share", Right)]);
    for p in &r.parts {
        table.row([
            p.name.clone(),
            grouped(p.launches),
            seconds(p.seconds),
            format!("{:.1} %", 100.0 * p.share),
        ]);
    }
    let mut text = format!("{}\n{table}\n", explain::text(&r.outline));
    text += &format!("render  {}", seconds(r.render));
    if let (Some(time), Some(over), Some(rays)) = (&r.outline.time, r.over_predicted, r.rays_over_predicted) {
        let within = if (time.low..=time.high).contains(&r.render) { "within" } else { "outside" };
        text += &format!(
            ": {over:.2} times the predicted {}, {within} the predicted range; rays {rays:.3} times the predicted",
            seconds(time.render)
        );
    }
    text += &format!(
        "\nmemory  {} planned, {} allocated with alignment and staging\n\n",
        bytes(r.bytes_planned),
        bytes(r.bytes_taken)
    );
    if let Some(why) = &r.absent_unknown_why {
        return text + &format!("the cost of unused features was not measured: {why}\n");
    }
    if r.absent.is_empty() {
        return text + "no feature is left out of the kernels\n";
    }
    let mut table = Table::new(&[
        ("left out", Left),
        ("time with it", Right),
        ("middle half", Left),
        ("memory", Right),
        ("compile", Right),
        ("image", Left),
        ("what it would add", Left),
    ]);
    for a in &r.absent {
        let sign = if a.bytes < 0 { "-" } else { "+" };
        table.row([
            a.feature.into(),
            format!("x {:.2}", a.ratio.median),
            format!("{:.2} to {:.2}", a.ratio.lower, a.ratio.upper),
            format!("{sign}{}", bytes(a.bytes.unsigned_abs())),
            seconds(a.prepare),
            if a.pixels_differ == 0 { "same bits".into() } else { plural(a.pixels_differ, "different pixel") },
            a.what.into(),
        ]);
    }
    text + &format!(
        "{table}\ntime with it: device time of {} samples with the feature switched on / without it, median and \
         interquartile range of {PAIRS} paired runs\n",
        grouped(r.samples)
    )
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
