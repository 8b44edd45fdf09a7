//! What a render took beside what was planned, and what each feature that the scene lacks would have cost:
//! measured by switching it on for a share of the image, in turn with the kernels as they are.

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

/// Runs of each variant, in turn with the render's own.
const PAIRS: usize = 5;
/// Device seconds of one run at most: a share of the bands is left out beyond.
const RUN_SECONDS: f64 = 0.15;

/// What was planned, and what came of it.
#[derive(Debug, Clone, Serialize)]
pub struct Receipt {
    /// The plan, with the predicted time.
    pub outline: Outline,
    /// The passes, all depths together, in the frame's order.
    pub parts: Vec<Part>,
    /// Measured time of the render.
    pub render: f64,
    /// That over the predicted time; null where none was predicted.
    pub over_predicted: Option<f64>,
    /// Rays traced over those predicted.
    pub rays_over_predicted: Option<f64>,
    /// Device bytes planned.
    pub bytes_planned: u64,
    /// Bytes taken from device and host: alignment and the staging buffer come on top of those planned.
    pub bytes_taken: u64,
    /// What the image has not and did not pay for.
    pub absent: Vec<Absent>,
    /// Why `absent` is empty, where something is.
    pub absent_unknown_why: Option<String>,
    /// Samples of one run that measured them.
    pub samples: u64,
}

/// What one kernel took.
#[derive(Debug, Clone, Serialize)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Dispatches.
    pub launches: u64,
    /// Device time.
    pub seconds: f64,
    /// Of all passes.
    pub share: f64,
}

/// A feature that was not paid for.
#[derive(Debug, Clone, Serialize)]
pub struct Absent {
    /// Its name, as `--general` takes it.
    pub feature: &'static str,
    /// What was switched on.
    pub what: &'static str,
    /// Device time with it over that without, in paired runs.
    pub ratio: Quartiles,
    /// Time to prepare its kernels; from the driver's cache, if that has them.
    pub prepare: f64,
    /// Device bytes of its plan less those of the render's.
    pub bytes: i64,
    /// Pixels of the share whose bits differ: none, or something is wrong.
    pub pixels_differ: u64,
}

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

impl Receipt {
    /// Sets `report` beside `outline`, and measures what is absent.
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
            outline,
        })
    }

    /// Features whose kernels gave other bits than the render's.
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

/// The receipt for people: the plan, then what came of it.
pub fn text(r: &Receipt) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[("took", Left), ("dispatches", Right), ("time", Right), ("share", Right)]);
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
            ", {over:.2} of the predicted {}, {within} its range; {rays:.3} of the predicted rays",
            seconds(time.render)
        );
    }
    text += &format!(
        "\nbytes   {} planned, {} taken with alignment and staging\n\n",
        bytes(r.bytes_planned),
        bytes(r.bytes_taken)
    );
    if let Some(why) = &r.absent_unknown_why {
        return text + &format!("what is absent was not measured: {why}\n");
    }
    if r.absent.is_empty() {
        return text + "nothing is absent: the kernels are the general ones\n";
    }
    let mut table = Table::new(&[
        ("not paid for", Left),
        ("time", Right),
        ("quartiles", Left),
        ("bytes", Right),
        ("prepare", Right),
        ("image", Left),
        ("switched on", Left),
    ]);
    for a in &r.absent {
        let sign = if a.bytes < 0 { "-" } else { "+" };
        table.row([
            a.feature.into(),
            format!("x {:.2}", a.ratio.median),
            format!("{:.2} to {:.2}", a.ratio.lower, a.ratio.upper),
            format!("{sign}{}", bytes(a.bytes.unsigned_abs())),
            seconds(a.prepare),
            if a.pixels_differ == 0 { "same bits".into() } else { plural(a.pixels_differ, "other pixel") },
            a.what.into(),
        ]);
    }
    text + &format!(
        "{table}\ndevice time of {} samples with the feature over that without, medians of {PAIRS} runs in turn\n",
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
