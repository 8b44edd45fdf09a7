//! The compiled kernels, as a typed table written by `build.rs`.

use crate::kernel::abi::{Buf, Specialisation};
#[cfg(feature = "defects")]
use crate::kernel::defects::{self, Defect};

/// SPIR-V bytes embedded in the program.
#[derive(Debug, Clone, Copy)]
pub struct Spirv(pub &'static [u8]);

impl Spirv {
    /// As words.
    pub fn words(self) -> Vec<u32> {
        self.0.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect()
    }
}

/// One compiled kernel.
#[derive(Debug, Clone, Copy)]
pub struct KernelCode {
    /// File name without extension: also the pass, the label and the profile row.
    pub name: &'static str,
    /// Compiled with `real` = float.
    pub single: Spirv,
    /// Compiled with `real` = double.
    pub double: Spirv,
    /// Compiled with `real` = float, the lanes of a subgroup working together, where it tests shapes; else as `single`.
    pub packet: Spirv,
    /// Bit b: the kernel may load from buffer b.
    pub reads: u64,
    /// Bit b: the kernel may store to buffer b.
    pub writes: u64,
    /// Bit b: in single precision, the kernel may read buffer b through its texel view as well.
    pub texels: u64,
}

impl Kernel {
    /// Its compiled form.
    pub fn code(self) -> &'static KernelCode {
        &KERNELS[self as usize]
    }

    /// File name without extension.
    pub fn name(self) -> &'static str {
        self.code().name
    }
}

/// Compiled kernels and how they are run.
#[derive(Debug, Clone, Copy)]
pub struct KernelSet {
    table: &'static [KernelCode],
    /// Id and value of a specialisation constant beside those of [`Specialisation`].
    constant: Option<(u32, u32)>,
    /// The kernel that no barrier follows.
    without_barrier: Option<Kernel>,
}

impl KernelSet {
    /// The kernels that render.
    pub const SHIPPED: KernelSet = KernelSet { table: &KERNELS, constant: None, without_barrier: None };

    /// Those with planted mistakes, of which `defect` is switched on.
    #[cfg(feature = "defects")]
    #[doc(hidden)]
    pub fn planted(defect: Defect) -> KernelSet {
        let constant = Some((defects::ID, defect as u32));
        KernelSet { table: &planted::KERNELS, constant, ..KernelSet::SHIPPED }
    }

    /// The shipped kernels, without the barrier after one of them.
    #[cfg(feature = "defects")]
    #[doc(hidden)]
    pub fn without_barrier_after(kernel: Kernel) -> KernelSet {
        KernelSet { without_barrier: Some(kernel), ..KernelSet::SHIPPED }
    }

    /// True if a barrier follows the kernel's dispatches.
    pub fn has_barrier_after(&self, kernel: Kernel) -> bool {
        self.without_barrier != Some(kernel)
    }

    /// Its compiled form of a kernel.
    pub fn code(&self, kernel: Kernel) -> &'static KernelCode {
        &self.table[kernel as usize]
    }

    /// Ids and values of the specialisation constants.
    pub fn values(&self, specialisation: &Specialisation) -> Vec<(u32, u32)> {
        specialisation.values().into_iter().chain(self.constant).collect()
    }
}

#[cfg(feature = "defects")]
mod planted {
    use super::{KernelCode, Spirv};
    include!(concat!(env!("OUT_DIR"), "/defects/kernels.rs"));

    // Descriptor layouts are made for the shipped kernels' buffers.
    const _: () = {
        let mut i = 0;
        while i < KERNELS.len() {
            let (a, b) = (&KERNELS[i], &super::KERNELS[i]);
            assert!(a.reads == b.reads && a.writes == b.writes && a.texels == b.texels);
            i += 1;
        }
    };
}

/// The set of `buffers` as a bit mask.
pub const fn mask(buffers: &[Buf]) -> u64 {
    let (mut bits, mut i) = (0, 0);
    while i < buffers.len() {
        bits |= 1 << buffers[i] as u32;
        i += 1;
    }
    bits
}

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
