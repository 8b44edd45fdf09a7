//! What to measure on families of scenes.

use crate::report::{DeviceInfo, ProgramInfo};
use crate::scene::procedural::families::Family;
use serde::{Deserialize, Serialize};

/// Scenes of one family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Chosen {
    /// The family.
    pub family: Family,
    /// The only scene to take; `None` for the first [`FamilyPlan::scenes`].
    pub number: Option<u32>,
}

/// A calibration on families of scenes.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyPlan {
    /// The families.
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

impl FamilyPlan {
    /// Family and number of every scene: first the first scene of each family, so that an early end has met them all.
    pub fn list(&self) -> Vec<(Family, u32)> {
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
        let list = FamilyPlan { families, scenes: 2, trials }.list();
        use Family::{Dim, Wires};
        assert_eq!(list, [(Wires, 0), (Dim, 0), (Wires, 1), (Dim, 1), (Dim, 5)]);
    }
}
