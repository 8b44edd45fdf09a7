//! Refines the truth until it is good enough for the points, then measures each point's error
//! against it.

use super::keys::{bias_key, scene_hash};
use super::plan::Watch;
use super::point::Words;
use super::record::Record;
use super::row::{Row, judge};
use super::run::Work;
use super::timing::WRITE_SECONDS;
use super::truth::{Identity, REPLICATES, Truth, TruthInfo, hidden_by_depth, limit_error};
use super::truth_tracer::{SweepError, Tracer, Watched};
use crate::accuracy::radiance_bound::radiance_limit;
use crate::accuracy::truncation::TruncationBound;
use crate::compare::metrics::compare;
use crate::render::samples::{Source, Traced};
use crate::render::{Observer, Renderer};
use crate::report::ProgramInfo;
use crate::settings::sampler::Sampler;
use crate::settings::{Origin, Precision, Settings};
use crate::units::figure;
use std::time::Instant;

/// Greatest depth of a truth.
const DEEPEST: u32 = 64;
/// Most refinements of a truth in one run.
const ROUNDS: u32 = 6;
/// Truncation of the truth (RMSE) that needs no greater depth: a thousandth of an 8-bit code.
const NEGLIGIBLE: f64 = 4e-6;
/// Samples per pixel from which the truncation of a depth is estimated.
const CUT_SAMPLES: u32 = REPLICATES;
/// Samples per pixel from which a bias is estimated. They are the same in both pictures, so that
/// most of their noise cancels.
const BIAS_SAMPLES: u32 = 2 * REPLICATES;

impl Work<'_> {
    /// A truth ten times better than the best point, or as good as the limit on its samples allows.
    pub(super) fn truth(
        &self,
        renderer: &mut Renderer,
        record: &mut Record,
        watch: &mut dyn Watch,
    ) -> Result<Truth, SweepError> {
        let mut truth = match self.stored(record) {
            Some(truth) => truth,
            None => {
                let mut observer = watch.begin("depth of the truth");
                let (depth, hidden) = self.depth(renderer, observer.as_mut())?;
                Truth::new(self.identity(depth), hidden)
            }
        };
        // So that a truth that is cut short is found again.
        let (identity, truncation) = (truth.identity.clone(), truth.truncation.clone());
        record.truth = Some(TruthInfo { identity, truncation, ..TruthInfo::default() });
        self.folder.write_json(record)?;
        let mut tracer = self.tracer(renderer, &self.truth_settings(truth.identity.depth))?;
        if truth.standard_error().is_infinite() {
            self.refine(&mut truth, &mut tracer, 0.0, 0, watch)?;
        }
        // A better truth may show that the smallest error is smaller than it seemed.
        for _ in 0..ROUNDS {
            let target = self.smallest_error(record, &truth)? / 10.0;
            if !truth.can_improve(target, self.plan.truth_samples) {
                break;
            }
            let ended = self.refine(&mut truth, &mut tracer, target, self.plan.truth_samples, watch);
            record.truth = Some(truth.info(self.smallest_error(record, &truth)?));
            self.folder.write_json(record)?;
            ended?;
        }
        let info = truth.info(self.smallest_error(record, &truth)?);
        watch.say(&format!(
            "truth: depth {}, {:.0} samples per pixel on average, standard error {}{}",
            info.identity.depth,
            info.samples_mean,
            figure(info.standard_error),
            if info.converged { "" } else { " (more than a tenth of the smallest error)" }
        ));
        record.truth = Some(info);
        Ok(truth)
    }

    /// The stored truth, if it belongs to this scene and is deep enough.
    fn stored(&self, record: &Record) -> Option<Truth> {
        let known = &record.truth.as_ref()?.identity;
        let deepest = self.plan.points.iter().map(|p| p.depth).max()?;
        if self.plan.fresh || known.depth < deepest || *known != self.identity(known.depth) {
            return None;
        }
        self.folder.truth(known)
    }

    fn identity(&self, depth: u32) -> Identity {
        let settings = self.truth_settings(depth);
        let tracer = match self.double {
            true => format!("f64 kernels on {}, {}", self.device.name, self.device.driver),
            false => "f64 oracle on the CPU".into(),
        };
        let program = ProgramInfo::default();
        Identity {
            tracer: format!("whitted {} {}, {tracer}", program.version, program.git),
            scene: scene_hash(&self.truth_scene),
            width: settings.width,
            height: settings.height,
            depth,
            seed: settings.seed,
        }
    }

    /// Depth of the truth, and a bound on the error that it hides.
    fn depth(
        &self,
        renderer: &mut Renderer,
        observer: &mut dyn Observer,
    ) -> Result<(u32, Option<TruncationBound>), SweepError> {
        if !self.double {
            // The oracle does not measure truncation, so it goes as deep as any truth.
            return Ok((DEEPEST, None));
        }
        let deepest =
            self.plan.points.iter().map(|p| p.depth).max().unwrap_or(1).max(self.plan.scene.render.depth);
        let mut depth = deepest.max(8);
        let limit = radiance_limit(&self.truth_scene);
        loop {
            let mut tracer = self.tracer(renderer, &self.truth_settings(depth))?;
            let traced = watched(&mut tracer, observer).trace(&self.pixels(), 0..CUT_SAMPLES)?;
            let hidden = hidden_by_depth(&traced, CUT_SAMPLES, &limit);
            if hidden.rms <= NEGLIGIBLE || depth >= DEEPEST {
                return Ok((depth, Some(hidden)));
            }
            depth = (2 * depth).min(DEEPEST);
        }
    }

    fn truth_settings(&self, depth: u32) -> Settings {
        let seeds: Vec<u32> = self.plan.points.iter().map(|p| p.seed).collect();
        let taken = |seed: &u32| seeds.contains(seed);
        Settings {
            samples: u32::MAX,
            depth,
            cutoff: 0.0,
            sampler: Sampler::Owen,
            replicates: REPLICATES,
            // A seed that no point uses: a shared seed would share, and hide, its error.
            seed: (0x7275_7468..).find(|s| !taken(s)).unwrap_or_default(),
            precision: Precision::Double,
            origin: Origin::Bound,
            crop: None,
            ..self.plan.base.clone()
        }
    }

    fn tracer(&self, renderer: &mut Renderer, settings: &Settings) -> Result<Tracer, SweepError> {
        if self.double {
            Tracer::device(renderer, &self.truth_scene, settings)
        } else {
            Ok(Tracer::oracle(&self.truth_scene, settings))
        }
    }

    fn pixels(&self) -> Vec<u32> {
        (0..self.plan.base.width * self.plan.base.height).collect()
    }

    /// Adds samples to the truth and stores it, also after an error.
    fn refine(
        &self,
        truth: &mut Truth,
        tracer: &mut Tracer,
        target: f64,
        most: u32,
        watch: &mut dyn Watch,
    ) -> Result<(), SweepError> {
        let mut observer = watch.begin("truth");
        let mut written = Instant::now();
        let mut show = |truth: &Truth, source: &mut Watched<'_>, done, total| {
            source.observer.progress(done, total);
            // For a process that is killed; a file that cannot be written is an error at the end.
            if written.elapsed().as_secs_f64() >= WRITE_SECONDS {
                drop(self.folder.write_truth(truth));
                written = Instant::now();
            }
        };
        let ended = truth.refine(&mut watched(tracer, observer.as_mut()), target, most, &mut show);
        self.folder.write_truth(truth)?;
        ended
    }

    /// The smallest RMSE of any point, with the truth's own noise subtracted.
    fn smallest_error(&self, record: &Record, truth: &Truth) -> Result<f64, SweepError> {
        let linear = truth.linear();
        let noise = truth.standard_error();
        let mut smallest = f64::INFINITY;
        for row in &record.rows {
            let total = compare(&self.folder.picture(row)?, &linear)?.rmse;
            // Half of the noise stays: the difference of two nearly equal squares is uncertain.
            let own = (total * total - noise * noise).max(noise * noise / 4.0).sqrt();
            smallest = smallest.min(own);
        }
        Ok(smallest)
    }

    /// Estimates each point's bias: its error in the limit of many samples. Points that differ only
    /// in samples, sampler or seed share one.
    pub(super) fn biases(
        &self,
        renderer: &mut Renderer,
        record: &mut Record,
        watch: &mut dyn Watch,
    ) -> Result<(), SweepError> {
        let depth = record.truth.as_ref().map_or(1, |t| t.identity.depth);
        let mut base: Option<Traced> = None;
        for point in &self.plan.points {
            let key = bias_key(&self.plan.base, depth, point);
            if record.limits.contains_key(&key) {
                continue;
            }
            let mut observer = watch.begin("bias");
            let all = self.pixels();
            if base.is_none() {
                let mut tracer = self.tracer(renderer, &self.truth_settings(depth))?;
                base = Some(watched(&mut tracer, observer.as_mut()).trace(&all, 0..BIAS_SAMPLES)?);
            }
            let own = self.truth_settings(depth);
            let settings = Settings {
                samples: u32::MAX,
                sampler: own.sampler,
                seed: own.seed,
                replicates: own.replicates,
                ..point.settings(&self.plan.base)
            };
            let scene = point.scene(&self.plan.scene);
            let mut tracer = Tracer::device(renderer, &scene, &settings)?;
            let traced = watched(&mut tracer, observer.as_mut()).trace(&all, 0..BIAS_SAMPLES)?;
            if let Some(base) = &base {
                record.limits.insert(key, limit_error(&traced, base, BIAS_SAMPLES));
            }
        }
        Ok(())
    }

    /// Fills the errors of all rows.
    pub(super) fn judge(&self, record: &mut Record, truth: &Truth) -> Result<(), SweepError> {
        let width = self.plan.base.width as usize;
        let linear = truth.linear();
        let noise = truth.standard_error();
        let exact: Vec<Row> =
            record.rows.iter().filter(|r| r.point.precision == Precision::Double.name()).cloned().collect();
        for row in &mut record.rows {
            let point = self.plan.points.iter().find(|p| self.key(p) == row.key);
            let key = point.map(|p| bias_key(&self.plan.base, truth.identity.depth, p));
            let bias = key.and_then(|k| record.limits.get(&k).copied());
            let image = self.folder.picture(row)?;
            let hidden = truth.truncation.as_ref().map(|t| t.rms);
            let mut error = judge(&image, &linear, width, noise, hidden, bias)?;
            let in_double = Words { precision: Precision::Double.name().into(), ..row.point.clone() };
            if let Some(other) = exact.iter().find(|r| r.point == in_double) {
                error.rounding = Some(compare(&image, &self.folder.picture(other)?)?.rmse);
            }
            row.error = Some(error);
        }
        Ok(())
    }
}

fn watched<'a>(tracer: &'a mut Tracer, observer: &'a mut dyn Observer) -> Watched<'a> {
    Watched { tracer, replicates: REPLICATES, observer }
}
