//! The command line as clap sees it: names, defaults, help. What commands do is in `commands`.

mod values;

pub use values::{Crop, Output, Size};
pub(crate) use values::{cutoff, origin, precision};

use crate::generate::Shape;
use crate::measure::promise::Layer;
use crate::measure::sweep::axes::Axis;
use crate::sampler::Sampler;
use crate::settings::{DeviceChoice, Hierarchy, Origin, Precision, Schedule};
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::sync::LazyLock;

static LONG_VERSION: LazyLock<String> = LazyLock::new(|| {
    format!("{} ({})", env!("CARGO_PKG_VERSION"), option_env!("WHITTED_GIT").unwrap_or("unknown"))
});

macro_rules! exit_codes {
    () => {
        "Exit codes: 0 done, 1 failure, 2 usage, 3 scene, 4 no device, 5 device lost, 6 above the \
         threshold, 130 interrupted."
    };
}

const RENDER_HELP: &str = concat!(
    "\
Examples:
  whitted render scenes/cornell.toml -o cornell.png
  whitted render scenes/cornell.toml -o small.exr --size 300x250 --samples 4 -v
  whitted render scenes/cornell.toml -o part.png --crop 100,100,200,160 --report part.json
  whitted render scenes/cornell.toml -o good.png --error 0.01
  whitted render scenes/cornell.toml -o quick.png --time 2
  whitted render scenes/cornell.toml -o - --device cpu | convert - cornell.webp

Only the image of `-o -` goes to standard output; everything else goes to standard error. Files \
appear whole or not at all. Ctrl-C stops after the work in flight, saves the pixels as they are and \
exits with 130; a second Ctrl-C ends at once and saves nothing. What is finished by then is kept \
beside the image in OUT.partial: the same command with --resume goes on from there, and the image \
is the same, bit for bit, as if it had not been interrupted. Only --time leaves nothing to go on from.

",
    exit_codes!()
);

const GALLERY_HELP: &str = "\
Pictures:
  samples_01, _02, _04, _10   1 to 10 samples per pixel, at the scene's depth
  depth_1 to depth_4          1 to 4 rays in the longest path, at up to 4 samples per pixel
  depth_STEM_1 to _4          the same of the sibling
  final_STEM                  the scene at its own settings; also its sibling, if there is one:
                              STEM_glass.toml beside STEM.toml, or the other way round
  contact_sheet.png           all of them, with samples, depth, time and rays
  gallery.json                the report of each

Samples are independent (`--sampler random` of `whitted render`), so that counts are compared and nothing else.

Example:
  whitted gallery scenes/cornell.toml -o out/gallery";

static SWEEP_HELP: LazyLock<String> = LazyLock::new(|| {
    format!(
        "\
Axes (values separated by commas; what no axis names is the scene's own or the default of `render`):
{}

In DIR: sweep.json and sweep.csv (a row a point), index.html (plots, tables and pictures in one file), the plots as \
SVG and PNG, the pictures behind the points (linear, EXR), and the truth that judged them. Ctrl-C stops \
after the work in flight; the same command goes on from there.

Example:
  whitted sweep scenes/cornell.toml --size 150x125 --over samples=1..64 sampler=all depth=1..6 -o out/sweep",
        crate::measure::sweep::axes::listing()
    )
});
const COMPARE_HELP: &str = concat!(
    "\
Both pictures are taken in linear light, clamped to [0, 1] as they will be shown: PNG codes (8 or 16 \
bits) are decoded from sRGB, EXR and HDR hold linear values. The table goes to standard output, or to \
standard error where --json - has standard output.

Examples:
  whitted compare new.png old.png
  whitted compare new.exr truth.exr --diff where.png --threshold 0.001
  whitted compare new.png old.png --metric flip --diff flip.png --json -

",
    exit_codes!()
);

const PROFILE_HELP: &str = concat!(
    "\
Renders once to warm up and then N times, and tells medians and the range between the quartiles. The \
table goes to standard output, or to standard error where --json - has standard output. A trace opens \
in Perfetto or chrome://tracing. It is of one more frame, with one batch to a submit, so that the \
items of every dispatch are known; its passes are placed by the device's own timestamps.

Bytes are those that one item's structs take in the buffers that hold one element per ray, sample or \
pixel, as the pass table lists them: each read and each write once, new rays by their number. An upper \
bound, as a pass may leave an item early. The scene, counters and caches are not counted.

Examples:
  whitted profile scenes/cornell.toml
  whitted profile scenes/cornell_glass.toml --size 300x200 --repeats 9 --json profile.json
  whitted profile scenes/cornell.toml --samples 4 --trace trace.json

",
    exit_codes!()
);

const CALIBRATE_HELP: &str = concat!(
    "\
Each image is judged by a truth in f64, sampled until its own standard error is a tenth of the smallest error judged. The \
tables are Markdown, on standard output unless -o names a file, or on standard error where --json - has standard output. \
Ctrl-C ends the work and keeps the trials there are. A promise that is not kept is published as such: it is no failure of \
this command.

Examples:
  whitted calibrate
  whitted calibrate scenes/cornell.toml --only error --errors 0.02,0.01,0.005 --seeds 100
  whitted calibrate --size 300x200 --times 1,5 -o calibration.md --json calibration.json

",
    exit_codes!()
);

const DEVICES_HELP: &str = "\
Any of index, UUID, part of the name, or `cpu` (the first software device) is good for --device and \
for the environment variable WHITTED_DEVICE.";

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

/// `whitted render`.
#[derive(Debug, Args)]
#[command(after_help = RENDER_HELP)]
pub struct RenderArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// Image to write: .png, .exr or .hdr; `-` for a PNG on standard output
    #[arg(short, long, value_name = "FILE", value_parser = values::output())]
    pub output: Output,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// Samples per pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = values::positive())]
    pub samples: Option<u32>,

    /// Rays in the longest path; 1 = neither reflection nor refraction [default: the scene's]
    #[arg(long, value_name = "D", value_parser = values::positive())]
    pub depth: Option<u32>,

    /// Do not trace rays that can add less than this share of their light to the pixel, in [0, 1)
    #[arg(long, value_name = "T", value_parser = values::cutoff, default_value_t = 0.0)]
    pub cutoff: f32,

    /// How the samples of a pixel are spread over it: `random`, `stratified` (jittered) or `owen` (scrambled Sobol points)
    #[arg(long, value_name = "WHICH", default_value = "owen")]
    pub sampler: Sampler,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub seed: u32,

    /// Arithmetic: `fast` f32, `robust` f32 with exact rechecks, or `f64`
    #[arg(long, value_name = "WHICH", value_parser = values::precision, help = "Arithmetic: `fast` f32, `robust` f32 with exact rechecks, or `f64` [default: robust]")]
    pub precision: Option<Precision>,

    /// Where secondary rays start: `bound` (off the surface by an error bound) or `fixed:X` (X metres along the ray, for measuring)
    #[arg(long, value_name = "WHICH", value_parser = values::origin, default_value = "bound")]
    pub origin: Origin,

    /// Render only pixels x0 <= x < x1, y0 <= y < y1; the image has that size
    #[arg(long, value_name = "x0,y0,x1,y1")]
    pub crop: Option<Crop>,

    /// Say how wrong the image may be.
    #[command(flatten)]
    pub accuracy: AccuracyArgs,

    /// Bits per channel of a PNG [default: 8]
    #[arg(long, value_parser = ["8", "16"])]
    pub bits: Option<String>,

    /// Write times, rays and settings as JSON
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,

    /// Go on with an interrupted render from OUT.partial, if that is there; else begin
    #[arg(long)]
    pub resume: bool,

    /// Run under the Vulkan validation layer; any message is a failure
    #[arg(long)]
    pub validate: bool,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How the work is cut.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

/// `whitted profile`.
#[derive(Debug, Args)]
#[command(after_help = PROFILE_HELP)]
pub struct ProfileArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// Renders that are timed
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub repeats: u32,

    /// Write all figures as JSON: the report of the run of median time, and the quartiles; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write one frame as Chrome trace events
    #[arg(long, value_name = "FILE.json")]
    pub trace: Option<PathBuf>,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// Samples per pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = values::positive())]
    pub samples: Option<u32>,

    /// Rays in the longest path; 1 = neither reflection nor refraction [default: the scene's]
    #[arg(long, value_name = "D", value_parser = values::positive())]
    pub depth: Option<u32>,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub seed: u32,

    /// Arithmetic: `fast` f32, `robust` f32 with exact rechecks, or `f64`
    #[arg(long, value_name = "WHICH", value_parser = values::precision, default_value = "robust")]
    pub precision: Precision,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How the work is cut.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

/// `whitted compare`.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_HELP)]
pub struct CompareArgs {
    /// Picture to judge: PNG, EXR or HDR
    pub a: PathBuf,

    /// Picture to judge it by, of the same size
    pub b: PathBuf,

    /// Write a false-colour picture of the difference, with its scale (PNG)
    #[arg(long, value_name = "OUT.png", value_parser = values::png())]
    pub diff: Option<PathBuf>,

    /// Difference that --diff shows in its lightest colour [default: the largest]
    #[arg(long, value_name = "X", value_parser = values::above_zero, requires = "diff")]
    pub full_scale: Option<f64>,

    /// Write all figures as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Figure that --threshold judges, and --diff shows
    #[arg(long, value_name = "WHICH", default_value = "rmse")]
    pub metric: Metric,

    /// Exit with 6 if the figure is above X; for psnr, below
    #[arg(long, value_name = "X", value_parser = values::not_negative)]
    pub threshold: Option<f64>,

    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// A figure of `whitted compare`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Root mean square error
    Rmse,
    /// Mean absolute error
    Mean,
    /// Largest error
    Max,
    /// 99.9th percentile of the pixels' errors
    P999,
    /// Peak signal-to-noise ratio, decibels
    Psnr,
    /// Mean LDR-FLIP: how different they look
    Flip,
    /// Share of the pixels that differ
    Pixels,
    /// Largest difference in 8-bit sRGB codes
    Codes,
}

/// How wrong the image may be.
#[derive(Debug, Args)]
#[command(next_help_heading = "Accuracy")]
pub struct AccuracyArgs {
    /// State the error of the image in three parts: sampling, truncation, rounding
    #[arg(long)]
    pub budget: bool,

    /// Choose samples, depth and precision so that the RMSE, in linear light from 0 to 1, is at most this
    #[arg(long, value_name = "E", value_parser = values::above_zero, conflicts_with_all = ["samples", "time", "cutoff", "replicates"])]
    pub error: Option<f64>,

    /// Choose samples and depth so that the error is least in this many seconds of wall time
    #[arg(long, value_name = "T", value_parser = values::above_zero, conflicts_with_all = ["samples", "cutoff", "resume", "replicates"])]
    pub time: Option<f64>,

    /// Confidence of what is said and promised, in (0, 1)
    #[arg(long, value_name = "P", value_parser = values::confidence, default_value_t = 0.95)]
    pub confidence: f64,

    /// Paint what is known of each pixel: any of sampling, truncation, rounding, samples, depth, cost; as channels of an EXR, as OUT.LAYER.png beside other images
    #[arg(long, value_name = "LAYERS", value_delimiter = ',')]
    pub aov: Vec<Layer>,

    /// Independent sets that the samples of a pixel are dealt to; divides the samples [default: with --budget up to 4, with a sampling layer up to 16, else 1]
    #[arg(long, value_name = "R", value_parser = values::positive())]
    pub replicates: Option<u32>,
}

/// `whitted calibrate`.
#[derive(Debug, Args)]
#[command(after_help = CALIBRATE_HELP)]
pub struct CalibrateArgs {
    /// Scene texts (TOML) [default: scenes/*.toml]
    pub scenes: Vec<PathBuf>,

    /// Trials of --budget and --error for each scene and setting
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 20)]
    pub seeds: u32,

    /// Runs that are timed, for each scene and setting
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub runs: u32,

    /// Samples a pixel that --budget is tried with, at least 2
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::two_or_more(), default_value = "16,64")]
    pub samples: Vec<u32>,

    /// Errors that --error is tried with
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::above_zero, default_value = "0.02,0.01")]
    pub errors: Vec<f64>,

    /// Seconds that --time is tried with
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::above_zero, default_value = "0.5")]
    pub times: Vec<f64>,

    /// Try only these promises
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<Promise>,

    /// Size of all images in pixels
    #[arg(long, value_name = "WxH", default_value = "96x72")]
    pub size: Size,

    /// Confidence of the promises, in (0, 1)
    #[arg(long, value_name = "P", value_parser = values::confidence, default_value_t = 0.95)]
    pub confidence: f64,

    /// Write the tables to this file, not to standard output
    #[arg(short, long, value_name = "FILE.md")]
    pub output: Option<PathBuf>,

    /// Write every trial as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

/// A promise of `whitted render`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Promise {
    /// --budget: the error lies within its parts
    Budget,
    /// --error: the image is as good as that
    Error,
    /// --time: the image is there in time
    Time,
}

/// `whitted stress`.
#[derive(Debug, Args)]
pub struct StressArgs {
    /// Run only these cases
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,

    /// List the cases
    #[arg(long)]
    pub list: bool,

    /// Arithmetic: `fast`, `robust` or `f64`
    #[arg(long, value_name = "WHICH", value_parser = values::precision, default_value = "robust")]
    pub precision: Precision,

    /// Write figures, bounds and verdicts as JSON
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,

    /// Measure more (a fixed epsilon, f32 against f64, the cost of protections) and write all as a page of Markdown with pictures beside it
    #[arg(long, value_name = "FILE.md")]
    pub page: Option<PathBuf>,

    /// Run under the Vulkan validation layer; any message is a failure
    #[arg(long)]
    pub validate: bool,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
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

    /// Work that goes into the hierarchy of a large scene: `fast`, `balanced` or `best`
    #[arg(long, value_name = "WHICH", value_parser = values::hierarchy, default_value = "balanced")]
    pub bvh: Hierarchy,
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

/// `whitted devices`.
#[derive(Debug, Args)]
#[command(after_help = DEVICES_HELP)]
pub struct DevicesArgs {
    /// As a JSON array on standard output
    #[arg(long)]
    pub json: bool,
}

/// `whitted sweep`.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_HELP.as_str())]
pub struct SweepArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// What to vary: all combinations are rendered; the axes are below
    #[arg(long, value_name = "AXIS=VALUES", num_args = 1.., required = true)]
    pub over: Vec<Axis>,

    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// Renders of each point after a warm-up; one that takes over 10 s is rendered once
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub repeats: u32,

    /// Errors (RMSE) to name the cheapest point for
    #[arg(long, value_name = "E,E", value_delimiter = ',', value_parser = values::above_zero, default_value = "0.1,0.03,0.01,0.003,0.001,0.0003,0.0001")]
    pub error: Vec<f64>,

    /// Most samples of a pixel of the truth; it stops earlier once it is ten times better than every point
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 4096)]
    pub truth_samples: u32,

    /// Judge by the oracle on the CPU, which shares only the sampler with the kernels, also where the device has f64; slow
    #[arg(long)]
    pub oracle: bool,

    /// Forget what an earlier sweep left in DIR
    #[arg(long)]
    pub fresh: bool,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

/// `whitted gallery`.
#[derive(Debug, Args)]
#[command(after_help = GALLERY_HELP)]
pub struct GalleryArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Factor on the width and height of every picture, in (0, 1]
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = values::scale)]
    pub scale: f64,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub seed: u32,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
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
        assert_eq!((args.seed, args.samples, args.depth, args.validate), (0, None, None, false));
    }
}
