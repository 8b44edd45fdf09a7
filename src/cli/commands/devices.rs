//! `whitted devices`.

use crate::cli::args::DevicesArgs;
use crate::cli::console::print;
use crate::cli::failure::Failure;
use crate::cli::threads;
use crate::plan::Switched;
use crate::render::RenderError;
use crate::render::self_test::{self, Arithmetic, SelfTest};
use crate::settings::DeviceChoice;
use crate::units::{bytes, grouped, number};
use crate::vk::{self, Device, DeviceSummary};
use anyhow::Context;
use serde::Serialize;
use std::io::{self, Write};
use std::rc::Rc;

/// A device with the results of its self-test.
#[derive(Debug, Serialize)]
struct Listed {
    #[serde(flatten)]
    device: DeviceSummary,
    /// `None` if the device cannot be used or opened.
    arithmetic: Option<SelfTest>,
    /// `None` if the device cannot be used or opened.
    switched: Option<Switched>,
}

impl Listed {
    fn new(device: DeviceSummary) -> Listed {
        let open = || Device::new(&DeviceChoice::Index(device.index), false).ok();
        let opened = if device.unusable.is_some() { None } else { open().map(Rc::new) };
        let arithmetic = opened.as_ref().and_then(|device| self_test::run(device).ok());
        let switched = opened.map(|device| Switched::of(&device.limits()));
        Listed { device, arithmetic, switched }
    }
}

/// Lists the devices on standard output.
pub fn run(args: &DevicesArgs) -> Result<(), Failure> {
    threads::check()?;
    let found = vk::list().map_err(RenderError::from)?;
    for note in &found.notes {
        // A closed standard error leaves the list.
        let _ = writeln!(io::stderr(), "warning: {note}");
    }
    let devices: Vec<Listed> = found.listed.into_iter().map(Listed::new).collect();
    let text = if args.json {
        serde_json::to_string_pretty(&devices).context("cannot express the devices as JSON")? + "\n"
    } else {
        listing(&devices)
    };
    print(&text)
}

fn listing(devices: &[Listed]) -> String {
    if devices.is_empty() {
        return "no Vulkan device\n".into();
    }
    devices.iter().map(block).collect::<Vec<_>>().join("\n")
}

/// One device: a heading, then one line per property.
fn block(listed: &Listed) -> String {
    let d = &listed.device;
    let behind = d.behind.as_ref().map_or(String::new(), |why| format!("; the default {why}"));
    let usable = match (&d.unusable, d.default) {
        (Some(why), _) => format!("no: {why}"),
        (None, true) => "yes; the default".into(),
        (None, false) => format!("yes, with --device {}", d.index) + &behind,
    };
    let timing = match d.timestamp_bits {
        0 => "no timestamps: each submit's wall time is divided evenly among its passes".into(),
        bits => {
            format!(
                "timestamps of {bits} bits, {} ns per tick: each pass is timed",
                number(d.timestamp_period.into())
            )
        }
    };
    let doubles = match d.float64 {
        true => "yes: --precision f64 is available",
        false => "no: --precision f64 is refused; the default, robust, does not need it",
    };
    let rows = [
        ("usable", usable),
        ("type", d.kind.clone()),
        ("driver", format!("{}, Vulkan {}", d.driver, d.api)),
        ("UUID", d.uuid.clone()),
        ("memory", format!("{}; at most {} per buffer", bytes(d.heap), bytes(d.storage_range))),
        (
            "kernels",
            format!(
                "workgroups of up to {}, subgroups of {}; {} storage buffers, {} of push constants",
                grouped(d.workgroup_invocations.into()),
                d.subgroup_size,
                grouped(d.storage_buffers.into()),
                bytes(d.push_constants.into()),
            ),
        ),
        ("code", code(listed.switched)),
        ("timing", timing),
        ("fp64", doubles.into()),
        ("numbers", numbers(listed.arithmetic.as_ref())),
    ];
    rows.iter().fold(format!("device {}: {}\n", d.index, d.name), |text, (name, line)| {
        text + &format!("  {name:<8} {line}\n")
    })
}

/// Variants of the kernels that the device's kind and limits select.
fn code(switched: Option<Switched>) -> String {
    let Some(s) = switched else { return "unknown".into() };
    let all = [
        if s.texels { "texel loads" } else { "storage buffer loads" },
        if s.packets { "packet traversal" } else { "single-ray traversal" },
        if s.fused { "one fused kernel per depth if samples are many" } else { "one kernel per stage" },
    ];
    all.join("; ")
}

/// The results of the self-test.
fn numbers(arithmetic: Option<&SelfTest>) -> String {
    let Some(test) = arithmetic else { return "not tested".into() };
    let one = |a: &Arithmetic| {
        let faults = a.faults();
        let exact = if faults.is_empty() {
            format!(
                "exact where required, division within {} ulp, root within {} ulp",
                number(a.division_ulp),
                number(a.sqrt_ulp)
            )
        } else {
            format!("unreliable: {}", faults.join("; "))
        };
        exact + if a.flushes_denormals { ", denormals flushed" } else { "" }
    };
    let double = test.double.as_ref().map_or(String::new(), |a| format!("\n           f64: {}", one(a)));
    format!("f32: {}{double}", one(&test.single))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Driver;

    fn device(index: usize, unusable: Option<&str>) -> Listed {
        let device = DeviceSummary {
            index,
            default: index == 0,
            behind: (index > 0 && unusable.is_none()).then(|| "computes in f64".into()),
            name: "llvmpipe".into(),
            kind: "cpu".into(),
            driver: "llvmpipe Mesa 22.3.6".into(),
            api: "1.3.230".into(),
            uuid: "00112233445566778899aabbccddeeff".into(),
            storage_range: 1 << 27,
            heap: 3 << 29,
            workgroup_invocations: 1024,
            subgroup_size: 8,
            push_constants: 256,
            storage_buffers: 16,
            timestamp_bits: 64 * (1 - index as u32 % 2),
            timestamp_period: 1.0,
            float64: index != 1,
            unusable: unusable.map(Into::into),
        };
        let lavapipe = crate::plan::Limits::LAVAPIPE;
        let limits = crate::plan::Limits {
            driver: if index == 0 { Driver::Lavapipe } else { Driver::Gpu },
            ..lavapipe
        };
        Listed { device, arithmetic: None, switched: (index != 1).then(|| Switched::of(&limits)) }
    }

    #[test]
    fn arithmetic_that_cannot_be_trusted_says_why() {
        let sound = Arithmetic { division_ulp: 0.5, sqrt_ulp: 0.5, ..Arithmetic::default() };
        let fused = Arithmetic { contracted: 3, ..sound };
        let text = numbers(Some(&SelfTest { single: fused, double: Some(sound) }));
        let (single, double) = text.split_once("f64").expect("both precisions");
        assert!(single.contains("3 of 4096") && !double.contains("4096"), "{text}");
    }

    #[test]
    fn each_device_is_a_block_with_its_faults_and_second_ways() {
        let text = listing(&[device(0, None), device(1, Some("it has no Vulkan 1.2")), device(2, None)]);
        let blocks: Vec<&str> = text.split("\n\n").collect();
        assert_eq!(blocks.len(), 3, "{text}");
        for (block, parts) in blocks.iter().zip([
            ["device 0: llvmpipe", "1.50 GiB", "128 MiB"],
            ["device 1: llvmpipe", "no: it has no Vulkan 1.2", "--precision f64"],
            ["device 2: llvmpipe", "--device 2; the default computes in f64", "1,024"],
        ]) {
            for part in parts {
                assert!(block.contains(part), "{part} is not in\n{block}");
            }
        }
        // The GPU, device 2, is used in other ways.
        let ways = |block: &str| block.lines().find(|l| l.trim().starts_with("code ")).map(str::to_owned);
        assert_ne!(ways(blocks[0]), ways(blocks[2]), "{text}");
        assert!(text.lines().all(|line| line.len() <= 100), "{text}");
        assert_eq!(listing(&[]), "no Vulkan device\n");
    }
}
