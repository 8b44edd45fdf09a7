//! Measures how often the error bounds of `--budget` and `--error` and the time limit of `--time`
//! hold, over scenes and seeds. Every image is compared with a truth: the same scene in f64 with
//! many more samples.

pub mod families;
mod page;
mod record;
mod coverage;
mod trials;
mod truth;

pub use coverage::{Aim, Coverage, Verdict};
pub use record::{BudgetRow, Calibration, ErrorRow, Plan, SceneCalibration, TimeRow};
pub use trials::{BudgetTrial, ErrorTrial, TimeTrial, Uniform};
pub use truth::{Sought, Truth, TruthInfo, find};

use crate::accuracy::radiance_bound::radiance_limit;
use crate::render::{Observer, RenderError, Renderer};
use crate::scene::Scene;
use crate::settings::Settings;
use trials::Bench;

/// Standard error of a truth / the smallest error that is compared with it.
const TRUTH_SHARE: f64 = 0.1;
/// Expected true error / error asked for: images are better than their bound. Determines how good
/// the truth has to be.
const REACHED_SHARE: f64 = 0.5;
/// Most rays of one truth: some ten seconds on a CPU driver.
const TRUTH_RAYS: f64 = 2e7;
/// Share of the seeds for which a uniform render must reach the error.
const UNIFORM_SHARE: f64 = 0.95;
/// Most seeds that the uniform render is tried with.
const UNIFORM_SEEDS: u32 = 20;
/// Seed of warm-up runs, which compile kernels and estimate errors.
const WARM_SEED: u32 = 0;

/// Progress in trials; the progress of single renders is not shown.
struct Steps<'a> {
    observer: &'a mut dyn Observer,
    done: u64,
    total: u64,
}

impl Steps<'_> {
    fn step(&mut self, steps: u32) {
        self.done += u64::from(steps);
        self.observer.progress(self.done, self.total);
    }
}

impl Observer for Steps<'_> {
    fn progress(&mut self, _done: u64, _total: u64) {}

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}

impl Plan {
    /// Steps of one scene: its trials, and each truth as [`Plan::runs`] steps.
    fn steps(&self) -> u64 {
        let seeded = self.samples.len() as u64 + 2 * self.errors.len() as u64;
        let timed = self.times.len() as u64 + self.errors.len() as u64 + 2;
        u64::from(self.seeds) * seeded + u64::from(self.runs) * timed
    }
}

impl Calibration {
    /// Measures all scenes, given with their names. If `observer` cancels, the result is
    /// incomplete. `say` gets the name of each scene when it begins.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn measure(
        renderer: &mut Renderer,
        scenes: &[(String, Scene)],
        plan: &Plan,
        observer: &mut dyn Observer,
        say: &mut dyn FnMut(&str),
    ) -> Result<Calibration, RenderError> {
        let mut steps = Steps { observer, done: 0, total: plan.steps() * scenes.len() as u64 };
        let device = renderer.device().info();
        let mut all = Calibration { device, plan: plan.clone(), scenes: Vec::new(), complete: true };
        for (name, scene) in scenes {
            if steps.cancelled() {
                all.complete = false;
                break;
            }
            say(name);
            let mut row = SceneCalibration {
                name: name.clone(),
                depth: scene.render.depth,
                truth: None,
                truth_at_depth: None,
                budget: Vec::new(),
                error: Vec::new(),
                time: Vec::new(),
            };
            all.complete &= row.measure(renderer, scene, plan, &mut steps)?.is_some();
            all.scenes.push(row);
        }
        Ok(all)
    }
}

impl SceneCalibration {
    /// Fills the rows; `None` if cancelled.
    fn measure(
        &mut self,
        renderer: &mut Renderer,
        scene: &Scene,
        plan: &Plan,
        steps: &mut Steps<'_>,
    ) -> Result<Option<()>, RenderError> {
        let settings = Settings { width: plan.width, height: plan.height, ..Settings::of(scene) };
        let limit = radiance_limit(scene);
        let mut bench = Bench { renderer, scene, settings: settings.clone(), confidence: plan.confidence };

        let mut least = plan.errors.iter().fold(f64::INFINITY, |m, e| m.min(REACHED_SHARE * e));
        let mut at_depth = None;
        if let Some(most) = plan.samples.iter().max() {
            let Some(known) = bench.budget(WARM_SEED, *most, steps)? else { return Ok(None) };
            let estimate = known.report.error.map_or(0.0, |e| e.sampling_estimate);
            let sought = Sought {
                depth: Some(settings.depth),
                standard_error: TRUTH_SHARE * estimate,
                most_rays: TRUTH_RAYS,
            };
            let found = find(bench.renderer, scene, &settings, &limit, &sought, steps)?;
            let Some(found) = found else { return Ok(None) };
            self.truth_at_depth = Some(found.info.clone());
            at_depth = Some(found);
            least = least.min(estimate);
        }
        steps.step(plan.runs);
        let standard_error = TRUTH_SHARE * if least.is_finite() { least } else { 0.01 };
        let sought = Sought { depth: None, standard_error, most_rays: TRUTH_RAYS };
        let Some(truth) = find(bench.renderer, scene, &settings, &limit, &sought, steps)? else {
            return Ok(None);
        };
        self.truth = Some(truth.info.clone());
        steps.step(plan.runs);

        if let Some(at_depth) = &at_depth {
            for &samples in &plan.samples {
                let mut row = BudgetRow { samples, trials: Vec::new(), pixels: Coverage::default() };
                let done = budget(&mut bench, plan, &mut row, (&truth, at_depth), steps)?;
                self.budget.push(row);
                if done.is_none() {
                    return Ok(None);
                }
            }
        }
        for &target in &plan.errors {
            let mut row = ErrorRow { target, trials: Vec::new(), uniform: Uniform::default() };
            let done = error(&mut bench, plan, &mut row, &truth, steps)?;
            self.error.push(row);
            if done.is_none() {
                return Ok(None);
            }
        }
        for &asked in &plan.times {
            let mut row = TimeRow { asked, trials: Vec::new() };
            let done = time(&mut bench, plan, &mut row, &truth, steps)?;
            self.time.push(row);
            if done.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }
}

fn budget(
    bench: &mut Bench<'_>,
    plan: &Plan,
    row: &mut BudgetRow,
    (truth, at_depth): (&Truth, &Truth),
    steps: &mut Steps<'_>,
) -> Result<Option<()>, RenderError> {
    for seed in 1..=plan.seeds {
        let Some(known) = bench.budget(seed, row.samples, steps)? else { return Ok(None) };
        row.trials.push(BudgetTrial::of(&known, seed, truth, at_depth));
        steps.step(1);
    }
    // Each image has many edge pixels, so few images suffice.
    if row.samples >= 4 {
        for seed in 1..=plan.runs.min(plan.seeds) {
            let Some(share) = bench.pixels(seed, row.samples, at_depth, steps)? else { return Ok(None) };
            row.pixels = row.pixels.plus(share);
        }
    }
    Ok(Some(()))
}

fn error(
    bench: &mut Bench<'_>,
    plan: &Plan,
    row: &mut ErrorRow,
    truth: &Truth,
    steps: &mut Steps<'_>,
) -> Result<Option<()>, RenderError> {
    let target = row.target;
    let Some((_, used)) = bench.error(WARM_SEED, target, truth, steps)? else { return Ok(None) };
    for seed in 1..=plan.seeds {
        let Some((trial, _)) = bench.error(seed, target, truth, steps)? else { return Ok(None) };
        row.trials.push(trial);
        steps.step(1);
    }
    let seeds = plan.seeds.min(UNIFORM_SEEDS);
    let mut declines = Vec::new();
    for seed in 1..=seeds {
        let settings = Settings { seed, ..used.clone() };
        let Some(errors) = bench.decline(&settings, target, truth, steps)? else { return Ok(None) };
        declines.push(errors);
        steps.step(1);
    }
    steps.step(plan.seeds - seeds);
    row.uniform.seeds = seeds;
    row.uniform.samples = enough(&declines, target);
    let Some(samples) = row.uniform.samples else { return Ok(Some(())) };
    // In turn, so that a slower device slows both.
    for seed in 1..=plan.runs {
        let settings = Settings { seed, ..used.clone() };
        let Some((seconds, rays)) = bench.plain(&settings, samples, steps)? else { return Ok(None) };
        let Some((trial, _)) = bench.error(seed, target, truth, steps)? else { return Ok(None) };
        row.uniform.seconds.push(seconds);
        row.uniform.rays = rays;
        row.uniform.adaptive_seconds.push(trial.seconds);
        steps.step(1);
    }
    Ok(Some(()))
}

/// The smallest sample count from which nearly all seeds stay within `target`. `declines` holds,
/// per seed, the errors at rising sample counts, up to where they stay within it.
fn enough(declines: &[Vec<f64>], target: f64) -> Option<u32> {
    let counts = trials::counts();
    let good = |at: usize| {
        let below = declines.iter().filter(|errors| match errors.get(at) {
            Some(error) => *error <= target,
            None => errors.last().is_some_and(|last| *last <= target),
        });
        below.count() as f64 >= UNIFORM_SHARE * declines.len() as f64
    };
    counts.iter().enumerate().find(|(at, _)| good(*at)).map(|(_, count)| *count)
}

fn time(
    bench: &mut Bench<'_>,
    plan: &Plan,
    row: &mut TimeRow,
    truth: &Truth,
    steps: &mut Steps<'_>,
) -> Result<Option<()>, RenderError> {
    // Compiles the kernels.
    if bench.time(WARM_SEED, row.asked, truth, steps)?.is_none() {
        return Ok(None);
    }
    for seed in 1..=plan.runs {
        let Some(trial) = bench.time(seed, row.asked, truth, steps)? else { return Ok(None) };
        row.trials.push(trial);
        steps.step(1);
    }
    Ok(Some(()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_render_is_good_where_nearly_all_seeds_are() {
        // 1, 2, 3, 4, ... samples; one of the two lists ends early, being below.
        let slow = vec![0.5, 0.2, 0.09, 0.05];
        let fast = vec![0.3, 0.08, 0.07];
        assert_eq!(enough(&[slow.clone(), fast.clone()], 0.1), Some(3));
        assert_eq!(enough(&[fast.clone(), fast.clone()], 0.1), Some(2));
        assert_eq!(enough(&[vec![0.5; 4], fast], 0.1), None);
    }
}
