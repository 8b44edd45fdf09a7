//! Each kernel alone, on random and spiteful buffers, against its twin: ids, counts, flags and order
//! exact, floats to the bit. The bit is the right bound here: no kernel uses an operation other than the
//! four of arithmetic and the square root, which the software device rounds correctly, none is contracted, and sums have a
//! fixed order. Buffers start full of NaN.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

#[path = "kernels/state.rs"]
mod state;

use common::{Bench, Rng, assert_same, device, differences, queue_of, spoil};
use state::{State, variants};
use std::collections::BTreeSet;
use std::rc::Rc;
use whitted::kernel::abi::{
    BUFFERS, COUNTER_CLAMPED_LIGHTS, COUNTER_NAN_RAYS, COUNTER_QUEUE_OVERFLOW, COUNTER_UNFINISHED, COUNTERS,
    Contribution, FRESNEL_CONSTANT, Film, LAYER_NORMAL, LAYER_PLACE, NONE, Push, RAY_KINDS, RAY_PRIMARY,
    RAY_REFLECTION, RAY_REFRACTION, RAY_SHADOW, Ray, Specialisation, TEST_WORDS,
};
use whitted::kernel::defects::Defect;
use whitted::kernel::table::{Kernel, KernelSet};
use whitted::reference::twin::single::Memory;
use whitted::vk::Device;

/// Uploads, runs on both sides, compares; the twin's result.
fn check(
    bench: &mut Bench,
    state: &State,
    memory: &Memory,
    kernel: Kernel,
    push: &Push,
    what: &str,
) -> Memory {
    bench.upload(memory);
    bench.run(kernel, push, push.items);
    let found = bench.download(memory);
    let mut twin = memory.clone();
    twin.run(kernel, &state.spec, push);
    assert_same(&format!("{}, {what}", kernel.name()), &twin, &found);
    assert!(!differences(memory, &twin).is_empty(), "{} wrote nothing: {what}", kernel.name());
    twin
}

fn each_state(seeds: std::ops::Range<u32>, test: impl FnMut(&mut Bench, &State, &mut Rng, &str)) {
    each_state_of(seeds, |_| {}, test);
}

/// `edit` changes every state's specialisation.
fn each_state_of(
    seeds: std::ops::Range<u32>,
    edit: impl Fn(&mut Specialisation),
    mut test: impl FnMut(&mut Bench, &State, &mut Rng, &str),
) {
    let device: Rc<Device> = device();
    let lanes = [0, device.limits().shuffle_lanes];
    for ((name, variant), lanes) in variants().into_iter().flat_map(|v| lanes.map(|l| (v, l))) {
        let with_lanes = |mut state: State| {
            edit(&mut state.spec);
            if lanes != 0 {
                (state.spec.lanes, state.spec.texels, state.spec.fused) = (lanes, 1, 1);
            }
            state
        };
        // One for all seeds: compiling takes longer than running.
        let first = with_lanes(State::new(variant, 0));
        if !matches!(lanes, 0 | 4 | 8) {
            continue;
        }
        let mut bench = Bench::new(&device, &first.spec, &first.memory);
        for seed in seeds.clone() {
            let state = with_lanes(State::new(variant, seed));
            let what = format!("{name}, {lanes} lanes together, seed {seed}");
            test(&mut bench, &state, &mut Rng::new(seed + 1000), &what);
        }
    }
}

#[test]
fn generate() {
    each_state(0..2, |bench, state, rng, what| {
        for samples in [1, 7] {
            let (width, height) = (13, 9);
            let push = Push {
                tile_x: rng.below(5000),
                tile_y: rng.below(5000),
                tile_width: width,
                tile_pixels: width * height,
                first_sample: rng.word() >> rng.pick(&[1, 12, 24]),
                batch_samples: samples,
                samples,
                seed: rng.word(),
                items: width * height * samples,
                ..state.push()
            };
            check(bench, state, &state.memory, Kernel::Generate, &push, what);
        }
    });
}

#[test]
fn intersect() {
    let mut hits = 0;
    each_state(0..6, |bench, state, _, what| {
        let twin = check(bench, state, &state.memory, Kernel::Intersect, &state.push(), what);
        hits += twin.hits[..state.count()].iter().filter(|h| h.primitive != NONE).count();
        assert!(twin.counters[COUNTER_NAN_RAYS as usize] > 0, "no ray was NaN: {what}");
    });
    assert!(hits > 2000, "only {hits} rays hit anything");
}

/// Box and primitive tests of a kind of ray at a depth.
fn tests_of(memory: &Memory, depth: u32, kind: u32) -> [u64; 2] {
    let at = (COUNTERS + TEST_WORDS * (RAY_KINDS * (depth - 1) + kind)) as usize;
    let number = |at: usize| u64::from(memory.counters[at + 1]) << 32 | u64::from(memory.counters[at]);
    [number(at), number(at + 2)]
}

/// Every traversal, alone and in packets, counts what its twin counts, of each kind of ray.
#[test]
fn box_and_primitive_tests_are_counted() {
    let mut seen = [[0; 2]; 4];
    each_state_of(
        0..3,
        |spec| spec.counting = 1,
        |bench, state, rng, what| {
            let mut memory = state.memory.clone();
            // A low word that overflows goes on in the high word.
            let words = (COUNTERS..COUNTERS + TEST_WORDS * RAY_KINDS).step_by(2);
            words.for_each(|at| memory.counters[at as usize] = u32::MAX - 100);
            let before = tests_of(&memory, 1, RAY_PRIMARY);
            let twin = check(bench, state, &memory, Kernel::Intersect, &state.push(), what);
            let primitives = u64::from(state.spec.triangle_count + state.spec.sphere_count);
            for kind in [RAY_PRIMARY, RAY_REFLECTION, RAY_REFRACTION] {
                let [boxes, tests] = tests_of(&twin, 1, kind).map(|n| n - before[0]);
                seen[kind as usize] = [seen[kind as usize][0] + boxes, seen[kind as usize][1] + tests];
                // Without a hierarchy the number is known: every primitive for every ray that is finite.
                let finite = |r: &&Ray| r.origin.iter().chain(&r.direction).all(|x| x.is_finite());
                let rays =
                    twin.rays[..state.count()].iter().filter(|r| r.kind == kind).filter(finite).count();
                if state.spec.use_bvh == 0 {
                    assert_eq!([boxes, tests], [0, primitives * rays as u64], "{what}");
                } else {
                    // At least two children of the root; not every primitive.
                    assert!(
                        boxes >= 2 * rays as u64 && tests < primitives * rays as u64,
                        "{boxes} {tests} {what}"
                    );
                }
            }

            let mut memory = state.hit();
            memory.run(Kernel::Shade, &state.spec, &state.push());
            state.place_lights(&mut memory, rng);
            let end = if state.spec.use_bvh != 0 { state.spec.light_count } else { 1 };
            let push = state.lights(0, end);
            let twin = check(bench, state, &memory, Kernel::Shadow, &push, what);
            let [boxes, tests] = tests_of(&twin, 1, RAY_SHADOW);
            seen[RAY_SHADOW as usize] =
                [seen[RAY_SHADOW as usize][0] + boxes, seen[RAY_SHADOW as usize][1] + tests];
            let rays = u64::from(twin.depth_counts[0].shadow);
            if state.spec.use_bvh == 0 {
                assert!(tests.is_multiple_of(primitives) && tests <= primitives * rays, "{what}");
            }

            if state.spec.fused != 0 {
                for (memory, push) in before_fused_depth(state, rng) {
                    let what = format!("{what}, depth {}", push.depth);
                    let twin = check(bench, state, &memory, Kernel::FusedDepth, &push, &what);
                    assert!(tests_of(&twin, push.depth, RAY_SHADOW)[1] > 0, "{what}");
                    let children = twin.next_rays.iter().filter(|r| r.kind == RAY_REFLECTION).count();
                    assert!(children > 100, "{children}: {what}");
                }
            }
        },
    );
    assert!(seen.as_flattened().iter().all(|n| *n > 1000), "{seen:?}");
}

/// What packets find comes from the compressed nodes: with every box one step wide, they find less.
#[test]
fn packets_read_compressed_nodes() {
    let device: Rc<Device> = device();
    let (_, variant) = variants()[1];
    let mut state = State::new(variant, 3);
    (state.spec.lanes, state.spec.texels) = (device.limits().shuffle_lanes, 1);
    let mut bench = Bench::new(&device, &state.spec, &state.memory);
    let twin =
        check(&mut bench, &state, &state.memory, Kernel::Intersect, &state.push(), "as they were made");
    let mut memory = state.memory.clone();
    memory.compressed_nodes.iter_mut().for_each(|c| c.hi = c.lo);
    bench.upload(&memory);
    bench.run(Kernel::Intersect, &state.push(), state.push().items);
    let found = bench.download(&memory);
    let hits = |m: &Memory| m.hits[..state.count()].iter().filter(|h| h.primitive != NONE).count();
    assert!(hits(&found) < hits(&twin), "{} of {}", hits(&found), hits(&twin));
}

#[test]
fn shade() {
    each_state(0..4, |bench, state, rng, what| {
        for depth in [1, 2] {
            let mut memory = state.hit();
            state.spoil_hits(&mut memory, rng);
            check(bench, state, &memory, Kernel::Shade, &Push { depth, ..state.push() }, what);
        }
    });
}

#[test]
fn scan() {
    each_state(0..1, |bench, state, rng, what| {
        for case in 0..40 {
            let mut memory = state.memory.clone();
            let Specialisation { workgroup, lanes, fused, .. } = state.spec;
            let most = match fused {
                0 => memory.child_counts.len() as u32 * workgroup,
                _ => memory.child_masks.len() as u32 * lanes,
            };
            // Also none, one, and one more than fills groups, runs and rows.
            let count = match case {
                0..6 => {
                    [0, 1, state.spec.workgroup, state.spec.workgroup + 1, 128 * state.spec.workgroup, most]
                        [case]
                        .min(most)
                }
                _ => rng.below(most + 1),
            };
            memory.queue[0] = queue_of(count, state.spec.workgroup);
            let limit = state.spec.workgroup + 1;
            match fused {
                0 => memory
                    .child_counts
                    .iter_mut()
                    .for_each(|t| *t = rng.below(limit) << 16 | rng.below(limit)),
                // A bit for each lane's reflection ray and for its refraction ray.
                _ => memory
                    .child_masks
                    .iter_mut()
                    .for_each(|t| *t = rng.below(1 << lanes) << 16 | rng.below(1 << lanes)),
            }
            memory.depth_counts.iter_mut().for_each(|d| d.traced = rng.below(100));
            let capacity = if case % 3 == 0 { rng.below(2 * count + 2) } else { u32::MAX };
            let push = Push { capacity, ..state.push() };
            let twin = check(bench, state, &memory, Kernel::Scan, &push, &format!("{what}, case {case}"));
            let overflow = twin.counters[COUNTER_QUEUE_OVERFLOW as usize];
            assert_eq!(
                overflow == 1,
                twin.next_queue[0].count == 0 && sum(&twin, &state.spec) > capacity,
                "{what}"
            );
        }
    });
}

/// Children of the whole queue.
fn sum(memory: &Memory, spec: &Specialisation) -> u32 {
    let groups =
        memory.offsets.iter().take_while(|o| **o != whitted::reference::twin::single::POISON).count();
    match spec.fused {
        0 => memory.child_counts[..groups].iter().map(|t| (t >> 16) + (t & 0xffff)).sum(),
        _ => {
            let words = groups * (spec.workgroup / spec.lanes) as usize;
            memory.child_masks[..words].iter().map(|t| t.count_ones()).sum()
        }
    }
}

#[test]
fn spawn() {
    let mut children = 0;
    each_state(0..4, |bench, state, rng, what| {
        let mut memory = state.hit();
        state.spoil_hits(&mut memory, rng);
        let push = state.push();
        memory.run(Kernel::Shade, &state.spec, &push);
        memory.run(Kernel::Scan, &state.spec, &push);
        state.spoil_surfaces(&mut memory, rng);
        children += memory.next_queue[0].count;
        check(bench, state, &memory, Kernel::Spawn, &push, what);
    });
    assert!(children > 1000, "only {children} children");
}

#[test]
fn shadow() {
    let mut clamped = 0;
    each_state(0..4, |bench, state, rng, what| {
        let mut memory = state.hit();
        memory.run(Kernel::Shade, &state.spec, &state.push());
        state.place_lights(&mut memory, rng);
        let all = state.spec.light_count;
        // The hierarchy takes lights in any number of passes; brute force takes one a pass.
        let cuts: &[&[u32]] =
            if state.spec.use_bvh != 0 { &[&[0, 5], &[0, 2, 5]] } else { &[&[0, 1, 2, 3, 4, 5]] };
        for cut in cuts {
            assert_eq!(cut.last(), Some(&all));
            let mut now = memory.clone();
            for pass in cut.windows(2) {
                let push = state.lights(pass[0], pass[1]);
                now = check(bench, state, &now, Kernel::Shadow, &push, &format!("{what}, lights {pass:?}"));
            }
            assert!(now.depth_counts[0].shadow > 100, "{:?}: {what}", now.depth_counts[0]);
            clamped += now.counters[COUNTER_CLAMPED_LIGHTS as usize];
        }
    });
    assert!(clamped > 0, "no light touches a surface");
}

/// Walks that stop after a few steps and go on, until all have ended: the rounds that took, and the buffers then. The
/// twin's never stop, so what a walk keeps and how many went on are left out.
fn walk_on(bench: &mut Bench, memory: &Memory, push: &Push) -> (u32, Memory) {
    bench.upload(memory);
    let mut unfinished = 0;
    for round in 0..5000 {
        bench.run(Kernel::Walk, &Push { walk_round: round, ..*push }, push.items);
        let mut found = bench.download(memory);
        let now = found.counters[COUNTER_UNFINISHED as usize];
        if now == unfinished {
            found.walks.clone_from(&memory.walks);
            found.counters[COUNTER_UNFINISHED as usize] = 0;
            return (round, found);
        }
        unfinished = now;
    }
    panic!("walks do not end");
}

#[test]
fn walk() {
    let (mut most, mut hidden) = ([0; 2], 0);
    let few = |spec: &mut Specialisation| (spec.loop_cap, spec.counting) = (12, 1);
    each_state_of(0..2, few, |bench, state, rng, what| {
        let mut both = |memory: &Memory, push: Push, what: &str| {
            let (rounds, found) = walk_on(bench, memory, &push);
            let mut twin = memory.clone();
            twin.run(Kernel::Walk, &state.spec, &push);
            assert_same(
                &format!("walk, {what}, lights {:?}", [push.light_begin, push.light_end]),
                &twin,
                &found,
            );
            (rounds, twin)
        };
        let (rounds, _) = both(&state.memory, state.push(), what);
        most[0] = most[0].max(rounds);
        let mut memory = state.hit();
        memory.run(Kernel::Shade, &Specialisation { counting: 0, ..state.spec }, &state.push());
        state.place_lights(&mut memory, rng);
        for [begin, end] in [[0, 1], [0, 2], [0, 3], [3, 4], [3, 5]] {
            let (rounds, twin) = both(&memory, state.lights(begin, end), what);
            most[1] = most[1].max(rounds);
            memory.hits = twin.hits;
        }
        hidden += memory.hits[..state.count()].iter().filter(|h| h.primitive == 3).count();
    });
    assert!(most[0] > 3 && most[1] > 3 && hidden > 50, "{most:?} rounds, {hidden} surfaces without light");
}

#[test]
fn light() {
    let mut clamped = 0;
    each_state(0..2, |bench, state, rng, what| {
        let mut memory = state.hit();
        memory.run(Kernel::Shade, &state.spec, &state.push());
        state.place_lights(&mut memory, rng);
        memory.hits.iter_mut().for_each(|h| h.primitive = rng.below(32));
        let cuts: &[&[u32]] =
            if state.spec.use_bvh != 0 { &[&[0, 5], &[0, 2, 5]] } else { &[&[0, 1, 2, 3, 4, 5]] };
        for cut in cuts {
            let mut now = memory.clone();
            for pass in cut.windows(2) {
                let push = state.lights(pass[0], pass[1]);
                now = check(bench, state, &now, Kernel::Light, &push, &format!("{what}, lights {pass:?}"));
            }
            assert!(now.depth_counts[0].shadow > 100, "{:?}: {what}", now.depth_counts[0]);
            clamped += now.counters[COUNTER_CLAMPED_LIGHTS as usize];
        }
    });
    assert!(clamped > 0, "no light touches a surface");
}

/// Sums of surfaces in place of light.
#[test]
fn surfaces() {
    for layer in [LAYER_PLACE, LAYER_NORMAL] {
        each_state_of(
            0..1,
            |spec| spec.surface_layer = layer,
            |bench, state, _, what| {
                let mut memory = state.hit();
                memory.run(Kernel::Shade, &state.spec, &state.push());
                let push = state.lights(0, state.spec.light_count.min(1));
                check(bench, state, &memory, Kernel::Light, &push, what);
            },
        );
    }
}

/// What `fused_depth` finds before it at depths 1 and 2: rays behind places of any order.
fn before_fused_depth(state: &State, rng: &mut Rng) -> [(Memory, Push); 2] {
    [1, 2].map(|depth| {
        let mut memory = state.hit();
        memory.run(Kernel::Shade, &state.spec, &state.push());
        state.place_lights(&mut memory, rng);
        let mut memory = Memory { lights: memory.lights, ..state.memory.clone() };
        if state.spec.branching == 0 {
            // Mirrors: a ray has one child at most.
            memory.materials.iter_mut().for_each(|m| (m.fresnel_kind, m.fresnel) = (FRESNEL_CONSTANT, 1.0));
        }
        for i in 0..state.count() {
            memory.ray_indices[i] = i as u32;
            memory.ray_indices.swap(i, rng.below(i as u32 + 1) as usize);
        }
        (memory, Push { depth, last_depth: 3, ..state.lights(0, state.spec.light_count) })
    })
}

fn check_fused_depth(bench: &mut Bench, state: &State, rng: &mut Rng, what: &str) {
    for (memory, push) in before_fused_depth(state, rng) {
        let what = format!("{what}, depth {}", push.depth);
        let twin = check(bench, state, &memory, Kernel::FusedDepth, &push, &what);
        assert!(twin.depth_counts[push.depth as usize - 1].shadow > 100, "{what}");
    }
}

#[test]
fn fused_depth() {
    let mut states = 0;
    each_state(0..4, |bench, state, rng, what| {
        if state.spec.fused != 0 {
            check_fused_depth(bench, state, rng, what);
            states += 1;
        }
    });
    assert!(states > 0, "nothing is fused");
}

#[test]
fn place() {
    let mut children = 0;
    each_state(0..4, |bench, state, rng, what| {
        for (mut memory, push) in before_fused_depth(state, rng).into_iter().filter(|_| state.spec.fused != 0)
        {
            memory.run(Kernel::FusedDepth, &state.spec, &push);
            memory.run(Kernel::Scan, &state.spec, &push);
            children += memory.next_queue[0].count;
            check(bench, state, &memory, Kernel::Place, &push, &format!("{what}, depth {}", push.depth));
        }
    });
    assert!(children > 1000, "only {children} children");
}

#[test]
fn gather() {
    each_state(0..4, |bench, state, rng, what| {
        let mut memory = state.memory.clone();
        let mut sample_index = 0;
        for i in 0..state.count() {
            sample_index += u32::from(rng.below(3) == 0);
            let scale = rng.pick(&[1.0, 1e-30, 1e30, -1.0, 1e-40, 3e38, f32::INFINITY, f32::NAN, 0.0, -0.0]);
            memory.contributions[i] = Contribution { light: rng.vector().map(|c| c * scale), sample_index };
        }
        memory.sample_radiance.iter_mut().for_each(|s| *s = rng.vector());
        check(bench, state, &memory, Kernel::Gather, &state.push(), what);
    });
}

#[test]
fn resolve() {
    each_state(0..4, |bench, state, rng, what| {
        let mut memory = state.memory.clone();
        // What sums of cut throughput may overflow: the high word must take over.
        memory.marks.iter_mut().for_each(|m| m.cut_low = u32::MAX - rng.below(1 << 31));
        for s in &mut memory.sample_radiance {
            let scale = rng.pick(&[1.0, 1.0, 1e-8, 1e8, 1e-40, 3e38, f32::NAN, 0.0, -0.0]);
            *s = rng.vector().map(|c| c * scale);
        }
        for f in &mut memory.film {
            f.sum = rng.vector();
            f.compensation = rng.vector().map(|c| c * 1e-7);
        }
        let first_sample = rng.below(9);
        // A batch within the range that the film sums, at its start, and one that is all of it.
        let range_first = first_sample - rng.below(first_sample + 1);
        let range_samples = first_sample - range_first + 5 + rng.below(4);
        let push = Push {
            tile_pixels: 101,
            first_sample,
            batch_samples: 5,
            range_first,
            range_samples,
            items: 101,
            ..state.push()
        };
        check(bench, state, &memory, Kernel::Resolve, &push, what);
    });
}

/// The test of a kernel against its twin. This file does not compile while a kernel has no arm here.
fn test_against_twin(kernel: Kernel) -> Option<fn()> {
    match kernel {
        Kernel::Gather => Some(gather),
        Kernel::Generate => Some(generate),
        Kernel::Intersect => Some(intersect),
        Kernel::Light => Some(light),
        Kernel::Place => Some(place),
        Kernel::Resolve => Some(resolve),
        Kernel::Scan => Some(scan),
        // It has no twin: the host judges its results (`whitted::render::self_test`).
        Kernel::SelfTest => None,
        Kernel::Shade => Some(shade),
        Kernel::Shadow => Some(shadow),
        Kernel::Spawn => Some(spawn),
        Kernel::FusedDepth => Some(fused_depth),
        Kernel::Walk => Some(walk),
    }
}

#[test]
fn every_kernel_has_a_test_against_its_twin() {
    let without: Vec<Kernel> =
        Kernel::ALL.into_iter().filter(|kernel| test_against_twin(*kernel).is_none()).collect();
    assert_eq!(without, [Kernel::SelfTest]);
    // A test serves one kernel.
    let tests: BTreeSet<usize> =
        Kernel::ALL.into_iter().filter_map(test_against_twin).map(|test| test as usize).collect();
    assert_eq!(tests.len() + without.len(), Kernel::ALL.len());
}

#[test]
fn one_flipped_bit_anywhere_is_seen() {
    let state = State::new(variants()[0].1, 5);
    let mut memory = state.hit();
    memory.run(Kernel::Shade, &state.spec, &state.push());
    memory.depth_counts.iter_mut().for_each(|d| d.shadow = 3);
    memory.film.iter_mut().for_each(|f| f.sum = [1.0; 3]);
    memory.self_test.fill(1.0);
    memory.contributions.fill(Contribution { light: [1.0; 3], sample_index: 1 });
    memory.sample_radiance.fill([1.0; 3]);
    assert!(differences(&memory, &memory.clone()).is_empty());
    for (name, _, buffer) in BUFFERS {
        let mut other = memory.clone();
        spoil(&mut other, *buffer);
        assert_eq!(differences(&memory, &other).len(), 1, "{name}");
    }
}

#[test]
fn a_kernel_that_is_wrong_by_one_operation_is_seen() {
    let state = State::new(variants()[0].1, 3);
    let mut honest = state.hit();
    let mut wrong = honest.clone();
    honest.run(Kernel::Shade, &state.spec, &state.push());
    // The ray points the other way by one unit in the last place.
    for r in &mut wrong.rays[..state.count()] {
        r.direction[0] = f32::from_bits(r.direction[0].to_bits() ^ 1);
    }
    wrong.run(Kernel::Shade, &state.spec, &state.push());
    wrong.rays = honest.rays.clone();
    assert!(!differences(&honest, &wrong).is_empty());
}

#[test]
fn a_kernel_with_a_planted_defect_differs_from_its_twin() {
    let device = device();
    let state = State::new(variants()[0].1, 3);
    for (kernel, defect) in [
        (Kernel::Intersect, Defect::MoellerTrumbore),
        (Kernel::Intersect, Defect::NaiveQuadratic),
        (Kernel::Shade, Defect::SchlickInside),
        (Kernel::Resolve, Defect::NaiveSum),
    ] {
        let mut memory = state.hit();
        memory.film.iter_mut().for_each(|f| *f = Film { sum: [1e6; 3], compensation: [0.0; 3] });
        let push = Push { tile_pixels: 101, batch_samples: 5, ..state.push() };
        let mut twin = memory.clone();
        twin.run(kernel, &state.spec, &push);
        let by_device = |defect| {
            let mut bench = Bench::of(KernelSet::planted(defect), &device, &state.spec, &memory);
            bench.upload(&memory);
            bench.run(kernel, &push, push.items);
            bench.download(&memory)
        };
        assert!(!differences(&twin, &by_device(defect)).is_empty(), "{defect:?} of {kernel:?} passes");
        assert_same(&format!("{kernel:?} with nothing planted"), &twin, &by_device(Defect::Nothing));
    }
}
