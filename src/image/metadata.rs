//! What an image file says about its making. Unless times are asked for, nothing in it depends on the clock, so that
//! equal renders give equal files.

use crate::report::{ErrorInfo, Report};
use crate::units::{figure, number, seconds};

/// Keywords and texts, in file order; and where the image lies in a larger one, if it is a crop.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Metadata(Vec<(String, String)>, Option<Window>);

/// A part of a larger image, in its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Column and row of the part's first pixel.
    pub at: [u32; 2],
    /// Width and height of the part.
    pub size: [u32; 2],
    /// Width and height of the larger image.
    pub full: [u32; 2],
}

impl Window {
    /// True if all of the part lies inside the larger image.
    pub fn is_inside(&self) -> bool {
        (0..2).all(|i| self.at[i].checked_add(self.size[i]).is_some_and(|end| end <= self.full[i]))
    }

    /// The part of a larger image, rows from the top.
    pub fn cut<T: Copy>(&self, pixels: &[T]) -> Vec<T> {
        let Window { at: [x, y], size: [width, height], full: [stride, _] } = *self;
        let first = |row: u32| row as usize * stride as usize + x as usize;
        (y..y + height).flat_map(|row| &pixels[first(row)..first(row) + width as usize]).copied().collect()
    }
}

impl Metadata {
    /// From keywords (1 to 79 Latin letters) and texts.
    pub fn new<'a>(pairs: impl IntoIterator<Item = (&'a str, &'a str)>) -> Metadata {
        Metadata(pairs.into_iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect(), None)
    }

    /// Where the image lies in a larger one.
    pub(super) fn window(&self) -> Option<Window> {
        self.1
    }

    /// Version, scene, settings, seed, device, driver, rays and error statement of a render, of which the share `done`
    /// was finished. Without times: [`Metadata::with_times`] adds them.
    pub fn of(report: &Report, done: f64) -> Metadata {
        let Report { program, device, scene, settings, .. } = report;
        let mut about = format!(
            "{}x{} pixels, {} samples per pixel, depth {}, sampler {}, precision {}, origin {}",
            settings.width,
            settings.height,
            settings.samples,
            settings.depth,
            settings.sampler,
            settings.precision,
            settings.origin,
        );
        if let Some([x0, y0, x1, y1]) = settings.crop {
            about += &format!(", crop {x0},{y0},{x1},{y1}");
        }
        if settings.cutoff > 0.0 {
            about += &format!(", cutoff {}", settings.cutoff);
        }
        if settings.replicates > 1 {
            about += &format!(", replicates {}", settings.replicates);
        }
        if done < 1.0 && report.asked.time.is_some() {
            about += &format!(", only {:.1} % of the pixels traced", 100.0 * done);
        } else if done < 1.0 {
            about += &format!(", interrupted with {:.1} % done", 100.0 * done);
        }
        let mut metadata = Metadata::new([
            ("Software", format!("{} {} ({})", program.name, program.version, program.git).as_str()),
            ("Scene", &scene.file),
            ("Settings", &about),
            ("Seed", &settings.seed.to_string()),
            ("Device", &device.name),
            ("Driver", &format!("{}, Vulkan {}", device.driver, device.api)),
        ]);
        if !scene.variables.is_empty() {
            // A list of strings has a JSON text.
            metadata.add("Variables", serde_json::to_string(&scene.variables).unwrap_or_default());
        }
        if let Some(up) = &scene.up {
            metadata.add("Up", up.clone());
        }
        metadata.1 = settings.crop.map(|[x0, y0, x1, y1]| Window {
            at: [x0, y0],
            size: [x1.saturating_sub(x0), y1.saturating_sub(y0)],
            full: [settings.width, settings.height],
        });
        let rays = &report.rays;
        metadata.add(
            "Rays",
            format!(
                "primary {}, reflection {}, refraction {}, shadow {}",
                rays.primary, rays.reflection, rays.refraction, rays.shadow
            ),
        );
        if let Some(error) = &report.error {
            metadata.add("Error", statement(error));
        }
        if let Some(asked) = asked(report) {
            metadata.add("Asked", asked);
        }
        metadata
    }

    /// Adds the render time, from the first submit to the last pixel, and the wall time up to now, seconds. Equal renders
    /// then give files that differ.
    pub fn with_times(mut self, report: &Report) -> Metadata {
        let time = &report.time;
        self.add("Time", format!("render {:.6} s, wall {:.6} s", time.render, time.wall));
        self
    }

    fn add(&mut self, keyword: &str, text: String) {
        self.0.push((keyword.to_owned(), text));
    }

    /// In file order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(k, v)| (k.as_str(), v.as_str()))
    }

    /// One `keyword: text` per line; line breaks inside a text become spaces.
    pub fn lines(&self) -> Vec<String> {
        self.iter().map(|(k, v)| format!("{k}: {}", v.replace(['\n', '\r'], " "))).collect()
    }
}

/// The bound on the error and its parts: RMSE, linear light clamped to [0, 1].
fn statement(error: &ErrorInfo) -> String {
    let ErrorInfo { kind, confidence, sampling, truncation, rounding, total, .. } = error;
    let rounding = rounding.map_or("not measured".into(), figure);
    let unbounded = if error.truncation_bounded { "" } else { " (with values above 1 clamped)" };
    format!(
        "{kind} at most {} with {} % confidence: sampling {}, truncation {}{unbounded}, rounding {rounding}",
        figure(*total),
        number(100.0 * confidence),
        figure(*sampling),
        figure(*truncation),
    )
}

/// The error or time asked for. Whether an error was kept; of a time only that it was not, since it runs until the file
/// is written.
fn asked(report: &Report) -> Option<String> {
    let asked = &report.asked;
    let what = match (asked.error, asked.time) {
        (Some(error), _) => format!("an error of {}", number(error)),
        (_, Some(time)) => seconds(time),
        _ => return None,
    };
    Some(match (asked.met, asked.error) {
        (Some(true), Some(_)) => format!("{what}: kept"),
        (Some(false), _) => {
            format!("{what}: not kept, {}", asked.unmet_why.as_deref().unwrap_or("no reason known"))
        }
        _ => what,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text<'a>(metadata: &'a Metadata, keyword: &str) -> Option<&'a str> {
        metadata.iter().find(|(k, _)| *k == keyword).map(|(_, text)| text)
    }

    fn report() -> Report {
        let mut report = Report::default();
        (report.rays.primary, report.rays.reflection, report.rays.shadow) = (4800, 70, 4321);
        (report.time.render, report.time.wall) = (0.25, 1.5);
        report
    }

    #[test]
    fn a_plain_render_has_rays_and_neither_error_nor_times() {
        let metadata = Metadata::of(&report(), 1.0);
        assert_eq!(text(&metadata, "Rays"), Some("primary 4800, reflection 70, refraction 0, shadow 4321"));
        for keyword in ["Error", "Asked", "Time"] {
            assert_eq!(text(&metadata, keyword), None);
        }
        // Another clock, the same metadata; unless times are asked for.
        let mut slow = report();
        (slow.time.render, slow.time.wall, slow.time.device) = (25.0, 30.0, 20.0);
        assert_eq!(Metadata::of(&slow, 1.0), metadata);
        let timed = metadata.with_times(&report());
        assert_eq!(text(&timed, "Time"), Some("render 0.250000 s, wall 1.500000 s"));
    }

    #[test]
    fn the_error_and_the_request_are_stated() {
        let mut report = report();
        report.error = Some(ErrorInfo {
            kind: "rmse".into(),
            confidence: 0.95,
            sampling: 0.0123,
            truncation: 8.28e-4,
            truncation_bounded: true,
            total: 0.0146,
            ..ErrorInfo::default()
        });
        report.asked.error = Some(0.02);
        report.asked.met = Some(true);
        let metadata = Metadata::of(&report, 1.0);
        let want = "rmse at most 0.0146 with 95 % confidence: sampling 0.0123, truncation 8.28e-4, rounding not measured";
        assert_eq!(
            (text(&metadata, "Error"), text(&metadata, "Asked")),
            (Some(want), Some("an error of 0.02: kept"))
        );
        report.asked.met = Some(false);
        report.asked.unmet_why = Some("too deep".into());
        let metadata = Metadata::of(&report, 1.0);
        assert_eq!(text(&metadata, "Asked"), Some("an error of 0.02: not kept, too deep"));

        // A time is not over before the file is written.
        (report.asked.error, report.asked.time, report.asked.met) = (None, Some(2.0), Some(true));
        assert_eq!(text(&Metadata::of(&report, 1.0), "Asked"), Some("2.00 s"));
    }
}
