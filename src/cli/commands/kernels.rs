//! `whitted kernels`.

use crate::cli::args::KernelsArgs;
use crate::cli::console::{self, Console};
use crate::cli::delivery::{settings, write_json};
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::{progress, read};
use crate::render::compiled;
use crate::report::compiled::{CompiledKernel, CompiledKernels, Executable};
use anyhow::Context;
use std::path::Path;

/// Prints what the driver made of a scene's kernels.
pub fn run(args: &KernelsArgs, console: &mut Console) -> Result<(), Failure> {
    let files =
        || Files::new().reads("the scene", &args.scene).writes("--json", args.json.as_deref()).prints();
    files().check()?;
    let scene = read::scene(&args.scene, &args.read, args.picture.size, console)?;
    files().reads_scene(&scene).check()?;
    let asked = settings(&args.picture, &args.schedule, &scene)?;
    progress::catch_interrupts()?;
    let found = compiled(&args.device.choice(), &scene, &asked, args.isa)?;
    match args.json.as_deref() {
        Some(file) if file == Path::new("-") => {
            let text = serde_json::to_string_pretty(&found).context("cannot express the kernels as JSON")?;
            return console::print(&(text + "\n"));
        }
        Some(file) => write_json(file, &found)?,
        None => {}
    }
    let mut text = table(&found);
    if args.isa {
        for kernel in &found.kernels {
            for of in &kernel.executables {
                for code in &of.texts {
                    text += &format!("\n; {}, {}: {}\n{}\n", kernel.kernel, of.name, code.name, code.text);
                }
            }
        }
    }
    console::print(&text)
}

/// A row per statistic, a column per piece of machine code.
fn table(found: &CompiledKernels) -> String {
    let device = &found.device;
    let mut text = format!(
        "device  {}, {}\nscene   {}: workgroups of {}, traversal stacks of {} words\n\n",
        device.name, device.driver, found.scene, found.workgroup, found.stack
    );
    let columns: Vec<(&CompiledKernel, &Executable)> =
        found.kernels.iter().flat_map(|k| k.executables.iter().map(move |e| (k, e))).collect();
    let mut names: Vec<&str> = Vec::new();
    for figure in columns.iter().flat_map(|(_, e)| &e.figures) {
        // A hash tells nobody anything.
        if !names.contains(&figure.name.as_str()) && !figure.name.to_lowercase().contains("hash") {
            names.push(&figure.name);
        }
    }
    let mut rows: Vec<(&str, Vec<String>)> = vec![
        ("kernel", columns.iter().map(|(k, _)| k.kernel.clone()).collect()),
        ("form", columns.iter().map(|(k, _)| k.form.clone()).collect()),
        (
            "runs",
            columns.iter().map(|(k, _)| if k.in_parts { "in parts" } else { "always" }.into()).collect(),
        ),
        ("subgroup", columns.iter().map(|(_, e)| e.subgroup.to_string()).collect()),
    ];
    for name in names {
        let of = |e: &Executable| e.figure(name).map_or_else(|| "-".into(), |value| value.to_string());
        rows.push((name, columns.iter().map(|(_, e)| of(e)).collect()));
    }
    let first = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let widths: Vec<usize> =
        (0..columns.len()).map(|i| rows.iter().map(|(_, cells)| cells[i].len()).max().unwrap_or(0)).collect();
    for (name, cells) in &rows {
        text += &format!("{name:<first$}");
        for (cell, width) in cells.iter().zip(&widths) {
            text += &format!("  {cell:>width$}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::DeviceInfo;
    use crate::report::compiled::{Figure, Value};

    #[test]
    fn statistics_that_drivers_lack_are_dashes_and_hashes_are_left_out() {
        let figure = |name: &str, value| Figure { name: name.into(), meaning: String::new(), value };
        let kernel = |name: &str, figures, in_parts| CompiledKernel {
            kernel: name.into(),
            form: "f32".into(),
            in_parts,
            executables: vec![Executable { name: "cs".into(), subgroup: 64, figures, texts: Vec::new() }],
        };
        let found = CompiledKernels {
            device: DeviceInfo { name: "D".into(), driver: "E".into(), ..DeviceInfo::default() },
            scene: "a.toml".into(),
            workgroup: 64,
            stack: 7,
            kernels: vec![
                kernel(
                    "shade",
                    vec![figure("Hash", Value::Whole(9)), figure("VGPRs", Value::Whole(72))],
                    false,
                ),
                kernel("walk", vec![figure("Spills", Value::Truth(false))], true),
            ],
        };
        let expected = "device  D, E\nscene   a.toml: workgroups of 64, traversal stacks of 7 words\n\n\
             kernel     shade      walk\n\
             form         f32       f32\n\
             runs      always  in parts\n\
             subgroup      64        64\n\
             VGPRs         72         -\n\
             Spills         -        no\n";
        assert_eq!(table(&found), expected);
    }
}
