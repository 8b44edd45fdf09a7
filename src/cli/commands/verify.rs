//! `whitted verify`.

use super::plan::report;
use crate::accuracy::promise::{Request, Target};
use crate::atomic_file;
use crate::cli::args::{ReadArgs, Size, VerifyArgs};
use crate::cli::console::Console;
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::compare::metrics::rmse;
use crate::image::{
    Bits, Format, Metadata, Picture, described, heat, is_picture, linear_sha256, read_metadata,
};
use crate::render::Renderer;
use crate::report::{DeviceInfo, ErrorInfo, Report};
use crate::scene::Scene;
use crate::settings::{Schedule, Settings};
use crate::units::{figure, plural};
use anyhow::{Context, anyhow};
use std::path::{Path, PathBuf};

/// Pixels that are listed.
const LISTED: usize = 10;

/// Draws a picture again and says how it differs.
pub fn run(args: &VerifyArgs, console: &mut Console) -> Result<(), Failure> {
    files(args).check()?;
    let then = then(&args.report)?;
    let bounded = then.error.is_some();
    if then.asked.error.is_some() || then.asked.time.is_some() {
        return Err(Failure::Usage(format!(
            "the samples of {} were chosen pixel by pixel, and nothing tells them: render with settings of `plan --error` \
             to be able to verify",
            then.image.file
        )));
    }
    let settings = then
        .settings
        .to_settings(Schedule::default())
        .map_err(|why| Failure::Usage(format!("{} cannot be drawn again: {why}", args.report.display())))?;
    let picture = picture(args, &then)?;
    let scene = scene(args, &then, console)?;
    files(args).reads_scene(&scene).check()?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let drawn = draw(&mut renderer, &scene, &settings, bounded.then_some(&then), console)?;
    let device = renderer.device().info();
    // A picture's metadata has no hash.
    let hash = then.image.linear_sha256.is_empty() || linear_sha256(&drawn) == then.image.linear_sha256;
    let same_device = is_device(&device, &then.device);

    let Some((path, picture)) = picture else {
        return match (hash, same_device) {
            (true, _) => {
                console.say("same bits: the hash of the report; there is no picture to look at");
                Ok(())
            }
            (false, same) => Err(Failure::AboveThreshold(format!(
                "different: the hash is not that of the report{}; give the --picture to see where",
                if same { "" } else { ", which is of another device" }
            ))),
        };
    };
    let [x0, y0, x1, y1] = settings.region();
    if (picture.width, picture.height) != (x1 - x0, y1 - y0) {
        return Err(Failure::AboveThreshold(format!(
            "different: {} has {}x{} pixels, and the report is of {}x{}",
            path.display(),
            picture.width,
            picture.height,
            x1 - x0,
            y1 - y0
        )));
    }
    let format = format(&path, &picture)?;
    let stored: Vec<[f32; 3]> = drawn.iter().map(|pixel| format.stored(*pixel)).collect();
    let wrong: Vec<usize> =
        (0..stored.len()).filter(|at| !same_bits(stored[*at], picture.linear[*at])).collect();
    if wrong.is_empty() {
        let of = |hash: bool| match hash {
            true => "",
            false => "; but the hash in the report is another one: the report is not of this picture",
        };
        let text = format!("same bits: {}{}", path.display(), of(hash));
        console.say(&text);
        return if hash { Ok(()) } else { Err(Failure::AboveThreshold(text)) };
    }
    let count = plural(wrong.len() as u64, "pixel");
    list(&wrong, &picture, &stored, [x0, y0], console);
    if let Some(out) = &args.diff {
        paint(out, &picture, &stored, &then)?;
        console.say(&format!("difference: {}", out.display()));
    }
    let found = rmse(&stored, &picture.linear).map_err(anyhow::Error::from)?;
    let differs = format!("{count} of {} differ, RMSE {}", path.display(), figure(found));
    if same_device {
        return Err(Failure::AboveThreshold(format!(
            "different: {differs}, although device and driver are those of the report"
        )));
    }
    let then_device = |d: &DeviceInfo| format!("{}, {}", d.name, d.driver);
    let devices = format!("drawn on {}, here on {}", then_device(&then.device), then_device(&device));
    match bound(&mut renderer, &scene, &settings, console)? {
        None => Err(Failure::AboveThreshold(format!(
            "different: {differs}; {devices}; how much rounding may do is unknown, since this device has no f64"
        ))),
        Some(most) if found <= most => {
            console.say(&format!("within the bound: {differs}, at most {} allowed; {devices}", figure(most)));
            Ok(())
        }
        Some(most) => Err(Failure::AboveThreshold(format!(
            "different: {differs}, more than the {} that rounding explains; {devices}",
            figure(most)
        ))),
    }
}

/// What is to be drawn again: a report, or what a picture says of itself.
fn then(path: &Path) -> Result<Report, Failure> {
    if !is_picture(path) {
        return report(path);
    }
    let mut then = described(&read_metadata(path)).ok_or_else(|| {
        Failure::Usage(format!(
            "{} does not say how it was rendered: give the report that `--report` wrote",
            path.display()
        ))
    })?;
    then.image.file = path.display().to_string();
    Ok(then)
}

/// True if `now` has the name, driver and Vulkan version of `then`. The metadata of a picture has no type: an empty one
/// matches any.
fn is_device(now: &DeviceInfo, then: &DeviceInfo) -> bool {
    let kind = then.kind.is_empty() || then.kind == now.kind;
    kind && (&now.name, &now.driver, &now.api) == (&then.name, &then.driver, &then.api)
}

/// Its files, without those that the report and the scene name.
fn files(args: &VerifyArgs) -> Files {
    let files = Files::new().reads("the report", &args.report);
    let files = args.scene.iter().fold(files, |files, scene| files.reads("--scene", scene));
    let files = args.picture.iter().fold(files, |files, picture| files.reads("--picture", picture));
    files.writes("--diff", args.diff.as_deref())
}

/// The scene of the report, with its variables.
fn scene(args: &VerifyArgs, then: &Report, console: &mut Console) -> Result<Scene, Failure> {
    let path = args.scene.clone().unwrap_or_else(|| PathBuf::from(&then.scene.file));
    let pair = |text: &String| text.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
    let variables = then.scene.variables.iter().filter_map(pair).collect();
    let size = Size { width: then.settings.width, height: then.settings.height };
    let up = match then.scene.up.as_deref().map(str::parse) {
        Some(Err(why)) => return Err(Failure::Usage(format!("the report's `up`: {why}"))),
        up => up.and_then(Result::ok),
    };
    read::scene(&path, &ReadArgs { variables, up, ..ReadArgs::default() }, Some(size), console)
}

/// The picture to look at. That of the report may have been moved.
fn picture(args: &VerifyArgs, then: &Report) -> Result<Option<(PathBuf, Picture)>, Failure> {
    let path = match &args.picture {
        Some(path) => path.clone(),
        None => PathBuf::from(&then.image.file),
    };
    let is_image = Format::of(&path).is_some() && path.exists();
    if args.picture.is_none() && !is_image {
        return Ok(None);
    }
    let picture = Picture::read(&path).map_err(|error| Failure::Other(error.into()))?;
    Ok(Some((path, picture)))
}

/// How the picture is stored.
fn format(path: &Path, picture: &Picture) -> Result<Format, Failure> {
    match (picture.encoding, Format::of(path)) {
        ("8-bit sRGB", _) => Ok(Format::Png(Bits::Eight)),
        ("16-bit sRGB", _) => Ok(Format::Png(Bits::Sixteen)),
        (_, Some(format)) => Ok(format),
        (_, None) => {
            Err(Failure::Usage(format!("{}: the extension must be {}", path.display(), Format::EXTENSIONS)))
        }
    }
}

/// The linear image of the report `bounded`, or of a plain render.
fn draw(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    bounded: Option<&Report>,
    console: &Console,
) -> Result<Vec<[f32; 3]>, Failure> {
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut progress = Progress::new(style, "drawing again");
    let (linear, done) = match bounded {
        None => {
            let rendered = renderer.render_with(scene, settings, &mut progress)?;
            (rendered.linear, rendered.done)
        }
        Some(report) => {
            let confidence = report.error.as_ref().map_or(0.95, |e| e.confidence);
            let request = Request { confidence, ..Request::to(Target::Settings) };
            let image = renderer.render_bounded_with(scene, settings, &request, &mut progress)?;
            (image.linear(), if image.cancelled { 0.0 } else { image.done })
        }
    };
    match done {
        1.0 => Ok(linear),
        _ => Err(Failure::Interrupted("interrupted; nothing was verified".into())),
    }
}

/// The RMSE that two devices may differ by, from the samples of one in f32 and f64. Values round on both, so twice that.
/// W samples take another way, which changes a pixel of n samples by 1/n at most: as many on each device, and three
/// standard errors of their number more.
fn bound(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    console: &Console,
) -> Result<Option<f64>, Failure> {
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut progress = Progress::new(style, "bounding the rounding");
    // Samples are told apart from two on.
    let samples = settings.samples.max(2);
    let settings = Settings { samples, replicates: 1, ..settings.clone() };
    let image =
        renderer.render_bounded_with(scene, &settings, &Request::to(Target::Settings), &mut progress)?;
    if image.cancelled {
        return Err(Failure::Interrupted("interrupted; nothing was verified".into()));
    }
    let Some(ErrorInfo { rounding_values: Some(values), rounding_pixels: Some(ways), .. }) =
        image.report.error
    else {
        return Ok(None);
    };
    let ways = 2.0 * ways as f64;
    let ways = ways + 3.0 * ways.sqrt() + 3.0;
    let (n, pixels) = (f64::from(settings.samples), image.samples.samples.len() as f64);
    Ok(Some(((2.0 * values).powi(2) + ways / (n * n * pixels)).sqrt()))
}

fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(f32::to_bits) == b.map(f32::to_bits)
}

/// Says where the first pixels are that differ, in coordinates of the whole image.
fn list(wrong: &[usize], picture: &Picture, drawn: &[[f32; 3]], [x0, y0]: [u32; 2], console: &mut Console) {
    let width = picture.width as usize;
    for at in wrong.iter().take(LISTED) {
        let (x, y) = (at % width + x0 as usize, at / width + y0 as usize);
        let ([a, b, c], [d, e, f]) = (picture.linear[*at], drawn[*at]);
        console.say(&format!("pixel ({x}, {y}): {a} {b} {c} in the picture, {d} {e} {f} drawn again"));
    }
    if wrong.len() > LISTED {
        console.say(&format!("and {} more", plural((wrong.len() - LISTED) as u64, "pixel")));
    }
}

/// The greatest difference of each pixel's channels.
fn paint(out: &Path, picture: &Picture, drawn: &[[f32; 3]], report: &Report) -> Result<(), Failure> {
    let difference = |(a, b): (&[f32; 3], &[f32; 3])| {
        (0..3).fold(0.0f64, |most, c| most.max((f64::from(a[c]) - f64::from(b[c])).abs()))
    };
    let values: Vec<f64> = picture.linear.iter().zip(drawn).map(difference).collect();
    let painted = heat::paint(&values, picture.width, heat::Range::Auto, "difference, linear light");
    let metadata = Metadata::of(report, 1.0);
    atomic_file::write(out, |to| painted.write(&metadata, to))
        .with_context(|| anyhow!("cannot write {}", out.display()))?;
    Ok(())
}
