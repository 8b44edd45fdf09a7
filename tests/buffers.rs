//! Writes from the host to device buffers: they arrive whole, or they are an error.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

use whitted::kernel::abi::{BUFFERS, Buf, Specialisation};
use whitted::kernel::table::KernelSet;
use whitted::vk::{Buffers, Made, Pipelines, Recorder, VkError};

/// The longest that one vkCmdUpdateBuffer takes is 16,384 words.
const WORDS: usize = 40_000;

/// A recorder without kernels, and buffers of `WORDS` words each.
fn recorder() -> (Recorder, Buffers) {
    let device = common::device();
    let spec = Specialisation::default();
    let pipelines = Pipelines::new(&device, KernelSet::SHIPPED, std::iter::empty(), &spec, false).unwrap();
    let buffers = Buffers::new(&device, &[4 * WORDS as u64; BUFFERS.len()], 0).unwrap();
    (Recorder::new(&device, &pipelines, &buffers, spec.workgroup).unwrap(), buffers)
}

#[test]
fn an_update_of_any_length_arrives_whole() {
    let (mut recorder, mut buffers) = recorder();
    for count in [1, 16_384, 16_385, WORDS] {
        let words: Vec<u32> = (1..=count as u32).collect();
        recorder.begin().unwrap();
        recorder.fill(&buffers, Buf::SampleRadiance, u32::MAX);
        recorder.update(&buffers, Buf::SampleRadiance, &words).unwrap();
        recorder.submit(&buffers).unwrap();
        let found = recorder.read(&mut buffers, Buf::SampleRadiance).unwrap();
        let found: Vec<u32> = bytemuck::pod_collect_to_vec(&found);
        assert!(found[..count] == words[..], "{count}");
        assert!(found[count..].iter().all(|w| *w == u32::MAX), "{count}");
    }
}

#[test]
fn a_write_beyond_the_end_is_an_error() {
    let (mut recorder, mut buffers) = recorder();
    let words = vec![0u32; WORDS + 1];
    recorder.begin().unwrap();
    let written = [
        recorder.update(&buffers, Buf::SampleRadiance, &words),
        recorder.upload(&mut buffers, Buf::SampleRadiance, bytemuck::cast_slice(&words)),
        recorder.upload_made(
            &mut buffers,
            Buf::SampleRadiance,
            Made { bytes: 4 * words.len(), element: 4 },
            &|_, _| {},
        ),
    ];
    assert!(written.iter().all(|w| matches!(w, Err(VkError::TooLong { .. }))), "{written:?}");
}
