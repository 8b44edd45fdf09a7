//! The compiled kernels, as a typed table written by `build.rs`.

use crate::kernel::abi::Buf;

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
    /// Compiled with `real` = float and a small scene's shapes as constants, where it tests shapes; else as `single`.
    pub few: Spirv,
    /// Compiled with `real` = float and rays that walk the hierarchy in packets, where it tests shapes; else as `single`.
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
