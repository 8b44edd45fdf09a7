//! The plan of a render as text for people.

use super::{ExplainedPlan, Planned};
use crate::report::prediction::Prediction;
use crate::report::table::{Align, Table};
use crate::units::{bytes, figure, grouped, number, plural, seconds, short};

/// Buffers smaller than the total divided by this are listed as one row.
const SMALL: u64 = 1000;

/// The whole outline.
pub fn text(o: &ExplainedPlan) -> String {
    let mut parts = vec![about(o), features(o)];
    if let Some(plan) = &o.plan {
        parts.extend([kernels(plan), memory(o, plan)]);
    }
    if let Some(time) = &o.time {
        parts.push(forecast(time));
    }
    if let Some(error) = &o.error {
        parts.push(format!(
            "error   {} expected, from {}; {} was asked for\n",
            figure(error.expected),
            plural(error.pixels.into(), "pixel"),
            number(error.asked)
        ));
    }
    if let Some(refused) = &o.refused {
        parts.push(format!("refused: {}\nexit code {}\n", refused.message, refused.exit_code));
    }
    parts.join("\n")
}

fn about(o: &ExplainedPlan) -> String {
    let (d, s) = (&o.device, &o.settings);
    let [x, y, z] = o.local_frame.center.map(number);
    let crop = s.crop.map_or(String::new(), |[x0, y0, x1, y1]| format!(", crop {x0},{y0},{x1},{y1}"));
    let lines = [
        ("device", format!("{} ({}), {}, Vulkan {}", d.name, d.kind, d.driver, d.api)),
        ("scene", o.scene.clone()),
        ("frame", format!("local = (world - ({x}, {y}, {z})) * 2^{}", o.local_frame.scale_log2)),
        (
            "image",
            format!(
                "{}x{} pixels{crop}, {} per pixel, depth {}; sampler {}, seed {}, precision {}, origin {}",
                s.width,
                s.height,
                plural(s.samples.into(), "sample"),
                s.depth,
                s.sampler,
                s.seed,
                s.precision,
                s.origin,
            ),
        ),
    ];
    lines.iter().fold(String::new(), |text, (name, line)| text + &format!("{name:<7} {line}\n"))
}

fn features(o: &ExplainedPlan) -> String {
    let mut table = Table::new(&[("feature", Align::Left), ("found", Align::Left), ("", Align::Left)]);
    for row in &o.features {
        let found = if row.found { "yes" } else { "no" };
        table.row([row.name.into(), found.into(), row.detail.clone()]);
    }
    let mut search = format!("traversal  {}: {}", o.search.kind, o.search.why);
    if o.search.nodes > 0 {
        search += &format!("; {}, {}", plural(o.search.nodes, "node"), plural(o.search.depth, "level"));
    }
    let max_depth = format!("max depth  {} of {}: {}", o.max_depth.last, o.max_depth.asked, o.max_depth.why);
    format!("{table}\n{search}\n{max_depth}\n")
}

fn kernels(p: &Planned) -> String {
    let run: Vec<String> = p
        .kernels
        .iter()
        .map(|k| match k.launches {
            1 => format!("{} ({})", k.kernel, k.form),
            n => format!("{} ({}) x{n}", k.kernel, k.form),
        })
        .collect();
    let yes = |on: bool| if on { "yes" } else { "no" };
    let mut text = format!("kernels per batch: {}\n", run.join(", "));
    text += &format!("texel views: {}; {}\n\n", yes(p.texels), p.texels_why);
    let mut table = Table::new(&[
        ("constant", Align::Left),
        ("value", Align::Right),
        ("general", Align::Right),
        ("effect", Align::Left),
    ]);
    for c in &p.constants {
        let general = c.general.map_or("any".into(), |g| g.to_string());
        table.row([c.name.into(), c.value.to_string(), general, c.why.clone()]);
    }
    text + &table.to_string()
}

fn memory(o: &ExplainedPlan, p: &Planned) -> String {
    let mut table =
        Table::new(&[("buffer", Align::Left), ("elements", Align::Right), ("bytes", Align::Right)]);
    let (large, small): (Vec<_>, Vec<_>) = p.buffers.iter().partition(|b| b.bytes * SMALL >= p.bytes);
    for b in large {
        table.row([b.name.into(), grouped(b.elements), bytes(b.bytes)]);
    }
    let rest = small.iter().map(|b| b.bytes).sum();
    table.row([plural(small.len() as u64, "smaller buffer"), String::new(), bytes(rest)]);
    table.row(["all".into(), String::new(), bytes(p.bytes)]);
    format!(
        "{table}\nqueue   {} rays, {} each; workgroups of {}; {} per shadow pass\n\
         work    {} of up to {} pixels, batches of up to {} per pixel; {} in total, {} each\n\
         limits  {} per buffer, {} in total (of a heap of {})\n\
         host    {} for the image, {} with its error bounded\n",
        grouped(p.capacity.into()),
        bytes(p.bytes_per_place),
        p.workgroup,
        plural(p.lights_per_pass.into(), "light"),
        plural(p.tiles, "tile"),
        grouped(p.tile_pixels.into()),
        plural(p.batch_samples.into(), "sample"),
        if p.batches == 1 { "1 batch".into() } else { format!("{} batches", grouped(p.batches)) },
        if p.dispatches == 1 { "1 dispatch".into() } else { format!("{} dispatches", grouped(p.dispatches)) },
        bytes(o.limits.one_buffer),
        bytes(o.limits.heap_share),
        bytes(o.limits.heap),
        bytes(o.host.image),
        bytes(o.host.bounded),
    )
}

/// The predicted time.
pub fn forecast(t: &Prediction) -> String {
    let mut table = Table::new(&[
        ("depth", Align::Right),
        ("rays", Align::Right),
        ("shadow rays", Align::Right),
        ("time", Align::Right),
        ("", Align::Left),
    ]);
    for d in &t.by_depth {
        let note = if d.extrapolated { "extrapolated" } else { "" };
        table.row([
            d.depth.to_string(),
            short(d.traced as f64),
            short(d.shadow as f64),
            seconds(d.seconds),
            note.into(),
        ]);
    }
    let start = t.start.map_or(String::new(), |s| format!(", plus {} start-up", seconds(s)));
    format!(
        "{table}\npredicted render time: {} ({} to {}) for {} rays{start}\nbased on {}\n",
        seconds(t.render),
        seconds(t.low),
        seconds(t.high),
        short(t.rays as f64),
        t.basis,
    )
}
