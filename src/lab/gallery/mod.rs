//! Pictures with several sample counts and depths, and a contact sheet of all.

mod sheet;
mod window;

pub use sheet::{Cell, Section, Sheet};

use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::sampler::Sampler;
use crate::units::plural;
use std::path::{Path, PathBuf};

/// Samples per pixel of the first row.
const SAMPLES: [u32; 4] = [1, 2, 4, 10];
/// Depths of the second row.
const DEPTHS: [u32; 4] = [1, 2, 3, 4];
/// Most samples per pixel of the second row: depth is visible without smooth edges.
const DEPTH_ROW_SAMPLES: u32 = 4;
/// Suffix of the name of a scene's variant with glass.
const SIBLING: &str = "_glass";

/// A scene to render, with the name of its pictures.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Stem of its file.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// Pictures under one heading.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What varies along the row, as `gallery.json` names it.
    pub name: &'static str,
    /// Heading of the row.
    pub heading: String,
    /// From left to right.
    pub pictures: Vec<Picture>,
}

/// One picture to render.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// File name without extension.
    pub name: String,
    /// Index into the subjects.
    pub subject: usize,
    /// Settings.
    pub settings: Settings,
}

/// The pictures of `subjects`: a row of sample counts for the first, and a row of depths for each,
/// since mirrors and glass need different depths. `scale` multiplies all sizes.
pub fn rows(subjects: &[Subject], seed: u32, scale: f64) -> Vec<Row> {
    let settings = |subject: &Subject| {
        let own = Settings::of(&subject.scene);
        let side = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).max(1);
        // Independent samples, so that the row shows the effect of their number alone, and pictures
        // stay comparable with earlier ones.
        let sampler = Sampler::Random;
        Settings { width: side(own.width), height: side(own.height), sampler, seed, ..own }
    };
    let Some(first) = subjects.first().map(settings) else {
        return Vec::new();
    };
    let samples = SAMPLES.map(|samples| Picture {
        name: format!("samples_{samples:02}"),
        subject: 0,
        settings: Settings { samples, ..first.clone() },
    });
    let mut rows = vec![Row {
        name: "samples",
        heading: format!("Anti-aliasing: samples per pixel, at depth {}", first.depth),
        pictures: samples.into(),
    }];
    for (subject, s) in subjects.iter().enumerate() {
        let own = settings(s);
        let samples = own.samples.min(DEPTH_ROW_SAMPLES);
        let of = if subject == 0 { String::new() } else { format!("_{}", s.name) };
        let pictures = DEPTHS.map(|depth| Picture {
            name: format!("depth{of}_{depth}"),
            subject,
            settings: Settings { depth, samples, ..own.clone() },
        });
        let with = plural(samples.into(), "sample");
        let heading = format!("Depth: rays in the longest path, with {with}, of {}", s.name);
        rows.push(Row { name: "depth", heading, pictures: pictures.into() });
    }
    let finals = subjects.iter().enumerate().map(|(subject, s)| Picture {
        name: format!("final_{}", s.name),
        subject,
        settings: settings(s),
    });
    rows.push(Row {
        name: "final",
        heading: "At the scenes' own settings".into(),
        pictures: finals.collect(),
    });
    rows
}

/// Path of the variant of a scene: `a_glass.toml` for `a.toml`, and vice versa.
pub fn sibling(scene: &Path) -> Option<PathBuf> {
    let stem = scene.file_stem()?.to_str()?;
    let other = match stem.strip_suffix(SIBLING) {
        Some(plain) => plain.to_owned(),
        None => format!("{stem}{SIBLING}"),
    };
    let path = scene.with_file_name(other).with_extension(scene.extension()?);
    path.is_file().then_some(path)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::scene::{Camera, Notes, ReadTime, RenderDefaults};
    use glam::DVec3;

    pub(crate) fn subject(name: &str, width: u32, samples: u32) -> Subject {
        let camera =
            Camera { look_from: DVec3::Z, look_at: DVec3::ZERO, up: DVec3::Y, fov: 1.0, width, height: 5 };
        let scene = Scene {
            file: PathBuf::new(),
            read_time: ReadTime::default(),
            camera,
            render: RenderDefaults { samples, depth: 3, background: DVec3::ZERO },
            lights: vec![],
            materials: vec![],
            spheres: vec![],
            polygons: vec![],
            meshes: vec![],
            notes: Notes::default(),
        };
        Subject { name: name.into(), scene }
    }

    #[test]
    fn rows_vary_one_thing_each() {
        let rows = rows(&[subject("a", 60, 20), subject("b", 30, 5)], 7, 0.5);
        let of = |row: usize| {
            let told = |p: &Picture| (p.name.clone(), p.settings.width, p.settings.samples, p.settings.depth);
            rows[row].pictures.iter().map(told).collect::<Vec<_>>()
        };
        let want = |list: &[(&str, u32, u32, u32)]| {
            list.iter().map(|&(n, w, s, d)| (n.to_owned(), w, s, d)).collect::<Vec<_>>()
        };
        assert_eq!(
            of(0),
            want(&[
                ("samples_01", 30, 1, 3),
                ("samples_02", 30, 2, 3),
                ("samples_04", 30, 4, 3),
                ("samples_10", 30, 10, 3)
            ])
        );
        assert_eq!(
            of(1),
            want(&[
                ("depth_1", 30, 4, 1),
                ("depth_2", 30, 4, 2),
                ("depth_3", 30, 4, 3),
                ("depth_4", 30, 4, 4)
            ])
        );
        assert_eq!(of(2)[0], ("depth_b_1".into(), 15, 4, 1));
        assert_eq!(of(3), want(&[("final_a", 30, 20, 3), ("final_b", 15, 5, 3)]));
        assert!(rows.iter().flat_map(|r| &r.pictures).all(|p| p.settings.seed == 7
            && p.settings.height == 3
            && p.settings.sampler == Sampler::Random));
    }

    #[test]
    fn few_samples_stay_few_and_sides_stay_above_zero() {
        let rows = rows(&[subject("a", 60, 2)], 0, 1e-6);
        assert!(rows[1].pictures.iter().all(|p| p.settings.samples == 2));
        assert_eq!((rows[0].pictures[0].settings.width, rows[0].pictures[0].settings.height), (1, 1));
    }

    #[test]
    fn siblings_find_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let (plain, glass) = (folder.path().join("a.toml"), folder.path().join("a_glass.toml"));
        std::fs::write(&plain, "").unwrap();
        assert_eq!(sibling(&plain), None);
        std::fs::write(&glass, "").unwrap();
        assert_eq!(sibling(&plain), Some(glass.clone()));
        assert_eq!(sibling(&glass), Some(plain));
    }
}
