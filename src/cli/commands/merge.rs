//! `whitted merge`.

use crate::atomic_file;
use crate::cli::args::MergeArgs;
use crate::cli::console::Console;
use crate::cli::delivery::write_json;
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::state::KeptState;
use crate::image::{Bits, Metadata, View};
use crate::render::Merge;
use crate::report::text;
use anyhow::Context;
use std::time::Instant;

/// Joins shares to their image.
pub fn run(args: &MergeArgs, started: Instant, console: &mut Console) -> Result<(), Failure> {
    let (path, format) = &args.output;
    let format = match (args.bits.as_deref(), format) {
        (None, format) => *format,
        (Some(bits), format) => {
            let bits = if bits == "16" { Bits::Sixteen } else { Bits::Eight };
            let apply = || Failure::Usage("--bits applies to PNG and PPM only".into());
            format.with_bits(bits).ok_or_else(apply)?
        }
    };
    files(args).check()?;
    // One after the other: all of them at once would need the memory of as many images.
    let mut merge = Merge::new(args.mixed_devices);
    for share in &args.shares {
        let state = KeptState::share(share).read()?;
        merge.add(&share.display().to_string(), state).map_err(anyhow::Error::from)?;
    }
    let mut rendered = merge.finish().map_err(anyhow::Error::from)?;
    if let Some(state) = rendered.state.take().filter(|_| args.keep_state) {
        KeptState::of(path).write(&state)?;
    }
    let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
    let report = &mut rendered.report;
    report.image.file = path.display().to_string();
    let metadata = Metadata::of(report, 1.0);
    atomic_file::write(path, |out| format.encode(view, &metadata, out))
        .with_context(|| format!("cannot write {}", path.display()))?;
    report.time.wall += started.elapsed().as_secs_f64();
    if let Some(path) = &args.report {
        write_json(path, report)?;
    }
    if console.is_verbose() {
        console.say(&text::report(report));
    }
    console.say(&text::summary(report));
    for line in text::warnings(report) {
        console.say(&line);
    }
    match rendered.fault() {
        Some(why) => Err(Failure::Unsound(format!("{why}; it is in {}", path.display()))),
        None => Ok(()),
    }
}

/// Its files.
fn files(args: &MergeArgs) -> Files {
    let files = args.shares.iter().fold(Files::new(), |files, share| files.reads("the share", share));
    let files = files.writes("-o", Some(&args.output.0)).writes("--report", args.report.as_deref());
    match args.keep_state {
        true => files.writes("the kept state", Some(KeptState::of(&args.output.0).path())),
        false => files,
    }
}
