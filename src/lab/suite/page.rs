//! The page's text.

use super::{Entry, Measured, Outcome, Suite};
use crate::lab::page::document;
use crate::lab::page::markup::{error, escaped, facts};
use crate::lab::page::pictures::scale;
use crate::lab::page::views::{image, views};
use crate::report::ProgramInfo;
use crate::units::{grouped, plural};
use std::fmt::Write;

/// A column of figures.
struct Column {
    head: &'static str,
    /// Explains the heading, as a tooltip.
    what: &'static str,
    /// Sort value and text; None if unknown.
    cell: fn(&Measured) -> Option<(f64, String)>,
}

fn real(x: f64) -> Option<(f64, String)> {
    Some((x, error(Some(x))))
}

fn count(n: u64) -> Option<(f64, String)> {
    Some((n as f64, grouped(n)))
}

macro_rules! columns {
    ($($head:literal $what:literal $cell:expr;)*) => {
        &[$(Column { head: $head, what: $what, cell: $cell },)*]
    };
}

/// In the order shown.
const COLUMNS: &[Column] = columns! {
    "RMSE" "root mean square error over all channels, linear light" |m| real(m.metrics.rmse);
    "mean" "mean absolute error over all channels, linear light" |m| real(m.metrics.mean_abs);
    "max" "largest error of any channel, linear light" |m| real(m.metrics.max_abs);
    "p99.9" "99.9th percentile of the pixels' worst channels" |m| real(m.metrics.p999);
    "PSNR" "peak signal-to-noise ratio; - for equal pictures" |m| m.metrics.psnr.map(|db| (db, format!("{db:.1} dB")));
    "FLIP" "mean LDR-FLIP, 0 to 1: perceived difference" |m| real(m.flip);
    "pixels" "pixels that differ" |m| count(m.metrics.differing_pixels);
    "codes" "largest difference in 8-bit sRGB codes" |m| count(m.metrics.code_max.into());
    "|z|" "largest mean difference of a block, in standard errors" |m| real(m.z?);
};

/// The whole page.
pub fn page(suite: &Suite) -> String {
    let [a, b] = &suite.folders;
    let failed = suite.entries.iter().filter(|e| e.has_failed()).count() as u64;
    let count = plural(suite.entries.len() as u64, "picture");
    let mut text = match failed {
        0 => format!("<p class=\"lead\">{count}, no failure.</p>\n"),
        n => format!("<p class=\"lead\">{count}, <b>{}</b>.</p>\n", plural(n, "failure")),
    };
    let ProgramInfo { version, git, .. } = ProgramInfo::default();
    let made = format!("<code>{}</code><br>whitted {version} ({})", escaped(&suite.command), escaped(&git));
    text += &facts(&[
        ("A", escaped(a)),
        ("B", escaped(b)),
        ("failure", escaped(&suite.criterion)),
        ("made by", made),
    ]);
    text += &table(suite);
    text += &gallery(suite);
    document(&format!("Comparison of {a} and {b}"), &text)
}

impl Entry {
    /// True if it was not accepted.
    pub fn has_failed(&self) -> bool {
        matches!(self.outcome, Outcome::Failed(_))
    }

    fn class(&self) -> &'static str {
        if self.has_failed() { "failed" } else { "passed" }
    }

    fn result(&self) -> &'static str {
        match self.outcome {
            Outcome::Measured => "measured",
            Outcome::Passed => "passed",
            Outcome::Failed(_) => "failed",
        }
    }
}

fn table(suite: &Suite) -> String {
    let columns: Vec<&Column> = COLUMNS
        .iter()
        .filter(|c| {
            c.head != "|z|" || suite.entries.iter().any(|e| e.measured.is_some_and(|m| m.z.is_some()))
        })
        .collect();
    let heads: String = columns
        .iter()
        .map(|c| format!("<th title=\"{}\">{}</th>", escaped(c.what), escaped(c.head)))
        .collect();
    let mut text = format!(
        "<h2 id=\"pairs\">Pictures</h2>\n<p>The worst first. Click a heading to sort by it, hover over it for its meaning, \
         click a name to see the pictures.</p>\n\
         <p><label><input type=\"checkbox\" id=\"failures-only\"> show failures only</label></p>\n\
         <div class=\"scroll tall\"><table class=\"sortable\"><thead><tr><th class=\"l\">result</th>\
         <th class=\"l\">picture</th>{heads}<th>size</th></tr></thead><tbody>\n"
    );
    for (i, entry) in suite.entries.iter().enumerate() {
        let (name, class, result) = (escaped(&entry.name), entry.class(), entry.result());
        let link = match entry.shown {
            Some(_) => format!("<a href=\"#pair-{i}\">{name}</a>"),
            None => name,
        };
        let _ =
            write!(text, "<tr class=\"{class}\"><td class=\"l\">{result}</td><td class=\"l\">{link}</td>");
        for column in &columns {
            let _ = match entry.measured.and_then(|m| (column.cell)(&m)) {
                Some((value, shown)) => write!(text, "<td data-v=\"{value:e}\">{shown}</td>"),
                None => write!(text, "<td>-</td>"),
            };
        }
        let _ = match entry.measured {
            Some(Measured { size: [w, h], .. }) => {
                writeln!(text, "<td data-v=\"{}\">{w}x{h}</td></tr>", u64::from(w) * u64::from(h))
            }
            None => writeln!(text, "<td>-</td></tr>"),
        };
    }
    text + "</tbody></table></div>\n"
}

/// Reasons of the failures, and the pictures.
fn gallery(suite: &Suite) -> String {
    let mut text = format!(
        "<h2 id=\"pictures\">Differences</h2>\n<p>Click a picture for full size; then the arrow keys flip between A, B and \
         their difference: the largest of the three channels, in linear light, on a logarithmic scale:<br>{}</p>\n",
        scale()
    );
    for (i, entry) in suite.entries.iter().enumerate() {
        let name = escaped(&entry.name);
        let (class, why) = match &entry.outcome {
            Outcome::Failed(why) => ("tag bad", escaped(why)),
            _ => ("tag", String::new()),
        };
        let pictures = match &entry.shown {
            None => String::new(),
            Some(shown) => match &shown.other {
                None => views(&[("A and B, which are equal", image(&shown.a, shown.size, "A and B"))]),
                Some([b, difference]) => views(&[
                    ("A", image(&shown.a, shown.size, "A")),
                    ("B", image(b, shown.size, "B")),
                    ("difference", image(difference, shown.size, "difference")),
                ]),
            },
        };
        let _ = writeln!(
            text,
            "<figure class=\"row {}\" id=\"pair-{i}\"><figcaption><span class=\"{class}\">{}</span><b>{name}</b> \
             {why}</figcaption>{pictures}</figure>",
            entry.class(),
            entry.result(),
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Picture;
    use crate::lab::suite::Shown;

    fn suite() -> Suite {
        let grey = |level| Picture {
            width: 2,
            height: 1,
            linear: vec![[level; 3]; 2],
            encoding: "linear",
            window: None,
        };
        let shown = Shown::of(&grey(0.5), &grey(0.25)).unwrap();
        let measured = Some(Measured { size: [2, 1], ..Measured::default() });
        let failed = Outcome::Failed("rmse 0.25 is above <0.1>".into());
        let equal = Shown::of(&grey(0.5), &grey(0.5)).unwrap();
        Suite {
            folders: ["new".into(), "old & \"good\"".into()],
            entries: vec![
                Entry {
                    name: "<gone>.png".into(),
                    outcome: Outcome::Failed("not in B".into()),
                    ..Entry::default()
                },
                Entry { name: "a.png".into(), outcome: failed, measured, shown: Some(shown) },
                Entry { name: "b.png".into(), outcome: Outcome::Passed, measured, shown: Some(equal) },
            ],
            ..Suite::default()
        }
    }

    #[test]
    fn every_pair_has_a_row_and_every_row_a_cell_for_every_heading() {
        let text = page(&suite());
        let (cells, heads) =
            (text.matches("<td").count(), text.matches("<th ").count() + text.matches("<th>").count());
        assert_eq!((cells, heads), (3 * heads, 2 + COLUMNS.len()), "|z| is left out, size is there");
        assert!(text.contains("3 pictures, <b>2 failures</b>"));
    }

    #[test]
    fn equal_pictures_are_embedded_once() {
        assert_eq!(page(&suite()).matches("<img ").count(), 3 + 1);
    }

    #[test]
    fn names_are_text_not_markup() {
        let text = page(&suite());
        assert!(text.contains("&lt;gone&gt;.png") && text.contains("old &amp; &quot;good&quot;"));
        assert!(!text.contains("<gone>") && !text.contains("<0.1>"));
        assert!(!text.contains("http"), "nothing is fetched");
    }
}
