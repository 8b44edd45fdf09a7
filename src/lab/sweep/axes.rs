//! `--over AXIS=VALUES`: the axes of a sweep.

use super::point::{Law, Point, Spheres};
use crate::scene::{Fresnel, MAX_DEPTH, MAX_SAMPLES, Scene};
use crate::settings::sampler::Sampler;
use crate::settings::{Origin, Precision, parse_cutoff};
use std::str::FromStr;

/// Finest mesh: 20 * 256^2 triangles a sphere.
const MAX_FREQUENCY: u32 = 256;
/// Most points of a grid: more would take days.
pub const MAX_POINTS: usize = 100_000;

/// All axes, each with its rule for values.
pub const AXES: [(&str, &str); 9] = [
    ("samples", "whole numbers from 1, or a range such as 1..256 (the powers of two in it)"),
    ("sampler", "random, stratified, owen, or all"),
    ("depth", "whole numbers from 1, or a range such as 1..8 (all in it)"),
    ("cutoff", "numbers from 0 to below 1"),
    ("precision", "fast, robust, f64, or all"),
    ("origin", "bound, fixed:X in metres, or a range such as fixed:1e-6..1 (two a decade)"),
    ("seed", "whole numbers from 0, or a range such as 0..7 (all in it)"),
    (
        "fresnel",
        "scene, exact, schlick, constant:F with F from 0 to 1, or all (exact, schlick, constant:0.5)",
    ),
    ("spheres", "analytic, or mesh:N with N from 1 to 256 (20 N^2 triangles a sphere)"),
];

/// One value on an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// `samples`.
    Samples(u32),
    /// `sampler`.
    Sampler(Sampler),
    /// `depth`.
    Depth(u32),
    /// `cutoff`.
    Cutoff(f32),
    /// `precision`.
    Precision(Precision),
    /// `origin`.
    Origin(Origin),
    /// `seed`.
    Seed(u32),
    /// `fresnel`.
    Fresnel(Law),
    /// `spheres`.
    Spheres(Spheres),
}

/// An axis and its values, none twice.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// One of [`AXES`].
    pub name: &'static str,
    /// In the order given.
    pub values: Vec<Value>,
    /// True if `all` values were asked for; those that the device does not support are then left
    /// out.
    pub all: bool,
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Axis, String> {
        let (name, list) = text.split_once('=').ok_or_else(|| {
            format!("write an axis and its values, such as samples=1..64; the axes are\n{}", listing())
        })?;
        let Some((name, rule)) = AXES.iter().find(|(known, _)| *known == name) else {
            return Err(format!("unknown axis `{name}`; the axes are\n{}", listing()));
        };
        let mut axis = Axis { name, values: Vec::new(), all: list == "all" };
        for word in list.split(',') {
            let values = values(name, word.trim());
            let values = values.ok_or_else(|| format!("`{word}` is not a value of {name}: write {rule}"))?;
            for value in values {
                if !axis.values.contains(&value) {
                    axis.values.push(value);
                }
            }
        }
        Ok(axis)
    }
}

/// The axes with their rules, one a line.
pub fn listing() -> String {
    AXES.map(|(name, rule)| format!("  {name}={rule}")).join("\n")
}

/// The values that one word means; `None` if it is not a value.
fn values(axis: &str, word: &str) -> Option<Vec<Value>> {
    let one = |value| Some(vec![value]);
    let whole = |most| numbers(word, most);
    match axis {
        "samples" => Some(counts(word)?.into_iter().map(Value::Samples).collect()),
        "depth" => {
            let list = whole(MAX_DEPTH)?;
            (list[0] > 0).then(|| list.into_iter().map(Value::Depth).collect())
        }
        "seed" => Some(whole(u32::MAX)?.into_iter().map(Value::Seed).collect()),
        "sampler" if word == "all" => Some(Sampler::ALL.map(Value::Sampler).to_vec()),
        "sampler" => one(Value::Sampler(word.parse().ok()?)),
        "cutoff" => one(Value::Cutoff(parse_cutoff(word).ok()?)),
        "precision" if word == "all" => {
            Some([Precision::Fast, Precision::Robust, Precision::Double].map(Value::Precision).to_vec())
        }
        "precision" => one(Value::Precision(word.parse().ok().filter(|p| *p != Precision::Auto)?)),
        "origin" => match word.strip_prefix("fixed:").and_then(|r| r.split_once("..")) {
            Some((low, high)) => epsilons(low, high),
            None => one(Value::Origin(word.parse().ok()?)),
        },
        "fresnel" => {
            let law = |word: &str| match (word, word.strip_prefix("constant:")) {
                ("scene", _) => Some(Law::Scene),
                ("exact", _) => Some(Law::Forced(Fresnel::Exact)),
                ("schlick", _) => Some(Law::Forced(Fresnel::Schlick)),
                (_, Some(share)) => share
                    .parse()
                    .ok()
                    .filter(|f| (0.0..=1.0).contains(f))
                    .map(|f| Law::Forced(Fresnel::Constant(f))),
                _ => None,
            };
            match word {
                "all" => ["exact", "schlick", "constant:0.5"]
                    .map(|w| law(w).map(Value::Fresnel))
                    .into_iter()
                    .collect(),
                word => one(Value::Fresnel(law(word)?)),
            }
        }
        "spheres" => match word.strip_prefix("mesh:") {
            None => (word == "analytic").then(|| vec![Value::Spheres(Spheres::Analytic)]),
            Some(n) => one(Value::Spheres(Spheres::Mesh(
                n.parse().ok().filter(|n| (1..=MAX_FREQUENCY).contains(n))?,
            ))),
        },
        _ => None,
    }
}

/// A whole number, or all from a to b of `a..b`.
fn numbers(word: &str, most: u32) -> Option<Vec<u32>> {
    let (low, high) = word.split_once("..").unwrap_or((word, word));
    let (low, high) = (low.parse::<u32>().ok()?, high.parse::<u32>().ok()?);
    (low <= high && high <= most && high - low < MAX_POINTS as u32).then(|| (low..=high).collect())
}

/// A whole number from 1, or a, b and the powers of two between of `a..b`.
fn counts(word: &str) -> Option<Vec<u32>> {
    let (low, high) = word.split_once("..").unwrap_or((word, word));
    let (low, high) = (low.parse::<u32>().ok()?, high.parse::<u32>().ok()?);
    if low < 1 || low > high || high > MAX_SAMPLES {
        return None;
    }
    let mut list = vec![low];
    list.extend((0..25).map(|k| 1 << k).filter(|n| (low + 1..high).contains(n)));
    list.push(high);
    list.dedup();
    Some(list)
}

/// From low to high, two a decade.
fn epsilons(low: &str, high: &str) -> Option<Vec<Value>> {
    let bound = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
    let (low, high) = (bound(low)?, bound(high)?);
    let steps = (2.0 * (high / low).log10()).round() as usize;
    if low > high || steps > 200 {
        return None;
    }
    // Three digits, written and read back: 0.1 is 0.1.
    let step = |k: usize| format!("{:.2e}", low * 10f64.powf(k as f64 / 2.0)).parse().ok();
    (0..=steps).map(|k| step(k).map(|x| Value::Origin(Origin::Fixed(x)))).collect()
}

impl Point {
    fn with(&self, value: Value) -> Point {
        let own = self.clone();
        match value {
            Value::Samples(samples) => Point { samples, ..own },
            Value::Sampler(sampler) => Point { sampler, ..own },
            Value::Depth(depth) => Point { depth, ..own },
            Value::Cutoff(cutoff) => Point { cutoff, ..own },
            Value::Precision(precision) => Point { precision, ..own },
            Value::Origin(origin) => Point { origin, ..own },
            Value::Seed(seed) => Point { seed, ..own },
            Value::Fresnel(fresnel) => Point { fresnel, ..own },
            Value::Spheres(spheres) => Point { spheres, ..own },
        }
    }
}

/// All combinations, the last axis varying fastest, about the scene's own settings.
///
/// # Errors
/// If an axis is named twice, or the points are more than [`MAX_POINTS`]; in words for the user.
pub fn grid(scene: &Scene, axes: &[Axis]) -> Result<Vec<Point>, String> {
    let mut points = vec![Point::of(scene)];
    for (i, axis) in axes.iter().enumerate() {
        if axes[..i].iter().any(|other| other.name == axis.name) {
            return Err(format!("the axis `{}` is given twice; put all its values into one list", axis.name));
        }
        if points.len().saturating_mul(axis.values.len()) > MAX_POINTS {
            return Err(format!("the axes give more than {MAX_POINTS} settings; use fewer values"));
        }
        points = points.iter().flat_map(|p| axis.values.iter().map(|v| p.with(*v))).collect();
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(text: &str) -> Axis {
        text.parse().unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    fn samples(text: &str) -> Vec<u32> {
        let number = |v: &Value| if let Value::Samples(n) = v { *n } else { panic!("{v:?}") };
        axis(text).values.iter().map(number).collect()
    }

    #[test]
    fn ranges_of_samples_are_powers_of_two_and_both_ends() {
        assert_eq!(samples("samples=1..256"), [1, 2, 4, 8, 16, 32, 64, 128, 256]);
        assert_eq!(samples("samples=3..20"), [3, 4, 8, 16, 20]);
        assert_eq!(samples("samples=4,1,4..8"), [4, 1, 8]);
        assert_eq!(samples("samples=5..5"), [5]);
    }

    #[test]
    fn ranges_of_depth_and_seed_are_every_number() {
        let depths = [3, 4, 5].map(Value::Depth);
        assert_eq!(axis("depth=3..5").values, depths);
        assert_eq!(axis("seed=0..2,9").values, [0, 1, 2, 9].map(Value::Seed));
    }

    #[test]
    fn words_and_all() {
        assert_eq!(axis("sampler=all").values, Sampler::ALL.map(Value::Sampler));
        assert!(axis("precision=all").all && !axis("precision=fast,f64").all);
        assert_eq!(
            axis("fresnel=schlick,constant:0.25").values,
            [Fresnel::Schlick, Fresnel::Constant(0.25)].map(|f| Value::Fresnel(Law::Forced(f)))
        );
        assert_eq!(
            axis("spheres=analytic,mesh:8").values,
            [Spheres::Analytic, Spheres::Mesh(8)].map(Value::Spheres)
        );
        assert_eq!(axis("cutoff=0,0.01").values, [0.0, 0.01].map(Value::Cutoff));
    }

    #[test]
    fn epsilons_are_two_a_decade() {
        let fixed = |x| Value::Origin(Origin::Fixed(x));
        let want = [
            Value::Origin(Origin::Bound),
            fixed(0.001),
            fixed(0.00316),
            fixed(0.01),
            fixed(0.0316),
            fixed(0.1),
        ];
        assert_eq!(axis("origin=bound,fixed:1e-3..0.1").values, want);
    }

    #[test]
    fn mistakes_are_told_with_what_there_is() {
        let error = |text: &str| text.parse::<Axis>().unwrap_err();
        assert!(
            error("sample=1").contains("samples=") && error("sample=1").contains("unknown axis `sample`")
        );
        assert!(error("samples").contains("such as samples=1..64"));
        for bad in [
            "samples=",
            "samples=0",
            "samples=8..4",
            "samples=all",
            "samples=1..",
            "samples=1..2..3",
            "samples=-1",
            "samples=99999999",
            "sampler=halton",
            "depth=0",
            "depth=0..3",
            "depth=2000",
            "cutoff=1",
            "cutoff=NaN",
            "precision=double",
            "origin=fixed:",
            "origin=fixed:-1",
            "origin=fixed:1..0.1",
            "origin=fixed:0..1",
            "seed=x",
            "seed=5..1",
            "fresnel=constant",
            "fresnel=constant:2",
            "spheres=mesh:0",
            "spheres=mesh",
            "samples=1,,2",
        ] {
            assert!(error(bad).contains(": write "), "{bad}: {}", error(bad));
        }
    }

    #[test]
    fn the_grid_holds_every_combination_once() {
        let scene = crate::lab::gallery::tests::subject("a", 8, 20).scene;
        let axes = ["samples=1..4", "depth=1,2", "sampler=all"].map(axis);
        let points = grid(&scene, &axes).unwrap();
        assert_eq!(points.len(), 18);
        assert!(points.iter().enumerate().all(|(i, p)| !points[..i].contains(p)));
        assert_eq!((points[0].samples, points[0].depth, points[0].sampler), (1, 1, Sampler::Random));
        assert_eq!((points[1].sampler, points[3].depth), (Sampler::Stratified, 2));
        // What no axis names stays the scene's.
        assert_eq!(grid(&scene, &[]).unwrap()[0].samples, 20);
        assert!(grid(&scene, &[axis("depth=1"), axis("depth=2")]).unwrap_err().contains("twice"));
    }
}
