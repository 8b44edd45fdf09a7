//! Where a render's time goes: medians and quartiles per pass and depth over several runs.

use crate::plan::Plan;
use crate::plan::memory_traffic;
use crate::plan::passes::{self, Size};
use crate::report::table::{Align, Table};
use crate::report::test_counts;
use crate::report::{PassInfo, Report, TimeInfo};
use crate::settings::Precision;
use crate::stats::{Quartiles, quartiles};
use crate::units::{grouped, plural, seconds, short};
use serde::Serialize;

/// The report of the run with the median render time, and statistics over all runs.
#[derive(Debug, Clone, Serialize)]
pub struct Profile {
    /// Report of one run. Its `first_dispatch` is the warm-up's, since later runs compile nothing.
    #[serde(flatten)]
    pub report: Report,
    /// Over all runs.
    pub profile: Spread,
}

/// Medians and quartiles over the runs. Times in seconds.
#[derive(Debug, Clone, Serialize)]
pub struct Spread {
    /// Runs that were timed, after the warm-up.
    pub repeats: usize,
    /// From the first submit to the last pixel on the host.
    pub render: Quartiles,
    /// Sum of the passes' device time.
    pub device: Quartiles,
    /// Rays of all kinds per second of the median render.
    pub rays_per_second: f64,
    /// What `bytes` in `passes` counts.
    pub bytes_counted: &'static str,
    /// One row per pass and depth, in the order of the report's `passes`.
    pub passes: Vec<Row>,
}

/// A pass at a depth.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The kernel's name.
    pub name: String,
    /// From 1; 0 outside the per-depth loop.
    pub depth: u32,
    /// Dispatches of one run.
    pub launches: u64,
    /// Live items of one run: rays, samples or pixels.
    pub items: u64,
    /// Device time.
    pub seconds: Quartiles,
    /// Share of the sum of all medians, 0 to 1.
    pub share: f64,
    /// At the median time; None for a pass with one item per dispatch.
    pub items_per_second: Option<f64>,
    /// Bytes read and written in one run, counted as [`BYTES_COUNTED`] says; None if zero.
    pub bytes: Option<u64>,
    /// `bytes` / `items`.
    pub bytes_per_item: Option<f64>,
    /// At the median time.
    pub bytes_per_second: Option<f64>,
}

/// What [`Row::bytes`] counts.
pub const BYTES_COUNTED: &str = "the structs of rays, samples and pixels that a pass reads and writes, each once; without scene data, \
     counters and caches";

impl Profile {
    /// From the reports of all runs, which have the same scene and settings; None if there are
    /// none. `warm_up` are the times of the run before them.
    pub fn new(runs: &[Report], warm_up: &TimeInfo, plan: &Plan, precision: Precision) -> Option<Profile> {
        let render = quartiles(&runs.iter().map(|r| r.time.render).collect::<Vec<_>>())?;
        let device = quartiles(&runs.iter().map(|r| r.time.device).collect::<Vec<_>>())?;
        let mut order: Vec<&Report> = runs.iter().collect();
        order.sort_by(|a, b| a.time.render.total_cmp(&b.time.render));
        let mut report = order[(order.len() - 1) / 2].clone();
        report.time.first_dispatch = warm_up.first_dispatch;
        let mut rows = Vec::with_capacity(report.passes.len());
        for pass in &report.passes {
            let same = |p: &&PassInfo| (&p.name, p.depth) == (&pass.name, pass.depth);
            let times: Vec<f64> =
                runs.iter().filter_map(|r| r.passes.iter().find(same)).map(|p| p.seconds).collect();
            rows.push(row(pass, quartiles(&times)?, &report, plan, precision));
        }
        let total: f64 = rows.iter().map(|r| r.seconds.median).sum();
        rows.iter_mut().for_each(|r| r.share = if total > 0.0 { r.seconds.median / total } else { 0.0 });
        let rays_per_second = report.rays.total() as f64 / render.median;
        let spread = Spread {
            repeats: runs.len(),
            render,
            device,
            rays_per_second,
            bytes_counted: BYTES_COUNTED,
            passes: rows,
        };
        Some(Profile { report, profile: spread })
    }
}

fn row(info: &PassInfo, seconds: Quartiles, report: &Report, plan: &Plan, precision: Precision) -> Row {
    let PassInfo { name, depth, launches, items, .. } = info.clone();
    let rate = |count: f64| (seconds.median > 0.0 && count > 0.0).then(|| count / seconds.median);
    let bytes = moved(info, report, plan, precision).filter(|bytes| *bytes > 0);
    Row {
        items_per_second: rate(items as f64).filter(|_| items > launches),
        bytes,
        bytes_per_item: bytes.map(|b| b as f64 / items.max(1) as f64),
        bytes_per_second: bytes.and_then(|b| rate(b as f64)),
        name,
        depth,
        launches,
        items,
        seconds,
        share: 0.0,
    }
}

/// Bytes that a pass moves in one run; None for an unknown pass.
fn moved(info: &PassInfo, report: &Report, plan: &Plan, precision: Precision) -> Option<u64> {
    let pass = passes::all().find(|p| p.kernel.name() == info.name)?;
    let traffic = memory_traffic::of(pass, plan, precision);
    let samples = report.rays.primary;
    // Rays run through a pass once per group of lights, pixels once per batch of their tile.
    let times = match pass.size {
        Size::Pixels => info.launches.div_ceil(report.plan.tiles.max(1)),
        _ => info.launches / report.plan.batches.max(1),
    };
    let children = report.rays.by_depth.get(info.depth as usize).map_or(0, |d| d.traced);
    Some(traffic.bytes(info.items * times.max(1), children, samples))
}

/// The profile as text for people.
pub fn text(profile: &Profile) -> String {
    use Align::{Left, Right};
    let Profile { report, profile: spread } = profile;
    let mut table = Table::new(&[
        ("pass", Left),
        ("depth", Right),
        ("dispatches", Right),
        ("median", Right),
        ("IQR", Right),
        ("share", Right),
        ("items", Right),
        ("items/s", Right),
        ("B/item", Right),
        ("B/s", Right),
    ]);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".into());
    // Passes run to the depth that was asked for, even if no ray is left.
    let traced = report.rays.by_depth.len() as u32;
    for r in spread.passes.iter().filter(|r| r.depth <= traced) {
        table.row([
            r.name.clone(),
            or_dash((r.depth > 0).then(|| r.depth.to_string())),
            grouped(r.launches),
            seconds(r.seconds.median),
            seconds(r.seconds.range()),
            format!("{:.1} %", 100.0 * r.share),
            grouped(r.items),
            or_dash(r.items_per_second.map(short)),
            or_dash(r.bytes_per_item.map(|b| format!("{b:.0}"))),
            or_dash(r.bytes_per_second.map(short)),
        ]);
    }
    let empty: Vec<&Row> = spread.passes.iter().filter(|r| r.depth > traced).collect();
    if let Some(last) = empty.iter().map(|r| r.depth).max() {
        let first = traced + 1;
        let dash = || "-".to_owned();
        table.row([
            "no rays".into(),
            if first == last { first.to_string() } else { format!("{first}-{last}") },
            grouped(empty.iter().map(|r| r.launches).sum()),
            seconds(empty.iter().map(|r| r.seconds.median).sum()),
            dash(),
            format!("{:.1} %", 100.0 * empty.iter().map(|r| r.share).sum::<f64>()),
            "0".into(),
            dash(),
            dash(),
            dash(),
        ]);
    }
    let time = &report.time;
    let both =
        |q: &Quartiles| format!("{} ({} to {})", seconds(q.median), seconds(q.lower), seconds(q.upper));
    let tests =
        report.tests.as_ref().map_or(String::new(), |tests| format!("\n{}", test_counts::text(tests)));
    format!(
        "{table}\n\
         medians of {} after a warm-up; IQR: interquartile range, the width of the middle half\n\
         items: rays, samples or pixels, depending on the pass\n\
         B: bytes of {}\n\
         render {}; {} rays/s\n\
         device {}\n\
         other: scene {}, build {}, first dispatch {}; whole process {}\n{tests}",
        plural(spread.repeats as u64, "run"),
        spread.bytes_counted,
        both(&spread.render),
        short(spread.rays_per_second),
        both(&spread.device),
        seconds(time.scene),
        seconds(time.build),
        seconds(time.first_dispatch),
        seconds(time.wall),
    )
}

#[cfg(test)]
mod tests;
