//! The frames of `whitted render`, one after another on one device.

use super::render::{Device, picture};
use crate::cli::args::{Output, RenderArgs};
use crate::cli::console::Console;
use crate::cli::failure::{Code, Failure};
use crate::cli::progress::interrupted;
use crate::cli::state::StateFile;
use std::path::PathBuf;
use std::time::Instant;

/// Renders `frames`, at least one. After a frame that fails the others follow, unless none could.
pub(super) fn run(
    args: &RenderArgs,
    frames: &[u32],
    started: Instant,
    console: &mut Console,
) -> Result<(), Failure> {
    check(args, frames)?;
    let mut device = Device::default();
    let mut first: Option<(u32, Failure)> = None;
    let (mut failed, mut from) = (0, started);
    for (i, &frame) in frames.iter().enumerate() {
        let args = args.of_frame(frame);
        if args.frames.skip_existing && is_done(&args) {
            console.say(&format!("frame {frame}: there"));
            continue;
        }
        let result = match interrupted() {
            true => Err(Failure::Interrupted("interrupted".into())),
            false => picture(&args, &mut device, from, console),
        };
        from = Instant::now();
        match result {
            Ok(()) => {}
            Err(Failure::Interrupted(why)) if frames.len() > 1 => {
                let left = frames.len() - i;
                return Err(Failure::Interrupted(format!(
                    "frame {frame}: {why}\n{left} of {} frames are left: the same command with --skip-existing --resume \
                     continues",
                    frames.len()
                )));
            }
            Err(failure) if ends_all(&failure) || frames.len() == 1 => return Err(failure),
            Err(failure) => {
                console.error(&format!("error: frame {frame}: {}", failure.message()));
                failed += 1;
                first.get_or_insert((frame, failure));
            }
        }
    }
    match first {
        None => Ok(()),
        Some((frame, failure)) => {
            Err(Failure::Frames { failed, of: frames.len(), frame, code: failure.code() })
        }
    }
}

/// Every frame needs files of its own.
fn check(args: &RenderArgs, frames: &[u32]) -> Result<(), Failure> {
    if frames.len() == 1 {
        return Ok(());
    }
    let image = match &args.output {
        Output::Stdout => {
            return Err(Failure::Usage("--frames writes files: -o needs a name such as a_####.png".into()));
        }
        Output::File(path, _) | Output::Share(path) => Some(path),
    };
    let files = [("-o", image), ("--report", args.report.as_ref()), ("--page", args.page.as_ref())];
    let same = |path: &PathBuf| !path.to_str().is_some_and(|name| name.contains('#'));
    match files.into_iter().find_map(|(option, path)| Some((option, path.filter(|p| same(p))?))) {
        None => Ok(()),
        Some((option, path)) => Err(Failure::Usage(format!(
            "every frame would write {}: {option} needs `####` in its name",
            path.display()
        ))),
    }
}

/// True if the image is there and whole.
fn is_done(args: &RenderArgs) -> bool {
    let (Output::File(path, _) | Output::Share(path)) = &args.output else { return false };
    path.exists() && !StateFile::of(path, true).exists()
}

/// True if no other frame can succeed either.
fn ends_all(failure: &Failure) -> bool {
    matches!(failure.code(), Code::NoDevice | Code::DeviceLost | Code::Interrupted)
}
