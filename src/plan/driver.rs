//! What is known of a driver, from measurements: which forms of the kernels are fast on it.

/// A Vulkan driver by what was measured on it. Two drivers that run on the processor have little in common: a form that one
/// compiles to vectors can keep another's compiler busy for minutes
/// (docs/design/decisions/038-forms-by-driver.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Driver {
    /// Hardware, whatever its driver.
    Gpu,
    /// Mesa's lavapipe.
    Lavapipe,
    /// Google's SwiftShader.
    SwiftShader,
    /// A driver that runs on the processor, of which nothing was measured.
    OtherCpu,
}

impl Driver {
    /// True for a software device: its memory is the caches of a few cores.
    pub fn is_cpu(self) -> bool {
        self != Driver::Gpu
    }

    /// True if loads through texel views are faster than loads from storage buffers. lavapipe gathers texels as one
    /// vector and loads from storage buffers lane by lane; a GPU has nothing to gain; SwiftShader fetches texels lane by lane.
    pub fn gathers_texels(self) -> bool {
        self == Driver::Lavapipe
    }

    /// True if the compiler copes with the kernels in which the lanes of a subgroup work together, and they are faster.
    pub fn joins_lanes(self) -> bool {
        self == Driver::Lavapipe
    }
}
