//! The comparison of two pictures as text for people.

use super::pair::region;
use super::{Comparison, Diff};
use crate::compare::statistical::Statistics;
use crate::report::table::{Align, Table};
use crate::units::{figure, grouped, number, plural};

/// Names, sizes, all metrics, the test, the picture of the difference.
pub(super) fn comparison(comparison: &Comparison) -> String {
    use Align::{Left, Right};
    let Comparison { a, b, metrics, judged, statistical, diff, .. } = comparison;
    let plain = &metrics.plain;
    let mut table = Table::new(&[("error", Left), ("value", Right), ("", Left)]);
    let mut row = |name: &str, value: String, note: &str| {
        let mark = if name == judged.metric {
            match (judged.threshold, judged.above) {
                (Some(limit), Some(true)) => format!("; exceeds the threshold {}", number(limit)),
                (Some(limit), _) => format!("; within the threshold {}", number(limit)),
                _ => String::new(),
            }
        } else {
            String::new()
        };
        table.row([name.into(), value, format!("{note}{mark}")]);
    };
    let share = |count: u64, share: f64| format!("{} pixels, {}", grouped(count), percent(share));
    row("rmse", number(plain.rmse), "root mean square over all channels");
    row("mean", number(plain.mean_abs), "mean absolute over all channels");
    row("max", number(plain.max_abs), "largest channel");
    row("p999", number(plain.p999), "99.9th percentile of the pixels' worst channels");
    row("psnr", plain.psnr.map_or("infinite".into(), |db| format!("{db:.2}")), "decibels");
    row("flip", number(metrics.flip), "mean LDR-FLIP, 67 pixels per degree");
    row(
        "pixels",
        number(metrics.differing_share),
        &format!("differ; {}", share(plain.differing_pixels, metrics.differing_share)),
    );
    row("codes", plain.code_max.to_string(), "largest difference in 8-bit sRGB codes");
    row("", number(plain.code_mean), "mean difference in 8-bit sRGB codes");
    row(
        "",
        number(metrics.code_differing_share),
        &format!(
            "differ in 8-bit sRGB codes; {}",
            share(plain.code_differing_pixels, metrics.code_differing_share)
        ),
    );
    let mut text = format!(
        "a  {} ({})\nb  {} ({})\n{}x{} pixels, in linear light clamped to [0, 1]\n\n{table}",
        a.file, a.encoding, b.file, b.encoding, a.width, a.height
    );
    if let Some(s) = statistical {
        text += &format!("\n{}", statistics(s));
    }
    if let Some(Diff { file, shows, scale: [low, high] }) = diff {
        text +=
            &format!("\n{file}: {shows}, from {} (black) to {} (pale yellow)\n", number(*low), number(*high));
    }
    text
}

/// The test: what was tested, the worst block, the verdict.
fn statistics(s: &Statistics) -> String {
    let mut text = format!(
        "{} of {} for a significance of {}: |z| above {} is a difference\n",
        plural(s.tests, "test"),
        plural(s.blocks, "block"),
        number(s.significance),
        figure(s.threshold),
    );
    if let Some(w) = &s.worst {
        text += &format!(
            "worst block {}, {}: mean difference {} with a standard error of {}, z {}, p at most {}\n",
            region(w.region),
            w.channel,
            figure(w.mean),
            figure(w.standard_error),
            figure(w.z),
            figure(w.p),
        );
    }
    text += &match (s.exact, s.significant) {
        (true, false) => "the pictures are equal: there is no noise to test\n".to_owned(),
        (true, true) => format!(
            "only {} differ, too few for noise: compared exactly, the pictures differ\n",
            plural(s.differing_pixels, "pixel")
        ),
        (false, false) => "no significant difference: noise explains it\n".to_owned(),
        (false, true) => {
            format!("significant difference in {}\n", plural(s.significant_blocks, "block"))
        }
    };
    text
}

fn percent(share: f64) -> String {
    format!("{} %", number(format!("{:.2e}", 100.0 * share).parse().unwrap_or(share)))
}
