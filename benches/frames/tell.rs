//! What the benchmark says: tables for people, lines of JSON for programs.

use crate::cases::Case;
use crate::paired::{Row, Work};
use anyhow::{Context, Result};
use serde::Serialize;
use std::io::Write;
use std::path::Path;
use whitted::report::DeviceInfo;
use whitted::report::table::{Align, Table};
use whitted::stats::Quartiles;
use whitted::units::{plural, seconds, short};

/// Order of the rows: the whole, then the passes as a frame runs them.
pub const ORDER: [&str; 14] = [
    "wall",
    "cpu",
    "build",
    "first dispatch",
    "render",
    "device",
    "generate",
    "intersect",
    "shade",
    "scan",
    "spawn",
    "shadow",
    "gather",
    "resolve",
];

/// How far two pictures are apart, in linear light clamped to [0, 1].
#[derive(Debug, Clone, Serialize)]
pub struct Picture {
    /// Root mean square over all channels.
    pub rmse: f64,
    /// Largest channel.
    pub max: f64,
    /// Share of pixels that differ at all.
    pub differing: f64,
}

/// All that was found out about a case.
pub struct Told<'a> {
    /// The case.
    pub case: &'a Case,
    /// What came first in each pair.
    pub first: &'a str,
    /// What came second; None where there is nothing beside the first.
    pub second: Option<&'a str>,
    /// Number of pairs.
    pub pairs: usize,
    /// Times.
    pub rows: Vec<Row>,
    /// Rays and bits.
    pub work: Work,
    /// How far apart, if the bits differ.
    pub picture: Option<Picture>,
}

/// To standard output; a reader who has left is no failure.
fn say(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// Prints tables as they come and keeps lines of JSON.
#[derive(Default)]
pub struct Teller {
    device: Option<DeviceInfo>,
    lines: Vec<String>,
}

#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    size: [u32; 2],
    samples: u32,
    depth: u32,
    device: &'a str,
    first: &'a str,
    second: Option<&'a str>,
    pairs: usize,
    what: &'a str,
    first_seconds: Quartiles,
    second_seconds: Option<Quartiles>,
    ratio: Option<Quartiles>,
    work: &'a Work,
    picture: &'a Option<Picture>,
}

impl Teller {
    /// The device of what follows.
    pub fn device(&mut self, device: &DeviceInfo) {
        if self.device.as_ref() != Some(device) {
            let DeviceInfo { name, kind, driver, api } = device;
            say(&format!("device  {name} ({kind}), {driver}, Vulkan {api}\n"));
            self.device = Some(device.clone());
        }
    }

    /// Prints a case's table.
    pub fn tell(&mut self, told: &Told) {
        let Told { case, first, second, pairs, rows, work, picture } = told;
        let [width, height] = case.size;
        let samples = plural(case.samples.into(), "sample");
        let against = match second {
            Some(second) => format!(" over {second}, {}", plural(*pairs as u64, "pair")),
            None => format!(", {}", plural(*pairs as u64, "run")),
        };
        say(&format!(
            "\n{}, {width}x{height}, {samples}, depth {}: {first}{against}\n",
            case.scene, case.depth
        ));
        say(&table(rows, work, first, *second));
        say(&(same_work(work, *second, picture.as_ref()) + "\n"));
        let device = self.device.as_ref().map_or("", |d| d.name.as_str());
        let line = |row: &Row| {
            let (what, first_seconds) = (row.what.as_str(), row.first);
            let second_seconds = second.map(|_| row.second);
            let ratio = second.map(|_| row.ratio);
            let Case { scene, size, samples, depth, .. } = **case;
            let (pairs, second) = (*pairs, *second);
            #[rustfmt::skip]
            let line = Line {
                scene, size, samples, depth, device, first, second, pairs, what, first_seconds, second_seconds, ratio, work, picture,
            };
            serde_json::to_string(&line)
        };
        self.lines.extend(rows.iter().map(line).filter_map(std::result::Result::ok));
    }

    /// Writes the lines of JSON.
    pub fn finish(self, json: Option<&Path>) -> Result<()> {
        let Some(path) = json else { return Ok(()) };
        whitted::atomic_file::write(path, |out| {
            self.lines.iter().try_for_each(|line| writeln!(out, "{line}"))
        })
        .with_context(|| format!("cannot write {}", path.display()))
    }
}

/// Times of both ways and their ratio, or of one with shares and rays a second.
pub fn table(rows: &[Row], work: &Work, first: &str, second: Option<&str>) -> String {
    use Align::{Left, Right};
    let Some(second) = second else {
        let mut table = Table::new(&[
            ("", Left),
            ("median", Right),
            ("quartiles apart", Right),
            ("of device", Right),
            ("rays/s", Right),
        ]);
        let device = rows.iter().find(|r| r.what == "device").map(|r| r.first.median);
        for row in rows {
            let whole = ["render", "device"].contains(&row.what.as_str());
            let share = device.filter(|_| !whole).map(|d| 100.0 * row.first.median / d);
            let rate = whole.then(|| work.first_rays as f64 / row.first.median);
            table.row([
                row.what.clone(),
                seconds(row.first.median),
                seconds(row.first.range()),
                share.map_or(String::new(), |s| format!("{s:.1} %")),
                rate.map_or(String::new(), short),
            ]);
        }
        return table.to_string();
    };
    let mut table = Table::new(&[
        ("", Left),
        (first, Right),
        ("quartiles apart", Right),
        (second, Right),
        ("quartiles apart", Right),
        ("ratio", Right),
        ("quartiles", Right),
    ]);
    for row in rows {
        table.row([
            row.what.clone(),
            seconds(row.first.median),
            seconds(row.first.range()),
            seconds(row.second.median),
            seconds(row.second.range()),
            format!("{:.3}", row.ratio.median),
            format!("{:.3} to {:.3}", row.ratio.lower, row.ratio.upper),
        ]);
    }
    table.to_string()
}

/// One line: rays and bits.
pub fn same_work(work: &Work, second: Option<&str>, picture: Option<&Picture>) -> String {
    let Some(second) = second else { return format!("{} rays", short(work.first_rays as f64)) };
    let rays = match work.rays_apart() {
        Some(0.0) => format!("{} rays each", short(work.first_rays as f64)),
        Some(apart) => format!(
            "{} rays against {} of {second}: {:+.2} %{}",
            short(work.first_rays as f64),
            short(work.second_rays as f64),
            100.0 * apart,
            if apart.abs() > 0.01 { ", not the same work" } else { "" }
        ),
        None => "no rays".into(),
    };
    let bits = match (work.same_bits, picture) {
        (Some(true), _) => "the same bits".into(),
        (_, Some(p)) => format!(
            "pictures differ: RMSE {:.2e}, largest {:.2e}, {:.2} % of the pixels",
            p.rmse,
            p.max,
            100.0 * p.differing
        ),
        (Some(false), None) => "pictures differ".into(),
        (None, None) => "pictures not compared".into(),
    };
    format!("{rays}; {bits}")
}
