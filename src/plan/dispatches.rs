//! The dispatches of one batch, in order: the one walk over the pass table. The host records them, the twins run
//! them, the plan counts them, the predicted time adds up their costs.

use super::Plan;
use super::passes::{EPILOGUE, PER_DEPTH, PROLOGUE, Pass, When, walk};
use crate::kernel::abi::{self, Push, Queue};
use crate::kernel::table::Kernel;
use crate::settings::Settings;

/// One dispatch of a batch.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// Row of the pass table.
    pub pass: &'static Pass,
    /// Depth from 1; 0 before the first and after the last.
    pub depth: u32,
    /// Lights of this dispatch: first, and one past the last. Of a `walk`: none, or the lights of the pass that it is
    /// for up to the one that it searches for.
    pub lights: [u32; 2],
}

impl Step {
    /// The push constants of this dispatch out of those of the batch.
    pub fn push(&self, batch: Push) -> Push {
        let [light_begin, light_end] = self.lights;
        Push { depth: self.depth, light_begin, light_end, ..batch }
    }
}

/// Pixels and samples that one batch traces.
#[derive(Debug, Clone, Copy)]
pub struct Batch {
    /// First pixel of the tile, image coordinates; 0 for a list of pixels.
    pub x: u32,
    /// As `x`.
    pub y: u32,
    /// Pixels of a row of the tile; of the image for a list.
    pub width: u32,
    /// Pixels.
    pub pixels: u32,
    /// First sample of every pixel.
    pub first_sample: u32,
    /// Samples of every pixel.
    pub samples: u32,
    /// The range of samples that the film sums: its first, and their number.
    pub range: (u32, u32),
    /// Depth of the last passes.
    pub last_depth: u32,
}

impl Batch {
    /// Primary rays.
    pub fn rays(&self) -> u32 {
        self.pixels * self.samples
    }

    /// Push constants of the batch; depth and lights are each step's ([`Step::push`]).
    pub fn push(&self, plan: &Plan, settings: &Settings) -> Push {
        Push {
            tile_x: self.x,
            tile_y: self.y,
            tile_width: self.width,
            tile_pixels: self.pixels,
            first_sample: self.first_sample,
            batch_samples: self.samples,
            samples: settings.samples,
            range_first: self.range.0,
            range_samples: self.range.1,
            seed: settings.seed,
            depth: 0,
            last_depth: self.last_depth,
            light_begin: 0,
            light_end: plan.specialisation.light_count,
            capacity: plan.capacity,
            items: self.rays(),
            cutoff: settings.cutoff,
            walk_first: 0,
            walk_round: 0,
        }
    }

    /// The queue of depth 1: every primary ray.
    pub fn first_queue(&self, plan: &Plan) -> Queue {
        let groups = self.rays().div_ceil(plan.specialisation.workgroup);
        Queue {
            groups_x: groups.min(abi::GROUPS_PER_ROW),
            groups_y: groups.div_ceil(abi::GROUPS_PER_ROW),
            groups_z: 1,
            count: self.rays(),
            reflections: 0,
        }
    }
}

/// Depths that are dispatched whether or not rays are known to get there. Each costs some dispatches of nothing where they
/// do not, and a submit in vain is the price of one too few.
pub const FIRST_REACH: u32 = 16;

/// The dispatches of a batch whose last passes are of depth `last_depth`, at least 1.
pub fn dispatches(plan: &Plan, last_depth: u32) -> impl Iterator<Item = Step> + use<> {
    dispatches_to(plan, last_depth, last_depth)
}

/// As [`dispatches`], without the passes of depths greater than `reach`: the same if no ray gets there. The passes of
/// depth `reach` say whether one does.
pub fn dispatches_to(plan: &Plan, last_depth: u32, reach: u32) -> impl Iterator<Item = Step> + use<> {
    let spec = &plan.specialisation;
    let (way, branching) = (plan.way(), spec.branching != 0);
    let (lights, group) = (spec.light_count, plan.lights_per_pass.max(1));
    let once = move |pass: &'static Pass| Step { pass, depth: 0, lights: [0, lights] };
    let at_depth = move |depth: u32| {
        PER_DEPTH.iter().filter(move |p| p.is_of(way)).flat_map(move |pass| {
            let groups = match pass.when {
                When::Always => 1,
                When::NotLast => u32::from(depth < last_depth),
                When::Branching => u32::from(depth > 1 && branching),
                When::PerLights => lights.div_ceil(group).max(1),
            };
            (0..groups).flat_map(move |g| {
                let [begin, end] = match pass.when {
                    When::PerLights => [g * group, (g * group + group).min(lights)],
                    _ if pass.kernel == Kernel::Walk => [0, 0],
                    _ => [0, lights],
                };
                // What `light` adds up has been searched for, a light at a time.
                let walks = if pass.kernel == Kernel::Light { begin..end } else { 0..0 };
                let walks = walks.map(move |l| Step { pass: walk(), depth, lights: [begin, l + 1] });
                walks.chain([Step { pass, depth, lights: [begin, end] }])
            })
        })
    };
    PROLOGUE
        .iter()
        .map(once)
        .chain((1..=last_depth.min(reach)).flat_map(at_depth))
        .chain(EPILOGUE.iter().map(once))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::table::Kernel;
    use crate::plan::{Limits, PlannedScene};
    use crate::scene::procedural::shapes::{empty, glass, light, sphere};
    use crate::scene::{Fresnel, Scene};
    use std::path::Path;

    fn plan(scene: &Scene, lights_per_pass: u32) -> Plan {
        let settings = Settings::of(scene);
        let planned = PlannedScene::new(scene, &settings, &Limits::LAVAPIPE);
        Plan { lights_per_pass, ..planned.plan().expect("a plan").clone() }
    }

    /// A glass sphere under five lights.
    fn scene() -> Scene {
        let mut scene = empty(vec![glass(1.5, Fresnel::Exact)]);
        scene.file = Path::new("scene").into();
        scene.spheres.push(sphere([0.0; 3], 1.0, 0));
        scene.lights = (0..5).map(|i| light([f64::from(i), 3.0, 0.0], 1.0)).collect();
        scene.render.depth = 3;
        scene
    }

    #[test]
    fn every_light_is_in_one_group_of_each_depth() {
        let plan = plan(&scene(), 2);
        for depth in 1..=3 {
            let of = |s: &Step| s.depth == depth && s.pass.kernel == Kernel::Shadow;
            let groups: Vec<[u32; 2]> = dispatches(&plan, 3).filter(of).map(|s| s.lights).collect();
            assert_eq!(groups, [[0, 2], [2, 4], [4, 5]], "depth {depth}");
        }
    }

    #[test]
    fn what_is_beyond_reach_is_left_out() {
        let plan = plan(&scene(), 2);
        let all = |steps: &mut dyn Iterator<Item = Step>| -> Vec<(Kernel, u32)> {
            steps.map(|s| (s.pass.kernel, s.depth)).collect()
        };
        let whole = all(&mut dispatches(&plan, 3));
        assert_eq!(all(&mut dispatches_to(&plan, 3, 3)), whole);
        assert_eq!(all(&mut dispatches_to(&plan, 3, 1024)), whole);
        let within: Vec<_> = whole.into_iter().filter(|(_, depth)| *depth < 3).collect();
        assert_eq!(all(&mut dispatches_to(&plan, 3, 2)), within);
        assert!(within.contains(&(Kernel::Spawn, 2)));
    }

    #[test]
    fn the_last_depth_spawns_nothing_and_the_first_gathers_nothing() {
        let plan = plan(&scene(), 8);
        let depths = |kernel| -> Vec<u32> {
            dispatches(&plan, 3).filter(|s| s.pass.kernel == kernel).map(|s| s.depth).collect()
        };
        assert_eq!(depths(Kernel::Generate), [0]);
        assert_eq!(depths(Kernel::Intersect), [1, 2, 3]);
        assert_eq!(depths(Kernel::Spawn), [1, 2]);
        assert_eq!(depths(Kernel::Gather), [2, 3]);
        assert_eq!(depths(Kernel::Resolve), [0]);
        assert_eq!(dispatches(&plan, 1).filter(|s| s.pass.kernel == Kernel::Scan).count(), 0);
    }

    #[test]
    fn in_parts_each_light_is_searched_for_before_its_group_is_added_up() {
        let plan = plan(&scene(), 2).in_parts();
        let of = |s: &Step| s.depth == 2 && matches!(s.pass.kernel, Kernel::Walk | Kernel::Light);
        let steps: Vec<_> = dispatches(&plan, 3).filter(of).map(|s| (s.pass.kernel, s.lights)).collect();
        let (walk, light) = (Kernel::Walk, Kernel::Light);
        let first = [(walk, [0, 0]), (walk, [0, 1]), (walk, [0, 2]), (light, [0, 2])];
        let rest = [(walk, [2, 3]), (walk, [2, 4]), (light, [2, 4]), (walk, [4, 5]), (light, [4, 5])];
        assert_eq!(steps, [&first[..], &rest].concat());
        assert!(dispatches(&plan, 3).all(|s| !matches!(s.pass.kernel, Kernel::Intersect | Kernel::Shadow)));
    }

    #[test]
    fn without_lights_there_is_one_shadow_pass_of_none() {
        let mut scene = scene();
        scene.lights.clear();
        let plan = plan(&scene, 8);
        let shadow: Vec<Step> = dispatches(&plan, 1).filter(|s| s.pass.kernel == Kernel::Shadow).collect();
        assert_eq!(shadow.iter().map(|s| s.lights).collect::<Vec<_>>(), [[0, 0]]);
    }
}
