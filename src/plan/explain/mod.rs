//! Fills the explained plan (`report::explain`) from a prepared scene and its plan.

mod variant;

pub(crate) use variant::form;

use super::host_memory::{HostWork, LARGEST_FILE, needed};
use super::tiles::tiles;
use super::{HEAP_EIGHTHS, Limits, Plan, element_bytes};
use crate::host::memory;
use crate::kernel::abi::{self, Buf};
use crate::prepare::Packed;
use crate::report::explain::{
    BufferRow, ExplainedPlan, FeatureRow, HostInfo, LimitInfo, MaxDepthInfo, Planned, SearchInfo,
};
use crate::report::{DeviceInfo, LocalFrameInfo, ProgramInfo, SettingsInfo};
use crate::settings::{Precision, Settings};
use crate::units::{grouped, plural};

/// Explains `plan`, or what is known of a scene that has none on this device.
pub fn explain(
    scene: &str,
    device: &DeviceInfo,
    packed: &Packed,
    settings: &Settings,
    limits: &Limits,
    plan: Option<&Plan>,
) -> ExplainedPlan {
    let max_depth = &packed.max_depth;
    ExplainedPlan {
        program: ProgramInfo::default(),
        device: device.clone(),
        scene: scene.into(),
        settings: SettingsInfo::of(settings),
        scene_features: packed.scene_features,
        features: features(packed),
        local_frame: LocalFrameInfo {
            center: packed.local_frame.center.to_array(),
            scale_log2: packed.local_frame.scale_log2,
        },
        max_depth: MaxDepthInfo {
            asked: settings.depth,
            last: max_depth.last_depth(settings.depth, settings.cutoff),
            weight: max_depth.weight,
            why: max_depth.words(settings.depth, settings.cutoff),
        },
        search: search(packed),
        plan: plan.map(|p| planned(settings, limits, p)),
        limits: LimitInfo {
            one_buffer: limits.storage_range,
            heap: limits.heap,
            heap_share: limits.heap / 8 * HEAP_EIGHTHS,
        },
        host: HostInfo {
            image: needed(settings.region(), HostWork::Image, LARGEST_FILE),
            bounded: needed(settings.region(), HostWork::Bounded, LARGEST_FILE),
            free: memory::free(),
        },
        time: None,
        refused: None,
        error: None,
    }
}

fn features(packed: &Packed) -> Vec<FeatureRow> {
    let f = &packed.scene_features;
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
            f.extended_spheres > 0,
            match f.extended_spheres {
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
                n => format!(
                    "a ray can be inside {} at once, judged by bounding boxes",
                    plural(n.into(), "solid")
                ),
            },
        ),
        is("branching", f.branching, "a hit can spawn two rays", "a hit spawns at most one ray"),
    ]
}

fn search(packed: &Packed) -> SearchInfo {
    let (count, max) = (grouped(packed.scene_features.primitives()), packed.brute_force_max);
    if packed.bvh_depth == 0 {
        return SearchInfo {
            kind: "brute force",
            nodes: 0,
            depth: 0,
            why: format!("{count} primitives; up to {max}, testing all is faster"),
        };
    }
    let outside = match packed.outside {
        [true, _] if packed.scene_features.triangles > 0 => "; the few triangles are tested outside it",
        [_, true] if packed.scene_features.spheres > 0 => "; the few spheres are tested outside it",
        _ => "",
    };
    let most = if packed.scene_features.primitives() > max as u64 {
        "more than"
    } else {
        "forced although not more than"
    };
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

fn planned(settings: &Settings, limits: &Limits, plan: &Plan) -> Planned {
    let [x0, y0, x1, y1] = settings.region();
    let tiles = tiles([x0, y0, x1, y1], plan.tile_pixels).len() as u64;
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
        Buf::RayIndices,
        Buf::Contributions,
    ];
    let in_queue: u64 = queue.iter().map(|b| plan.buffer_bytes[*b as usize]).sum();
    Planned {
        dispatches: kernels.iter().map(|k| k.launches).sum(),
        kernels,
        constants: variant::constants(plan),
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

fn texels(settings: &Settings, limits: &Limits, plan: &Plan) -> &'static str {
    if plan.specialisation.texels != 0 {
        "lavapipe loads a texel as one vector"
    } else if settings.precision == Precision::Double {
        "there is no f64 texel format"
    } else if !limits.driver.gathers_texels() {
        "not faster on this driver"
    } else {
        "switched off, or a buffer exceeds the limit on texels per view"
    }
}
