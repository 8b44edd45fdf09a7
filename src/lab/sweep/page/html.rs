//! The page's text: one file that needs no other and no network.

use super::pictures::{LEAST, Shown};
use crate::image::heat::heat;
use crate::lab::sweep::record::Record;
use crate::lab::sweep::row::Row;
use crate::stats::{median, quartiles};
use crate::units::{plural, seconds, short};
use std::fmt::Write;

const STYLE: &str = "\
body{font:15px/1.5 system-ui,sans-serif;max-width:1200px;margin:2em auto;padding:0 1em;color:#222;background:#fff}\
h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em}.note{background:#fff6dd;border-left:4px solid #e69f00;padding:.5em 1em}\
.plots,.pictures{display:flex;flex-wrap:wrap;gap:1em}.plots svg{max-width:100%;height:auto;border:1px solid #ddd}\
figure{margin:0}figcaption{font-size:.85em;max-width:320px}figure img{display:block;max-width:100%;image-rendering:pixelated}\
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:.85em;font-variant-numeric:tabular-nums}\
th,td{padding:.2em .6em;border-bottom:1px solid #ddd;text-align:right;white-space:nowrap}th{position:sticky;top:0;background:#f4f4f4}\
th.sort{cursor:pointer}td.l,th.l{text-align:left}tr.front{background:#fdf3d8}\
.ramp{display:inline-block;width:12em;height:1em;vertical-align:middle}";

/// Sorts a table by the column clicked, numbers as numbers; again turns the order round.
const SCRIPT: &str = "\
document.querySelectorAll('table.rows').forEach(t=>{const b=t.tBodies[0];t.querySelectorAll('th').forEach((h,i)=>{\
h.classList.add('sort');h.title='sort';let up=1;h.onclick=()=>{const v=r=>{const c=r.cells[i];const x=c.dataset.v??c.textContent;\
const n=parseFloat(x);return isNaN(n)?x:n};[...b.rows].sort((p,q)=>{const a=v(p),c=v(q);\
return up*(typeof a==='number'&&typeof c==='number'?a-c:String(a).localeCompare(String(c)))}).forEach(r=>b.append(r));up=-up}})})";

/// The whole page; `plots` are SVG.
pub(super) fn page(record: &Record, plots: &[String], pictures: &[Shown]) -> String {
    let title = format!("Sweep of {}", escaped(&record.scene));
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{title}</title><style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
    );
    text += &introduction(record);
    let _ = writeln!(text, "<h2>Plots</h2><div class=\"plots\">{}</div>", plots.join("\n"));
    text += &front(record);
    text += &cheapest(record);
    text += &slopes(record);
    text += &doublings(record);
    text += &precisions(record);
    text += &gallery(pictures);
    text += &rows(record);
    let _ = writeln!(text, "<script>{SCRIPT}</script></body></html>");
    text
}

fn introduction(record: &Record) -> String {
    let d = &record.device;
    let points = plural(record.points as u64, "point");
    let mut text = format!(
        "<p>{points} over {}, {}x{} pixels, judged by one truth. Made by <code>{}</code>, whitted {} ({}).</p>\n",
        record.axes.iter().map(|a| escaped(a)).collect::<Vec<_>>().join(", "),
        record.width,
        record.height,
        escaped(&record.command),
        record.program.version,
        escaped(&record.program.git),
    );
    let _ = writeln!(
        text,
        "<p>Device of all times: {} ({}), {}, Vulkan {}.</p>",
        escaped(&d.name),
        escaped(&d.kind),
        escaped(&d.driver),
        escaped(&d.api)
    );
    if d.kind == "cpu" {
        text += "<p class=\"note\"><b>This is a software device.</b> Its times are its own and say nothing of a GPU's; \
                 errors do not depend on the kind of device.</p>\n";
    }
    let Some(t) = &record.truth else { return text };
    let hidden = match &t.truncation {
        None => "what lies deeper is unknown".into(),
        Some(h) if h.pixels == 0 => "no path goes deeper".into(),
        Some(h) => format!("deeper paths hide an RMSE of at most {:.1e}", h.rms),
    };
    let _ = writeln!(
        text,
        "<p>Truth: {}, depth {} ({hidden}); {:.0} Owen-scrambled samples a pixel on average, {} at most, in 16 \
         replicates. Its own standard error is <b>{:.1e}</b> (RMSE){}. Errors are in linear light clamped to [0, 1]. \
         <i>Limit</i> is what infinitely many samples would leave of an error; <i>sampling</i> is the rest; \
         <i>rounding</i> is the difference from the same settings in f64. Efficiency is \
         1/(MSE &times; time). One sample lies at the pixel's centre.</p>",
        escaped(&t.identity.tracer),
        t.identity.depth,
        t.samples_mean,
        t.samples_most,
        t.standard_error,
        if t.converged {
            ", under a tenth of the smallest error below"
        } else {
            ", <b>more than a tenth of the smallest error below</b>: small errors are uncertain by that much; \
             a larger --truth-samples mends it"
        }
    );
    text
}

fn front(record: &Record) -> String {
    let mut rows: Vec<&Row> = record.rows.iter().filter(|r| r.on_front).collect();
    rows.sort_by(|a, b| a.seconds().total_cmp(&b.seconds()));
    let cells =
        rows.iter().map(|r| [r.name.clone(), seconds(r.seconds()), error(r.rmse()), error(r.efficiency)]);
    table("The front: no point is both faster and better", &["point", "time", "RMSE", "efficiency"], cells)
}

fn cheapest(record: &Record) -> String {
    let cells = record.cheapest.iter().map(|c| {
        [
            c.name.clone().unwrap_or("none of these points".into()),
            error(Some(c.error)),
            c.seconds.map_or("-".into(), seconds),
            error(c.rmse),
        ]
    });
    table("The cheapest point for an error", &["point", "RMSE asked for", "time", "its RMSE"], cells)
}

fn slopes(record: &Record) -> String {
    let cells = record.slopes.iter().map(|s| {
        let sure = s.uncertainty.map_or(String::new(), |u| format!(" &plusmn; {u:.2}"));
        [s.line.clone(), format!("{:.2}{sure}", s.fitted), s.theory.clone(), s.points.to_string()]
    });
    table("Slope of the sampling error against samples", &["line", "fitted", "theory", "points"], cells)
}

/// Ratios by samples: predicted is two.
fn doublings(record: &Record) -> String {
    let mut counts: Vec<u32> = record.doublings.iter().map(|d| d.samples).collect();
    counts.sort_unstable();
    counts.dedup();
    let cells = counts.iter().map(|n| {
        let of: Vec<f64> = record.doublings.iter().filter(|d| d.samples == *n).map(|d| d.ratio).collect();
        let hold = of.iter().filter(|r| (*r / 2.0 - 1.0).abs() <= 0.2).count();
        let q = quartiles(&of);
        [
            format!("{n} to {}", 2 * n),
            q.map_or("-".into(), |q| format!("{:.2}", q.median)),
            q.map_or("-".into(), |q| format!("{:.2} to {:.2}", q.lower, q.upper)),
            format!("{hold} of {}", of.len()),
        ]
    });
    let heads = ["samples", "device time, ratio (median; 2 is predicted)", "middle half", "within 20 %"];
    table("Twice the samples, twice the time?", &heads, cells)
}

/// Each precision against `robust` at the same settings otherwise.
fn precisions(record: &Record) -> String {
    let mut names: Vec<&str> = record.rows.iter().map(|r| r.point.precision.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    if names.len() < 2 {
        return String::new();
    }
    let base = if names.contains(&"robust") { "robust" } else { names[0] };
    let cells = names.iter().map(|name| {
        let of = record.rows.iter().filter(|r| r.point.precision == *name);
        let (mut times, mut errors, mut rounding) = (vec![], vec![], vec![]);
        for row in of {
            let mut other = row.point.clone();
            other.precision = base.into();
            let Some(other) = record.rows.iter().find(|r| r.point == other) else { continue };
            times.push(row.measured.device.median / other.measured.device.median);
            errors.extend(row.rmse().zip(other.rmse()).map(|(a, b)| a / b));
            rounding.extend(row.error.as_ref().and_then(|e| e.rounding));
        }
        let factor = |list: &[f64]| median(list).map_or("-".into(), |m| format!("{m:.3}"));
        let most = rounding.iter().copied().reduce(f64::max);
        [(*name).to_owned(), factor(&times), factor(&errors), error(median(&rounding)), error(most)]
    });
    let time = format!("device time / {base}'s (median)");
    let rmse = format!("RMSE / {base}'s (median)");
    table("Precisions", &["precision", &time, &rmse, "rounding: RMSE from f64 (median)", "at most"], cells)
}

fn gallery(pictures: &[Shown]) -> String {
    let color = |i: u32| heat(f64::from(i) / 8.0);
    let stops: Vec<String> = (0..=8).map(color).map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
    let mut text = format!(
        "<h2>Pictures</h2><p>Below each its largest channel's difference from the truth: \
         {LEAST} <span class=\"ramp\" style=\"background:linear-gradient(90deg,{})\"></span> 1 in decades, black below. \
         The front, and the worst and the slowest point.</p>\n<div class=\"pictures\">",
        stops.join(",")
    );
    for shown in pictures {
        let [width, height] = shown.size;
        let image = |bytes: &[u8]| {
            format!(
                "<img width=\"{width}\" height=\"{height}\" alt=\"\" src=\"data:image/png;base64,{}\">",
                base64(bytes)
            )
        };
        let difference = shown.difference.as_deref().map_or(String::new(), image);
        let title = escaped(&shown.title);
        let _ = writeln!(
            text,
            "<figure><figcaption>{title}</figcaption>{}{difference}</figure>",
            image(&shown.picture)
        );
    }
    text + "</div>\n"
}

fn rows(record: &Record) -> String {
    let axes: Vec<String> =
        record.axes.iter().map(|a| format!("<th class=\"l\">{}</th>", escaped(a))).collect();
    let heads = [
        "time",
        "IQR",
        "device",
        "IQR",
        "n",
        "rays",
        "primary",
        "reflection",
        "refraction",
        "shadow",
        "RMSE",
        "sampling",
        "limit",
        "rounding",
        "truth &plusmn;",
        "mean abs",
        "max",
        "p99.9",
        "PSNR dB",
        "FLIP",
        "codes mean",
        "max",
        "efficiency",
    ];
    let mut text = format!(
        "<h2>All points</h2><p>Click a heading to sort. <i>n</i>: renders behind the median; a point that takes over 10 s is \
         rendered once. The front is tinted.</p>\n<div class=\"scroll\"><table class=\"rows\"><thead><tr>{}<th>{}</th></tr></thead><tbody>\n",
        axes.concat(),
        heads.join("</th><th>")
    );
    for row in &record.rows {
        text += if row.on_front { "<tr class=\"front\">" } else { "<tr>" };
        for axis in &record.axes {
            let _ = write!(text, "<td class=\"l\">{}</td>", escaped(&row.point.value(axis)));
        }
        let (m, r) = (&row.measured, &row.rays);
        let mut cell = |value: f64, shown: String| {
            let _ = write!(text, "<td data-v=\"{value:e}\">{shown}</td>");
        };
        for time in [m.render.median, m.render.iqr, m.device.median, m.device.iqr] {
            cell(time, seconds(time));
        }
        cell(m.repeats.into(), m.repeats.to_string());
        for count in [r.total(), r.primary, r.reflection, r.refraction, r.shadow] {
            cell(count as f64, short(count as f64));
        }
        match &row.error {
            None => text += &"<td>-</td>".repeat(13),
            Some(e) => {
                let m = &e.metrics;
                let known = |x: Option<f64>| x.unwrap_or(f64::INFINITY);
                cell(e.total, error(Some(e.total)));
                cell(known(e.sampling), error(e.sampling));
                cell(known(e.limit), error(e.limit));
                cell(known(e.rounding), error(e.rounding));
                for x in [e.truth, m.mean_abs, m.max_abs, m.p999] {
                    cell(x, error(Some(x)));
                }
                cell(known(m.psnr), m.psnr.map_or("-".into(), |p| format!("{p:.1}")));
                cell(e.flip, error(Some(e.flip)));
                cell(m.code_mean, format!("{:.3}", m.code_mean));
                cell(m.code_max.into(), m.code_max.to_string());
                cell(row.efficiency.unwrap_or(0.0), error(row.efficiency));
            }
        }
        text += "</tr>\n";
    }
    text + "</tbody></table></div>\n"
}

/// A table whose first column is words.
fn table<const N: usize>(title: &str, heads: &[&str; N], rows: impl Iterator<Item = [String; N]>) -> String {
    let mut body = String::new();
    for row in rows {
        for (i, cell) in row.iter().enumerate() {
            let _ = match i {
                0 => write!(body, "<tr><td class=\"l\">{}</td>", escaped(cell)),
                _ => write!(body, "<td>{cell}</td>"),
            };
        }
        body += "</tr>\n";
    }
    if body.is_empty() {
        return String::new();
    }
    let heads: Vec<String> = heads.iter().map(|h| format!("<th>{}</th>", escaped(h))).collect();
    let heads = heads.concat().replacen("<th>", "<th class=\"l\">", 1);
    format!(
        "<h2>{title}</h2><div class=\"scroll\"><table><thead><tr>{heads}</tr></thead><tbody>\n{body}</tbody></table></div>\n"
    )
}

fn error(x: Option<f64>) -> String {
    match x {
        None => "-".into(),
        Some(0.0) => "0".into(),
        Some(x) if (1e-3..1e6).contains(&x) => crate::units::number((x * 1e6).round() / 1e6),
        Some(x) => format!("{x:.2e}"),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let word = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= three.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors of RFC 4648, section 10.
    #[test]
    fn base64_is_the_standards() {
        for (text, want) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
        ] {
            assert_eq!(base64(text.as_bytes()), want);
        }
    }

    #[test]
    fn what_the_user_wrote_is_text_not_markup() {
        let record = Record { scene: "<b>&\".toml".into(), rows: vec![Row::default()], ..Record::default() };
        let text = page(&record, &[], &[]);
        assert!(text.contains("&lt;b&gt;&amp;&quot;.toml") && !text.contains("<b>&"));
        // One file: nothing is fetched.
        assert!(!text.contains("http") && !text.contains("src=\"/") && !text.contains("@import"));
    }

    #[test]
    fn a_software_device_is_named_as_one() {
        let mut record = Record::default();
        record.device.kind = "cpu".into();
        assert!(page(&record, &[], &[]).contains("say nothing of a GPU"));
        record.device.kind = "discrete".into();
        assert!(!page(&record, &[], &[]).contains("say nothing of a GPU"));
    }
}
