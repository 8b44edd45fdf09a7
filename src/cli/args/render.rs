//! `whitted render`.

use super::values::{self, Crop, Output, Size};
use super::{DeviceArgs, FrameArgs, ReadArgs, ScheduleArgs, Verbosity};
use crate::accuracy::promise::Layer;
use crate::settings::sampler::Sampler;
use crate::settings::{Origin, Precision, parse_cutoff};
use clap::Args;
use std::path::PathBuf;

const RENDER_HELP: &str = "\
Only the image of `-o -` goes to standard output; messages go to standard error. Files appear whole or \
not at all. Ctrl-C stops after the work in flight, keeps the finished part in OUT.partial and the pixels \
as they are in OUT.incomplete.png, and exits with 130; a second Ctrl-C after a second or more ends at \
once and saves nothing. The same command with --resume continues and gives the same image, bit for bit. \
--time keeps nothing to resume from.

Examples:
  whitted render scenes/cornell.toml -o cornell.png
  whitted render scenes/cornell.toml -o small.exr --size 300x250 --samples 4 -v
  whitted render scenes/cornell.toml -o part.png --crop 100,100,200,160 --report part.json
  whitted render scenes/cornell.toml -o good.png --error 0.01
  whitted render scenes/cornell.toml -o known.png --aov sampling,cost --page known.html
  whitted render scenes/cornell.toml -o quick.png --time 2
  whitted render scenes/cornell.toml -o curve.png --reference good.exr --page curve.html
  whitted render scenes/cornell.toml -o - --device cpu | convert - cornell.webp
  whitted render model.obj -o model.png
  whitted render turning.toml -o turn_####.png --frames 0..35 --skip-existing --resume
  generate | whitted render - -o made.png -D radius=2";

/// `whitted render`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::notes(RENDER_HELP))]
pub struct RenderArgs {
    /// Scene text (TOML), or a model; `-` for a scene on standard input
    pub scene: PathBuf,

    /// Image to write: .png, .exr, .hdr, .ppm or .pfm; `-` for a PNG on standard output
    #[arg(short, long, value_name = "FILE", value_parser = values::output(), help_heading = "Output")]
    pub output: Output,

    /// Size, samples, depth and the like.
    #[command(flatten)]
    pub picture: PictureArgs,

    /// The error of the image.
    #[command(flatten)]
    pub accuracy: AccuracyArgs,

    /// Bits per channel of a PNG or PPM [default: 8]
    #[arg(long, value_parser = ["8", "16"], help_heading = "Output")]
    pub bits: Option<String>,

    /// Write times, rays and settings as JSON
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub report: Option<PathBuf>,

    /// Write one page with picture, layers, error, passes and settings, which needs no other file (HTML)
    #[arg(long, value_name = "OUT.html", value_parser = values::html(), help_heading = "Output")]
    pub page: Option<PathBuf>,

    /// Also write render and wall time into the image's metadata; without it, equal renders give equal files
    #[arg(long, help_heading = "Output")]
    pub record_time: bool,

    /// Afterwards print the plan, the time of each part, and the measured cost of each feature that the scene does not need; takes some seconds more
    #[arg(long, conflicts_with_all = ["resume", "error", "time", "budget", "aov"], help_heading = "Output")]
    pub receipt: bool,

    /// Continue an interrupted render from OUT.partial; start anew if there is none
    #[arg(long, help_heading = "Output")]
    pub resume: bool,

    /// Run under the Vulkan validation layer; any message is a failure
    #[arg(long, help_heading = "Device")]
    pub validate: bool,

    /// How files are read.
    #[command(flatten)]
    pub read: ReadArgs,

    /// Frames of a moving scene.
    #[command(flatten)]
    pub frames: FrameArgs,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How the work is divided.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// Messages.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

/// What a picture is made of. The scene file gives the defaults.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// Samples per pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = values::samples())]
    pub samples: Option<u32>,

    /// Rays in the longest path; 1 = neither reflection nor refraction [default: the scene's]
    #[arg(long, value_name = "D", value_parser = values::depth())]
    pub depth: Option<u32>,

    /// Do not trace rays that carry less than this share of their light to the pixel, in [0, 1)
    #[arg(long, value_name = "T", value_parser = parse_cutoff, default_value_t = 0.0)]
    pub cutoff: f32,

    /// Positions of the samples in a pixel: `random`, `stratified` (jittered) or `owen` (scrambled Sobol points)
    #[arg(long, value_name = "WHICH", default_value = "owen")]
    pub sampler: Sampler,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub seed: u32,

    /// Arithmetic: `fast` f32, `robust` f32 with exact rechecks, `f64`, or `auto`: robust, or f64 where the scene needs it [default: auto]
    #[arg(long, value_name = "WHICH")]
    pub precision: Option<Precision>,

    /// Origin of secondary rays: `bound` (moved off the surface by an error bound) or `fixed:X` (moved X metres along the ray, for measurements)
    #[arg(long, value_name = "WHICH", default_value = "bound")]
    pub origin: Origin,

    /// Render only pixels x0 <= x < x1, y0 <= y < y1; the image has that size
    #[arg(long, value_name = "x0,y0,x1,y1")]
    pub crop: Option<Crop>,
}

/// The error of the image.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Accuracy")]
pub struct AccuracyArgs {
    /// State the error of the image in four parts: sampling, truncation, rounding
    #[arg(long)]
    pub budget: bool,

    /// Choose samples, depth and precision for an RMSE of at most E, in linear light from 0 to 1
    #[arg(long, value_name = "E", value_parser = values::above_zero, conflicts_with_all = ["samples", "time", "cutoff", "replicates"])]
    pub error: Option<f64>,

    /// Choose samples and depth for the least error in T seconds of wall time
    #[arg(long, value_name = "T", value_parser = values::above_zero, conflicts_with_all = ["samples", "cutoff", "resume", "replicates"])]
    pub time: Option<f64>,

    /// Confidence of the stated error, in (0, 1)
    #[arg(long, value_name = "P", value_parser = values::confidence, default_value_t = 0.95)]
    pub confidence: f64,

    /// Also write a value per pixel: any of sampling, truncation, rounding, rounding-paths, samples, depth, cost (rays), tests (of boxes and primitives); as channels of an EXR, as OUT.LAYER.png beside other formats
    #[arg(long, value_name = "LAYERS", value_delimiter = ',')]
    pub aov: Vec<Layer>,

    /// Compare the image on its way with this picture: RMSE against time and rays, in the report, on the page and with -v; the image is traced in rounds of 1, 1, 2, 4, ... samples, to the same bits
    #[arg(long, value_name = "TRUTH", conflicts_with_all = ["resume", "receipt"])]
    pub reference: Option<PathBuf>,

    /// Independent sets that the samples of a pixel are divided into; must divide the samples. More sets are less even: the error bound of 1 needs none [default: 1]
    #[arg(long, value_name = "R", value_parser = values::positive())]
    pub replicates: Option<u32>,
}
