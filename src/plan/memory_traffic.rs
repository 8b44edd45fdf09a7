//! Bytes that the passes move per item, from the pass table and the structs of `abi`.
//!
//! Counted are the buffers that hold one element per ray, sample or pixel: whole structs, each listed
//! read and each listed write once per item. That is an upper bound, since an item may leave a pass
//! early (a ray that missed has no children). Not counted: the scene, whose reads depend on the
//! hierarchy's walk, counters, the words per workgroup, and what caches save.

use crate::kernel::abi::{BUFFERS, Buf};
use crate::kernel::table::Kernel;
use crate::plan::passes::{Pass, Size};
use crate::plan::{Plan, element_bytes};
use crate::settings::Precision;

/// Bytes of one pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traffic {
    /// Per item and dispatch.
    pub per_item: u64,
    /// Per ray that goes on to the next depth.
    pub per_child: u64,
    /// Per sample of the batch; of passes that work on pixels.
    pub per_sample: u64,
}

impl Traffic {
    /// Bytes of so many items, of their `children` and of the `samples` they stand for.
    pub fn bytes(self, items: u64, children: u64, samples: u64) -> u64 {
        self.per_item * items + self.per_child * children + self.per_sample * samples
    }
}

/// What an element of a buffer belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Ray,
    Child,
    Sample,
    Pixel,
    /// The scene, counters, words per workgroup.
    Shared,
}

fn place(buffer: Buf) -> Place {
    match buffer {
        Buf::Rays | Buf::Media | Buf::Hits | Buf::Surfaces | Buf::RayIndices | Buf::Contributions => {
            Place::Ray
        }
        Buf::NextRays | Buf::NextMedia => Place::Child,
        Buf::SampleRadiance | Buf::Paths => Place::Sample,
        Buf::Film | Buf::Marks | Buf::Pixels => Place::Pixel,
        _ => Place::Shared,
    }
}

/// Bytes that a pass of this plan moves.
pub fn of(pass: &Pass, plan: &Plan, precision: Precision) -> Traffic {
    let mut traffic = Traffic::default();
    for buffer in pass.reads.iter().chain(pass.writes) {
        let bytes = element(*buffer, plan, precision) * u64::from(moved(pass, *buffer, plan));
        let place = match (pass.kernel, buffer) {
            (Kernel::Place, Buf::RayIndices) => Place::Child,
            _ => place(*buffer),
        };
        match (place, pass.size) {
            (Place::Shared, _) | (_, Size::One) => {}
            (Place::Child, _) => traffic.per_child += bytes,
            (Place::Sample, Size::Pixels) => traffic.per_sample += bytes,
            _ => traffic.per_item += bytes,
        }
    }
    traffic
}

/// Bytes of a buffer's element; a ray's list of solids is as long as the plan says.
fn element(buffer: Buf, plan: &Plan, precision: Precision) -> u64 {
    let bytes = element_bytes(BUFFERS[buffer as usize].1, precision);
    match buffer {
        Buf::Media | Buf::NextMedia => bytes * u64::from(plan.specialisation.media_capacity),
        Buf::Film => bytes * u64::from(plan.specialisation.film_sums()),
        _ => bytes,
    }
}

/// Whether this variant of the kernel touches the buffer: `shadow` leaves a ray's colour in
/// `contributions` for `gather` where rays branch or for its next pass over other lights, else it adds
/// to `sample_radiance` itself.
fn moved(pass: &Pass, buffer: Buf, plan: &Plan) -> bool {
    let branching = plan.specialisation.branching != 0;
    let groups = plan.specialisation.light_count.max(1).div_ceil(plan.lights_per_pass.max(1));
    match (pass.kernel, buffer) {
        // Only the tests of a survey go there.
        (Kernel::Intersect, Buf::Paths) => {
            plan.specialisation.survey != 0 && plan.specialisation.counting != 0
        }
        (_, Buf::Paths | Buf::Marks | Buf::Pixels) => plan.specialisation.survey != 0,
        (Kernel::Shadow | Kernel::FusedDepth, Buf::SampleRadiance) => !branching,
        (Kernel::Shadow, Buf::Contributions) => branching || groups > 1,
        (Kernel::FusedDepth, Buf::Contributions) => branching,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::abi::single::{Film, Hit, Ray, Surface};
    use crate::plan::passes;
    use crate::plan::{Limits, pack_for};
    use crate::scene::Scene;
    use crate::settings::Settings;
    use std::path::Path;

    /// A plan of `size` samples for each of 512 times `size` pixels.
    fn plan(name: &str, size: u32) -> Plan {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
        let scene = Scene::load(&path).unwrap();
        let mut settings = Settings::of(&scene);
        settings.samples = size;
        (settings.width, settings.height) = (64, 8 * size);
        let limits = Limits {
            storage_range: 1 << 30,
            heap: 1 << 33,
            workgroup_invocations: 1024,
            driver: crate::plan::Driver::Gpu,
            texel_elements: 1 << 27,
            shuffle_lanes: 8,
            storage_buffers: 16,
        };
        Plan::new(&pack_for(&scene, &settings, &limits), &settings, &limits).unwrap()
    }

    fn row(kernel: Kernel, name: &str, precision: Precision) -> Traffic {
        of(passes::all().find(|p| p.kernel == kernel).unwrap(), &plan(name, 1), precision)
    }

    #[test]
    fn bytes_are_those_of_the_structs() {
        let single = |kernel| row(kernel, "cornell.toml", Precision::Robust);
        let (ray, hit) = (size_of::<Ray>() as u64, size_of::<Hit>() as u64);
        let (surface, film, slot) = (size_of::<Surface>() as u64, size_of::<Film>() as u64, 12);
        assert_eq!(single(Kernel::Intersect).per_item, ray + hit);
        assert_eq!(single(Kernel::Shade).per_item, ray + hit + surface);
        let spawn = single(Kernel::Spawn);
        assert_eq!((spawn.per_item, spawn.per_child), (ray + surface, ray));
        // A room of mirrors has one ray a sample: `shadow` adds to the slot, which it reads and writes.
        assert_eq!(single(Kernel::Shadow).per_item, ray + surface + 2 * slot);
        let resolve = single(Kernel::Resolve);
        assert_eq!((resolve.per_item, resolve.per_sample), (2 * film, slot));
        assert_eq!(single(Kernel::Scan), Traffic::default());
        // In f64 the same structs are larger.
        let double = row(Kernel::Intersect, "cornell.toml", Precision::Double).per_item;
        assert_eq!(
            double,
            (size_of::<crate::kernel::abi::double::Ray>() + size_of::<crate::kernel::abi::double::Hit>())
                as u64
        );
    }

    #[test]
    fn glass_costs_its_lists_and_contributions() {
        let solids = u64::from(plan("cornell_glass.toml", 1).specialisation.media_capacity);
        assert!(solids > 0);
        let glass = |kernel| row(kernel, "cornell_glass.toml", Precision::Robust);
        let plain = |kernel| row(kernel, "cornell.toml", Precision::Robust);
        assert_eq!(glass(Kernel::Shade).per_item - plain(Kernel::Shade).per_item, 4 * solids);
        assert_eq!(glass(Kernel::Spawn).per_child - plain(Kernel::Spawn).per_child, 4 * solids);
        // Contributions instead of sample_radiance, read and written: they say besides whose they are.
        assert_eq!(glass(Kernel::Shadow).per_item, plain(Kernel::Shadow).per_item + 2 * 4);
    }

    /// A buffer that grows with the samples of a batch or the pixels of a tile has elements per ray, sample or pixel.
    #[test]
    fn no_buffer_per_ray_is_forgotten() {
        for scene in ["cornell.toml", "cornell_glass.toml"] {
            let (small, large) = (plan(scene, 8), plan(scene, 64));
            for (name, _, buffer) in BUFFERS {
                let [before, after] = [&small, &large].map(|p| p.buffer_bytes[*buffer as usize]);
                let grows = after >= 4 * before
                    && !matches!(buffer, Buf::ChildCounts | Buf::ChildMasks | Buf::Offsets);
                assert!(!grows || place(*buffer) != Place::Shared, "{name} is counted nowhere");
            }
        }
    }
}
