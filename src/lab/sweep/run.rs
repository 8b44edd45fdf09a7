//! A sweep from begin to end: renders and times the points, refines the truth, judges, writes the
//! page.

use super::folder::Folder;
use super::keys::{row_key, scene_hash};
use super::page;
use super::plan::{Plan, Watch};
use super::point::{Law, Point};
use super::record::Record;
use super::truth_tracer::SweepError;
use crate::render::Renderer;
use crate::report::{DeviceInfo, ProgramInfo};
use crate::scene::{Fresnel, Scene};

/// Runs a sweep and writes `sweep.json`, `sweep.csv`, the page, the truth and the pictures. After
/// an error the rows finished so far are in the files.
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
    work.biases(renderer, &mut record, watch)?;
    work.judge(&mut record, &truth)?;
    work.save(&mut record)?;
    page::write(work.folder, &record, &truth.linear())?;
    Ok(record)
}

/// What all steps of one sweep share.
pub(super) struct Work<'a> {
    pub(super) plan: &'a Plan,
    pub(super) folder: Folder<'a>,
    /// Scene of the truth: with the exact Fresnel law if the law is swept.
    pub(super) truth_scene: Scene,
    pub(super) device: DeviceInfo,
    /// True if the device traces the truth in f64, false if the oracle does.
    pub(super) double: bool,
    scene_hash: String,
}

impl<'a> Work<'a> {
    fn new(renderer: &Renderer, plan: &'a Plan) -> Work<'a> {
        let exact = Point { fresnel: Law::Forced(Fresnel::Exact), ..Point::of(&plan.scene) };
        let swept = plan.points.iter().any(|p| p.fresnel != Law::Scene);
        Work {
            plan,
            folder: Folder::new(&plan.folder),
            truth_scene: if swept { exact.scene(&plan.scene) } else { plan.scene.clone() },
            scene_hash: scene_hash(&plan.scene),
            device: renderer.device().info(),
            double: renderer.device().has_double() && !plan.oracle,
        }
    }

    /// The record of an earlier run, reduced to the rows that are still wanted, under this run's
    /// heading.
    fn begin(&self) -> Result<Record, SweepError> {
        self.folder.create()?;
        let plan = self.plan;
        let mut record = match plan.fresh {
            true => Record::default(),
            false => self.folder.record()?.unwrap_or_default(),
        };
        let wanted: Vec<String> = plan.points.iter().map(|p| self.key(p)).collect();
        self.folder.remove_states_but(if plan.fresh { &[] } else { &wanted });
        record.rows.retain(|row| {
            let there = wanted.contains(&row.key) && self.folder.has_picture(row);
            if !wanted.contains(&row.key) {
                self.folder.remove_picture(row);
            }
            there
        });
        let program = ProgramInfo::default();
        if record.scene_sha256 != self.scene_hash || record.device != self.device || record.program != program
        {
            record.limits.clear();
            record.truth = None;
        }
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

    pub(super) fn key(&self, point: &Point) -> String {
        row_key(self.plan, &self.device, &self.scene_hash, point)
    }

    fn save(&self, record: &mut Record) -> Result<(), SweepError> {
        record.conclude(&self.plan.errors);
        self.folder.write_json(record)?;
        self.folder.write_csv(record)
    }
}
