//! `whitted render`.

use super::values::{self, Crop, Output, Size};
use super::{DeviceArgs, FrameArgs, ReadArgs, ScheduleArgs, Verbosity};
use crate::accuracy::promise::Layer;
use crate::cli::progress::Style;
use crate::render::SurfaceLayer;
use crate::settings::sampler::Sampler;
use crate::settings::{Origin, Precision, Share, parse_cutoff};
use clap::Args;
use std::path::PathBuf;

const RENDER_HELP: &str = "\
Only the image of `-o -` goes to standard output; messages go to standard error. Files appear whole or \
not at all. Ctrl-C stops after the work in flight, keeps its state in OUT.partial and the pixels as they \
are in OUT.incomplete.png, and exits with 130; a second Ctrl-C after a second or more ends at once and \
saves nothing. The state is written every few seconds too, so that a crash costs no more. The same command \
with --resume continues and gives the same image, bit for bit. --time then goes on for what is left of \
its time.

--share divides an image among machines: each renders one share, and `whitted merge` writes the bytes \
that one render would have written.

Examples:
  whitted render scenes/cornell.toml -o cornell.png
  whitted render scenes/cornell.toml -o small.exr --size 300x250 --samples 4 -v
  whitted render scenes/cornell.toml -o part.png --crop 100,100,200,160 --report part.json
  whitted render scenes/cornell.toml -o good.png --error 0.01
  whitted render scenes/cornell.toml -o known.png --aov sampling,cost --page known.html
  whitted render scenes/cornell.toml -o quick.png --time 2
  whitted render model.glb -o layers.exr --alpha --layers z,normal,object
  whitted render scenes/cornell.toml -o curve.png --reference good.exr --page curve.html
  whitted render scenes/cornell.toml -o part-2.share --share 2/8
  whitted render scenes/cornell.toml -o part-2.share --share 2/8 --as plan.json
  whitted render scenes/cornell.toml -o a.exr --samples 64 --keep-state
  whitted render scenes/cornell.toml -o a.exr --samples 256 --continue
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

    /// Image to write: .png, .exr, .hdr, .ppm or .pfm; `-` for a PNG on standard output; with --share, a file .share
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

    /// Write how much of each pixel is covered as alpha, and leave out the background behind it: PNG and EXR; of fixed samples only
    #[arg(long, conflicts_with_all = ["error", "time", "budget", "aov", "share", "reference"], help_heading = "Output")]
    pub alpha: bool,

    /// Also write what the first surfaces are: any of z (distance along the view), normal, albedo, object, material (their numbers); as channels of an EXR, as OUT.LAYER.png beside other formats
    #[arg(
        long,
        value_name = "LAYERS",
        value_delimiter = ',',
        conflicts_with = "share",
        help_heading = "Output"
    )]
    pub layers: Vec<SurfaceLayer>,

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
    #[arg(long, help_heading = "Resuming and sharing")]
    pub resume: bool,

    /// Seconds between two states of long work in OUT.partial, which is all that a crash loses; 0 keeps none
    #[arg(long, value_name = "T", value_parser = values::not_negative, default_value_t = 5.0, help_heading = "Resuming and sharing")]
    pub checkpoint: f64,

    /// Also write OUT.state, from which --continue adds samples: 24 bytes a pixel
    #[arg(long, conflicts_with_all = ["error", "time", "budget", "aov"], help_heading = "Resuming and sharing")]
    pub keep_state: bool,

    /// Add samples to the finished picture of OUT.state, up to --samples: the same bits as of one longer render
    #[arg(long = "continue", conflicts_with_all = ["error", "time", "budget", "aov", "receipt", "reference"], help_heading = "Resuming and sharing")]
    pub more: bool,

    /// Render share I of N, to OUT.share; `whitted merge` joins all shares to the picture
    #[arg(long, value_name = "I/N", conflicts_with_all = ["error", "time", "budget", "aov", "receipt", "reference", "page"], help_heading = "Resuming and sharing")]
    pub share: Option<Share>,

    /// Run under the Vulkan validation layer; any message is a failure
    #[arg(long, help_heading = "Device")]
    pub validate: bool,

    /// How files are read.
    #[command(flatten)]
    pub read: ReadArgs,

    /// Frames of a moving scene.
    #[command(flatten)]
    pub frames: FrameArgs,

    /// Take all settings from the JSON of `plan` or of a report, so that all shares have the same
    #[arg(long = "as", value_name = "PLAN.json", conflicts_with_all = ["size", "samples", "depth", "cutoff", "sampler", "seed", "precision", "origin", "crop", "replicates", "error", "time"], help_heading = "Resuming and sharing")]
    pub settings_of: Option<PathBuf>,

    /// How progress is shown: bar, plain (lines), json (an object a line), both on standard error, openjd (Open Job Description, on standard output) or none [default: a bar on a terminal]
    #[arg(long, value_name = "HOW", help_heading = "Messages")]
    pub progress: Option<Style>,

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
    #[arg(long, value_name = "T", value_parser = values::above_zero, conflicts_with_all = ["samples", "cutoff", "replicates"])]
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
