//! Two folders of pictures, compared name by name.

use super::pair::{Criteria, Figures, Judged, Pair};
use super::tell;
use crate::atomic_file;
use crate::cli::args::{CompareArgs, Metric};
use crate::cli::commands::command_line;
use crate::cli::console::Console;
use crate::cli::failure::Failure;
use crate::compare::statistical::{self, Statistics};
use crate::image::Format;
use crate::lab::suite::{self, Entry, Measured, Outcome, Shown, Suite};
use crate::report::ProgramInfo;
use crate::report::table::{Align, Table};
use crate::units::{figure, grouped, number, plural};
use anyhow::{Context, anyhow};
use serde::Serialize;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct Comparison {
    program: ProgramInfo,
    a: String,
    b: String,
    /// The worst first.
    pairs: Vec<PairRecord>,
    /// Number of pairs that were not accepted.
    failed: usize,
}

/// One name.
#[derive(Debug, Serialize)]
struct PairRecord {
    /// Path in both folders.
    file: String,
    failed: bool,
    /// Reason of the failure.
    why: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    metrics: Option<Figures>,
    #[serde(skip_serializing_if = "Option::is_none")]
    judged: Option<Judged>,
    #[serde(skip_serializing_if = "Option::is_none")]
    statistical: Option<Statistics>,
    /// Pictures for the page.
    #[serde(skip)]
    shown: Option<Shown>,
    #[serde(skip)]
    size: [u32; 2],
}

/// Compares all pictures below two folders.
pub(super) fn run(args: &CompareArgs, console: &mut Console) -> Result<(), Failure> {
    if args.diff.is_some() {
        return Err(Failure::Usage("--diff shows two pictures; use -o PAGE.html for two folders".into()));
    }
    let (in_a, in_b) = (names(&args.a)?, names(&args.b)?);
    let all: BTreeSet<&PathBuf> = in_a.union(&in_b).collect();
    if all.is_empty() {
        return Err(Failure::Other(anyhow!(
            "neither {} nor {} has a picture with the extension {}",
            args.a.display(),
            args.b.display(),
            Format::EXTENSIONS
        )));
    }
    // All pairs together raise a false alarm with the probability asked for.
    let each = Criteria::of(args);
    let significance = each.significance.map(|p| statistical::corrected(p, all.len() as u64));
    let criteria = Criteria { significance, ..each };
    let mut pairs = Vec::with_capacity(all.len());
    for name in all {
        let record = match (in_a.contains(name), in_b.contains(name)) {
            (true, true) => compared(name, args, &criteria)?,
            (true, false) => PairRecord::failure(name, format!("not in {}", args.b.display())),
            _ => PairRecord::failure(name, format!("not in {}", args.a.display())),
        };
        pairs.push(record);
    }
    pairs.sort_by(|x, y| y.badness(args.metric).total_cmp(&x.badness(args.metric)));
    if let Some(path) = &args.output {
        let page = suite::page(&suite(args, &mut pairs));
        atomic_file::write(path, |out| out.write_all(page.as_bytes()))
            .with_context(|| format!("cannot write {}", path.display()))?;
        console.say(&format!("page: {}", path.display()));
    }
    let failed = pairs.iter().filter(|p| p.failed).count();
    let of = plural(pairs.len() as u64, "picture");
    let [a, b] = [&args.a, &args.b].map(|path| path.display().to_string());
    let comparison = Comparison { program: ProgramInfo::default(), a, b, pairs, failed };
    tell(args, &text(&comparison, args), &comparison, console)?;
    match failed {
        0 => Ok(()),
        n => Err(Failure::AboveThreshold(format!("{of}, {}", plural(n as u64, "failure")))),
    }
}

/// Paths of the pictures below a folder, relative to it. Links to folders are not followed.
pub(super) fn names(folder: &Path) -> Result<BTreeSet<PathBuf>, Failure> {
    let mut found = BTreeSet::new();
    let mut open = vec![folder.to_owned()];
    while let Some(inner) = open.pop() {
        let read = || format!("cannot read the folder {}", inner.display());
        for entry in fs::read_dir(&inner).with_context(read)? {
            let entry = entry.with_context(read)?;
            let path = entry.path();
            if entry.file_type().with_context(read)?.is_dir() {
                open.push(path);
            } else if Format::of(&path).is_some() {
                // Every path below begins with the folder's.
                found.insert(path.strip_prefix(folder).unwrap_or(&path).to_owned());
            }
        }
    }
    Ok(found)
}

/// Compares one pair. Pictures that cannot be compared are a failure of the pair, not of the command.
fn compared(name: &Path, args: &CompareArgs, criteria: &Criteria) -> Result<PairRecord, Failure> {
    let pair = match Pair::of(&args.a.join(name), &args.b.join(name), criteria) {
        Ok(pair) => pair,
        Err(failure) => return Ok(PairRecord::failure(name, failure.message())),
    };
    let shown = match &args.output {
        Some(path) => Some(
            Shown::of(&pair.a, &pair.b)
                .with_context(|| format!("cannot encode {} for {}", name.display(), path.display()))?,
        ),
        None => None,
    };
    let why = pair.refusal();
    Ok(PairRecord {
        file: slashes(name),
        failed: why.is_some(),
        why,
        size: [pair.a.width, pair.a.height],
        metrics: Some(pair.figures),
        judged: Some(pair.judged),
        statistical: pair.statistics,
        shown,
    })
}

impl PairRecord {
    fn failure(name: &Path, why: String) -> PairRecord {
        PairRecord {
            file: slashes(name),
            failed: true,
            why: Some(why),
            metrics: None,
            judged: None,
            statistical: None,
            shown: None,
            size: [0; 2],
        }
    }

    /// Largest |z| of a statistical test; 0 for equal pictures.
    fn z(&self) -> Option<f64> {
        self.statistical.as_ref().map(|s| s.worst.as_ref().map_or(0.0, |w| w.z.abs()))
    }

    /// Larger is worse: |z| under a statistical test, else the metric; infinite if there is none.
    fn badness(&self, metric: Metric) -> f64 {
        match (&self.statistical, &self.judged) {
            (Some(s), _) if s.exact && s.significant => f64::INFINITY,
            (Some(s), _) => s.worst.as_ref().map_or(0.0, |w| w.z.abs() / s.threshold),
            (None, None) => f64::INFINITY,
            (None, Some(judged)) => match (metric, judged.value) {
                (Metric::Psnr, value) => value.map_or(f64::NEG_INFINITY, |db| -db),
                (_, value) => value.unwrap_or(0.0),
            },
        }
    }
}

/// A relative path as it is written on every system.
fn slashes(path: &Path) -> String {
    path.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// How pairs are judged.
fn criterion(args: &CompareArgs) -> String {
    let judged = match (args.significance(), args.threshold) {
        (Some(p), _) => format!("a difference beyond noise, significance {} over all pictures", number(p)),
        (None, Some(x)) => {
            let side = if args.metric == Metric::Psnr { "below" } else { "above" };
            format!("{} {side} {}", args.metric.name(), number(x))
        }
        (None, None) => return "a picture without a partner, or one that cannot be compared".into(),
    };
    format!("{judged}; a picture without a partner, or one that cannot be compared")
}

/// What the page shows. Takes the pictures.
fn suite(args: &CompareArgs, pairs: &mut [PairRecord]) -> Suite {
    let judges = args.statistical || args.threshold.is_some();
    let entries = pairs.iter_mut().map(|p| Entry {
        name: p.file.clone(),
        outcome: match &p.why {
            Some(why) => Outcome::Failed(why.clone()),
            None if judges => Outcome::Passed,
            None => Outcome::Measured,
        },
        measured: p.metrics.as_ref().map(|figures| Measured {
            size: p.size,
            metrics: figures.plain,
            flip: figures.flip,
            z: p.z(),
        }),
        shown: p.shown.take(),
    });
    Suite {
        folders: [&args.a, &args.b].map(|path| path.display().to_string()),
        criterion: criterion(args),
        command: command_line(),
        entries: entries.collect(),
    }
}

/// A line per pair, the worst first, and a summary.
fn text(comparison: &Comparison, args: &CompareArgs) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[
        ("picture", Left),
        ("rmse", Right),
        ("max", Right),
        ("p999", Right),
        ("flip", Right),
        ("codes", Right),
        ("pixels", Right),
        (if args.statistical { "|z|" } else { "" }, Right),
        ("result", Left),
    ]);
    let judges = args.statistical || args.threshold.is_some();
    for p in &comparison.pairs {
        let cell = |value: &dyn Fn(&Figures) -> String| p.metrics.as_ref().map_or("-".into(), value);
        table.row([
            p.file.clone(),
            cell(&|f| figure(f.plain.rmse)),
            cell(&|f| figure(f.plain.max_abs)),
            cell(&|f| figure(f.plain.p999)),
            cell(&|f| figure(f.flip)),
            cell(&|f| f.plain.code_max.to_string()),
            cell(&|f| grouped(f.plain.differing_pixels)),
            p.z().map_or(String::new(), figure),
            match &p.why {
                // A message of several lines would tear the table.
                Some(why) => format!("failed: {}", why.replace('\n', " ")),
                None if judges => "passed".into(),
                None => String::new(),
            },
        ]);
    }
    let failed = match comparison.failed {
        0 => "no failure".to_owned(),
        n => plural(n as u64, "failure"),
    };
    format!("{table}\n{}, {failed}\n", plural(comparison.pairs.len() as u64, "picture"))
}
