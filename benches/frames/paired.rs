//! Two ways of doing the same work, timed in turn in one run, and what is said of them: medians, quartiles
//! and ratios. A machine's pace drifts by a tenth and more within minutes; neighbours in time share it, so
//! the ratio is taken within each pair, and the first place changes hands after every pair.

use serde::Serialize;
use std::collections::BTreeMap;
use whitted::stats::{Quartiles, quartiles};

/// What is known of one run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Run {
    /// Seconds by what they were spent on.
    pub seconds: BTreeMap<String, f64>,
    /// Rays of all kinds.
    pub rays: u64,
    /// Hash of the linear image; empty if it is not known.
    pub picture: String,
}

/// One thing that both ways spend time on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// `wall`, `cpu`, `render`, `device`, or a kernel's name, among others.
    pub what: String,
    /// Seconds of the first way.
    pub first: Quartiles,
    /// Seconds of the second.
    pub second: Quartiles,
    /// First over second, within each pair.
    pub ratio: Quartiles,
}

/// `count` pairs of runs. The first way begins the first pair, the second way the second, and so on.
///
/// # Errors
/// The first error of either way.
pub fn in_turn<T, E>(
    count: usize,
    first: &mut dyn FnMut() -> Result<T, E>,
    second: &mut dyn FnMut() -> Result<T, E>,
) -> Result<Vec<(T, T)>, E> {
    let mut pairs = Vec::with_capacity(count);
    for i in 0..count {
        pairs.push(if i % 2 == 0 {
            let a = first()?;
            (a, second()?)
        } else {
            let b = second()?;
            (first()?, b)
        });
    }
    Ok(pairs)
}

/// A row for everything that all runs of both ways have timed, in the order of `order`; what is not named
/// there comes last. Times of zero have no ratio and no row.
pub fn rows(pairs: &[(Run, Run)], order: &[&str]) -> Vec<Row> {
    let Some((model, _)) = pairs.first() else { return Vec::new() };
    let place = |what: &str| order.iter().position(|o| *o == what).unwrap_or(order.len());
    let mut names: Vec<&String> = model.seconds.keys().collect();
    names.sort_by_key(|name| place(name));
    names.into_iter().filter_map(|name| row(pairs, name)).collect()
}

fn row(pairs: &[(Run, Run)], what: &str) -> Option<Row> {
    let times: Vec<(f64, f64)> = pairs
        .iter()
        .map(|(a, b)| Some((*a.seconds.get(what)?, *b.seconds.get(what)?)))
        .collect::<Option<_>>()?;
    if times.iter().any(|(a, b)| *a <= 0.0 || *b <= 0.0) {
        return None;
    }
    let of = |f: fn(&(f64, f64)) -> f64| quartiles(&times.iter().map(f).collect::<Vec<_>>());
    Some(Row { what: what.to_owned(), first: of(|t| t.0)?, second: of(|t| t.1)?, ratio: of(|t| t.0 / t.1)? })
}

/// Whether the two ways did the same work.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Work {
    /// Rays of the first way.
    pub first_rays: u64,
    /// Rays of the second.
    pub second_rays: u64,
    /// Whether every run of both made the same bits; None where a picture is not known.
    pub same_bits: Option<bool>,
}

/// From all runs.
pub fn work(pairs: &[(Run, Run)]) -> Work {
    let model = pairs.first();
    let pictures: Vec<&str> =
        pairs.iter().flat_map(|(a, b)| [a.picture.as_str(), b.picture.as_str()]).collect();
    let known = !pictures.is_empty() && pictures.iter().all(|p| !p.is_empty());
    Work {
        first_rays: model.map_or(0, |m| m.0.rays),
        second_rays: model.map_or(0, |m| m.1.rays),
        same_bits: known.then(|| pictures.iter().all(|p| *p == pictures[0])),
    }
}

impl Work {
    /// Rays of the first way over those of the second, less one; None without rays.
    pub fn rays_apart(&self) -> Option<f64> {
        (self.second_rays > 0).then(|| self.first_rays as f64 / self.second_rays as f64 - 1.0)
    }
}
