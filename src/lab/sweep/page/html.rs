//! The page's text: one file that needs no other file, no network and, for reading, no JavaScript.

use super::charts::Plot;
use super::pictures::{Pictures, Shown};
use super::{rows, tables};
use crate::lab::page::markup::{self, data_url, error, escaped};
use crate::lab::page::pictures::scale;
use crate::lab::page::{document, views};
use crate::lab::sweep::record::Record;
use crate::units::{plural, seconds};
use std::fmt::Write;

/// The whole page; each plot comes with its SVG.
pub(super) fn page(record: &Record, plots: &[(Plot, String)], pictures: &Pictures) -> String {
    let mut text = summary(record);
    text += &facts(record);
    text += TERMS;
    text += &figures(plots);
    text += &tables::front(record);
    text += &tables::cheapest(record);
    text += &gallery(pictures);
    text += &tables::slopes(record);
    text += &tables::doublings(record);
    text += &tables::precisions(record);
    text += &rows::section(record);
    document(&format!("Sweep of {}", record.scene), &text)
}

/// The result in one paragraph, and what it does not say.
fn summary(record: &Record) -> String {
    let front = tables::front_rows(record);
    let mut text = String::new();
    if let (Some(fast), Some(good)) = (front.first(), front.last()) {
        let _ = writeln!(
            text,
            "<p class=\"lead\">{} of {} are worth choosing (<a href=\"#pareto-front\">Pareto front</a>): from {} with an RMSE of \
             {} to {} with an RMSE of {}.</p>",
            front.len(),
            plural(record.rows.len() as u64, "setting"),
            seconds(fast.seconds()),
            error(fast.rmse()),
            seconds(good.seconds()),
            error(good.rmse()),
        );
    }
    if record.device.kind == "cpu" {
        text += "<p class=\"note\"><b>The device is a CPU driver.</b> Its times say nothing about a GPU; errors do not \
                 depend on the kind of device.</p>\n";
    }
    if record.truth.as_ref().is_some_and(|t| !t.converged) {
        text += "<p class=\"note\"><b>The truth is not exact enough for the best settings:</b> its standard error is more \
                 than a tenth of the smallest error. Raise <code>--truth-samples</code>.</p>\n";
    }
    text
}

/// What was measured, how and by what.
fn facts(record: &Record) -> String {
    let d = &record.device;
    let swept = |axis: &String| {
        let mut values: Vec<String> = Vec::new();
        for value in record.rows.iter().map(|r| r.point.value(axis)) {
            if !values.contains(&value) {
                values.push(value);
            }
        }
        let values = match values.as_slice() {
            [first, .., last] if values.len() > 12 => format!("{first} ... {last} ({} values)", values.len()),
            _ => values.join(", "),
        };
        format!("<b>{}</b> {}", escaped(axis), escaped(&values))
    };
    let mut list = vec![
        ("swept", record.axes.iter().map(swept).collect::<Vec<_>>().join("<br>")),
        ("image", format!("{} x {} pixels, {}", record.width, record.height, escaped(&record.scene))),
        (
            "device",
            format!(
                "{} ({}), {}, Vulkan {}",
                escaped(&d.name),
                escaped(&d.kind),
                escaped(&d.driver),
                escaped(&d.api)
            ),
        ),
    ];
    if let Some(t) = &record.truth {
        let hidden = match &t.truncation {
            None => "error of longer paths unknown".into(),
            Some(h) if h.pixels == 0 => "no path is longer".into(),
            Some(h) => format!("longer paths change the RMSE by at most {}", error(Some(h.rms))),
        };
        list.push((
            "truth",
            format!(
                "{}; depth {} ({hidden}); {:.0} samples per pixel on average, at most {}; standard error {} (RMSE)",
                escaped(&t.identity.tracer),
                t.identity.depth,
                t.samples_mean,
                t.samples_most,
                error(Some(t.standard_error)),
            ),
        ));
    }
    let (version, git) = (&record.program.version, escaped(&record.program.git));
    list.push(("made by", format!("<code>{}</code><br>whitted {version} ({git})", escaped(&record.command))));
    markup::facts(&list)
}

const TERMS: &str = "<details><summary>Terms used on this page</summary><dl>
<dt>setting</dt><dd>one combination of the swept values.</dd>
<dt>truth</dt><dd>the image that errors are measured against: rendered in f64, deeper than every setting, with many more \
samples.</dd>
<dt>RMSE</dt><dd>root mean square error over all pixels and channels, in linear light clamped to [0, 1].</dd>
<dt>sampling error, bias</dt><dd>the two parts of an error: what more samples would remove, and what infinitely many \
samples would leave (from the depth limit, the cutoff, rounding, or a simplified model). RMSE<sup>2</sup> = \
sampling<sup>2</sup> + bias<sup>2</sup> + the truth's own error<sup>2</sup>.</dd>
<dt>Pareto front</dt><dd>the settings that no other setting beats in both time and error.</dd>
<dt>median, interquartile range (IQR)</dt><dd>of repeated measurements, the middle value and the width of the middle \
half: a quarter of the values lies below it, a quarter above. A setting that takes longer than 10 s is rendered \
once.</dd>
<dt>FLIP</dt><dd>a perceptual error from 0 to 1: how different the pictures look when flipping between them \
(Andersson et al. 2020).</dd>
<dt>efficiency</dt><dd>1 / (RMSE<sup>2</sup> &times; time), relative to the best setting. While the sampling error is all, \
independent samples keep it, however many they are.</dd>
<dt>one sample</dt><dd>lies at the pixel's centre with every sampler, so one-sample pictures of all samplers are \
equal.</dd>
</dl></details>
";

fn figures(plots: &[(Plot, String)]) -> String {
    if plots.is_empty() {
        return String::new();
    }
    let mut text = String::from("<h2 id=\"plots\">Plots</h2>\n<div class=\"plots\">");
    for (plot, svg) in plots {
        let _ = writeln!(
            text,
            "<figure id=\"{}\">{svg}<figcaption>{}</figcaption></figure>",
            plot.name, plot.caption
        );
    }
    text + "</div>\n"
}

fn gallery(pictures: &Pictures) -> String {
    if pictures.list.is_empty() {
        return String::new();
    }
    let [width, height] = pictures.size;
    let mut text = format!(
        "<h2 id=\"pictures\">Pictures</h2>\n<p>Settings of the Pareto front from fast to exact, then the largest error and the slowest \
         setting. Settings with equal pictures share a row. Click a picture for full size; then the arrow keys flip \
         between picture, truth and difference.</p>\n\
         <p>The difference is the largest of the three channels, in linear light, on a logarithmic scale:<br>{}</p>\n\
         <svg width=\"0\" height=\"0\" style=\"position:absolute\"><symbol id=\"truth\" viewBox=\"0 0 {width} {height}\">\
         <image width=\"{width}\" height=\"{height}\" href=\"{}\"/></symbol></svg>\n",
        scale(),
        data_url(&pictures.truth),
    );
    for shown in &pictures.list {
        text += &row(shown, pictures.size);
    }
    text
}

/// One row: picture, truth and difference side by side.
fn row(shown: &Shown, size: [u32; 2]) -> String {
    let [width, height] = size;
    let mut names = String::new();
    for (name, figures) in &shown.settings {
        let _ = write!(names, "<li><b>{}</b>{}</li>", escaped(name), escaped(figures));
    }
    let tags: String = shown.tags.iter().map(|t| format!("<span class=\"tag\">{t}</span>")).collect();
    let truth = format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"truth\"><use href=\"#truth\"/></svg>"
    );
    let apart = "difference from the truth";
    let views = views::views(&[
        ("picture", views::image(&shown.picture, size, "picture")),
        ("truth", truth),
        (apart, views::image(&shown.difference, size, apart)),
    ]);
    format!(
        "<figure class=\"row\"><figcaption>{tags}<ul class=\"names\">{names}</ul></figcaption>{views}</figure>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::sweep::row::Row;

    #[test]
    fn what_the_user_wrote_is_text_not_markup() {
        let record = Record {
            scene: "<b>&\".toml".into(),
            axes: vec!["depth".into()],
            rows: vec![Row::default()],
            ..Record::default()
        };
        let text = page(&record, &[], &Pictures::default());
        assert!(text.contains("&lt;b&gt;&amp;&quot;.toml") && !text.contains("<b>&"));
        // One file: nothing is fetched.
        assert!(!text.contains("http") && !text.contains("src=\"/") && !text.contains("@import"));
    }

    #[test]
    fn a_cpu_driver_is_named_as_one() {
        let mut record = Record::default();
        record.device.kind = "cpu".into();
        let note = "class=\"note\"";
        assert!(page(&record, &[], &Pictures::default()).contains(note));
        record.device.kind = "discrete".into();
        assert!(!page(&record, &[], &Pictures::default()).contains(note));
    }
}
