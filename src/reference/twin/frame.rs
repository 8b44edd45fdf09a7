//! The frame on the CPU: the passes of a plan, tile by tile and batch by batch, as `render` records them.

use super::super::Counts;
use super::memory::Memory;
use super::structs::{DepthCount, Film, Push, Queue};
use crate::kernel::abi::{self, Film as ImageFilm};
use crate::plan::Plan;
use crate::plan::passes::{EPILOGUE, PER_DEPTH, PROLOGUE, When};
use crate::plan::tiles::{Tile, tiles};
use crate::prepare::Packed;
use crate::render::mean;
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
    let mut counts =
        Counts { depths: vec![[0; 4]; settings.depth as usize], counters: [0; abi::COUNTERS as usize] };
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
        let pixels = memory.film.chunks(plan.specialisation.replicates as usize);
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
    let mut counts =
        Counts { depths: vec![[0; 4]; settings.depth as usize], counters: [0; abi::COUNTERS as usize] };
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
    let spec = &plan.specialisation;
    let last_depth = plan.reach.last_depth(settings.depth, settings.cutoff);
    let items = tile.pixels() * samples;
    let push = Push {
        tile_x: tile.x,
        tile_y: tile.y,
        tile_width: tile.width,
        tile_pixels: tile.pixels(),
        first_sample,
        batch_samples: samples,
        samples: settings.samples,
        seed: settings.seed,
        last_depth,
        light_end: spec.light_count,
        capacity: plan.capacity,
        items,
        cutoff: settings.cutoff,
        ..Push::default()
    };
    let groups = items.div_ceil(spec.workgroup);
    memory.queue[0] = Queue {
        groups_x: groups.min(abi::GROUPS_PER_ROW),
        groups_y: groups.div_ceil(abi::GROUPS_PER_ROW),
        groups_z: 1,
        count: items,
        reflections: 0,
    };
    for pass in PROLOGUE {
        memory.run(pass.kernel, spec, &push);
    }
    for depth in 1..=last_depth {
        let push = Push { depth, ..push };
        for pass in PER_DEPTH.iter().filter(|p| p.is_of(spec.fused != 0)) {
            match pass.when {
                When::Always => memory.run(pass.kernel, spec, &push),
                When::NotLast if depth < last_depth => memory.run(pass.kernel, spec, &push),
                When::Branching if depth > 1 && spec.branching != 0 => memory.run(pass.kernel, spec, &push),
                When::PerLights => {
                    let mut begin = 0;
                    loop {
                        let end = (begin + plan.lights_per_pass).min(spec.light_count);
                        let push = Push { light_begin: begin, light_end: end, ..push };
                        memory.run(pass.kernel, spec, &push);
                        begin = end;
                        if begin >= spec.light_count {
                            break;
                        }
                    }
                }
                When::NotLast | When::Branching => {}
            }
        }
        if depth < last_depth {
            memory.next_depth();
        }
    }
    if last_depth.is_multiple_of(2) {
        // The next batch starts with the buffers under their own names again, as on the device.
        memory.next_depth();
    }
    for pass in EPILOGUE {
        memory.run(pass.kernel, spec, &push);
    }
}

fn add(counts: &mut Counts, memory: &Memory) {
    for (sum, d) in counts.depths.iter_mut().zip(&memory.depth_counts) {
        let more = [d.traced, d.reflections, d.refractions, d.shadow];
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += u64::from(more));
    }
    counts.counters.iter_mut().zip(&memory.counters).for_each(|(sum, more)| *sum += u64::from(*more));
}
