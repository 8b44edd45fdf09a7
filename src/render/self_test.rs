//! What a device's arithmetic is worth, asked of the device (numerics.md, Self-test): Vulkan promises
//! less than the kernels need, and vendors' names promise nothing.

use crate::host::cache_folder;
use crate::kernel::abi::{self, BUFFERS, Buf, Push, Specialisation};
use crate::kernel::table::KernelSet;
use crate::plan::element_bytes;
use crate::plan::passes::SELF_TEST;
use crate::report::ProgramInfo;
use crate::settings::Precision;
use crate::vk::{Buffers, Device, Dispatch, Pipelines, Recorder, VkError};
use serde::{Deserialize, Serialize};
use std::rc::Rc;

/// Vectors tried.
const ITEMS: u32 = 4096;

/// What one precision of a device does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Arithmetic {
    /// Sums and products that were not correctly rounded.
    pub misrounded: u32,
    /// Largest error of a quotient, units in the last place (0.5 = correctly rounded; Vulkan: 2.5).
    pub division_ulp: f64,
    /// Largest error of a square root, units in the last place.
    pub sqrt_ulp: f64,
    /// Rounding errors of sums (Knuth) that were not exact.
    pub inexact_sums: u32,
    /// Rounding errors of products (Dekker) that were not exact.
    pub inexact_products: u32,
    /// Products fused with a sum although forbidden.
    pub contracted: u32,
    /// NaN and infinity were not told from numbers.
    pub blind_to_nan: u32,
    /// Half the least normal f32 is zero.
    pub flushes_denormals: bool,
}

impl Arithmetic {
    /// Why the exact rechecks and bounds of the kernels do not hold here, if so.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut count = |n: u32, what: &str| {
            if n > 0 {
                faults.push(format!("{n} of {ITEMS} {what}"));
            }
        };
        count(self.misrounded, "sums and products are not correctly rounded");
        count(self.inexact_sums, "errors of sums are inexact");
        count(self.inexact_products, "errors of products are inexact");
        count(self.contracted, "products were fused although forbidden");
        count(self.blind_to_nan, "NaN tests fail");
        // The slab factor 1 + 2g(7) allows 2.5 ulp of a reciprocal; a root comes from 1/sqrt with two
        // roundings more.
        if self.division_ulp > 2.5 {
            faults.push(format!("division is off by {:.1} ulp, 2.5 are allowed", self.division_ulp));
        }
        if self.sqrt_ulp > 4.5 {
            faults.push(format!("square roots are off by {:.1} ulp, 4.5 are allowed", self.sqrt_ulp));
        }
        faults
    }
}

/// The two precisions of a device.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SelfTest {
    /// f32.
    pub single: Arithmetic,
    /// f64; `None` without shaderFloat64.
    pub double: Option<Arithmetic>,
}

/// The verdict of an earlier run on this device and driver, or a new one.
pub fn known(device: &Rc<Device>) -> Result<SelfTest, VkError> {
    let file = device.cache_file("self_test");
    // What the verdict follows from: the test of this version, on this device under this driver.
    let key = format!("{:?} {:?}", ProgramInfo::default(), device.info());
    let stored = file.as_ref().and_then(|f| cache_folder::read(f, key.as_bytes()));
    if let Some(stored) = stored.and_then(|json| serde_json::from_slice(&json).ok()) {
        return Ok(stored);
    }
    let fresh = run(device)?;
    if let (Some(file), Ok(json)) = (file, serde_json::to_vec(&fresh)) {
        cache_folder::write(&file, key.as_bytes(), &json);
    }
    Ok(fresh)
}

/// Runs one dispatch per precision.
pub fn run(device: &Rc<Device>) -> Result<SelfTest, VkError> {
    let single = judge_single(&dispatch(device, Precision::Robust)?);
    let double = match device.has_double() {
        true => Some(judge_double(&dispatch(device, Precision::Double)?)),
        false => None,
    };
    Ok(SelfTest { single, double })
}

fn dispatch(device: &Rc<Device>, precision: Precision) -> Result<Vec<u8>, VkError> {
    let specialisation = Specialisation::default();
    let kernels = SELF_TEST.iter().map(|p| p.kernel);
    let pipelines =
        Pipelines::new(device, KernelSet::SHIPPED, kernels, &specialisation, precision == Precision::Double)?;
    let total = u64::from(ITEMS * abi::SELF_TEST_ROW) * element_bytes("real", precision);
    let bytes: Vec<u64> = BUFFERS.iter().map(|(.., b)| if *b == Buf::SelfTest { total } else { 4 }).collect();
    let mut buffers = Buffers::new(device, &bytes, total)?;
    let mut recorder = Recorder::new(device, &pipelines, &buffers, specialisation.workgroup)?;
    recorder.begin()?;
    let push = Push { items: ITEMS, ..Push::default() };
    for pass in SELF_TEST {
        recorder.dispatch(&pipelines, &buffers, &Dispatch { pass, depth: 0, push, items: ITEMS });
    }
    recorder.submit(&buffers)?;
    recorder.read(&mut buffers, Buf::SelfTest)
}

/// The judgement is the same text at both precisions; only the types differ.
macro_rules! judge {
    ($name:ident, $real:ty, $sum_error:expr, $product_error:expr) => {
        fn $name(bytes: &[u8]) -> Arithmetic {
            let numbers: Vec<$real> = bytemuck::pod_collect_to_vec(bytes);
            let mut a = Arithmetic::default();
            for row in numbers.chunks_exact(abi::SELF_TEST_ROW as usize) {
                let (x, y) = (row[0], row[1]);
                let ulps = |got: $real, want: $real| {
                    let step = f64::from(want.abs().next_up() - want.abs());
                    f64::from((got - want).abs()) / step + if got == want { 0.5 } else { 0.0 }
                };
                a.misrounded += u32::from(row[2] != x + y || row[3] != x * y);
                a.division_ulp = a.division_ulp.max(ulps(row[4], x / y));
                a.sqrt_ulp = a.sqrt_ulp.max(ulps(row[5], x.abs().sqrt()));
                a.inexact_sums += u32::from(row[6] != $sum_error(x, y));
                a.inexact_products += u32::from(row[7] != $product_error(x, y));
                a.contracted += u32::from(row[8] != 0.0);
                a.blind_to_nan += u32::from(row[9] != 1.0);
                a.flushes_denormals |= row[10] == 0.0;
            }
            a
        }
    };
}

// Knuth's and Dekker's errors in the host's IEEE arithmetic: a fused multiply-add gives the second
// outright.
judge!(
    judge_single,
    f32,
    |x: f32, y: f32| {
        let s = x + y;
        let b = s - x;
        (x - (s - b)) + (y - b)
    },
    |x: f32, y: f32| x.mul_add(y, -(x * y))
);
judge!(
    judge_double,
    f64,
    |x: f64, y: f64| {
        let s = x + y;
        let b = s - x;
        (x - (s - b)) + (y - b)
    },
    |x: f64, y: f64| x.mul_add(y, -(x * y))
);

#[cfg(test)]
mod tests {
    use super::*;

    fn honest() -> Vec<f32> {
        let (x, y) = (1.25f32.next_up(), 3.0f32.next_down());
        let p = x * y;
        let row = [x, y, x + y, p, x / y, x.sqrt(), 0.0, x.mul_add(y, -p), 0.0, 1.0, 5.877_472e-39];
        let mut row = row.to_vec();
        let s = x + y;
        let b = s - x;
        row[6] = (x - (s - b)) + (y - b);
        row
    }

    #[test]
    fn sound_arithmetic_has_no_faults() {
        let a = judge_single(bytemuck::cast_slice(&honest()));
        assert!(a.faults().is_empty() && !a.flushes_denormals, "{a:?}");
        assert!((a.division_ulp, a.sqrt_ulp) == (0.5, 0.5));
    }

    #[test]
    fn each_fault_is_seen() {
        let mut flush = honest();
        flush[10] = 0.0;
        assert!(judge_single(bytemuck::cast_slice(&flush)).flushes_denormals);
        for (column, wrong) in
            [(2, 0.0), (3, 0.0), (4, 9.0), (5, 9.0), (6, 9.0), (7, 9.0), (8, 1e-9), (9, 0.0)]
        {
            let mut row = honest();
            row[column] = wrong;
            assert!(!judge_single(bytemuck::cast_slice(&row)).faults().is_empty(), "column {column}");
        }
    }
}
