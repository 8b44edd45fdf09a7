//! The pass table: one row = one dispatch. Recording, barriers, the CPU twins, profile rows,
//! debug labels and `plan` all walk these tables. No render graph, no reordering.

use crate::kernel::abi::Buf;
use crate::kernel::table::{Kernel, mask};

/// How many items a pass works on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// One workgroup.
    One,
    /// Every sample of the batch (known to the host).
    Samples,
    /// Every pixel of the tile (known to the host).
    Pixels,
    /// Every live ray: indirect, from `queue`.
    Rays,
    /// Some of the live rays (known to the host, which asks the device how many there are).
    Walks,
}

/// When a pass runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// Once per batch (prologue, epilogue) or at every depth.
    Always,
    /// At every depth but the last, whose secondary rays are not traced.
    NotLast,
    /// Once for each group of lights.
    PerLights,
    /// Where several rays of one sample may share a depth: from depth 2 on.
    Branching,
}

/// The ways to do a depth ([`Plan::way`](super::Plan::way)).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// A part of all.
    Any,
    /// A kernel for each stage.
    Split,
    /// One kernel for the stages that work on a ray alone.
    Fused,
    /// As split, but walks take as many dispatches as they need: for batches in which one dispatch is not enough.
    Parts,
    /// Split or in parts.
    Stages,
}

/// One row of the pass table.
#[derive(Debug, Clone, Copy)]
pub struct Pass {
    /// What runs.
    pub kernel: Kernel,
    /// Buffers it loads from.
    pub reads: &'static [Buf],
    /// Buffers it stores to (a buffer in both lists is updated in place).
    pub writes: &'static [Buf],
    /// On how much.
    pub size: Size,
    /// When.
    pub when: When,
    /// In which way of doing a depth.
    pub way: Way,
}

impl Pass {
    /// Whether the pass runs where depths are done this way.
    pub fn is_of(&self, way: Way) -> bool {
        match self.way {
            Way::Any => true,
            Way::Stages => way != Way::Fused,
            own => own == way,
        }
    }
}

use Buf::*;

/// The buffers of the scene that closest hit and occlusion read.
macro_rules! shapes {
    ($($more:ident),*) => { &[Triangles, Spheres, ExtendedSpheres, Nodes, CompressedNodes, $($more),*] };
}

/// Once per batch, before the first depth.
pub const PROLOGUE: &[Pass] = &[Pass {
    kernel: Kernel::Generate,
    reads: &[Camera, EyeMedia, Pixels],
    writes: &[Rays, Media, Paths],
    size: Size::Samples,
    when: When::Always,
    way: Way::Any,
}];

/// Once per depth: the rows of one [`Way`] and those of both. `rays`, `media` and `queue` change places with their `next_` after each.
pub const PER_DEPTH: &[Pass] = &[
    Pass {
        kernel: Kernel::Intersect,
        reads: shapes![Rays, Queue, Paths, Counters],
        writes: &[Hits, Paths, Counters],
        size: Size::Rays,
        when: When::Always,
        way: Way::Split,
    },
    Pass {
        kernel: Kernel::Walk,
        reads: shapes![Camera, Materials, Lights, Rays, Queue, Surfaces, Hits, Walks, Paths, Counters],
        writes: &[Hits, Walks, Paths, Counters],
        size: Size::Walks,
        when: When::Always,
        way: Way::Parts,
    },
    Pass {
        kernel: Kernel::Shade,
        reads: &[
            Triangles,
            FlatNormals,
            CornerNormals,
            Spheres,
            ExtendedSpheres,
            Materials,
            SolidIors,
            SolidPriorities,
            Rays,
            Media,
            Queue,
            Hits,
            Paths,
        ],
        writes: &[Surfaces, ChildCounts, Paths],
        size: Size::Rays,
        when: When::Always,
        way: Way::Stages,
    },
    Pass {
        kernel: Kernel::FusedDepth,
        reads: &[
            Triangles,
            Spheres,
            ExtendedSpheres,
            CompressedNodes,
            Camera,
            FlatNormals,
            CornerNormals,
            Materials,
            Lights,
            SolidIors,
            SolidPriorities,
            Rays,
            Media,
            Queue,
            RayIndices,
            Contributions,
            SampleRadiance,
            Paths,
            DepthCounts,
            Counters,
        ],
        writes: &[
            NextRays,
            NextMedia,
            ChildMasks,
            Contributions,
            SampleRadiance,
            Paths,
            DepthCounts,
            Counters,
        ],
        size: Size::Rays,
        when: When::Always,
        way: Way::Fused,
    },
    Pass {
        kernel: Kernel::Scan,
        reads: &[Queue, ChildCounts, ChildMasks, DepthCounts, Counters],
        writes: &[Offsets, NextQueue, DepthCounts, Counters],
        size: Size::One,
        when: When::NotLast,
        way: Way::Any,
    },
    Pass {
        kernel: Kernel::Spawn,
        reads: &[Camera, Materials, Rays, Media, Queue, NextQueue, Surfaces, Offsets, Counters],
        writes: &[NextRays, NextMedia, Counters],
        size: Size::Rays,
        when: When::NotLast,
        way: Way::Stages,
    },
    Pass {
        kernel: Kernel::Place,
        reads: &[Queue, NextQueue, ChildMasks, Offsets],
        writes: &[RayIndices],
        size: Size::Rays,
        when: When::NotLast,
        way: Way::Fused,
    },
    Pass {
        kernel: Kernel::Shadow,
        reads: shapes![
            Camera,
            Materials,
            Lights,
            Rays,
            Queue,
            Surfaces,
            Contributions,
            SampleRadiance,
            Paths,
            DepthCounts,
            Counters
        ],
        writes: &[Contributions, SampleRadiance, Paths, DepthCounts, Counters],
        size: Size::Rays,
        when: When::PerLights,
        way: Way::Split,
    },
    Pass {
        kernel: Kernel::Light,
        reads: &[
            Camera,
            Triangles,
            Spheres,
            Materials,
            Lights,
            Rays,
            Queue,
            Hits,
            Surfaces,
            Contributions,
            SampleRadiance,
            Paths,
            DepthCounts,
            Counters,
        ],
        writes: &[Contributions, SampleRadiance, Paths, DepthCounts, Counters],
        size: Size::Rays,
        when: When::PerLights,
        way: Way::Parts,
    },
    Pass {
        kernel: Kernel::Gather,
        reads: &[Queue, Contributions, SampleRadiance, Counters],
        writes: &[SampleRadiance, Counters],
        size: Size::Rays,
        when: When::Branching,
        way: Way::Any,
    },
];

/// Once per batch, after the last depth.
pub const EPILOGUE: &[Pass] = &[Pass {
    kernel: Kernel::Resolve,
    reads: &[SampleRadiance, Paths, Film, Marks],
    writes: &[Film, Marks],
    size: Size::Pixels,
    when: When::Always,
    way: Way::Any,
}];

/// Once per device, apart from any batch.
pub const SELF_TEST: &[Pass] = &[Pass {
    kernel: Kernel::SelfTest,
    reads: &[],
    writes: &[SelfTest],
    size: Size::Pixels,
    when: When::Always,
    way: Way::Any,
}];

// The tables say what the compiled kernels do, or the build fails.
const fn agrees(passes: &[Pass]) -> bool {
    let mut i = 0;
    while i < passes.len() {
        let code = &crate::kernel::table::KERNELS[passes[i].kernel as usize];
        if mask(passes[i].reads) != code.reads || mask(passes[i].writes) != code.writes {
            return false;
        }
        i += 1;
    }
    true
}
const _: () = assert!(agrees(PROLOGUE), "PROLOGUE differs from its kernels' buffer accesses");
const _: () = assert!(agrees(PER_DEPTH), "PER_DEPTH differs from its kernels' buffer accesses");
const _: () = assert!(agrees(EPILOGUE), "EPILOGUE differs from its kernels' buffer accesses");

const _: () = assert!(agrees(SELF_TEST), "SELF_TEST differs from its kernel's buffer accesses");

/// The buffer a depth sees under a name: odd depths (from 1) see them as named, even depths with
/// each queue and its next exchanged.
pub fn at_depth(buffer: Buf, depth: u32) -> Buf {
    if depth % 2 == 1 {
        return buffer;
    }
    match buffer {
        Rays => NextRays,
        NextRays => Rays,
        Media => NextMedia,
        NextMedia => Media,
        Queue => NextQueue,
        NextQueue => Queue,
        other => other,
    }
}

/// The row that searches for hits in parts.
pub fn walk() -> &'static Pass {
    PER_DEPTH.iter().find(|p| p.kernel == Kernel::Walk).unwrap_or(&PER_DEPTH[0])
}

/// All rows of the pass table, in order.
pub fn all() -> impl Iterator<Item = &'static Pass> {
    PROLOGUE.iter().chain(PER_DEPTH).chain(EPILOGUE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kernel_is_a_pass() {
        for code in &crate::kernel::table::KERNELS {
            assert!(
                all().chain(SELF_TEST).any(|p| p.kernel.name() == code.name),
                "{} is in no table",
                code.name
            );
        }
    }

    #[test]
    fn a_wrong_row_is_caught() {
        let honest = PER_DEPTH[0];
        assert!(!agrees(&[Pass { writes: &[Hits], ..honest }]), "a missing write passes");
        assert!(!agrees(&[Pass { kernel: Kernel::Gather, ..honest }]), "a wrong kernel passes");
    }
}
