//! The render that a picture's metadata describes: the inverse of [`Metadata::of`](super::Metadata::of).

use crate::report::{ErrorInfo, Report};

/// The report of the render, as far as `metadata` tells it: program, device, scene, settings, and what was asked for.
/// `None` where the picture is no complete one of this program.
pub fn described(metadata: &[(String, String)]) -> Option<Report> {
    let get = |keyword: &str| metadata.iter().find(|(k, _)| k == keyword).map(|(_, text)| text.as_str());
    let mut report = Report::default();
    let mut software = get("Software")?.split(' ');
    if software.next()? != env!("CARGO_PKG_NAME") {
        return None;
    }
    report.program.version = software.next().unwrap_or_default().to_owned();
    report.scene.file = get("Scene")?.to_owned();
    report.scene.up = get("Up").map(str::to_owned);
    report.scene.variables =
        get("Variables").map_or(Some(Vec::new()), |text| serde_json::from_str(text).ok())?;
    report.device.name = get("Device").unwrap_or_default().to_owned();
    if let Some((driver, api)) = get("Driver").and_then(|text| text.rsplit_once(", Vulkan ")) {
        (report.device.driver, report.device.api) = (driver.to_owned(), api.to_owned());
    }

    let settings = &mut report.settings;
    settings.seed = get("Seed")?.parse().ok()?;
    settings.replicates = 1;
    let list = |text: &str| -> Option<Vec<u32>> { text.split(',').map(|n| n.parse().ok()).collect() };
    // A crop is a list of numbers with commas but no spaces.
    for part in get("Settings")?.split(", ") {
        let (first, rest) = part.split_once(' ')?;
        match (first, rest) {
            (size, "pixels") => {
                let (width, height) = size.split_once('x')?;
                (settings.width, settings.height) = (width.parse().ok()?, height.parse().ok()?);
            }
            (samples, "samples per pixel") => settings.samples = samples.parse().ok()?,
            ("depth", depth) => settings.depth = depth.parse().ok()?,
            ("sampler", sampler) => settings.sampler = sampler.to_owned(),
            ("precision", precision) => settings.precision = precision.to_owned(),
            ("origin", origin) => settings.origin = origin.to_owned(),
            ("crop", crop) => settings.crop = Some(list(crop)?.try_into().ok()?),
            ("cutoff", cutoff) => settings.cutoff = cutoff.parse().ok()?,
            ("replicates", replicates) => settings.replicates = replicates.parse().ok()?,
            // Interrupted, or short of time.
            _ => return None,
        }
    }

    if let Some(error) = get("Error") {
        // The confidence is all that another render needs of it.
        let (_, rest) = error.split_once(" with ")?;
        let confidence = rest.split_once(" % confidence")?.0.parse::<f64>().ok()? / 100.0;
        report.error = Some(ErrorInfo { confidence, ..ErrorInfo::default() });
    }
    if let Some(asked) = get("Asked") {
        match asked.strip_prefix("an error of ") {
            Some(error) => report.asked.error = Some(error.split(':').next()?.parse().ok()?),
            None => report.asked.time = Some(asked.split(' ').next()?.parse().ok()?),
        }
    }
    Some(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Metadata;

    fn pairs(report: &Report, done: f64) -> Vec<(String, String)> {
        Metadata::of(report, done).iter().map(|(k, v)| (k.into(), v.into())).collect()
    }

    #[test]
    fn what_was_written_is_described() {
        let mut report = Report::default();
        report.scene.file = "a, b/ö.toml".into();
        report.scene.variables = vec!["frame=7".into(), "name=it's".into()];
        report.scene.up = Some("-z".into());
        report.device.name = "a device".into();
        (report.device.driver, report.device.api) = ("it, Vulkan driver 7".into(), "1.3.230".into());
        let s = &mut report.settings;
        (s.width, s.height, s.samples, s.depth, s.seed) = (60, 50, 4, 3, 9);
        (s.sampler, s.precision, s.origin) = ("stratified".into(), "f64".into(), "fixed:0.1".into());
        (s.crop, s.cutoff, s.replicates) = (Some([1, 2, 30, 40]), 0.01, 2);
        let error = ErrorInfo { kind: "RMSE".into(), confidence: 0.9, total: 0.1, ..ErrorInfo::default() };
        report.error = Some(error);
        let found = described(&pairs(&report, 1.0)).unwrap();
        let json = |r: &Report| serde_json::to_value((&r.scene, &r.settings, &r.asked)).unwrap();
        assert_eq!(json(&found), json(&report));
        assert_eq!((&found.device.name, &found.device.driver), (&report.device.name, &report.device.driver));
        assert_eq!(found.error.unwrap().confidence, 0.9);

        report.asked.error = Some(0.02);
        report.asked.met = Some(true);
        assert_eq!(described(&pairs(&report, 1.0)).unwrap().asked.error, Some(0.02));
        assert!(described(&pairs(&report, 0.5)).is_none(), "interrupted");
        (report.asked.error, report.asked.time) = (None, Some(2.0));
        assert_eq!(described(&pairs(&report, 1.0)).unwrap().asked.time, Some(2.0));
        assert!(described(&[("Software".into(), "another 1".into())]).is_none());
        assert!(described(&[]).is_none());
    }
}
