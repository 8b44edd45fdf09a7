//! What an image file says about its making. Nothing in it depends on the time, so that equal
//! renders give equal files.

use crate::report::Report;

/// Keywords and texts, in file order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Metadata(Vec<(String, String)>);

impl Metadata {
    /// From keywords (1 to 79 Latin letters) and texts.
    pub fn new<'a>(pairs: impl IntoIterator<Item = (&'a str, &'a str)>) -> Metadata {
        Metadata(pairs.into_iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect())
    }

    /// Version, scene, settings, seed, device and driver of a render, of which the share `done` was
    /// finished.
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
        if done < 1.0 && report.asked.time.is_some() {
            about += &format!(", only {:.1} % of the pixels traced", 100.0 * done);
        } else if done < 1.0 {
            about += &format!(", interrupted with {:.1} % done", 100.0 * done);
        }
        Metadata::new([
            ("Software", format!("{} {} ({})", program.name, program.version, program.git).as_str()),
            ("Scene", &scene.file),
            ("Settings", &about),
            ("Seed", &settings.seed.to_string()),
            ("Device", &device.name),
            ("Driver", &format!("{}, Vulkan {}", device.driver, device.api)),
        ])
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
