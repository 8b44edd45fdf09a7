//! Every scene under the validation layer with synchronisation validation: it says nothing; and it
//! does say something when a barrier is missing.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

use common::{render, scenes, small};
use whitted::kernel::abi::Buf;
use whitted::kernel::table::Kernel;
use whitted::render::Renderer;
use whitted::settings::forced_features::{Feature, ForcedFeatures};
use whitted::settings::{DeviceChoice, Schedule, Settings};

fn validated() -> Renderer {
    Renderer::with_validation(&DeviceChoice::Cpu)
        .unwrap_or_else(|e| panic!("these tests need the validation layer: {e}"))
}

#[test]
fn every_scene_is_valid() {
    let mut renderer = validated();
    for (name, scene) in scenes() {
        for fused in [None, Some(true)] {
            let schedule =
                Schedule { tile_pixels: Some(120), batch_samples: Some(1), fused, ..Schedule::default() };
            let settings = Settings { schedule, ..small(&scene, 20, 2, 0) };
            render(&mut renderer, &scene, &settings);
            let messages = renderer.validation_messages();
            assert!(messages.is_empty(), "{name}: {}", messages.join("\n"));
        }
    }
}

#[test]
fn a_missing_barrier_is_reported() {
    let (_, scene) = scenes().into_iter().find(|(name, _)| name == "nested_glass").unwrap();
    let forced_features = ForcedFeatures::default().with(Feature::SplitKernels);
    let split = Schedule { forced_features, ..Schedule::default() };
    let fused = Schedule { fused: Some(true), ..Schedule::default() };
    // Each with the buffer that the pass after it reads too early. Not `spawn`: what it writes is read
    // a depth later, behind other barriers; and `resolve` is followed by the next batch alone.
    for (kernel, buffer, schedule) in [
        (Kernel::Generate, Buf::Rays, &split),
        (Kernel::Intersect, Buf::Hits, &split),
        (Kernel::Shade, Buf::ChildCounts, &split),
        (Kernel::Scan, Buf::Counters, &split),
        (Kernel::Shadow, Buf::Contributions, &split),
        (Kernel::Gather, Buf::SampleRadiance, &split),
        (Kernel::FusedDepth, Buf::ChildMasks, &fused),
        (Kernel::Place, Buf::RayIndices, &fused),
    ] {
        let mut renderer = validated();
        renderer.omit_barrier_after(kernel);
        let settings = Settings { schedule: *schedule, ..small(&scene, 8, 1, 0) };
        render(&mut renderer, &scene, &settings);
        let messages = renderer.validation_messages();
        let binding = format!("binding #{} ", buffer as u32);
        // Other messages are about the marker of the last pass, which has the same barrier.
        let told = messages.iter().any(|m| m.contains("READ_AFTER_WRITE") && m.contains(&binding));
        assert!(told, "no barrier after {}, no word of {buffer:?}:\n{}", kernel.name(), messages.join("\n"));
    }
}
