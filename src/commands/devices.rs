//! `whitted devices`.

use super::failure::Failure;
use crate::cli::DevicesArgs;
use crate::table::{Align, Table};
use crate::vk::{self, DeviceSummary};
use anyhow::Context;
use serde::Serialize;
use std::io::{self, Write};

/// One device, as `--json` names it.
#[derive(Debug, Clone, Serialize)]
struct Row {
    index: usize,
    name: String,
    #[serde(rename = "type")]
    kind: String,
    driver: String,
    api: String,
    uuid: String,
    /// Why it cannot render; null if it can.
    unsuitable: Option<String>,
}

impl Row {
    fn new(index: usize, summary: DeviceSummary) -> Row {
        let DeviceSummary { info, uuid, unsuitable } = summary;
        let hex: Vec<String> =
            [0..4, 4..6, 6..8, 8..10, 10..16].map(|part| uuid[part].iter().map(|b| format!("{b:02x}")).collect()).into();
        Row {
            index,
            name: info.name,
            kind: info.kind,
            driver: info.driver,
            api: info.api,
            uuid: hex.join("-"),
            unsuitable,
        }
    }
}

/// Lists the devices on standard output.
pub fn run(args: &DevicesArgs) -> Result<(), Failure> {
    let rows: Vec<Row> = vk::list()?.into_iter().enumerate().map(|(i, s)| Row::new(i, s)).collect();
    let text = if args.json {
        serde_json::to_string_pretty(&rows).context("cannot write the list as JSON")? + "\n"
    } else {
        listing(&rows)
    };
    match io::stdout().lock().write_all(text.as_bytes()) {
        // The reader has seen enough (`whitted devices | head -1`).
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other.context("cannot write to standard output")?),
    }
}

fn listing(rows: &[Row]) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[
        ("index", Right),
        ("type", Left),
        ("Vulkan", Left),
        ("UUID", Left),
        ("name", Left),
        ("driver", Left),
        ("", Left),
    ]);
    for row in rows {
        let note = row.unsuitable.as_ref().map_or(String::new(), |why| format!("unsuitable: {why}"));
        table.row([
            row.index.to_string(),
            row.kind.clone(),
            row.api.clone(),
            row.uuid.clone(),
            row.name.clone(),
            row.driver.clone(),
            note,
        ]);
    }
    table.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::DeviceInfo;

    #[test]
    fn rows_are_named_and_aligned() {
        let info = DeviceInfo {
            name: "llvmpipe".into(),
            kind: "cpu".into(),
            driver: "Mesa".into(),
            api: "1.3.230".into(),
        };
        let uuid = std::array::from_fn(|i| i as u8 * 16 + i as u8);
        let row = Row::new(0, DeviceSummary { info, uuid, unsuitable: Some("no storage".into()) });
        assert_eq!(row.uuid, "00112233-4455-6677-8899-aabbccddeeff");
        let text = listing(std::slice::from_ref(&row));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0].find("UUID"), lines[1].find("00112233"));
        assert!(lines[1].ends_with("unsuitable: no storage"));
        assert_eq!(serde_json::to_value(&row).unwrap()["type"], "cpu");
    }
}
