use super::*;
use crate::kernel::abi::{self, Buf, double};
use crate::kernel::table::KERNELS;
use crate::prepare::bvh::Forms;
use crate::prepare::{pack, pack_forms};
use crate::scene::procedural::shapes::{cuboid, empty, glass};
use crate::scene::{Fresnel, Scene};
use crate::settings::forced_features::Feature;
use bytemuck::zeroed_vec;
use glam::DVec3;

/// The least storage range that Vulkan promises, as some phones have it, and a quarter of a gigabyte.
const SMALL: Limits = Limits {
    storage_range: 1 << 27,
    heap: 1 << 28,
    workgroup_invocations: 128,
    texel_elements: 1 << 16,
    shuffle_lanes: 32,
    storage_buffers: 16,
    driver: Driver::Gpu,
};

fn scene() -> Scene {
    let mut scene = empty(vec![glass(1.5, Fresnel::Exact)]);
    scene.meshes = vec![cuboid(DVec3::ZERO, DVec3::ONE, 0)];
    scene
}

/// A mesh of so many triangles with a hierarchy; its memory is never touched, and so never there.
fn mesh(triangles: usize) -> Packed {
    let mut packed = pack(&scene(), &Settings::of(&scene()), 0);
    packed.triangles = zeroed_vec::<double::Triangle>(triangles);
    packed.flat_normals = zeroed_vec::<double::FlatNormal>(triangles);
    // As many as a mesh of 1,1 million has, in proportion.
    packed.nodes = zeroed_vec::<double::Node>(triangles / 4);
    packed.compressed_nodes = zeroed_vec(triangles / 7);
    packed
}

fn check(plan: &Plan, limits: &Limits) {
    assert!(plan.bytes() <= limits.heap / 4 * 3, "{}", plan.bytes());
    for ((name, _, buffer), bytes) in abi::BUFFERS.iter().zip(&plan.buffer_bytes) {
        // What goes beyond the range is read as texels, and is no longer than those reach.
        let as_texels = plan.specialisation.texels == 1
            && KERNELS.iter().all(|k| {
                let bit = 1 << *buffer as u32;
                k.writes & bit == 0 && (k.reads & bit == 0 || k.texels & bit != 0)
            })
            && bytes / TEXEL_BYTES <= u64::from(limits.texel_elements);
        assert!(*bytes <= limits.storage_range || as_texels, "{name}: {bytes}");
    }
}

#[test]
fn what_is_too_large_is_refused_with_what_fits() {
    for limits in [Limits::LAVAPIPE, SMALL] {
        let settings = Settings::of(&scene());
        let plan = |triangles: usize| Plan::new(&mesh(triangles), &settings, &limits);
        check(&plan(500_000).unwrap(), &limits);
        for triangles in [30_000_000, 100_000_000] {
            let message = plan(triangles).unwrap_err().to_string();
            let (_, tail) = message.split_once("about ").expect("a number that fits");
            let fit: usize = tail.split(' ').next().and_then(|n| n.parse().ok()).expect("a number");
            check(&plan(fit).unwrap_or_else(|e| panic!("{fit} should fit: {e}")), &limits);
            assert!(plan(fit + fit / 50).is_err(), "more than {fit} fit");
        }
    }
}

/// Where only texels are read, a buffer may pass the storage range.
#[test]
fn texels_reach_further_than_storage() {
    let mut packed = mesh(1000);
    // 134 MB of nodes alone, in either form.
    packed.nodes = zeroed_vec(1_300_000);
    packed.compressed_nodes = zeroed_vec(1_100_000);
    let settings = Settings::of(&scene());
    let plan = Plan::new(&packed, &settings, &Limits::LAVAPIPE).unwrap();
    assert!(plan.buffer_bytes[Buf::CompressedNodes as usize] > Limits::LAVAPIPE.storage_range);
    check(&plan, &Limits::LAVAPIPE);
    let without = Limits { driver: Driver::Gpu, ..Limits::LAVAPIPE };
    let message = Plan::new(&packed, &settings, &without).unwrap_err().to_string();
    assert!(message.contains("for `nodes`"), "{message}");
}

#[test]
fn large_images_and_deep_paths_are_cut_to_size() {
    for limits in [Limits::LAVAPIPE, SMALL] {
        for (side, samples, depth) in [(8192, 64, 4), (8192, 1, 64), (300, 1024, 64), (65_535, 1 << 24, 1024)]
        {
            let settings = Settings { width: side, height: side, samples, depth, ..Settings::of(&scene()) };
            let packed = pack_for(&scene(), &settings, &limits);
            let plan = Plan::new(&packed, &settings, &limits).unwrap();
            check(&plan, &limits);
            assert!(plan.specialisation.branching == 1);
            assert!(u64::from(plan.capacity) >= u64::from(plan.tile_pixels) * u64::from(plan.batch_samples));
        }
    }
}

/// Tests are counted where that is asked for, and nowhere else: the kernels that count are others.
#[test]
fn nothing_counts_unasked() {
    let scene = scene();
    for samples in [1, 1 << 20] {
        for survey in [false, true] {
            let of = |count_tests: bool| {
                let mut settings = Settings { samples, ..Settings::of(&scene) };
                settings.schedule.count_tests = count_tests;
                let packed = pack_for(&scene, &settings, &Limits::LAVAPIPE);
                let input = Input { packed: &packed, settings: &settings, limits: &Limits::LAVAPIPE, survey };
                Plan::build(input).unwrap()
            };
            let (plain, counting) = (of(false), of(true));
            assert_eq!((plain.specialisation.counting, counting.specialisation.counting), (0, 1));
            let words = |plan: &Plan| plan.buffer_bytes[Buf::Counters as usize] / 4;
            assert_eq!(words(&plain), u64::from(abi::COUNTERS));
            let depth = u64::from(scene.render.depth);
            assert_eq!(words(&counting) - words(&plain), depth * u64::from(abi::RAY_KINDS * abi::TEST_WORDS));
            // Nothing else differs.
            let mut same = counting;
            same.specialisation.counting = 0;
            let counters = Buf::Counters as usize;
            same.buffer_bytes[counters] = plain.buffer_bytes[counters];
            same.bytes_in_parts[counters] = plain.bytes_in_parts[counters];
            assert_eq!(same, plain);
        }
    }
}

/// A plan holds one form of nodes alone, and what it asks `pack` for is what it then needs.
#[test]
fn one_form_of_nodes_is_held() {
    let settings = Settings::of(&scene());
    let gpu = Limits { driver: Driver::Gpu, ..Limits::LAVAPIPE };
    let mut lone = settings.clone();
    lone.schedule.forced_features = lone.schedule.forced_features.with(Feature::LoneRays);
    let mut odd = settings.clone();
    odd.schedule.workgroup = Some(12);
    // Fewer texels than a storage binding may have: nodes must be there for the case that they do not reach.
    let short = Limits { texel_elements: 1 << 22, ..Limits::LAVAPIPE };
    let cases = [
        (&settings, Limits::LAVAPIPE, Forms::Compressed, true),
        (&settings, gpu, Forms::Nodes, false),
        (&lone, Limits::LAVAPIPE, Forms::Nodes, false),
        (&odd, Limits::LAVAPIPE, Forms::Nodes, false),
        (&settings, short, Forms::Both, true),
        (&settings, Limits { texel_elements: 1 << 10, ..Limits::LAVAPIPE }, Forms::Both, false),
    ];
    for (settings, limits, forms, packets) in cases {
        assert_eq!(limits.forms(settings), forms, "{limits:?}");
        let plan = |packed: &Packed| Plan::new(packed, settings, &limits).unwrap();
        let alone = pack_forms(&scene(), settings, 0, forms);
        let both = plan(&pack(&scene(), settings, 0));
        assert_eq!(plan(&alone), both, "{limits:?}");
        assert_eq!(both.specialisation.lanes != 0, packets, "{limits:?}");
        let bytes = |buffer: Buf| both.buffer_bytes[buffer as usize];
        let unused = if packets { Buf::Nodes } else { Buf::CompressedNodes };
        assert_eq!(bytes(unused), element_bytes(abi::BUFFERS[unused as usize].1, settings.precision));
    }
}
