//! What this scene needs on this device, decided before anything is allocated: specialisation,
//! queue capacity, tile and batch, bytes.

pub mod dispatches;
mod error;
pub mod explain;
mod fit;
pub mod memory_traffic;
pub mod passes;
mod planned_scene;
pub mod predicted_time;
pub mod tiles;

pub use error::{PlanError, Shortage};
pub(crate) use fit::HEAP_EIGHTHS;
pub use planned_scene::{PlannedScene, Purpose};

use crate::kernel::abi::{self, Buf, GpuStruct, Specialisation};
use crate::kernel::table::{KERNELS, Kernel};
use crate::prepare::bvh::Forms;
use crate::prepare::max_depth::MaxDepth;
use crate::prepare::{Packed, pack};
use crate::scene::Scene;
use crate::settings::forced_features::Feature;
use crate::settings::{Origin, Precision, Settings};
use dispatches::dispatches;

/// The limits of a device that a plan depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one storage-buffer binding.
    pub storage_range: u64,
    /// Bytes of the heap that buffers come from.
    pub heap: u64,
    /// Invocations per workgroup.
    pub workgroup_invocations: u32,
    /// Texels of a texel buffer.
    pub texel_elements: u32,
    /// Invocations of a subgroup, if compute kernels may shuffle values among them; else 0.
    pub shuffle_lanes: u32,
    /// Storage buffers that one kernel may have.
    pub storage_buffers: u32,
    /// True for a software device: its memory is the caches of a few cores.
    pub is_cpu: bool,
}

impl Limits {
    /// Those of lavapipe 22.3 with vectors of 8 lanes: plans without a device, as the twins take them, are made for it.
    pub const LAVAPIPE: Limits = Limits {
        storage_range: 1 << 27,
        heap: 1 << 31,
        workgroup_invocations: 1024,
        texel_elements: 1 << 27,
        shuffle_lanes: 8,
        storage_buffers: 32,
        is_cpu: true,
    };
}

impl Limits {
    /// The forms of a hierarchy's nodes that a plan for such a device may need: which way rays walk. Where a vector
    /// of a few lanes is the whole machine, what each lane loads and stores by itself is the cost, and the rays of
    /// eight pixels meet much the same nodes: they walk together. A GPU's lanes load side by side, and 32 or 64
    /// rays have less in common.
    pub fn forms(&self, settings: &Settings) -> Forms {
        let lone = settings.schedule.general.has(Feature::LoneRays);
        if lone || !may_join(settings, self) {
            Forms::Nodes
        } else if TEXEL_BYTES * u64::from(self.texel_elements) >= self.storage_range {
            // What texels do not reach fits no binding either.
            Forms::Compressed
        } else {
            Forms::Both
        }
    }
}

/// What a device's properties switch for scenes of a usual size (docs/design/gpu.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Switched {
    /// Scene and queues are read as texels, not as storage buffers.
    pub texels: bool,
    /// The rays of a subgroup walk the hierarchy together.
    pub packets: bool,
    /// Renders of many samples take one kernel for the stages of a depth.
    pub fused: bool,
}

impl Switched {
    /// By the limits of a device, in single precision.
    pub fn of(limits: &Limits) -> Switched {
        let workgroup = DEFAULT_WORKGROUP.min(limits.workgroup_invocations);
        let packets = limits.is_cpu && is_full(workgroup, limits);
        Switched { texels: limits.is_cpu, packets, fused: packets && binds_all(limits) }
    }
}

/// Bytes of a texel: four words.
pub const TEXEL_BYTES: u64 = 16;

/// A plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Kernel variant.
    pub specialisation: Specialisation,
    /// Rays that fit a queue.
    pub capacity: u32,
    /// Pixels of a tile, at most.
    pub tile_pixels: u32,
    /// Samples per pixel traced together, at most.
    pub batch_samples: u32,
    /// Lights per `shadow` pass.
    pub lights_per_pass: u32,
    /// How deep light can travel.
    pub reach: MaxDepth,
    /// Depth of the last passes, as far as is known before cutoffs change.
    pub last_depth: u32,
    /// Bytes of each buffer, in binding order.
    pub buffer_bytes: Vec<u64>,
    /// What the scene requires, in plain words.
    pub features: Vec<&'static str>,
}

/// How rays go through a depth.
#[derive(Debug, Clone, Copy, Default)]
struct Choice {
    /// One kernel for the stages that work on a ray alone.
    fused: bool,
    /// The lanes of a subgroup look for hits together.
    joined: bool,
}

/// Rays per batch that keep lavapipe's queues in its caches (docs/design/decisions/002-batch-size.md).
const CPU_BATCH: u32 = 1 << 17;
/// Rays per batch on a GPU: two million rays of some 200 bytes fill it many times over, and stay
/// under a quarter of a small card's memory.
const GPU_BATCH: u32 = 1 << 21;
/// Queue entries per sample of a batch where rays branch. Not a bound: a fuller queue is detected
/// before it is written, and the tile is traced again in smaller batches.
const BRANCHING_ROOM: u32 = 4;
/// Queue entries at least where rays branch: as many rays of one sample as `gather` can add up
/// (LOOP_CAP), rounded up.
const BRANCHING_LEAST: u32 = 1 << 16;
/// Lights that one `shadow` pass walks at most. All loops of an invocation share lavapipe's 65,535
/// iterations, so each light's traversal has LOOP_CAP / lights of them.
const LIGHTS_PER_PASS: u32 = 8;
/// Samples from which on the stages of a depth are one kernel on software devices: it starts later and saves a fifth
/// of the time (docs/design/decisions/025-fused-depth.md).
const FUSED_SAMPLES: u64 = 1 << 21;

/// Primitives that are all tested, at most; beyond them walking a hierarchy pays
/// (docs/design/decisions/010-brute-force-limit.md).
pub const BRUTE_FORCE_MAX: usize = 32;
/// The same where the lanes of a subgroup work together (docs/design/decisions/030-constant-shapes.md).
const BRUTE_FORCE_MAX_JOINED: usize = 12;

/// Up to how many primitives every one is tested (`pack`). `forced`: always or never, whatever the scene.
pub fn brute_force_max(forced: Option<bool>, settings: &Settings, limits: &Limits) -> usize {
    let on = |f: Feature| settings.schedule.general.has(f);
    match forced {
        Some(true) => usize::MAX,
        Some(false) => 0,
        None if on(Feature::Hierarchy) => 0,
        None if !may_join(settings, limits) || on(Feature::LoneRays) => BRUTE_FORCE_MAX,
        None => BRUTE_FORCE_MAX_JOINED,
    }
}

/// Packs `scene` for a [`Plan::new`] under these limits.
pub fn pack_for(scene: &Scene, settings: &Settings, limits: &Limits) -> Packed {
    pack(scene, settings, brute_force_max(None, settings, limits))
}

impl Plan {
    /// Plans the image of `packed` under `settings`.
    ///
    /// # Errors
    /// If the scene does not fit the device; says what would.
    pub fn new(packed: &Packed, settings: &Settings, limits: &Limits) -> Result<Plan, PlanError> {
        Plan::build(packed, settings, limits, false)
    }

    fn build(packed: &Packed, settings: &Settings, limits: &Limits, survey: bool) -> Result<Plan, PlanError> {
        let workgroup = workgroup(settings, limits);
        let [x0, y0, x1, y1] = settings.region();
        let pixels = u64::from(x1 - x0) * u64::from(y1 - y0);
        let total = pixels.saturating_mul(u64::from(settings.samples));
        let wanted = if limits.is_cpu { CPU_BATCH } else { GPU_BATCH };
        // A survey may be told to cut less than at first.
        let cutoff = if survey { 0.0 } else { settings.cutoff };
        let last_depth = packed.reach.last_depth(settings.depth, cutoff);
        let room = match packed.branching {
            true => BRANCHING_ROOM.min(1u32.checked_shl(last_depth - 1).unwrap_or(u32::MAX)),
            false => 1,
        };
        let by_brute_force = packed.bvh_depth == 0;
        let lights_per_pass =
            if by_brute_force { 1 } else { (packed.lights.len() as u32).clamp(1, LIGHTS_PER_PASS) };
        let per_light = abi::LOOP_CAP / lights_per_pass;
        if by_brute_force && packed.primitive_count() as u32 > per_light {
            return Err(PlanError::TooManyToTry { primitives: packed.primitive_count(), limit: per_light });
        }
        let on = |f: Feature| settings.schedule.general.has(f);
        let mut plan = Plan {
            specialisation: Specialisation {
                workgroup,
                triangle_count: packed.triangles.len() as u32,
                sphere_count: packed.spheres.len() as u32,
                light_count: packed.lights.len() as u32,
                use_bvh: u32::from(packed.bvh_depth > 0),
                smooth_normals: u32::from(!packed.corner_normals.is_empty()),
                media_capacity: packed.media_capacity,
                extended_spheres_used: u32::from(
                    !packed.extended_spheres.is_empty() || on(Feature::ExtendedSpheres),
                ),
                robust: u32::from(settings.precision != Precision::Fast),
                origin_fixed: u32::from(settings.origin != Origin::Bound),
                branching: u32::from(packed.branching),
                loop_cap: per_light,
                sampler_kind: settings.sampler.word(),
                replicates: settings.replicates.max(1),
                survey: u32::from(survey),
                texels: 0,
                lanes: 0,
                stack_size: abi::STACK_SIZE,
                triangles_outside: u32::from(packed.outside[0]),
                spheres_outside: u32::from(packed.outside[1]),
                fused: 0,
            },
            capacity: 0,
            tile_pixels: 0,
            batch_samples: 0,
            lights_per_pass,
            reach: packed.reach,
            last_depth,
            buffer_bytes: Vec::new(),
            features: packed.features(),
        };
        let few = by_brute_force && packed.primitive_count() <= abi::UNROLL_MAX as usize;
        let joined = limits.forms(settings) != Forms::Nodes && (few || !packed.compressed_nodes.is_empty());
        let fused = joined && plan.may_fuse(settings, limits, survey);
        // What is wanted, then what else there is where texel views do not reach.
        let choices = [Choice { fused, joined }, Choice { fused: false, joined }, Choice::default()];
        // Halve the batch until every queue fits a binding and all of them the heap.
        let mut batch = u64::from(wanted).min(total).max(1) as u32;
        let choice = loop {
            let mut can = |choice: &Choice| plan.can(*choice, packed, settings, limits, batch, room);
            let choice = choices.into_iter().find(|choice| can(choice));
            if let Some(choice) = choice.filter(|_| plan.fits(limits)) {
                break choice;
            }
            if batch == 1 {
                // What fits may be read as texels even where all of this may not.
                plan.size_for(packed, settings, limits, batch, room, choices[1]);
                return Err(plan.too_large(packed, settings, limits));
            }
            batch = (batch / 2).max(1);
        };
        if choice.joined {
            plan.specialisation.lanes = limits.shuffle_lanes;
            // In steps, so that scenes of about a size share their compiled kernels.
            plan.specialisation.stack_size = (packed.packet_stack as u32 + 1).next_multiple_of(8) - 1;
        }
        if choice.fused {
            // One invocation walks for its ray and for the shadow ray of each light.
            plan.specialisation.loop_cap = abi::LOOP_CAP / (packed.lights.len() as u32 + 1);
        }
        if let Some(tile) = settings.schedule.tile_pixels {
            plan.tile_pixels = plan.tile_pixels.min(tile.max(1));
        }
        plan.batch_samples = (batch / plan.tile_pixels).clamp(1, settings.samples);
        // `resolve` walks a pixel's samples of the batch in one loop, in a survey in two.
        plan.batch_samples = plan.batch_samples.min(abi::LOOP_CAP / 2);
        if let Some(samples) = settings.schedule.batch_samples {
            plan.batch_samples = plan.batch_samples.min(samples.max(1));
        }
        if let Some(capacity) = settings.schedule.capacity {
            plan.capacity = plan.capacity.min(capacity.max(plan.tile_pixels * plan.batch_samples));
        }
        Ok(plan)
    }

    /// Whether one kernel may do the stages of a depth that work on a ray alone: what goes through queues between
    /// kernels is stored and loaded lane by lane on a software device, which is dear; but one large kernel is
    /// compiled on one core. A GPU keeps split kernels (docs/design/gpu.md).
    fn may_fuse(&self, settings: &Settings, limits: &Limits, survey: bool) -> bool {
        let many = samples(settings, survey) >= FUSED_SAMPLES;
        limits.is_cpu
            && binds_all(limits)
            && self.specialisation.light_count <= LIGHTS_PER_PASS
            && settings.schedule.fused.unwrap_or(many)
            && !settings.schedule.general.has(Feature::SplitKernels)
    }

    /// Sizes everything for `choice`, and tells whether there are kernels for it.
    fn can(
        &mut self,
        choice: Choice,
        packed: &Packed,
        settings: &Settings,
        limits: &Limits,
        batch: u32,
        room: u32,
    ) -> bool {
        self.size_for(packed, settings, limits, batch, room, choice);
        self.specialisation.texels = u32::from(self.reads_texels(settings, limits));
        self.specialisation.fused = u32::from(choice.fused);
        let made = choice.joined || self.specialisation.use_bvh == 0 || !packed.nodes.is_empty();
        made && (!choice.joined || self.specialisation.texels != 0)
    }

    fn size_for(
        &mut self,
        packed: &Packed,
        settings: &Settings,
        limits: &Limits,
        batch: u32,
        room: u32,
        choice: Choice,
    ) {
        let [x0, y0, x1, y1] = settings.region();
        // A small image has few samples, but each of them may branch as far as in a large one.
        let growth = 1u32.checked_shl(self.last_depth - 1).unwrap_or(u32::MAX);
        let least = if packed.branching { BRANCHING_LEAST.min(batch.saturating_mul(growth)) } else { 0 };
        self.capacity = batch.saturating_mul(room).max(least);
        // Whole rows where a row fits.
        let width = x1 - x0;
        let rows = (batch / width).clamp(1, y1 - y0);
        self.tile_pixels = (rows * width).min(batch);
        let (capacity, tile, batch) =
            (u64::from(self.capacity), u64::from(self.tile_pixels), u64::from(batch));
        let groups = capacity.div_ceil(u64::from(self.specialisation.workgroup)) + 1;
        let media = u64::from(packed.media_capacity);
        let (Choice { fused, joined }, deep) = (choice, self.last_depth > 1);
        // `fused_depth` leaves a ray's children at places of their own.
        let places = if fused && deep && packed.branching { 2 * capacity } else { capacity };
        let masks = u64::from(self.specialisation.workgroup / limits.shuffle_lanes.max(1));
        self.buffer_bytes = abi::BUFFERS
            .iter()
            .map(|(_, element, buffer)| {
                let count = match buffer {
                    Buf::Camera | Buf::Queue | Buf::NextQueue => 1,
                    Buf::Triangles => packed.triangles.len() as u64,
                    Buf::FlatNormals => packed.flat_normals.len() as u64,
                    Buf::CornerNormals => packed.corner_normals.len() as u64,
                    Buf::Spheres => packed.spheres.len() as u64,
                    Buf::ExtendedSpheres => packed.extended_spheres.len() as u64,
                    Buf::Nodes if joined => 1,
                    Buf::Nodes => packed.nodes.len() as u64,
                    Buf::CompressedNodes if joined => packed.compressed_nodes.as_flattened().len() as u64,
                    Buf::CompressedNodes => 1,
                    Buf::Materials => packed.materials.len() as u64,
                    Buf::Lights => packed.lights.len() as u64,
                    Buf::SolidIors => packed.solid_iors.len() as u64,
                    Buf::SolidPriorities => packed.solid_priorities.len() as u64,
                    Buf::EyeMedia => media,
                    Buf::NextRays | Buf::NextMedia if !deep => 1,
                    Buf::Rays | Buf::NextRays => places,
                    Buf::Hits | Buf::Surfaces if fused => 1,
                    Buf::Hits | Buf::Surfaces => capacity,
                    Buf::RayIndices if fused && deep => capacity,
                    Buf::RayIndices => 1,
                    Buf::Contributions
                        if packed.branching && deep || packed.lights.len() as u32 > self.lights_per_pass =>
                    {
                        capacity
                    }
                    Buf::Contributions => 1,
                    Buf::Media | Buf::NextMedia => places * media,
                    Buf::ChildMasks if fused => groups * masks,
                    Buf::ChildCounts if fused => 1,
                    Buf::ChildMasks => 1,
                    Buf::ChildCounts | Buf::Offsets => groups,
                    Buf::SampleRadiance => batch,
                    Buf::Film => tile * u64::from(self.specialisation.replicates),
                    Buf::Paths if self.specialisation.survey != 0 => batch,
                    Buf::Pixels | Buf::Marks if self.specialisation.survey != 0 => tile,
                    Buf::Paths | Buf::Pixels | Buf::Marks => 1,
                    Buf::DepthCounts => u64::from(settings.depth) + 1,
                    Buf::Counters => u64::from(abi::COUNTERS),
                    Buf::SelfTest => 1,
                };
                // Vulkan knows no empty buffer.
                count.max(1) * element_bytes(element, settings.precision)
            })
            .collect();
    }

    /// Whether kernels read through texel views. A software device gathers texels as one vector, and
    /// loads from storage buffers lane by lane; a GPU has nothing to gain. Views have no f64.
    fn reads_texels(&self, settings: &Settings, limits: &Limits) -> bool {
        let viewed = KERNELS.iter().fold(0, |bits, k| bits | k.texels);
        let fits = |(i, bytes): (usize, &u64)| {
            viewed >> i & 1 == 0 || bytes / TEXEL_BYTES <= u64::from(limits.texel_elements)
        };
        may_read_texels(settings, limits) && self.buffer_bytes.iter().enumerate().all(fits)
    }

    /// Whether the rays of a subgroup walk the hierarchy together, over compressed nodes.
    pub fn walks_in_packets(&self) -> bool {
        self.specialisation.use_bvh != 0 && self.specialisation.lanes != 0
    }

    /// The kernels that a batch runs, in the order of the pass table.
    pub fn kernels(&self) -> Vec<Kernel> {
        let runs: Vec<Kernel> = dispatches(self, self.last_depth).map(|s| s.pass.kernel).collect();
        passes::all().map(|p| p.kernel).filter(|k| runs.contains(k)).collect()
    }

    /// Device bytes in all.
    pub fn bytes(&self) -> u64 {
        self.buffer_bytes.iter().sum()
    }
}

/// Invocations per workgroup, unless a schedule says otherwise.
const DEFAULT_WORKGROUP: u32 = 64;

/// Whether one kernel can bind what the stages of a depth read and write.
fn binds_all(limits: &Limits) -> bool {
    let code = Kernel::FusedDepth.code();
    limits.storage_buffers >= (code.reads | code.writes).count_ones()
}

/// Invocations per workgroup.
fn workgroup(settings: &Settings, limits: &Limits) -> u32 {
    settings
        .schedule
        .workgroup
        .unwrap_or(DEFAULT_WORKGROUP)
        .min(limits.workgroup_invocations)
        .min(abi::WORKGROUP_MAX)
}

/// Whether subgroups are full and of a size that the kernels' shuffles know.
fn is_full(workgroup: u32, limits: &Limits) -> bool {
    matches!(limits.shuffle_lanes, 4 | 8) && workgroup.is_multiple_of(limits.shuffle_lanes)
}

/// Whether the lanes of a subgroup can work together on a scene that texel views reach all of.
fn may_join(settings: &Settings, limits: &Limits) -> bool {
    may_read_texels(settings, limits) && is_full(workgroup(settings, limits), limits)
}

/// Samples of the picture. A survey does not say how many it will be asked for: as many as a picture takes.
fn samples(settings: &Settings, survey: bool) -> u64 {
    let [x0, y0, x1, y1] = settings.region();
    let pixels = u64::from(x1 - x0) * u64::from(y1 - y0);
    pixels.saturating_mul(if survey { 16 } else { settings.samples.into() })
}

/// Whether kernels read texels where views reach far enough.
fn may_read_texels(settings: &Settings, limits: &Limits) -> bool {
    limits.is_cpu
        && settings.precision != Precision::Double
        && !settings.schedule.general.has(Feature::Storage)
}

/// Bytes of a buffer's element by its GLSL name.
pub fn element_bytes(element: &str, precision: Precision) -> u64 {
    let structs = if precision == Precision::Double { abi::double::STRUCTS } else { abi::single::STRUCTS };
    let of_struct = |s: &&GpuStruct| s.name == element;
    match (element, structs.iter().find(of_struct)) {
        (_, Some(s)) => s.size as u64,
        ("vec3", None) => 12,
        ("real", None) if precision == Precision::Double => 8,
        _ => 4,
    }
}

#[cfg(test)]
mod tests;
