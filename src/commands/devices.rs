//! `whitted devices`.

use super::failure::Failure;
use crate::cli::DevicesArgs;
use crate::render::RenderError;
use crate::table::{Align, Table, mebibytes};
use crate::vk::{self, DeviceSummary};
use anyhow::Context;
use std::io::{self, Write};

/// Lists the devices on standard output.
pub fn run(args: &DevicesArgs) -> Result<(), Failure> {
    let devices = vk::list().map_err(RenderError::from)?;
    let text = if args.json {
        serde_json::to_string_pretty(&devices).context("cannot express the devices as JSON")? + "\n"
    } else {
        listing(&devices)
    };
    match io::stdout().lock().write_all(text.as_bytes()) {
        // The reader has seen enough (`whitted devices | head -1`).
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other.context("cannot write to standard output")?),
    }
}

fn listing(devices: &[DeviceSummary]) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[
        ("index", Right),
        ("type", Left),
        ("Vulkan", Left),
        ("memory", Right),
        ("name", Left),
        ("driver", Left),
        ("UUID", Left),
    ]);
    for device in devices {
        table.row([
            device.index.to_string(),
            device.kind.clone(),
            device.api.clone(),
            mebibytes(device.heap),
            device.name.clone(),
            device.driver.clone(),
            device.uuid.clone(),
        ]);
    }
    let mut text = table.to_string();
    for device in devices {
        if let Some(why) = &device.unusable {
            text += &format!("device {} cannot be used: {why}\n", device.index);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_aligned_and_their_faults_told() {
        let device = |index: usize, name: &str, unusable: Option<&str>| DeviceSummary {
            index,
            name: name.into(),
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
            timestamp_bits: 64,
            timestamp_period: 1.0,
            float64: true,
            unusable: unusable.map(Into::into),
        };
        let text = listing(&[device(0, "llvmpipe", None), device(1, "old", Some("Vulkan 1.1"))]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[1].find("00112233"), lines[0].find("UUID"));
        assert_eq!(lines[2].find("00112233"), lines[0].find("UUID"));
        assert!(lines[1].contains("1536.0 MiB"));
        assert_eq!(lines[3], "device 1 cannot be used: Vulkan 1.1");
    }
}
