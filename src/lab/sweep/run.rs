//! The work of a sweep: render and time what is missing, make the truth good enough, judge.

use super::page;
use super::point::{Law, Point, Words};
use super::record::Record;
use super::row::{Measured, Row, Spread, judge};
use super::trace::{SweepError, Tracer, Watched};
use super::truth::{Identity, REPLICATES, Truth, hidden_by_depth, limit_error};
use crate::accuracy::radiance_bound::radiance_limit;
use crate::accuracy::truncation::TruncationBound;
use crate::atomic_file;
use crate::compare::metrics::compare;
use crate::image::{Format, Metadata, View};
use crate::render::samples::{Source, Traced};
use crate::render::{Observer, Rendered, Renderer};
use crate::report::ProgramInfo;
use crate::scene::{Fresnel, Scene};
use crate::settings::sampler::Sampler;
use crate::settings::{Origin, Precision, Settings};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A point whose render takes longer is measured once.
const LONG_SECONDS: f64 = 10.0;
/// Between two writings of the rows while points are measured.
const WRITE_SECONDS: f64 = 5.0;
/// The truth is no deeper.
const DEEPEST: u32 = 64;
/// Times that a truth is asked to be better still.
const ROUNDS: u32 = 6;
/// An RMSE that a truth's depth may hide without going deeper: a thousandth of an 8-bit code.
const NEGLIGIBLE: f64 = 4e-6;
/// Samples a pixel that say how much a depth cuts.
const CUT_SAMPLES: u32 = REPLICATES;
/// Samples a pixel behind what infinitely many samples would leave; the same in both pictures, so their noise
/// mostly cancels.
const LIMIT_SAMPLES: u32 = 2 * REPLICATES;

/// What to sweep.
#[derive(Debug, Clone)]
pub struct Plan {
    /// As read.
    pub scene: Scene,
    /// Size and scheduling; a planted defect, for the tests of the tests.
    pub base: Settings,
    /// Names of the axes, in the order given.
    pub axes: Vec<String>,
    /// The grid.
    pub points: Vec<Point>,
    /// Where everything goes.
    pub folder: PathBuf,
    /// Renders a point, after a warm-up.
    pub repeats: u32,
    /// Most samples of a pixel of the truth.
    pub truth_samples: u32,
    /// Errors to name the cheapest point for.
    pub errors: Vec<f64>,
    /// The command line, to be shown.
    pub command: String,
    /// Judge by the oracle even where the device has f64.
    pub oracle: bool,
    /// Forget earlier rows and truths.
    pub fresh: bool,
}

/// How a sweep is watched.
pub trait Watch {
    /// An observer for one piece of work; dropped at its end.
    fn begin(&mut self, what: &str) -> Box<dyn Observer>;
    /// A line about what is finished.
    fn say(&mut self, line: &str);
}

/// Runs a sweep and writes `sweep.json`, `sweep.csv`, the page, the truth and the pictures. After an error the rows
/// finished so far are in the files.
///
/// # Errors
/// If the device fails, a file cannot be written, or an observer cancels.
pub fn run(renderer: &mut Renderer, plan: &Plan, watch: &mut dyn Watch) -> Result<Record, SweepError> {
    let work = Work::new(renderer, plan);
    let mut record = work.begin()?;
    let ended = work.measure(renderer, &mut record, watch);
    work.save(&mut record)?;
    ended?;
    let truth = work.truth(renderer, &mut record, watch)?;
    work.limits(renderer, &mut record, watch)?;
    work.judge(&mut record, &truth)?;
    work.save(&mut record)?;
    page::write(&plan.folder, &record, &truth.linear())?;
    Ok(record)
}

struct Work<'a> {
    plan: &'a Plan,
    /// Scene of the truth: the exact Fresnel law if that is swept.
    judged_by: Scene,
    scene_hash: String,
    device: crate::report::DeviceInfo,
    /// The device traces the truth.
    double: bool,
}

impl<'a> Work<'a> {
    fn new(renderer: &Renderer, plan: &'a Plan) -> Work<'a> {
        let exact = Point { fresnel: Law::Forced(Fresnel::Exact), ..Point::of(&plan.scene) };
        let swept = plan.points.iter().any(|p| p.fresnel != Law::Scene);
        let judged_by = if swept { exact.scene(&plan.scene) } else { plan.scene.clone() };
        Work {
            plan,
            judged_by,
            scene_hash: scene_hash(&plan.scene),
            device: renderer.device().info(),
            double: renderer.device().has_double() && !plan.oracle,
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.plan.folder.join(name)
    }

    /// The rows of an earlier run that are still wanted.
    fn begin(&self) -> Result<Record, SweepError> {
        let points = self.path("points");
        fs::create_dir_all(&points).map_err(SweepError::file(&points))?;
        let path = self.path("sweep.json");
        let mut record = Record::default();
        if path.exists() && !self.plan.fresh {
            let text = fs::read_to_string(&path).map_err(SweepError::file(&path))?;
            record = serde_json::from_str(&text).map_err(|e| {
                let text = format!("it is not what an earlier sweep wrote ({e}); start over with --fresh");
                SweepError::File { path: path.clone(), error: std::io::Error::other(text) }
            })?;
        }
        let wanted: Vec<String> = self.plan.points.iter().map(|p| self.key(p)).collect();
        record.rows.retain(|row| {
            let there = wanted.contains(&row.key) && self.plan.folder.join(&row.image.file).is_file();
            if !wanted.contains(&row.key) {
                // A picture that no row names any more; if it cannot be removed it only takes room.
                let _ = fs::remove_file(self.plan.folder.join(&row.image.file));
            }
            there
        });
        let program = ProgramInfo::default();
        if record.scene_sha256 != self.scene_hash || record.device != self.device || record.program != program
        {
            record.limits.clear();
            record.truth = None;
        }
        let plan = self.plan;
        Ok(Record {
            program,
            device: self.device.clone(),
            command: plan.command.clone(),
            scene: plan.scene.file.display().to_string(),
            scene_sha256: self.scene_hash.clone(),
            width: plan.base.width,
            height: plan.base.height,
            axes: plan.axes.clone(),
            points: plan.points.len(),
            ..record
        })
    }

    /// All that a point's image and time depend on.
    fn key(&self, point: &Point) -> String {
        let s = &self.plan.base;
        let text = format!(
            "{:?} {:?} {} {:?} {}x{} {} {:?} {:?}",
            ProgramInfo::default(),
            self.device,
            self.scene_hash,
            point.words(),
            s.width,
            s.height,
            self.plan.repeats,
            s.planted,
            s.schedule
        );
        format!("{:x}", Sha256::digest(text))[..16].into()
    }

    /// The swept values, or all that there is to say.
    fn name(&self, point: &Point) -> String {
        let words = point.words();
        let of = |a: &String| format!("{a}={}", words.value(a));
        let parts: Vec<String> = self.plan.axes.iter().map(of).collect();
        if parts.is_empty() { "the scene's settings".into() } else { parts.join(" ") }
    }

    fn measure(
        &self,
        renderer: &mut Renderer,
        record: &mut Record,
        watch: &mut dyn Watch,
    ) -> Result<(), SweepError> {
        let total = self.plan.points.len();
        let mut written = Instant::now();
        let mut earlier = std::mem::take(&mut record.rows);
        for (i, point) in self.plan.points.iter().enumerate() {
            let key = self.key(point);
            if let Some(at) = earlier.iter().position(|r| r.key == key) {
                // The axes may be named in another order now.
                record.rows.push(Row { name: self.name(point), ..earlier.swap_remove(at) });
                continue;
            }
            let name = self.name(point);
            let mut observer = watch.begin(&format!("point {} of {total}", i + 1));
            let measured = self.point(renderer, point, observer.as_mut());
            drop(observer);
            let row = match measured {
                Ok(Some(row)) => row,
                other => {
                    // What was found earlier further on stays, whatever ended this.
                    record.rows.append(&mut earlier);
                    return other.and(Err(SweepError::Stopped));
                }
            };
            let (m, plural) = (row.measured, if row.measured.repeats == 1 { "render" } else { "renders" });
            watch.say(&format!(
                "{name}: {} ({} {plural})",
                crate::units::seconds(m.render.median),
                m.repeats
            ));
            record.rows.push(row);
            // For an end by force; at any other all is written. A big file is not written often.
            if written.elapsed().as_secs_f64() < WRITE_SECONDS {
                continue;
            }
            written = Instant::now();
            // Rows not reached yet in this run too.
            let whole =
                Record { rows: record.rows.iter().chain(&earlier).cloned().collect(), ..record.clone() };
            self.write_json(&whole)?;
        }
        Ok(())
    }

    /// Renders, times, and stores the picture; `None` if cancelled.
    fn point(
        &self,
        renderer: &mut Renderer,
        point: &Point,
        observer: &mut dyn Observer,
    ) -> Result<Option<Row>, SweepError> {
        let scene = point.scene(&self.plan.scene);
        let settings = point.settings(&self.plan.base);
        let mut whole = Share { inner: observer, index: 0, of: u64::from(self.plan.repeats) + 1 };
        let mut last = renderer.render_with(&scene, &settings, &mut whole)?;
        let (mut device, mut render) = (Vec::new(), Vec::new());
        let mut note = |r: &Rendered| {
            device.push(r.report.time.device);
            render.push(r.report.time.render);
        };
        if last.done == 1.0 && last.report.time.render > LONG_SECONDS {
            note(&last);
        } else {
            for _ in 0..self.plan.repeats {
                if last.done < 1.0 || whole.cancelled() {
                    return Ok(None);
                }
                whole.index += 1;
                last = renderer.render_with(&scene, &settings, &mut whole)?;
                note(&last);
            }
        }
        if last.done < 1.0 {
            return Ok(None);
        }
        let measured = Measured {
            repeats: render.len() as u32,
            device: Spread::of(&device),
            render: Spread::of(&render),
        };
        let key = self.key(point);
        let file = format!("points/{key}.exr");
        let path = self.path(&file);
        let mut report = last.report;
        report.image.file = file;
        let view = View { width: last.width, height: last.height, linear: &last.linear };
        let metadata = Metadata::of(&report, last.done);
        atomic_file::write(&path, |out| Format::Exr.encode(view, &metadata, out))
            .map_err(SweepError::file(&path))?;
        Ok(Some(Row::new(key, self.name(point), point.words(), report, measured)))
    }

    /// Settings of the truth at a depth.
    fn truth_settings(&self, depth: u32) -> Settings {
        let seeds: Vec<u32> = self.plan.points.iter().map(|p| p.seed).collect();
        let taken = |seed: &u32| seeds.contains(seed);
        Settings {
            samples: u32::MAX,
            depth,
            cutoff: 0.0,
            sampler: Sampler::Owen,
            replicates: REPLICATES,
            // None of the points', so that no error is hidden by being shared.
            seed: (0x7275_7468..).find(|s| !taken(s)).unwrap_or_default(),
            precision: Precision::Double,
            origin: Origin::Bound,
            crop: None,
            planted: None,
            ..self.plan.base.clone()
        }
    }

    fn tracer(&self, renderer: &mut Renderer, settings: &Settings) -> Result<Tracer, SweepError> {
        if self.double {
            Tracer::device(renderer, &self.judged_by, settings)
        } else {
            Ok(Tracer::oracle(&self.judged_by, settings))
        }
    }

    fn pixels(&self) -> Vec<u32> {
        (0..self.plan.base.width * self.plan.base.height).collect()
    }

    /// Depth of the truth, and what it cuts.
    fn depth(
        &self,
        renderer: &mut Renderer,
        observer: &mut dyn Observer,
    ) -> Result<(u32, Option<TruncationBound>), SweepError> {
        if !self.double {
            // The oracle does not say what it cuts; it goes as deep as any truth.
            return Ok((DEEPEST, None));
        }
        let deepest =
            self.plan.points.iter().map(|p| p.depth).max().unwrap_or(1).max(self.plan.scene.render.depth);
        let mut depth = deepest.max(8);
        let limit = radiance_limit(&self.judged_by);
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

    fn identity(&self, depth: u32) -> Identity {
        let settings = self.truth_settings(depth);
        let tracer = match self.double {
            true => format!("f64 kernels on {}, {}", self.device.name, self.device.driver),
            false => "f64 oracle on the host".into(),
        };
        let program = ProgramInfo::default();
        Identity {
            tracer: format!("whitted {} {}, {tracer}", program.version, program.git),
            scene: scene_hash(&self.judged_by),
            width: settings.width,
            height: settings.height,
            depth,
            seed: settings.seed,
        }
    }

    /// The stored truth, if it is still of this scene at a depth that will do.
    fn stored(&self, record: &Record) -> Option<Truth> {
        let known = &record.truth.as_ref()?.identity;
        let deepest = self.plan.points.iter().map(|p| p.depth).max()?;
        if self.plan.fresh || known.depth < deepest || *known != self.identity(known.depth) {
            return None;
        }
        let file = File::open(self.path("truth.bin")).ok()?;
        // One that cannot be read is made anew.
        Truth::load(&mut BufReader::new(file), known).ok()?
    }

    /// A truth good enough for the smallest error, or as good as allowed.
    fn truth(
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
            self.write_json(record)?;
            ended?;
        }
        record.truth = Some(truth.info(self.smallest_error(record, &truth)?));
        let info = record.truth.clone().unwrap_or_default();
        watch.say(&format!(
            "truth: depth {}, {:.0} samples a pixel on average, standard error {:.1e}{}",
            info.identity.depth,
            info.samples_mean,
            info.standard_error,
            if info.converged { "" } else { ", which is more than a tenth of the smallest error" }
        ));
        Ok(truth)
    }

    /// Samples for the truth; what there is is stored, whatever ended it.
    fn refine(
        &self,
        truth: &mut Truth,
        tracer: &mut Tracer,
        target: f64,
        most: u32,
        watch: &mut dyn Watch,
    ) -> Result<(), SweepError> {
        let mut observer = watch.begin("truth");
        let mut tell = |source: &mut Watched<'_>, done, total| source.observer.progress(done, total);
        let ended = truth.refine(&mut watched(tracer, observer.as_mut()), target, most, &mut tell);
        self.write_truth(truth)?;
        ended
    }

    /// The smallest error of any point, its share from the truth's noise taken off.
    fn smallest_error(&self, record: &Record, truth: &Truth) -> Result<f64, SweepError> {
        let linear = truth.linear();
        let noise = truth.standard_error();
        let mut smallest = f64::INFINITY;
        for row in &record.rows {
            let total = compare(&self.picture(row)?, &linear)?.rmse;
            // Half of the noise stays: a difference of two near equals says little.
            let own = (total * total - noise * noise).max(noise * noise / 4.0).sqrt();
            smallest = smallest.min(own);
        }
        Ok(smallest)
    }

    fn picture(&self, row: &Row) -> Result<Vec<[f32; 3]>, SweepError> {
        picture(&self.plan.folder, row)
    }

    /// What infinitely many samples would leave of each row's error.
    fn limits(
        &self,
        renderer: &mut Renderer,
        record: &mut Record,
        watch: &mut dyn Watch,
    ) -> Result<(), SweepError> {
        let depth = record.truth.as_ref().map_or(1, |t| t.identity.depth);
        let mut base: Option<Traced> = None;
        for point in &self.plan.points {
            let key = limit_key(&self.plan.base, depth, point);
            if record.limits.contains_key(&key) {
                continue;
            }
            let mut observer = watch.begin("what more samples cannot mend");
            let all = self.pixels();
            if base.is_none() {
                let mut tracer = self.tracer(renderer, &self.truth_settings(depth))?;
                base = Some(watched(&mut tracer, observer.as_mut()).trace(&all, 0..LIMIT_SAMPLES)?);
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
            let traced = watched(&mut tracer, observer.as_mut()).trace(&all, 0..LIMIT_SAMPLES)?;
            if let Some(base) = &base {
                record.limits.insert(key, limit_error(&traced, base, LIMIT_SAMPLES));
            }
        }
        Ok(())
    }

    fn judge(&self, record: &mut Record, truth: &Truth) -> Result<(), SweepError> {
        let width = self.plan.base.width as usize;
        let linear = truth.linear();
        let noise = truth.standard_error();
        let exact: Vec<Row> =
            record.rows.iter().filter(|r| r.point.precision == Precision::Double.name()).cloned().collect();
        for row in &mut record.rows {
            let point = self.plan.points.iter().find(|p| self.key(p) == row.key);
            let key = point.map(|p| limit_key(&self.plan.base, truth.identity.depth, p));
            let limit = key.and_then(|k| record.limits.get(&k).copied());
            let image = self.picture(row)?;
            let hidden = truth.truncation.as_ref().map(|t| t.rms);
            let mut error = judge(&image, &linear, width, noise, hidden, limit)?;
            let in_double = Words { precision: Precision::Double.name().into(), ..row.point.clone() };
            if let Some(other) = exact.iter().find(|r| r.point == in_double) {
                error.rounding = Some(compare(&image, &self.picture(other)?)?.rmse);
            }
            row.error = Some(error);
        }
        Ok(())
    }

    fn save(&self, record: &mut Record) -> Result<(), SweepError> {
        record.conclude(&self.plan.errors);
        self.write_json(record)?;
        let path = self.path("sweep.csv");
        atomic_file::write(&path, |out| out.write_all(record.csv().as_bytes()))
            .map_err(SweepError::file(&path))
    }

    fn write_json(&self, record: &Record) -> Result<(), SweepError> {
        let path = self.path("sweep.json");
        let write = |out: &mut dyn Write| {
            serde_json::to_writer_pretty(&mut *out, record)?;
            out.write_all(b"\n")
        };
        atomic_file::write(&path, write).map_err(SweepError::file(&path))
    }

    fn write_truth(&self, truth: &Truth) -> Result<(), SweepError> {
        let path = self.path("truth.bin");
        atomic_file::write(&path, |out| truth.save(out)).map_err(SweepError::file(&path))
    }
}

/// The stored picture of a row.
pub(super) fn picture(folder: &Path, row: &Row) -> Result<Vec<[f32; 3]>, SweepError> {
    let path = folder.join(&row.image.file);
    let broken = |error: ::image::ImageError| SweepError::File {
        path: path.clone(),
        error: std::io::Error::other(format!("{error}; start over with --fresh")),
    };
    let image = ::image::open(&path).map_err(broken)?.into_rgb32f();
    Ok(image.pixels().map(|p| p.0).collect())
}

fn watched<'a>(tracer: &'a mut Tracer, observer: &'a mut dyn Observer) -> Watched<'a> {
    Watched { tracer, replicates: REPLICATES, observer }
}

/// All that the limit of a point depends on.
fn limit_key(base: &Settings, truth_depth: u32, point: &Point) -> String {
    let Point { depth, cutoff, precision, .. } = point;
    let planted = base.planted.map_or(String::new(), |defect| format!(" planted {defect:?}"));
    format!(
        "{}x{} depth {depth} of {truth_depth} cutoff {cutoff} precision {} origin {} fresnel {} spheres {}{planted}",
        base.width,
        base.height,
        precision.name(),
        point.origin.name(),
        point.fresnel.name(),
        point.spheres.name()
    )
}

/// SHA-256 of all that a scene holds; the file's name does not count.
fn scene_hash(scene: &Scene) -> String {
    struct Into<'a>(&'a mut Sha256);
    impl std::fmt::Write for Into<'_> {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.update(text);
            Ok(())
        }
    }
    let mut hash = Sha256::new();
    // Its `Debug` text names every field, and each number in the digits that give it back.
    let _ = write!(Into(&mut hash), "{:?}", Scene { file: PathBuf::new(), ..scene.clone() });
    format!("{:x}", hash.finalize())
}

/// One of several renders of a point.
struct Share<'a> {
    inner: &'a mut dyn Observer,
    index: u64,
    of: u64,
}

impl Observer for Share<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        self.inner.progress(self.index * total + done, self.of * total);
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }
}
