//! The plan of a render: features found in the scene, kernels and memory that follow from them, and the
//! predicted time. For people and as JSON.

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

/// Everything known before a render runs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Outline {
    /// Version of the program.
    pub program: ProgramInfo,
    /// Device planned for.
    pub device: DeviceInfo,
    /// Path as given.
    pub scene: String,
    /// The settings in force.
    pub settings: SettingsInfo,
    /// Features of the scene.
    pub found: Found,
    /// The same in words, one row per feature, absent ones included.
    pub features: Vec<FeatureRow>,
    /// Centre and power-of-two scale of the kernels' coordinates.
    pub local_frame: LocalFrameInfo,
    /// Greatest depth of a ray.
    pub reach: ReachInfo,
    /// How the closest hit is found.
    pub search: SearchInfo,
    /// Kernels, sizes and buffers; null if the device cannot hold them.
    pub plan: Option<Planned>,
    /// Memory limits that the plan keeps.
    pub limits: LimitInfo,
    /// Predicted time; null if not asked for, or if there is no plan.
    pub time: Option<Prediction>,
    /// Why there is no plan.
    pub refused: Option<Refused>,
}

/// A feature of scenes, present or absent.
#[derive(Debug, Clone, Serialize)]
pub struct FeatureRow {
    /// Its name.
    pub name: &'static str,
    /// True if the scene has it and the kernels are compiled for it.
    pub found: bool,
    /// How many, or why it is absent.
    pub detail: String,
}

/// Greatest depth of a ray.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ReachInfo {
    /// Depth asked for.
    pub asked: u32,
    /// Depth of the last passes.
    pub last: u32,
    /// Greatest factor by which a surface multiplies a ray's throughput, 0 to 1.
    pub weight: f64,
    /// Reason for `last`.
    pub why: String,
}

/// How the closest hit is found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SearchInfo {
    /// `brute force` or `hierarchy`.
    pub kind: &'static str,
    /// Nodes of the hierarchy; 0 for brute force.
    pub nodes: u64,
    /// Levels of the hierarchy; 0 for brute force.
    pub depth: u64,
    /// Reason for `kind`.
    pub why: String,
}

/// Kernels, sizes and buffers of a render.
#[derive(Debug, Clone, Serialize)]
pub struct Planned {
    /// Kernels in the order of their first dispatch.
    pub kernels: Vec<KernelRow>,
    /// Specialisation constants that remove or add code.
    pub constants: Vec<Constant>,
    /// True if shapes are compiled into the kernels as constants.
    pub known_shapes: bool,
    /// Reason for `known_shapes`.
    pub known_shapes_why: String,
    /// True if kernels read the scene through texel views.
    pub texels: bool,
    /// Reason for `texels`.
    pub texels_why: String,
    /// Rays that fit a queue.
    pub capacity: u32,
    /// Device bytes per ray in a queue, over all buffers of the queue.
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
    /// Sum over all buffers.
    pub bytes: u64,
}

/// A buffer of the plan.
#[derive(Debug, Clone, Serialize)]
pub struct BufferRow {
    /// Its name in the kernels.
    pub name: &'static str,
    /// Length in elements.
    pub elements: u64,
    /// Length in bytes.
    pub bytes: u64,
}

/// Limits of the device.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LimitInfo {
    /// Bytes that one binding can hold.
    pub one_buffer: u64,
    /// Bytes of its heap.
    pub heap: u64,
    /// Bytes of the heap that a plan may use.
    pub heap_share: u64,
}

/// A plan that the device cannot hold.
#[derive(Debug, Clone, Serialize)]
pub struct Refused {
    /// The limit that is exceeded, and what would fit.
    pub message: String,
    /// Exit code of the render.
    pub exit_code: u8,
}

impl Outline {
    /// Describes `plan`; with `None`, everything that is known without a plan.
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
        is("smooth normals", f.smooth_normals, "some vertices have normals", "all triangles are flat-shaded"),
        count("spheres", f.spheres, "sphere"),
        row(
            "wide spheres",
            f.wide_spheres > 0,
            match f.wide_spheres {
                0 => "every sphere fits single precision".into(),
                n => format!("{} too large or too small for single precision", plural(n, "sphere")),
            },
        ),
        count("lights", f.lights, "light"),
        is("mirrors", f.mirrors, "some surfaces reflect", "no surface reflects"),
        row(
            "refraction",
            f.solids > 0,
            match f.solids {
                0 => "no refracting solid".into(),
                n => plural(n, "refracting solid"),
            },
        ),
        row(
            "nested media",
            f.solids_at_once > 1,
            match f.solids_at_once {
                0 => "no ray is inside a solid".into(),
                n => format!("a ray can be inside {} at once, judged by bounding boxes", plural(n.into(), "solid")),
            },
        ),
        is("branching", f.branching, "a hit can spawn two rays", "a hit spawns at most one ray"),
    ]
}

fn search(packed: &Packed) -> SearchInfo {
    let (count, max) = (grouped(packed.found.primitives()), packed.brute_force_max);
    if packed.bvh_depth == 0 {
        return SearchInfo {
            kind: "brute force",
            nodes: 0,
            depth: 0,
            why: format!("{count} primitives; up to {max}, testing all is faster"),
        };
    }
    let outside = match packed.loose {
        [true, _] if packed.found.triangles > 0 => "; the few triangles are tested outside it",
        [_, true] if packed.found.spheres > 0 => "; the few spheres are tested outside it",
        _ => "",
    };
    let most = if packed.found.primitives() > max as u64 { "more than" } else { "forced although not more than" };
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
        return format!("{have} samples; compiling kernels for this scene pays off from {needed} on");
    }
    if packed.found.primitives() > BRUTE_FORCE_MAX as u64 {
        "there are too many".into()
    } else if settings.precision == Precision::Double {
        "not available in f64".into()
    } else if !limits.is_cpu {
        "not faster on a GPU".into()
    } else if samples < KNOWN_SAMPLES {
        format!("{have} samples; compiling kernels for this scene pays off from {needed} on")
    } else {
        "switched off".into()
    }
}

fn texels(settings: &Settings, limits: &Limits, plan: &Plan) -> &'static str {
    if plan.specialisation.texels != 0 {
        "a CPU driver loads a texel as one vector"
    } else if settings.precision == Precision::Double {
        "there is no f64 texel format"
    } else if !limits.is_cpu {
        "not faster on a GPU"
    } else {
        "switched off, or a buffer exceeds the limit on texels per view"
    }
}
