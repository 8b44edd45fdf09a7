//! A scene prepared and planned for a device, before any memory is taken. Everything that renders, predicts or
//! explains starts here.

use super::build::Input;
use super::{Limits, Plan, PlanError, brute_force_max};
use crate::prepare::bvh::Forms;
use crate::prepare::{Packed, Recipe, pack_by};
use crate::scene::Scene;
use crate::settings::Settings;

/// What is traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The image of the settings.
    Image,
    /// Listed pixels on demand (`render::Survey`), up to the whole image at once.
    Survey,
}

/// Arrays and plan of a scene under fixed settings.
#[derive(Debug, Clone)]
pub struct PlannedScene {
    /// What the kernels see of the scene.
    pub packed: Packed,
    /// The settings in force.
    pub settings: Settings,
    /// The device's limits.
    pub limits: Limits,
    plan: Result<Plan, PlanError>,
}

impl PlannedScene {
    /// For an image, its search chosen by the plan.
    pub fn new(scene: &Scene, settings: &Settings, limits: &Limits) -> PlannedScene {
        PlannedScene::with(Recipe::of(scene), scene, settings, limits, Purpose::Image, None)
    }

    /// For any purpose; `brute_force` tests every primitive (true) or walks the hierarchy (false), whatever the
    /// scene's size. Only the form of nodes is made that the device's rays walk.
    pub(crate) fn with(
        recipe: Recipe,
        scene: &Scene,
        settings: &Settings,
        limits: &Limits,
        purpose: Purpose,
        brute_force: Option<bool>,
    ) -> PlannedScene {
        PlannedScene::of(recipe, scene, settings, limits, purpose, brute_force, limits.forms(settings))
    }

    /// An image for the kernels' twins, which walk one form of nodes whatever the plan says: with both forms.
    pub(crate) fn for_twins(
        recipe: Recipe,
        scene: &Scene,
        settings: &Settings,
        limits: &Limits,
        brute_force: Option<bool>,
    ) -> PlannedScene {
        PlannedScene::of(recipe, scene, settings, limits, Purpose::Image, brute_force, Forms::Both)
    }

    fn of(
        recipe: Recipe,
        scene: &Scene,
        settings: &Settings,
        limits: &Limits,
        purpose: Purpose,
        brute_force: Option<bool>,
        forms: Forms,
    ) -> PlannedScene {
        let survey = purpose == Purpose::Survey;
        let most = brute_force_max(brute_force, settings, limits);
        let packed = pack_by(recipe, scene, settings, most, forms);
        let plan = Plan::build(Input { packed: &packed, settings, limits, survey });
        PlannedScene { packed, settings: settings.clone(), limits: *limits, plan }
    }

    /// The plan.
    ///
    /// # Errors
    /// If the scene does not fit the device; says what would.
    pub fn plan(&self) -> Result<&Plan, PlanError> {
        self.plan.as_ref().map_err(Clone::clone)
    }
}
