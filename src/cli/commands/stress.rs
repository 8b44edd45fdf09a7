//! `whitted stress`.

use super::command_line;
use crate::atomic_file;
use crate::cli::args::StressArgs;
use crate::cli::console::{Console, print};
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress;
use crate::lab::stress::page::{self, Outcome, Page, PageError};
use crate::lab::stress::{Case, Figure, Harness, cases};
use crate::render::Renderer;
use crate::report::DeviceInfo;
use crate::report::table::{Align, Table};
use crate::settings::DeviceChoice;
use crate::units::seconds;
use anyhow::Context;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The result of one case.
#[derive(Debug, Serialize)]
struct Row {
    name: &'static str,
    does: &'static str,
    stands_for: &'static str,
    derivation: &'static str,
    #[serde(flatten)]
    figure: Figure,
    passed: bool,
    seconds: f64,
}

/// The results of a run.
#[derive(Debug, Serialize)]
struct StressReport {
    device: DeviceInfo,
    precision: &'static str,
    cases: Vec<Row>,
}

/// Runs the cases and prints their results. Fails if any case does.
pub fn run(args: &StressArgs, console: &mut Console) -> Result<(), Failure> {
    let chosen = choose(&args.only)?;
    if args.list {
        let mut table = Table::new(&[("case", Align::Left), ("what it does", Align::Left)]);
        chosen.iter().for_each(|c| table.row([c.name.into(), c.does.into()]));
        return print(&table.to_string());
    }
    files(args).check()?;
    progress::catch_interrupts()?;
    let choice = args.device.device.clone().unwrap_or(DeviceChoice::Best);
    let mut renderer = Renderer::open(&choice, args.validate)?;
    let mut report = StressReport {
        device: renderer.device().info(),
        precision: args.precision.name(),
        cases: Vec::new(),
    };
    for case in chosen {
        if progress::interrupted() {
            print(&text(&report))?;
            return Err(Failure::Interrupted(format!("interrupted after {} cases", report.cases.len())));
        }
        let start = Instant::now();
        let mut harness = Harness::new(&mut renderer, args.precision);
        let figure = (case.run)(&mut harness)?;
        let row = Row {
            name: case.name,
            does: case.does,
            stands_for: case.stands_for,
            derivation: case.bound,
            passed: figure.passes(),
            figure,
            seconds: start.elapsed().as_secs_f64(),
        };
        if console.is_verbose() {
            console.say(&format!("{}: {} ({})", row.name, verdict(&row), seconds(row.seconds)));
        }
        report.cases.push(row);
    }
    print(&text(&report))?;
    if let Some(path) = &args.report {
        let json = serde_json::to_string_pretty(&report).context("cannot express the report as JSON")? + "\n";
        write(path, &json)?;
    }
    if let Some(path) = &args.page {
        let outcomes: Vec<Outcome> = report.cases.iter().map(Row::outcome).collect();
        let mut say = |what: &str| console.say(&format!("measuring: {what}"));
        let page = page::make(
            &mut renderer,
            args.precision,
            &outcomes,
            &command_line(),
            &mut say,
            &progress::interrupted,
        );
        save(path, &page.map_err(page_failure)?)?;
    }
    for message in renderer.validation_messages() {
        console.error(&format!("validation: {message}"));
    }
    let failed = report.cases.iter().filter(|r| !r.passed).count();
    if failed > 0 {
        return Err(anyhow::anyhow!("{failed} of {} cases failed", report.cases.len()).into());
    }
    if !renderer.validation_messages().is_empty() {
        return Err(anyhow::anyhow!("the validation layer reported errors").into());
    }
    Ok(())
}

/// The files it writes.
fn files(args: &StressArgs) -> Files {
    let files = Files::new().prints().writes("--report", args.report.as_deref());
    let files = files.writes("--page", args.page.as_deref());
    let pictures = args.page.iter().flat_map(|page| page::PICTURES.map(|name| page.with_file_name(name)));
    pictures.fold(files, |files, picture| files.writes("the picture of --page", Some(&picture)))
}

impl Row {
    fn outcome(&self) -> Outcome {
        Outcome {
            name: self.name,
            stands_for: self.stands_for,
            derivation: self.derivation,
            figure: self.figure.clone(),
        }
    }
}

fn page_failure(error: PageError) -> Failure {
    match error {
        PageError::Render(error) => error.into(),
        PageError::Stopped => Failure::Interrupted(error.to_string()),
        PageError::Figure(_) => anyhow::Error::new(error).into(),
    }
}

/// Writes the pictures, then the page that refers to them.
fn save(path: &Path, page: &Page) -> Result<(), Failure> {
    for (name, svg) in &page.pictures {
        write(&path.with_file_name(name), svg)?;
    }
    write(path, &page.text)
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(atomic_file::write(path, |out| out.write_all(text.as_bytes()))
        .with_context(|| format!("cannot write {}", path.display()))?)
}

fn choose(only: &[String]) -> Result<Vec<Case>, Failure> {
    let all = cases();
    if let Some(unknown) = only.iter().find(|name| !all.iter().any(|c| c.name == name.as_str())) {
        let names: Vec<&str> = all.iter().map(|c| c.name).collect();
        return Err(Failure::Usage(format!("unknown case `{unknown}`; the cases are {}", names.join(", "))));
    }
    Ok(all.into_iter().filter(|c| only.is_empty() || only.iter().any(|n| n == c.name)).collect())
}

fn verdict(row: &Row) -> &'static str {
    if row.passed { "pass" } else { "FAIL" }
}

fn text(report: &StressReport) -> String {
    let mut table = Table::new(&[("case", Align::Left), ("", Align::Left), ("result", Align::Left)]);
    for row in &report.cases {
        table.row([row.name.into(), verdict(row).into(), row.figure.to_string()]);
    }
    let d = &report.device;
    format!(
        "{} ({}), {}, Vulkan {}; precision {}\n\n{table}",
        d.name, d.kind, d.driver, d.api, report.precision
    )
}
