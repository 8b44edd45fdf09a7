//! What a render counts and times, tile by tile, and the report made of it.

use crate::kernel::abi;
use crate::kernel::table::Kernel;
use crate::plan::Plan;
use crate::plan::passes::Size;
use crate::prepare::Packed;
use crate::report::test_counts::{KindTests, TestCounts};
use crate::report::{Counters, LocalFrameInfo, PassInfo, PlanInfo, RayInfo, Report, SceneInfo, SettingsInfo};
use crate::settings::Settings;
use crate::vk::Timed;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What was counted and timed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tally {
    /// Rays traced, reflections, refractions and shadow rays of each depth.
    pub(super) depths: Vec<[u64; 4]>,
    /// Depth and row of the pass table; launches and seconds.
    #[serde(with = "rows")]
    pub(super) passes: BTreeMap<(u32, usize), (u64, f64)>,
    pub(super) counters: [u64; abi::COUNTERS as usize],
    /// Tests of each depth and kind of ray; none if they are not counted.
    #[serde(default)]
    pub(super) tests: Vec<KindTests>,
    pub(super) tiles: u64,
    pub(super) batches: u64,
    pub(super) samples: u64,
    pub(super) pixels: u64,
}

/// JSON has no keys but texts: the map as a list of pairs.
mod rows {
    use serde::{Deserialize, Deserializer, Serializer};
    use std::collections::BTreeMap;

    type Rows = BTreeMap<(u32, usize), (u64, f64)>;

    pub(super) fn serialize<S: Serializer>(rows: &Rows, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(rows)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Rows, D::Error> {
        Ok(Vec::deserialize(from)?.into_iter().collect())
    }
}

impl Tally {
    pub(super) fn add(&mut self, other: &Tally) {
        if self.depths.len() < other.depths.len() {
            self.depths.resize(other.depths.len(), [0; 4]);
        }
        for (a, b) in self.depths.iter_mut().zip(&other.depths) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        }
        if self.tests.len() < other.tests.len() {
            self.tests.resize(other.tests.len(), KindTests::default());
        }
        let (sums, more) = (self.tests.as_flattened_mut().as_flattened_mut(), other.tests.as_flattened());
        sums.iter_mut().zip(more.as_flattened()).for_each(|(a, b)| *a += b);
        for (key, (launches, seconds)) in &other.passes {
            let row = self.passes.entry(*key).or_default();
            *row = (row.0 + launches, row.1 + seconds);
        }
        self.counters.iter_mut().zip(other.counters).for_each(|(a, b)| *a += b);
        self.tiles += other.tiles;
        self.batches += other.batches;
        self.samples += other.samples;
        self.pixels += other.pixels;
    }

    /// Rays of all kinds.
    pub(super) fn rays(&self) -> u64 {
        self.depths.iter().map(|[traced, _, _, shadow]| traced + shadow).sum()
    }

    pub(super) fn add_timings(&mut self, timed: &[Timed]) {
        for t in timed {
            let place = place_of(t.kernel);
            let row = self.passes.entry((t.depth, place)).or_default();
            *row = (row.0 + 1, row.1 + t.seconds);
        }
    }

    pub(super) fn report(&self, settings: &Settings, packed: &Packed, plan: &Plan) -> Report {
        let mut report = Report {
            scene: SceneInfo {
                file: String::new(),
                triangles: packed.scene_features.triangles,
                spheres: packed.scene_features.spheres,
                lights: packed.scene_features.lights,
                notes: Vec::new(),
                variables: Vec::new(),
                local_frame: LocalFrameInfo {
                    center: packed.local_frame.center.to_array(),
                    scale_log2: packed.local_frame.scale_log2,
                },
            },
            settings: SettingsInfo::of(settings),
            plan: PlanInfo {
                features: plan.features.iter().map(|f| (*f).to_owned()).collect(),
                bytes: plan.bytes(),
                tiles: self.tiles,
                batches: self.batches,
            },
            counters: Counters {
                degenerate_triangles: packed.degenerate_triangles,
                nan_rays: self.counters[abi::COUNTER_NAN_RAYS as usize],
                clamped_lights: self.counters[abi::COUNTER_CLAMPED_LIGHTS as usize],
                stack_overflow: self.counters[abi::COUNTER_STACK_OVERFLOW as usize],
                loop_cap: self.counters[abi::COUNTER_LOOP_CAP as usize],
                media_overflow: self.counters[abi::COUNTER_MEDIA_OVERFLOW as usize]
                    + packed.eye_media_dropped,
            },
            ..Report::default()
        };
        report.rays = RayInfo::of(&self.depths);
        report.tests = (plan.specialisation.counting != 0).then(|| TestCounts::of(&report.rays, &self.tests));
        let mut rows: Vec<_> = self.passes.iter().collect();
        rows.sort_by_key(|((depth, place), _)| (row_group(*depth, *place), *depth, *place));
        for ((depth, place), (launches, seconds)) in rows {
            let pass = crate::plan::passes::all().nth(*place).expect("a place is a row of the pass table");
            let at = self.depths.get((*depth).max(1) as usize - 1).map_or(0, |d| d[0]);
            let items = match pass.size {
                Size::Rays | Size::Walks => at,
                Size::Samples => self.samples,
                Size::Pixels => self.pixels,
                Size::One => *launches,
            };
            report.passes.push(PassInfo {
                name: pass.kernel.name().into(),
                depth: *depth,
                launches: *launches,
                seconds: *seconds,
                items,
            });
        }
        report
    }
}

/// Row of a kernel in the pass table.
fn place_of(kernel: Kernel) -> usize {
    crate::plan::passes::all().position(|p| p.kernel == kernel).unwrap_or(0)
}

/// Prologue, depths, epilogue.
fn row_group(depth: u32, place: usize) -> u32 {
    match (depth, place) {
        (0, 0) => 0,
        (0, _) => 2,
        _ => 1,
    }
}
