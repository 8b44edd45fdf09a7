//! The command line as clap sees it: names, defaults, help. What commands do is in `commands`.

macro_rules! exit_codes {
    () => {
        "Exit codes: 0 done, 1 failure, 2 usage, 3 scene, 4 no device, 5 device lost, 6 above the \
         threshold, 130 interrupted."
    };
}

mod calibrate;
mod compare;
mod devices;
mod gallery;
mod plan;
mod profile;
mod render;
mod stress;
mod sweep;
mod values;

pub use calibrate::{CalibrateArgs, Promise};
pub use compare::{CompareArgs, Metric};
pub use devices::DevicesArgs;
pub use gallery::GalleryArgs;
pub use plan::PlanArgs;
pub use profile::ProfileArgs;
pub use render::{AccuracyArgs, PictureArgs, RenderArgs};
pub use stress::StressArgs;
pub use sweep::SweepArgs;
pub use values::{Crop, Output, Size};

use crate::scene::procedural::Shape;
use crate::settings::forced_features::General;
use crate::settings::{DeviceChoice, Hierarchy, Schedule};
use clap::{ArgAction, Args, Parser, Subcommand};
use std::sync::LazyLock;

static LONG_VERSION: LazyLock<String> = LazyLock::new(|| {
    format!("{} ({})", env!("CARGO_PKG_VERSION"), option_env!("WHITTED_GIT").unwrap_or("unknown"))
});

/// A Whitted ray tracer on raw Vulkan compute.
#[derive(Debug, Parser)]
#[command(version, long_version = LONG_VERSION.as_str(), after_help = exit_codes!(), max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to an image
    Render(RenderArgs),
    /// List the Vulkan devices
    Devices(DevicesArgs),
    /// Tell what a render of a scene needs and how long it takes, before it runs
    Plan(PlanArgs),
    /// Time a scene's passes, depth by depth
    Profile(ProfileArgs),
    /// Render the comparison of sample counts and depths, with a contact sheet
    Gallery(GalleryArgs),
    /// Time and judge every point of a grid of settings: error against time, with plots
    Sweep(SweepArgs),
    /// Measure the difference of two pictures
    Compare(CompareArgs),
    /// Measure how often --budget, --error and --time keep what they promise
    Calibrate(CalibrateArgs),
    /// Run the numerical extremes on a device, each against its derived bound
    Stress(StressArgs),
    /// Write a shape as an OBJ file or as scene text
    #[command(subcommand)]
    Generate(Shape),
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
            general: self.general.unwrap_or_default(),
            ..Schedule::default()
        }
    }
}

/// Which device.
#[derive(Debug, Args)]
pub struct DeviceArgs {
    /// Vulkan device: index, part of the name, UUID or `cpu` [default: the most capable]
    #[arg(long, env = "WHITTED_DEVICE", value_name = "DEVICE", value_parser = values::device, hide_env_values = true)]
    pub device: Option<DeviceChoice>,
}

impl DeviceArgs {
    /// The choice made, or the most capable device.
    pub fn choice(&self) -> DeviceChoice {
        self.device.clone().unwrap_or_default()
    }
}

/// How the work is cut; never changes the image.
#[derive(Debug, Args)]
#[command(next_help_heading = "Scheduling (never changes the image)")]
pub struct ScheduleArgs {
    /// Pixels per tile, at most [default: as memory allows]
    #[arg(long, value_name = "N", value_parser = values::positive())]
    pub tile_pixels: Option<u32>,

    /// Samples of a pixel traced together, at most [default: as memory allows]
    #[arg(long, value_name = "N", value_parser = values::positive())]
    pub batch_samples: Option<u32>,

    /// Invocations per workgroup [default: chosen for the device]
    #[arg(long, value_parser = ["32", "64", "128", "256"])]
    pub workgroup: Option<String>,

    /// Work that goes into the hierarchy of a large scene: `balanced` or `best`
    #[arg(long, value_name = "WHICH", default_value = "balanced")]
    pub bvh: Hierarchy,
    /// Features that kernels have although the scene lacks them, separated by commas, or `all`: for tests
    #[arg(long, value_name = "FEATURES", hide = true)]
    pub general: Option<General>,
}

/// How much to say on standard error.
#[derive(Debug, Clone, Copy, Args)]
pub struct Verbosity {
    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Messages")]
    pub quiet: bool,

    /// Print device, plan, and time and rays per pass and depth
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

    #[test]
    fn everything_is_optional_but_scene_and_output() {
        let cli = Cli::try_parse_from(["whitted", "render", "a.toml", "-o", "a.png"]).unwrap();
        let Command::Render(args) = cli.command else { panic!("render expected") };
        assert_eq!(
            (args.picture.seed, args.picture.samples, args.picture.depth, args.validate),
            (0, None, None, false)
        );
    }
}
