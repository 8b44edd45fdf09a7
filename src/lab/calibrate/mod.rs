//! Calibration: how often the bounds of `--budget` and `--error` hold and `--time` is kept, what they cost, and on which
//! scenes they fail; on scenes drawn at random from families, which nobody has seen before, and on scene files.
//!
//! ```text
//! plan ─ scenes and trials            bench ─ renders of one scene
//! truth ─ mean of independent seeds   judge ─ true error, with its uncertainty, against a bound
//! measure ─ all of it for one scene ─▶ store ─ one line per scene ─▶ summary ─▶ tables, page
//! ```

mod bench;
mod coverage;
mod judge;
mod layer;
mod measure;
mod page;
mod plan;
mod record;
mod seeds;
mod small;
mod store;
mod summary;
mod tables;
mod truth;

pub use coverage::{Aim, Coverage, Verdict};
pub use judge::{Judgement, Measured, Reference, Shown};
pub use layer::{LayerTrial, spearman};
pub use plan::{Chosen, Header, Plan, SceneFile, Subject, Trials, choose};
pub use record::{
    BudgetRecord, ErrorRecord, ErrorTrialRecord, PlainInTime, PlainRecord, SceneRecord, Stated, TimeRecord,
    TruthRecord,
};
pub use store::{Store, StoreError};
pub use summary::{FamilySummary, Tally};
pub use truth::reference;

use crate::render::{Observer, RenderError, Renderer};
use crate::report::ProgramInfo;
use crate::scene::SceneError;

/// Scenes, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// What all records have in common.
    pub header: Header,
    /// The plan.
    pub plan: Plan,
    /// The records of its scenes, in the order of families and numbers.
    pub scenes: Vec<SceneRecord>,
}

/// Why a calibration ended.
#[derive(Debug, thiserror::Error)]
pub enum CalibrateError {
    /// A generator drew an invalid scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The device failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The records cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl Plan {
    /// The header of records measured with this plan on this device.
    pub fn header(&self, renderer: &Renderer) -> Header {
        Header {
            program: ProgramInfo::default(),
            device: renderer.device().info(),
            trials: self.trials.clone(),
            files: self.files.iter().map(SceneFile::fingerprint).collect(),
        }
    }

    /// Measures the scenes that `store` does not hold yet. `begin` gets the place of each scene in the list, the length
    /// of the list and the scene's name, and gives the observer of its progress. A scene that does not fit the device is
    /// recorded as a failure. If cancelled, ends before the scene's record.
    ///
    /// # Errors
    /// If a scene is invalid, the device is lost, or a record cannot be written.
    pub fn measure<'a>(
        &self,
        renderer: &mut Renderer,
        store: &mut Store,
        begin: &mut dyn FnMut(usize, usize, &str) -> Box<dyn Observer + 'a>,
    ) -> Result<(), CalibrateError> {
        let list = self.list();
        let size = [self.trials.width, self.trials.height];
        for (place, subject) in list.iter().enumerate() {
            let (family, number) = self.key(*subject);
            if store.has(family, number) {
                continue;
            }
            let mut record = SceneRecord { family: family.into(), number, ..SceneRecord::default() };
            let mut observer = begin(place + 1, list.len(), &record.name());
            let scene = match *subject {
                Subject::Drawn(family, number) => family.scene(number, self.trials.seed, size)?,
                Subject::File(at) => self.files[at].scene.clone(),
            };
            let measured = measure::measure(renderer, &scene, &self.trials, &mut *observer);
            match measured {
                Ok(Some(found)) => {
                    record = SceneRecord { family: record.family, number: record.number, ..found };
                }
                Ok(None) => break,
                Err(error @ (RenderError::DoesNotFit(_) | RenderError::TooManyRays { .. })) => {
                    record.failure = Some(error.to_string());
                }
                Err(error) => return Err(error.into()),
            }
            store.push(record)?;
        }
        Ok(())
    }

    /// The records of this plan's scenes in `store`.
    pub fn collect(&self, header: Header, store: &Store) -> Calibration {
        let mut list = self.list();
        list.sort_unstable();
        let record = |subject: &Subject| {
            let (family, number) = self.key(*subject);
            store.records().iter().find(|r| r.family == family && r.number == number).cloned()
        };
        Calibration { header, plan: self.clone(), scenes: list.iter().filter_map(record).collect() }
    }
}

impl Calibration {
    /// True if every scene of the plan has a record.
    pub fn is_complete(&self) -> bool {
        self.scenes.len() == self.plan.list().len()
    }
}
