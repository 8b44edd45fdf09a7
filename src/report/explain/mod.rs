//! A plan told: what was found in the scene, what follows from it, what it takes. For people and as JSON.

mod text;
mod variant;

pub use text::text;

use crate::kernel::abi::{self, Buf};
use crate::plan::predicted_time::Prediction;
use crate::plan::{BRUTE_FORCE_MAX, HEAP_EIGHTHS, KNOWN_SAMPLES, Limits, Plan, element_bytes};
use crate::prepare::Packed;
use crate::prepare::scene_features::Found;
use crate::report::{DeviceInfo, LocalFrameInfo, ProgramInfo, SettingsInfo};
use crate::settings::{Precision, Settings};
use crate::units::{grouped, plural};
use serde::Serialize;
pub use variant::{Constant, KernelRow};

/// All that is known before a render runs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Outline {
    /// Which program plans.
    pub program: ProgramInfo,
    /// For which device.
    pub device: DeviceInfo,
    /// Path as given.
    pub scene: String,
    /// The settings in force.
    pub settings: SettingsInfo,
    /// What the scene has.
    pub found: Found,
    /// The same in words, absent features included.
    pub features: Vec<FeatureRow>,
    /// Centre and power-of-two scale of the kernels' coordinates.
    pub local_frame: LocalFrameInfo,
    /// How deep light travels.
    pub reach: ReachInfo,
    /// How the closest hit is found.
    pub search: SearchInfo,
    /// What follows; null where the device cannot hold it.
    pub plan: Option<Planned>,
    /// Limits of the device that the plan keeps.
    pub limits: LimitInfo,
    /// How long it will take; null where that was not asked for or there is no plan.
    pub time: Option<Prediction>,
    /// Why there is no plan.
    pub refused: Option<Refused>,
}

/// A feature, found or not.
#[derive(Debug, Clone, Serialize)]
pub struct FeatureRow {
    /// Its name.
    pub name: &'static str,
    /// Whether the kernels are made for it.
    pub found: bool,
    /// How much of it, or why not.
    pub detail: String,
}

/// How deep light travels.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ReachInfo {
    /// Depth that was asked for.
    pub asked: u32,
    /// Depth of the last passes.
    pub last: u32,
    /// Greatest factor of any surface on a ray's throughput.
    pub weight: f64,
    /// In words.
    pub why: String,
}

/// How the closest hit is found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SearchInfo {
    /// `brute force` or `hierarchy`.
    pub kind: &'static str,
    /// Nodes of the hierarchy.
    pub nodes: u64,
    /// Its levels.
    pub depth: u64,
    /// In words.
    pub why: String,
}

/// What follows from scene, settings and device.
#[derive(Debug, Clone, Serialize)]
pub struct Planned {
    /// The kernels of the frame.
    pub kernels: Vec<KernelRow>,
    /// Specialisation constants that leave code out, or add it.
    pub constants: Vec<Constant>,
    /// Shapes are constants of the kernels.
    pub known_shapes: bool,
    /// Why, or why not.
    pub known_shapes_why: String,
    /// Kernels read what a ray looks up through texel views.
    pub texels: bool,
    /// Why, or why not.
    pub texels_why: String,
    /// Rays that fit a queue.
    pub capacity: u32,
    /// Device bytes of a place in a queue, over all its buffers.
    pub bytes_per_place: u64,
    /// Invocations of a workgroup.
    pub workgroup: u32,
    /// Lights of one `shadow` pass.
    pub lights_per_pass: u32,
    /// Pixels of a tile, at most.
    pub tile_pixels: u32,
    /// Tiles of the image.
    pub tiles: u64,
    /// Samples of a pixel traced together, at most.
    pub batch_samples: u32,
    /// Batches over all tiles, if no queue overflows.
    pub batches: u64,
    /// Dispatches of one batch.
    pub dispatches: u64,
    /// Bytes of each buffer.
    pub buffers: Vec<BufferRow>,
    /// Bytes of all.
    pub bytes: u64,
}

/// A buffer of the plan.
#[derive(Debug, Clone, Serialize)]
pub struct BufferRow {
    /// As the kernels spell it.
    pub name: &'static str,
    /// Elements.
    pub elements: u64,
    /// Bytes.
    pub bytes: u64,
}

/// Limits of the device.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LimitInfo {
    /// Bytes that one binding can hold.
    pub one_buffer: u64,
    /// Bytes of its heap.
    pub heap: u64,
    /// Bytes of it that a plan may take.
    pub heap_share: u64,
}

/// A plan that the device cannot hold.
#[derive(Debug, Clone, Serialize)]
pub struct Refused {
    /// What it lacks, and what would fit.
    pub message: String,
    /// Exit code of the render.
    pub exit_code: u8,
}

impl Outline {
    /// Tells `plan`, or what is known without one.
    pub fn new(
        scene: &str,
        device: &DeviceInfo,
        packed: &Packed,
        settings: &Settings,
        limits: &Limits,
        plan: Option<&Plan>,
    ) -> Outline {
        let reach = &packed.reach;
        Outline {
            program: ProgramInfo::default(),
            device: device.clone(),
            scene: scene.into(),
            settings: crate::render::settings_info(settings),
            found: packed.found,
            features: features(packed),
            local_frame: LocalFrameInfo {
                center: packed.frame.center.to_array(),
                scale_log2: packed.frame.scale_log2,
            },
            reach: ReachInfo {
                asked: settings.depth,
                last: reach.last_depth(settings.depth, settings.cutoff),
                weight: reach.weight,
                why: reach.words(settings.depth, settings.cutoff),
            },
            search: search(packed),
            plan: plan.map(|p| planned(packed, settings, limits, p)),
            limits: LimitInfo {
                one_buffer: limits.storage_range,
                heap: limits.heap,
                heap_share: limits.heap / 8 * HEAP_EIGHTHS,
            },
            time: None,
            refused: None,
        }
    }
}

fn features(packed: &Packed) -> Vec<FeatureRow> {
    let f = &packed.found;
    let row = |name, found, detail| FeatureRow { name, found, detail };
    let count = |name, count: u64, noun: &str| row(name, count > 0, plural(count, noun));
    let is =
        |name, found: bool, yes: &str, no: &str| row(name, found, if found { yes } else { no }.to_owned());
    vec![
        count("triangles", f.triangles, "triangle"),
        is("smooth normals", f.smooth_normals, "some corners have normals", "every triangle is flat"),
        count("spheres", f.spheres, "sphere"),
        row(
            "wide spheres",
            f.wide_spheres > 0,
            match f.wide_spheres {
                0 => "single precision holds every sphere".into(),
                n => format!("{} beyond single precision", plural(n, "sphere")),
            },
        ),
        count("lights", f.lights, "light"),
        is("mirrors", f.mirrors, "some surface mirrors", "no surface mirrors"),
        row(
            "refraction",
            f.solids > 0,
            match f.solids {
                0 => "no solid refracts".into(),
                n => plural(n, "refracting solid"),
            },
        ),
        row(
            "nested media",
            f.solids_at_once > 1,
            match f.solids_at_once {
                0 => "a ray is in no solid".into(),
                n => format!("a ray is in {} at once at most, by their boxes", plural(n.into(), "solid")),
            },
        ),
        is("branching", f.branching, "a hit may send on two rays", "a hit sends on one ray at most"),
    ]
}

fn search(packed: &Packed) -> SearchInfo {
    let (count, max) = (grouped(packed.found.primitives()), packed.brute_force_max);
    if packed.bvh_depth == 0 {
        return SearchInfo {
            kind: "brute force",
            nodes: 0,
            depth: 0,
            why: format!("{count} primitives; up to {max} every one is tested"),
        };
    }
    let outside = match packed.loose {
        [true, _] if packed.found.triangles > 0 => "; the few triangles are tested one by one",
        [_, true] if packed.found.spheres > 0 => "; the few spheres are tested one by one",
        _ => "",
    };
    let most = if packed.found.primitives() > max as u64 { "more than" } else { "switched on; not above" };
    SearchInfo {
        kind: "hierarchy",
        nodes: match packed.compressed_nodes.len() {
            0 => packed.nodes.len() as u64,
            packets => packets as u64,
        },
        depth: packed.bvh_depth as u64,
        why: format!("{count} primitives, {most} {max}{outside}"),
    }
}

fn planned(packed: &Packed, settings: &Settings, limits: &Limits, plan: &Plan) -> Planned {
    let [x0, y0, x1, y1] = settings.region();
    let tiles = crate::render::tiles([x0, y0, x1, y1], plan.tile_pixels).len() as u64;
    let per_tile = u64::from(settings.samples.div_ceil(plan.batch_samples.max(1)));
    let buffers: Vec<BufferRow> = abi::BUFFERS
        .iter()
        .zip(&plan.buffer_bytes)
        .filter(|((_, _, buffer), _)| *buffer != Buf::SelfTest)
        .map(|((name, element, _), &bytes)| BufferRow {
            name,
            elements: bytes / element_bytes(element, settings.precision),
            bytes,
        })
        .collect();
    let kernels = variant::kernels(plan, settings);
    let queue = [
        Buf::Rays,
        Buf::NextRays,
        Buf::Media,
        Buf::NextMedia,
        Buf::Hits,
        Buf::Surfaces,
        Buf::Places,
        Buf::Contributions,
    ];
    let in_queue: u64 = queue.iter().map(|b| plan.buffer_bytes[*b as usize]).sum();
    Planned {
        dispatches: kernels.iter().map(|k| k.launches).sum(),
        kernels,
        constants: variant::constants(plan),
        known_shapes: plan.specialisation.few_known != 0,
        known_shapes_why: known_shapes(packed, settings, limits, plan),
        texels: plan.specialisation.texels != 0,
        texels_why: texels(settings, limits, plan).into(),
        capacity: plan.capacity,
        bytes_per_place: in_queue / u64::from(plan.capacity.max(1)),
        workgroup: plan.specialisation.workgroup,
        lights_per_pass: plan.lights_per_pass,
        tile_pixels: plan.tile_pixels,
        tiles,
        batch_samples: plan.batch_samples,
        batches: tiles * per_tile,
        buffers,
        bytes: plan.bytes(),
    }
}

fn known_shapes(packed: &Packed, settings: &Settings, limits: &Limits, plan: &Plan) -> String {
    let [x0, y0, x1, y1] = settings.region();
    let samples = u64::from(x1 - x0) * u64::from(y1 - y0) * u64::from(settings.samples);
    let (have, needed) = (grouped(samples), grouped(KNOWN_SAMPLES));
    if plan.specialisation.few_known != 0 {
        return format!("{have} samples, from {needed} on they repay kernels of their own for this scene");
    }
    if packed.found.primitives() > BRUTE_FORCE_MAX as u64 {
        "there are too many".into()
    } else if settings.precision == Precision::Double {
        "kernels in f64 have no such form".into()
    } else if !limits.is_cpu {
        "a GPU gains nothing by it".into()
    } else if samples < KNOWN_SAMPLES {
        format!("{have} samples, fewer than the {needed} that repay kernels of their own for this scene")
    } else {
        "switched off".into()
    }
}

fn texels(settings: &Settings, limits: &Limits, plan: &Plan) -> &'static str {
    if plan.specialisation.texels != 0 {
        "a software device gathers texels as one vector"
    } else if settings.precision == Precision::Double {
        "texels have no f64"
    } else if !limits.is_cpu {
        "a GPU gains nothing by them"
    } else {
        "switched off, or a buffer has more texels than a view can hold"
    }
}
