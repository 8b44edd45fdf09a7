//! A plan is made in steps: the specialisation that follows from the scene; the largest batch that fits the
//! device, with the kernels for it; the specialisation that follows from those kernels; the schedule of the
//! settings.

use super::limits::{binds_all, may_read_texels, workgroup};
use super::{Limits, Plan, PlanError, TEXEL_BYTES};
use crate::kernel::abi::{self, Specialisation};
use crate::kernel::table::KERNELS;
use crate::prepare::Packed;
use crate::prepare::bvh::Forms;
use crate::settings::forced_features::Feature;
use crate::settings::{Origin, Precision, Settings, SurfaceSums};

/// Rays per batch that keep lavapipe's queues in its caches (docs/design/decisions/002-batch-size.md).
const CPU_BATCH: u32 = 1 << 17;
/// Rays per batch on a GPU: two million rays of some 200 bytes fill it many times over, and stay
/// under a quarter of a small card's memory.
const GPU_BATCH: u32 = 1 << 21;
/// Greatest number of lights of one `shadow` pass, whose walks share the steps of a dispatch. `light` is told of each
/// of them in a bit.
const LIGHTS_PER_PASS: u32 = 8;
/// Lanes of lavapipe's widest vectors, of 512 bits.
const WIDEST_VECTOR: u32 = 16;
/// Least number of samples for which software devices run the stages of a depth as one kernel: it takes longer to
/// compile and saves a fifth of the time (docs/design/decisions/025-fused-depth.md).
const FUSED_SAMPLES: u64 = 1 << 21;

/// Scene, settings and device that a plan is made for.
#[derive(Clone, Copy)]
pub(super) struct Input<'a> {
    pub(super) packed: &'a Packed,
    pub(super) settings: &'a Settings,
    pub(super) limits: &'a Limits,
    /// True if listed pixels are traced instead of an image.
    pub(super) survey: bool,
}

/// A choice between kernels for the stages of a depth.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Choice {
    /// One kernel for the stages that work on a ray alone.
    pub(super) fused: bool,
    /// The lanes of a subgroup search for hits together.
    pub(super) joined: bool,
}

impl Plan {
    pub(super) fn build(input: Input<'_>) -> Result<Plan, PlanError> {
        let mut plan = Plan::without_sizes(input);
        let choices = plan.choices(input);
        let Some((batch, choice)) = plan.fit_batch(input, choices) else {
            // What fits may be read as texels even where all of this may not.
            plan.size_for(input, 1, choices[1]);
            return Err(plan.too_large(input.packed, input.settings, input.limits));
        };
        plan.specialise(input, choice);
        plan.schedule(input.settings, batch);
        plan.size_in_parts(input, batch, choice);
        if let Some(steps) = input.settings.schedule.walk_steps {
            plan.specialisation.loop_cap = plan.specialisation.loop_cap.min(steps);
        }
        Ok(plan)
    }

    /// The parts that follow from scene and settings alone.
    fn without_sizes(input: Input<'_>) -> Plan {
        let Input { packed, settings, survey, .. } = input;
        // A survey may be told to cut less than at first.
        let cutoff = if survey { 0.0 } else { settings.cutoff };
        let by_brute_force = packed.bvh_depth == 0;
        let lights_per_pass =
            if by_brute_force { 1 } else { (packed.lights.len() as u32).clamp(1, LIGHTS_PER_PASS) };
        Plan {
            specialisation: specialisation(input),
            capacity: 0,
            tile_pixels: 0,
            batch_samples: 0,
            lights_per_pass,
            max_depth: packed.max_depth,
            last_depth: packed.max_depth.last_depth(settings.depth, cutoff),
            buffer_bytes: Vec::new(),
            bytes_in_parts: Vec::new(),
            parts: false,
            features: packed.features(),
        }
    }

    /// The choices in order of preference. The later ones are for buffers that do not fit texel views.
    fn choices(&self, input: Input<'_>) -> [Choice; 3] {
        let Input { packed, settings, limits, .. } = input;
        let few = packed.bvh_depth == 0 && packed.primitive_count() <= abi::UNROLL_MAX as usize;
        let joined = limits.forms(settings) != Forms::Nodes && (few || !packed.compressed_nodes.is_empty());
        let fused = joined && self.may_fuse(input);
        [Choice { fused, joined }, Choice { fused: false, joined }, Choice::default()]
    }

    /// True if one kernel may do the stages of a depth that work on a ray alone. lavapipe stores and loads
    /// the queues between kernels lane by lane, which is slow; but it compiles one large kernel on one core. Others
    /// keep split kernels (docs/design/gpu.md).
    fn may_fuse(&self, input: Input<'_>) -> bool {
        let Input { settings, limits, survey, .. } = input;
        let many = samples(settings, survey) >= FUSED_SAMPLES;
        limits.driver.joins_lanes()
            && binds_all(limits)
            && self.specialisation.light_count <= LIGHTS_PER_PASS
            && settings.schedule.fused.unwrap_or(many)
            && !settings.schedule.forced_features.has(Feature::SplitKernels)
    }

    /// Halves the batch until every queue fits a binding and all of them the heap. Gives the samples of the batch
    /// and the first choice that has kernels, and sizes the plan for them; `None` if one sample does not fit.
    fn fit_batch(&mut self, input: Input<'_>, choices: [Choice; 3]) -> Option<(u32, Choice)> {
        let wanted = if input.limits.driver.is_cpu() { CPU_BATCH } else { GPU_BATCH };
        let all = pixels(input.settings).saturating_mul(input.settings.samples.into());
        let mut batch = u64::from(wanted).min(all).max(1) as u32;
        loop {
            let choice = choices.into_iter().find(|choice| self.can(input, batch, *choice));
            if let Some(choice) = choice.filter(|_| self.fits(input.limits)) {
                return Some((batch, choice));
            }
            if batch == 1 {
                return None;
            }
            batch /= 2;
        }
    }

    /// Sizes everything for `choice`; true if there are kernels for it.
    fn can(&mut self, input: Input<'_>, batch: u32, choice: Choice) -> bool {
        self.size_for(input, batch, choice);
        self.specialisation.texels = u32::from(self.reads_texels(input.settings, input.limits));
        self.specialisation.fused = u32::from(choice.fused);
        let has_nodes = choice.joined || self.specialisation.use_bvh == 0 || !input.packed.nodes.is_empty();
        has_nodes && (!choice.joined || self.specialisation.texels != 0)
    }

    /// True if kernels read through texel views: they may, and every buffer fits its view.
    fn reads_texels(&self, settings: &Settings, limits: &Limits) -> bool {
        let viewed = KERNELS.iter().fold(0, |bits, k| bits | k.texels);
        let fits = |(i, bytes): (usize, &u64)| {
            viewed >> i & 1 == 0 || bytes / TEXEL_BYTES <= u64::from(limits.texel_elements)
        };
        may_read_texels(settings, limits) && self.buffer_bytes.iter().enumerate().all(fits)
    }

    /// Sets the specialisation that follows from the choice of kernels.
    fn specialise(&mut self, input: Input<'_>, choice: Choice) {
        if choice.joined {
            self.specialisation.lanes = input.limits.shuffle_lanes;
            // In steps, so that scenes of similar size share their compiled kernels.
            self.specialisation.stack_size = (input.packed.packet_stack as u32 + 1).next_multiple_of(8) - 1;
            // A packet's lanes take every step together.
            self.specialisation.loop_cap = abi::LOOP_CAP;
        }
    }

    /// Sets the samples of a batch, and the lower sizes that a schedule asks for.
    fn schedule(&mut self, settings: &Settings, batch: u32) {
        if let Some(tile) = settings.schedule.tile_pixels {
            self.tile_pixels = self.tile_pixels.min(tile.max(1));
        }
        let share = settings.schedule.share;
        if !share.is_whole() {
            self.tile_pixels = self.tile_pixels.min(share.tile_side(settings.region()).pow(2));
        }
        self.batch_samples = (batch / self.tile_pixels).clamp(1, settings.samples);
        // `resolve` walks a pixel's samples of the batch in one loop, in a survey in two.
        self.batch_samples = self.batch_samples.min(abi::LOOP_CAP / 2);
        if let Some(samples) = settings.schedule.batch_samples {
            self.batch_samples = self.batch_samples.min(samples.max(1));
        }
        if let Some(capacity) = settings.schedule.capacity {
            self.capacity = self.capacity.min(capacity.max(self.tile_pixels * self.batch_samples));
        }
    }
}

/// The specialisation before kernels are chosen: each ray walks alone.
fn specialisation(input: Input<'_>) -> Specialisation {
    let Input { packed, settings, limits, survey } = input;
    let forced = settings.schedule.forced_features;
    Specialisation {
        workgroup: workgroup(settings, limits),
        triangle_count: packed.triangles.len() as u32,
        sphere_count: packed.spheres.len() as u32,
        light_count: packed.lights.len() as u32,
        use_bvh: u32::from(packed.bvh_depth > 0),
        smooth_normals: u32::from(!packed.corner_normals.is_empty()),
        media_capacity: packed.media_capacity,
        extended_spheres_used: u32::from(
            !packed.extended_spheres.is_empty() || forced.has(Feature::ExtendedSpheres),
        ),
        robust: u32::from(settings.precision != Precision::Fast),
        origin_fixed: u32::from(settings.origin != Origin::Bound),
        branching: u32::from(packed.branching),
        loop_cap: abi::LOOP_CAP / walks_counted_together(limits),
        sampler_kind: settings.sampler.word(),
        replicates: settings.replicates.max(1),
        parts: if survey && settings.replicates <= 1 { abi::PARTS } else { 1 },
        survey: u32::from(survey),
        texels: 0,
        lanes: 0,
        stack_size: abi::STACK_SIZE,
        triangles_outside: u32::from(packed.outside[0]),
        spheres_outside: u32::from(packed.outside[1]),
        counting: u32::from(settings.schedule.count_tests),
        surface_layer: settings.schedule.surface_layer.map_or(abi::LAYER_LIGHT, SurfaceSums::word),
        fused: 0,
    }
}

/// Lanes whose steps count together. lavapipe counts the iterations of a vector, in which at least one lane takes
/// part, so they are at most the sum over its lanes; where their number is not known, the most that it has. A GPU has no
/// such limit: the cap only keeps its dispatches short.
fn walks_counted_together(limits: &Limits) -> u32 {
    match limits.driver.is_cpu() {
        true if limits.shuffle_lanes > 0 => limits.shuffle_lanes,
        true => WIDEST_VECTOR,
        false => 1,
    }
}

/// Pixels of the region.
fn pixels(settings: &Settings) -> u64 {
    let [x0, y0, x1, y1] = settings.region();
    u64::from(x1 - x0) * u64::from(y1 - y0)
}

/// Samples of the image. The number for a survey is not known in advance; 16 a pixel are assumed.
fn samples(settings: &Settings, survey: bool) -> u64 {
    pixels(settings).saturating_mul(if survey { 16 } else { settings.samples.into() })
}
