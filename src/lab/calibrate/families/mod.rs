//! Calibration on families of scenes that nobody has seen before: how often the bounds of `--budget` and `--error` hold on
//! each, what they cost, and on which scenes they fail.
//!
//! ```text
//! plan ─ scenes and trials            bench ─ renders of one scene
//! truth ─ mean of independent seeds   judge ─ true error, with its uncertainty, against a bound
//! measure ─ all of it for one scene ─▶ store ─ one line per scene ─▶ summary ─▶ tables, page
//! ```

mod bench;
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

pub use judge::{Judgement, Measured, Reference, Shown};
pub use layer::{LayerTrial, spearman};
pub use plan::{Chosen, FamilyPlan, Header, Trials, choose};
pub use record::{
    BudgetRecord, ErrorRecord, ErrorTrialRecord, PlainRecord, SceneRecord, Stated, TimeRecord, TruthRecord,
};
pub use store::{Store, StoreError};
pub use summary::{FamilySummary, Tally};

use crate::render::{Observer, RenderError, Renderer};
use crate::report::ProgramInfo;
use crate::scene::SceneError;

/// Scenes of families, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyCalibration {
    /// What all records have in common.
    pub header: Header,
    /// The plan.
    pub plan: FamilyPlan,
    /// The records of its scenes, in the order of families and numbers.
    pub scenes: Vec<SceneRecord>,
}

/// Why a calibration ended.
#[derive(Debug, thiserror::Error)]
pub enum FamilyError {
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

impl FamilyPlan {
    /// The header of records measured with this plan on this device.
    pub fn header(&self, renderer: &Renderer) -> Header {
        Header {
            program: ProgramInfo::default(),
            device: renderer.device().info(),
            trials: self.trials.clone(),
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
    ) -> Result<(), FamilyError> {
        let list = self.list();
        let size = [self.trials.width, self.trials.height];
        for (place, (family, number)) in list.iter().enumerate() {
            if store.has(family.name(), *number) {
                continue;
            }
            let mut observer = begin(place + 1, list.len(), &format!("{}:{number}", family.name()));
            let scene = family.scene(*number, self.trials.seed, size)?;
            let measured = measure::measure(renderer, &scene, &self.trials, &mut *observer);
            let record = match measured {
                Ok(Some(record)) => record,
                Ok(None) => break,
                Err(error @ (RenderError::DoesNotFit(_) | RenderError::TooManyRays { .. })) => {
                    SceneRecord { failure: Some(error.to_string()), ..SceneRecord::default() }
                }
                Err(error) => return Err(error.into()),
            };
            store.push(SceneRecord { family: family.name().into(), number: *number, ..record })?;
        }
        Ok(())
    }

    /// The records of this plan's scenes in `store`.
    pub fn collect(&self, header: Header, store: &Store) -> FamilyCalibration {
        let mut list = self.list();
        list.sort_unstable();
        let record = |(family, number): &(crate::scene::procedural::families::Family, u32)| {
            store.records().iter().find(|r| r.family == family.name() && r.number == *number).cloned()
        };
        FamilyCalibration { header, plan: self.clone(), scenes: list.iter().filter_map(record).collect() }
    }
}

impl FamilyCalibration {
    /// True if every scene of the plan has a record.
    pub fn is_complete(&self) -> bool {
        self.scenes.len() == self.plan.list().len()
    }
}
