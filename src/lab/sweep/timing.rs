//! Renders every point of the grid, several times, and stores its picture.

use super::folder::Folder;
use super::plan::Watch;
use super::point::Point;
use super::record::Record;
use super::row::{Measured, Row, Spread};
use super::run::Work;
use super::truth_tracer::SweepError;
use crate::render::{Checkpoints, Observer, RenderError, Rendered, Renderer, State};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::units::{plural, seconds};
use std::time::Instant;

/// A point that takes longer is rendered once, without a warm-up.
const LONG_SECONDS: f64 = 10.0;
/// Least time between two writes of the record, the truth, or the state of a point.
pub(super) const WRITE_SECONDS: f64 = 5.0;

impl Work<'_> {
    /// Measures the points that have no row yet. After an error the rows measured so far, in this
    /// run or an earlier one, are in `record`.
    pub(super) fn measure(
        &self,
        renderer: &mut Renderer,
        record: &mut Record,
        watch: &mut dyn Watch,
    ) -> Result<(), SweepError> {
        let total = self.plan.points.len();
        let mut written = Instant::now();
        let mut earlier = std::mem::take(&mut record.rows);
        for (i, point) in self.plan.points.iter().enumerate() {
            let (key, name) = (self.key(point), self.name(point));
            if let Some(at) = earlier.iter().position(|r| r.key == key) {
                // The axes may be named in another order now.
                record.rows.push(Row { name, ..earlier.swap_remove(at) });
                continue;
            }
            let mut observer = watch.begin(&format!("setting {} of {total}", i + 1));
            let measured = self.point(renderer, point, observer.as_mut());
            drop(observer);
            let row = match measured {
                Ok(Some(row)) => row,
                other => {
                    record.rows.append(&mut earlier);
                    return other.and(Err(SweepError::Stopped));
                }
            };
            let m = row.measured;
            let renders = plural(m.repeats.into(), "render");
            watch.say(&format!("{name}: {} (median of {renders})", seconds(m.render.median)));
            record.rows.push(row);
            // For a process that is killed; any other end writes the record anyway.
            if written.elapsed().as_secs_f64() < WRITE_SECONDS {
                continue;
            }
            written = Instant::now();
            let rows = record.rows.iter().chain(&earlier).cloned().collect();
            self.folder.write_json(&Record { rows, ..record.clone() })?;
        }
        Ok(())
    }

    /// Renders and times one point and stores its picture; `None` if cancelled.
    fn point(
        &self,
        renderer: &mut Renderer,
        point: &Point,
        observer: &mut dyn Observer,
    ) -> Result<Option<Row>, SweepError> {
        let scene = point.scene(&self.plan.scene);
        let settings = point.settings(&self.plan.base);
        let mut part = Part { inner: observer, index: 0, of: u64::from(self.plan.repeats) + 1 };
        let key = self.key(point);
        let mut last = self.resumable(renderer, &scene, &settings, &key, &mut part)?;
        let (mut device, mut render) = (Vec::new(), Vec::new());
        let mut note = |r: &Rendered| {
            device.push(r.report.time.device);
            render.push(r.report.time.render);
        };
        if last.done == 1.0 && last.report.time.render > LONG_SECONDS {
            note(&last);
        } else {
            for _ in 0..self.plan.repeats {
                if last.done < 1.0 || part.cancelled() {
                    return Ok(None);
                }
                part.index += 1;
                last = renderer.render_with(&scene, &settings, &mut part)?;
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
        let mut report = last.report.clone();
        report.image.file = Folder::picture_name(&key);
        self.folder.write_picture(&last, &report)?;
        Ok(Some(Row::new(key, self.name(point), point.words(), report, measured)))
    }

    /// Renders a point whose state is kept on the way, or goes on with what an earlier run kept of it.
    fn resumable(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
        settings: &Settings,
        key: &str,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, SweepError> {
        let mut prepared = renderer.prepare(scene, settings)?;
        // A state that is damaged, or that cannot be written, only costs time.
        let keep = |state: &dyn State| drop(self.folder.write_state(key, state));
        let mut rendered = {
            let observer = &mut Checkpoints::new(observer, Some(Box::new(keep)), WRITE_SECONDS);
            match self.folder.state(key).map(|earlier| prepared.resume(earlier, observer)) {
                None | Some(Err(RenderError::Mismatch(_))) => prepared.render_with(observer)?,
                Some(rendered) => rendered?,
            }
        };
        match rendered.state.take().filter(|_| rendered.done < 1.0) {
            Some(state) => self.folder.write_state(key, &state)?,
            None => self.folder.remove_state(key),
        }
        Ok(rendered)
    }

    /// The swept values of a point, in words.
    fn name(&self, point: &Point) -> String {
        let words = point.words();
        let parts: Vec<String> =
            self.plan.axes.iter().map(|axis| format!("{axis}={}", words.value(axis))).collect();
        if parts.is_empty() { "the scene's settings".into() } else { parts.join(" ") }
    }
}

/// Progress of one of several renders of a point, as part of the whole.
struct Part<'a> {
    inner: &'a mut dyn Observer,
    index: u64,
    of: u64,
}

impl Observer for Part<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        self.inner.progress(self.index * total + done, self.of * total);
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }
}
