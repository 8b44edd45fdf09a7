//! Scenes of few primitives, which have no hierarchy.

use super::Limits;
use super::limits::may_join;
use crate::prepare::{Packed, pack};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::forced_features::Feature;

/// Greatest number of primitives that are all tested; with more of them a hierarchy is faster
/// (docs/design/decisions/010-brute-force-limit.md).
pub const BRUTE_FORCE_MAX: usize = 32;
/// The same where the lanes of a subgroup work together (docs/design/decisions/030-constant-shapes.md).
const BRUTE_FORCE_MAX_JOINED: usize = 12;

/// Greatest number of primitives that are all tested (`pack`). `forced`: all (true) or none (false),
/// whatever the scene.
pub fn brute_force_max(forced: Option<bool>, settings: &Settings, limits: &Limits) -> usize {
    let on = |f: Feature| settings.schedule.forced_features.has(f);
    match forced {
        Some(true) => usize::MAX,
        Some(false) => 0,
        None if on(Feature::Hierarchy) => 0,
        None if !may_join(settings, limits) || on(Feature::LoneRays) => BRUTE_FORCE_MAX,
        None => BRUTE_FORCE_MAX_JOINED,
    }
}

/// Packs `scene` for [`Plan::new`](super::Plan::new) under these limits.
pub fn pack_for(scene: &Scene, settings: &Settings, limits: &Limits) -> Packed {
    pack(scene, settings, brute_force_max(None, settings, limits))
}
