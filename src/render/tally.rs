//! What a render counts and times, tile by tile, and the report made of it.

use crate::kernel::abi;
use crate::kernel::table::Kernel;
use crate::plan::Plan;
use crate::plan::passes::{self, Size};
use crate::prepare::Packed;
use crate::report::test_counts::{KindTests, TestCounts};
use crate::report::{Counters, LocalFrameInfo, PassInfo, PlanInfo, RayInfo, Report, SceneInfo, SettingsInfo};
use crate::scene::MAX_DEPTH;
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

/// No count of a sound tally is as large: sums over all depths and passes then fit 64 bits.
const LIMIT: u64 = 1 << 50;
/// Most rows of depths, of any plan.
const DEPTHS: usize = MAX_DEPTH as usize + 1;

impl Tally {
    /// True if a render can have counted it: what was read from a file need not be so.
    pub(super) fn is_sound(&self) -> bool {
        let rows = self.passes.iter().all(|((depth, place), (launches, seconds))| {
            *depth <= DEPTHS as u32
                && *place < passes::all().count()
                && *launches < LIMIT
                && (0.0..LIMIT as f64).contains(seconds)
        });
        let tests = self.tests.as_flattened().as_flattened();
        let counts = self.depths.as_flattened().iter().chain(tests).chain(&self.counters).chain([
            &self.tiles,
            &self.batches,
            &self.samples,
            &self.pixels,
        ]);
        let depths = self.depths.len().max(self.tests.len()) <= DEPTHS;
        rows && depths && counts.into_iter().all(|count| *count < LIMIT)
    }

    pub(super) fn add(&mut self, other: &Tally) {
        if self.depths.len() < other.depths.len() {
            self.depths.resize(other.depths.len(), [0; 4]);
        }
        for (a, b) in self.depths.iter_mut().zip(&other.depths) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a = a.saturating_add(*b));
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

    /// The report of a render that counted this.
    pub(super) fn report(&self, settings: &Settings, packed: &Packed, plan: &Plan) -> Report {
        let mut report = outline(settings, packed, plan);
        self.fill(&mut report);
        report
    }

    /// Puts the counts and times into a report that has none.
    pub(super) fn fill(&self, report: &mut Report) {
        (report.plan.tiles, report.plan.batches) = (self.tiles, self.batches);
        let count = |of: u32| self.counters[of as usize];
        report.counters.nan_rays += count(abi::COUNTER_NAN_RAYS);
        report.counters.clamped_lights += count(abi::COUNTER_CLAMPED_LIGHTS);
        report.counters.stack_overflow += count(abi::COUNTER_STACK_OVERFLOW);
        report.counters.loop_cap += count(abi::COUNTER_LOOP_CAP);
        report.counters.media_overflow += count(abi::COUNTER_MEDIA_OVERFLOW);
        report.rays = RayInfo::of(&self.depths);
        report.tests = report.tests.take().map(|_| TestCounts::of(&report.rays, &self.tests));
        let mut rows: Vec<_> = self.passes.iter().collect();
        rows.sort_by_key(|((depth, place), _)| (row_group(*depth, *place), *depth, *place));
        for ((depth, place), (launches, seconds)) in rows {
            let Some(pass) = passes::all().nth(*place) else { continue };
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
    }
}

/// What a report says of a render before any ray is traced; `tests` is there if tests are counted.
pub(super) fn outline(settings: &Settings, packed: &Packed, plan: &Plan) -> Report {
    Report {
        scene: SceneInfo {
            file: String::new(),
            triangles: packed.scene_features.triangles,
            spheres: packed.scene_features.spheres,
            lights: packed.scene_features.lights,
            notes: Vec::new(),
            variables: Vec::new(),
            up: None,
            local_frame: LocalFrameInfo {
                center: packed.local_frame.center.to_array(),
                scale_log2: packed.local_frame.scale_log2,
            },
        },
        settings: SettingsInfo::of(settings),
        plan: PlanInfo {
            features: plan.features.iter().map(|f| (*f).to_owned()).collect(),
            bytes: plan.bytes(),
            ..PlanInfo::default()
        },
        counters: Counters {
            degenerate_triangles: packed.degenerate_triangles,
            media_overflow: packed.eye_media_dropped,
            ..Counters::default()
        },
        tests: (plan.specialisation.counting != 0).then(TestCounts::default),
        ..Report::default()
    }
}

/// Row of a kernel in the pass table.
fn place_of(kernel: Kernel) -> usize {
    passes::all().position(|p| p.kernel == kernel).unwrap_or(0)
}

/// Prologue, depths, epilogue.
fn row_group(depth: u32, place: usize) -> u32 {
    match (depth, place) {
        (0, 0) => 0,
        (0, _) => 2,
        _ => 1,
    }
}
