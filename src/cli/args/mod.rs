//! The command line as clap sees it: names, defaults, help. What commands do is in `commands`.

mod calibrate;
mod compare;
mod devices;
mod frames;
mod gallery;
mod import;
mod info;
mod manual;
mod merge;
mod kernels;
mod plan;
mod profile;
mod read;
mod render;
mod stress;
mod sweep;
mod values;
mod verify;

pub use calibrate::{CalibrateArgs, Promise};
pub use compare::{CompareArgs, Metric};
pub use devices::DevicesArgs;
pub use frames::{FrameArgs, Frames};
pub use gallery::GalleryArgs;
pub use import::ImportArgs;
pub use info::InfoArgs;
pub use kernels::KernelsArgs;
pub use manual::{CompletionsArgs, ManArgs};
pub use merge::MergeArgs;
pub use plan::PlanArgs;
pub use profile::ProfileArgs;
pub use read::ReadArgs;
pub use render::{AccuracyArgs, PictureArgs, RenderArgs};
pub use stress::StressArgs;
pub use sweep::SweepArgs;
pub use values::{Crop, Output, Size};
pub use verify::VerifyArgs;

use crate::cli::failure::Code;
use crate::scene::procedural::Shape;
use crate::settings::forced_features::ForcedFeatures;
use crate::settings::{DeviceChoice, Hierarchy, Schedule};
use clap::{ArgAction, Args, Parser, Subcommand};
use std::fmt::Write;
use std::sync::LazyLock;

static LONG_VERSION: LazyLock<String> = LazyLock::new(|| {
    format!("{} ({})", env!("CARGO_PKG_VERSION"), option_env!("WHITTED_GIT").unwrap_or("unknown"))
});

const HELP: &str = "\
Examples:
  whitted render scenes/cornell.toml -o cornell.png
  whitted render scenes/cornell.toml -o good.png --error 0.01
  whitted compare good.png cornell.png

`whitted COMMAND --help` shows the options of a command, with examples.";

const GENERATE_HELP: &str = "\
The same options write the same bytes.

Example:
  whitted generate sphereflake -o flake.toml";

/// What help prints after the options: `notes`, then the exit codes.
fn notes(notes: &str) -> String {
    let mut text = format!("{notes}\n\nExit codes:\n");
    for (code, meaning) in Code::ALL {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {:>3}  {meaning}", code as u8);
    }
    text
}

/// A Whitted ray tracer on raw Vulkan compute.
#[derive(Debug, Parser)]
#[command(name = "whitted", version, long_version = LONG_VERSION.as_str(), after_help = notes(HELP), max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene or a model to an image
    Render(Box<RenderArgs>),
    /// Join the shares of a picture
    Merge(MergeArgs),
    /// Draw again what a report describes, and say whether the picture is the same
    Verify(VerifyArgs),
    /// List the Vulkan devices
    Devices(DevicesArgs),
    /// Write the scene around a model: camera, lights, materials
    Import(ImportArgs),
    /// Tell what is in a model, a scene or a picture
    Info(InfoArgs),
    /// Show what a render needs and how long it will take, without rendering
    Plan(PlanArgs),
    /// Show what the driver makes of a scene's kernels: registers, spills, code size, code
    Kernels(KernelsArgs),
    /// Time the passes of a render, depth by depth
    Profile(ProfileArgs),
    /// Render a scene at several sample counts and depths, with a contact sheet
    Gallery(GalleryArgs),
    /// Time and judge every combination of settings: error against time, with plots
    Sweep(SweepArgs),
    /// Measure the difference between two pictures
    Compare(CompareArgs),
    /// Measure how often --budget, --error and --time keep what they promise
    Calibrate(CalibrateArgs),
    /// Run numerical extremes on a device, each against its derived bound
    Stress(StressArgs),
    /// Write a shape as an OBJ file or a scene
    #[command(subcommand, after_help = notes(GENERATE_HELP))]
    Generate(Shape),
    /// Print the completion script of a shell
    Completions(CompletionsArgs),
    /// Print the manual page, or write the pages of all commands
    Man(ManArgs),
}

impl ScheduleArgs {
    /// As the settings have it.
    pub fn schedule(&self) -> Schedule {
        Schedule {
            tile_pixels: self.tile_pixels,
            batch_samples: self.batch_samples,
            // clap lets through only 32, 64, 128 and 256.
            workgroup: self.workgroup.as_deref().and_then(|n| n.parse().ok()),
            hierarchy: self.bvh,
            forced_features: self.forced_features.unwrap_or_default(),
            ..Schedule::default()
        }
    }
}

/// Which device.
#[derive(Debug, Clone, Args)]
pub struct DeviceArgs {
    /// Vulkan device: index, part of the name, UUID or `cpu` [default: the most capable]
    #[arg(long, env = "WHITTED_DEVICE", value_name = "DEVICE", value_parser = values::device, hide_env_values = true, help_heading = "Device")]
    pub device: Option<DeviceChoice>,
}

impl DeviceArgs {
    /// The choice made, or the most capable device.
    pub fn choice(&self) -> DeviceChoice {
        self.device.clone().unwrap_or_default()
    }
}

/// How the work is divided; never changes the image.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Scheduling (never changes the image)")]
pub struct ScheduleArgs {
    /// Pixels per tile, at most [default: as memory allows]
    #[arg(long, value_name = "N", value_parser = values::positive())]
    pub tile_pixels: Option<u32>,

    /// Samples of a pixel that are traced together, at most [default: as memory allows]
    #[arg(long, value_name = "N", value_parser = values::positive())]
    pub batch_samples: Option<u32>,

    /// Invocations per workgroup [default: chosen for the device]
    #[arg(long, value_parser = ["32", "64", "128", "256"])]
    pub workgroup: Option<String>,

    /// Work that goes into the hierarchy of a large scene: `balanced` or `best`
    #[arg(long, value_name = "WHICH", default_value = "balanced")]
    pub bvh: Hierarchy,
    /// Features that kernels have although the scene lacks them, separated by commas, or `all`: for tests
    #[arg(long = "general", value_name = "FEATURES", hide = true)]
    pub forced_features: Option<ForcedFeatures>,
}

/// Messages on standard error.
#[derive(Debug, Clone, Copy, Args)]
pub struct Verbosity {
    /// Print only errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Messages")]
    pub quiet: bool,

    /// Print the device, the plan, and time and rays for each pass and depth
    #[arg(short, long, action = ArgAction::SetTrue, help_heading = "Messages")]
    pub verbose: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }
}
