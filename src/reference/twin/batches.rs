//! A render on the CPU: the passes of a plan, tile by tile and batch by batch, as `render` records them.

use super::super::Counts;
use super::memory::Memory;
use super::structs::{DepthCount, Film};
use crate::kernel::abi::{self, Film as ImageFilm};
use crate::plan::Plan;
use crate::plan::dispatches::{Batch, dispatches};
use crate::plan::tiles::{Tile, tiles};
use crate::prepare::Packed;
use crate::render::mean;
use crate::report::test_counts::{KindTests, tests_of};
use crate::scene::Scene;
use crate::settings::Settings;

/// The linear image and the counts of a scene under a plan. `None` if one sample of a pixel has more
/// rays at one depth than the plan's queue holds.
pub fn render(
    packed: &Packed,
    scene: &Scene,
    settings: &Settings,
    plan: &Plan,
) -> Option<(Vec<[f32; 3]>, Counts)> {
    let [x0, y0, x1, y1] = settings.region();
    let width = x1 - x0;
    let mut memory = Memory::new(&plan.buffer_bytes, packed, &packed.camera(scene, settings));
    let mut counts = Counts {
        depths: vec![[0; 4]; settings.depth as usize],
        counters: [0; abi::COUNTERS as usize],
        tests: Vec::new(),
    };
    let mut linear = vec![[0.0; 3]; (width * (y1 - y0)) as usize];
    let mut batch_samples = plan.batch_samples;
    let mut work = tiles([x0, y0, x1, y1], plan.tile_pixels);
    while let Some(tile) = work.pop() {
        let traced = trace_tile(&mut memory, &tile, settings, plan, batch_samples);
        let Some(tally) = traced else {
            // As `render` does: smaller batches, then smaller tiles.
            if batch_samples > 1 {
                batch_samples /= 2;
                work.push(tile);
            } else {
                let [first, second] = tile.halves()?;
                work.extend([second, first]);
            }
            continue;
        };
        counts.depths.iter_mut().zip(&tally.depths).for_each(|(sum, more)| {
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        });
        counts.counters.iter_mut().zip(tally.counters).for_each(|(sum, more)| *sum += more);
        add_tests(&mut counts.tests, &tally.tests);
        let pixels = memory.film.chunks(plan.specialisation.film_sums() as usize);
        for (films, at) in pixels.zip(tile.offsets([x0, y0, x1, y1])) {
            let films: Vec<ImageFilm> =
                films.iter().map(|&Film { sum, compensation }| ImageFilm { sum, compensation }).collect();
            linear[at] = mean(&films, settings.samples);
        }
    }
    Some((linear, counts))
}

/// All samples of one tile; `None` if a queue was too small.
fn trace_tile(
    memory: &mut Memory,
    tile: &Tile,
    settings: &Settings,
    plan: &Plan,
    batch_samples: u32,
) -> Option<Counts> {
    let mut counts = Counts {
        depths: vec![[0; 4]; settings.depth as usize],
        counters: [0; abi::COUNTERS as usize],
        tests: Vec::new(),
    };
    memory.film.fill(Film::default());
    let mut first = 0;
    while first < settings.samples {
        memory.depth_counts.fill(DepthCount::default());
        memory.counters.fill(0);
        let samples = batch_samples.min(settings.samples - first);
        batch(memory, tile, settings, plan, first, samples);
        if memory.counters[abi::COUNTER_QUEUE_OVERFLOW as usize] != 0 {
            return None;
        }
        add(&mut counts, memory);
        counts.depths[0][0] += u64::from(tile.pixels()) * u64::from(samples);
        first += samples;
    }
    Some(counts)
}

fn batch(
    memory: &mut Memory,
    tile: &Tile,
    settings: &Settings,
    plan: &Plan,
    first_sample: u32,
    samples: u32,
) {
    let (Tile { x, y, width, .. }, pixels) = (*tile, tile.pixels());
    let last_depth = plan.max_depth.last_depth(settings.depth, settings.cutoff);
    let range = (0, settings.samples);
    let batch = Batch { x, y, width, pixels, first_sample, samples, range, last_depth };
    let push = batch.push(plan, settings);
    memory.queue[0] = batch.first_queue(plan);
    let mut depth = 1;
    for step in dispatches(plan, last_depth) {
        if step.depth > depth {
            memory.next_depth();
            depth = step.depth;
        }
        if step.depth == 0 && depth > 1 {
            // After the last depth the buffers have their own names again, as on the device.
            if depth.is_multiple_of(2) {
                memory.next_depth();
            }
            depth = 1;
        }
        memory.run(step.pass.kernel, &plan.specialisation, &step.push(push));
    }
}

fn add(counts: &mut Counts, memory: &Memory) {
    for (sum, d) in counts.depths.iter_mut().zip(&memory.depth_counts) {
        let more = [d.traced, d.reflections, d.refractions, d.shadow];
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += u64::from(more));
    }
    counts.counters.iter_mut().zip(&memory.counters).for_each(|(sum, more)| *sum += u64::from(*more));
    add_tests(&mut counts.tests, &tests_of(&memory.counters));
}

fn add_tests(sums: &mut Vec<KindTests>, more: &[KindTests]) {
    sums.resize(sums.len().max(more.len()), KindTests::default());
    let (sums, more) = (sums.as_flattened_mut().as_flattened_mut(), more.as_flattened().as_flattened());
    sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}
