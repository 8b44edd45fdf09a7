//! What to measure, on which scenes.

use crate::report::{DeviceInfo, ProgramInfo};
use crate::scene::procedural::families::Family;
use crate::scene::{Notes, ReadTime, Scene};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::path::PathBuf;

/// Scenes of one family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Chosen {
    /// The family.
    pub family: Family,
    /// The only scene to take; `None` for the first [`Plan::scenes`].
    pub number: Option<u32>,
}

/// A scene that was read from a file; the tables show it as a family of one.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneFile {
    /// Its name in tables: the file's, without folder and extension.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

impl SceneFile {
    /// Name and a hash of all that the scene says.
    pub(super) fn fingerprint(&self) -> (String, String) {
        let scene = Scene {
            file: PathBuf::new(),
            read_time: ReadTime::default(),
            notes: Notes::default(),
            ..self.scene.clone()
        };
        let hash = Sha256::digest(format!("{scene:?}"));
        (self.name.clone(), hash.iter().map(|byte| format!("{byte:02x}")).collect())
    }
}

/// A scene to measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// That scene of a family.
    Drawn(Family, u32),
    /// Index into [`Plan::files`].
    File(usize),
}

/// A calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Scenes from files.
    pub files: Vec<SceneFile>,
    /// Families to draw scenes from.
    pub families: Vec<Chosen>,
    /// Scenes of each family; their numbers are 0, 1, ...
    pub scenes: u32,
    /// How each scene is measured.
    pub trials: Trials,
}

/// How one scene is measured. Records of other trials are not comparable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trials {
    /// Seed that scenes are drawn with.
    pub seed: u64,
    /// Pixels of every image.
    pub width: u32,
    /// Pixels of every image.
    pub height: u32,
    /// Sampler seeds per scene and setting: 1, 2, ...
    pub seeds: u32,
    /// Samples per pixel for `--budget`.
    pub samples: Vec<u32>,
    /// Values of `--error`, RMSE.
    pub errors: Vec<f64>,
    /// Values of `--time`, seconds.
    pub times: Vec<f64>,
    /// Confidence of all error bounds, in (0, 1).
    pub confidence: f64,
    /// Most rays of one truth.
    pub truth_rays: f64,
}

/// First line of a file of records: what all records in it have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The program that made them.
    pub program: ProgramInfo,
    /// The device that rendered.
    pub device: DeviceInfo,
    /// The trials.
    pub trials: Trials,
    /// Scenes from files: name, and hash of the content.
    #[serde(default)]
    pub files: Vec<(String, String)>,
}

/// The scenes named by words such as `all`, `wires` and `wires:3`, each once.
///
/// # Errors
/// If a word names no family, or no number follows its colon; says what to write.
pub fn choose(words: &[String]) -> Result<Vec<Chosen>, String> {
    let mut chosen = Vec::new();
    for word in words {
        let (name, number) = match word.split_once(':') {
            None => (word.as_str(), None),
            Some((name, number)) => {
                let number = number.parse().map_err(|_| {
                    format!("`{word}`: write the number of a scene after the colon, such as wires:3")
                })?;
                (name, Some(number))
            }
        };
        match name {
            "all" => chosen.extend(Family::ALL.map(|family| Chosen { family, number })),
            _ => chosen.push(Chosen { family: name.parse()?, number }),
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

impl Plan {
    /// Every scene: the files, then those of families.
    pub fn list(&self) -> Vec<Subject> {
        let drawn = self.drawn().into_iter().map(|(family, number)| Subject::Drawn(family, number));
        (0..self.files.len()).map(Subject::File).chain(drawn).collect()
    }

    /// Family and number of every drawn scene: first the first scene of each family, so that an early end has met them
    /// all.
    pub fn drawn(&self) -> Vec<(Family, u32)> {
        let mut list: Vec<(Family, u32)> = Vec::new();
        for chosen in &self.families {
            match chosen.number {
                Some(number) => list.push((chosen.family, number)),
                None => list.extend((0..self.scenes).map(|number| (chosen.family, number))),
            }
        }
        list.sort_unstable_by_key(|(family, number)| (*number, *family));
        list.dedup();
        list
    }

    /// Family and number in the records.
    pub(super) fn key(&self, subject: Subject) -> (&str, u32) {
        match subject {
            Subject::Drawn(family, number) => (family.name(), number),
            Subject::File(at) => (&self.files[at].name, 0),
        }
    }
}

impl Header {
    /// What differs from `other`, for people; `None` if nothing does.
    pub fn difference(&self, other: &Header) -> Option<String> {
        let (a, b) = (&self.trials, &other.trials);
        let all = [
            (
                "program",
                same(
                    &(&self.program.version, &self.program.git),
                    &(&other.program.version, &other.program.git),
                ),
            ),
            (
                "device",
                same(&(&self.device.name, &self.device.driver), &(&other.device.name, &other.device.driver)),
            ),
            ("scenes", same(&self.files, &other.files)),
            ("--seed", same(&a.seed, &b.seed)),
            ("--size", same(&[a.width, a.height], &[b.width, b.height])),
            ("--seeds", same(&a.seeds, &b.seeds)),
            ("--samples", same(&a.samples, &b.samples)),
            ("--errors", same(&a.errors, &b.errors)),
            ("--times", same(&a.times, &b.times)),
            ("--confidence", same(&a.confidence, &b.confidence)),
            ("--truth-rays", same(&a.truth_rays, &b.truth_rays)),
        ];
        let found: Vec<String> =
            all.into_iter().filter_map(|(name, found)| Some(format!("{name} {}", found?))).collect();
        (!found.is_empty()).then(|| found.join(", "))
    }
}

fn same<T: PartialEq + std::fmt::Debug>(now: &T, then: &T) -> Option<String> {
    (now != then).then(|| format!("{then:?} there, {now:?} now"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(words: &[&str]) -> Result<Vec<Chosen>, String> {
        choose(&words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn families_are_named_singly_or_all_at_once() {
        assert_eq!(words(&["all"]).unwrap().len(), Family::ALL.len());
        assert_eq!(words(&["all", "wires"]).unwrap().len(), Family::ALL.len());
        assert_eq!(words(&["dim:7"]), Ok(vec![Chosen { family: Family::Dim, number: Some(7) }]));
        assert!(words(&["wire"]).unwrap_err().contains("wires") && words(&["wires:x"]).is_err());
    }

    #[test]
    fn every_family_is_met_before_any_second_scene() {
        let trials = Trials {
            seed: 1,
            width: 8,
            height: 8,
            seeds: 1,
            samples: vec![4],
            errors: Vec::new(),
            times: Vec::new(),
            confidence: 0.95,
            truth_rays: 1e6,
        };
        let families = words(&["wires", "dim", "dim:5", "dim:1"]).unwrap();
        let list = Plan { files: Vec::new(), families, scenes: 2, trials }.list();
        use Family::{Dim, Wires};
        let drawn = [(Wires, 0), (Dim, 0), (Wires, 1), (Dim, 1), (Dim, 5)];
        assert_eq!(list, drawn.map(|(family, number)| Subject::Drawn(family, number)));
    }
}
