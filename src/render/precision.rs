//! The precision of a render: the one asked for, or the one that the scene needs on the device at hand.

use crate::prepare::near::Near;
use crate::settings::{Precision, Settings};

/// What a choice of precision depends on besides the scene.
pub(super) struct Chosen<'a> {
    /// Faults of the device's f32.
    pub(super) single: &'a [String],
    /// The device has f64, and it has no faults.
    pub(super) sound_double: bool,
}

impl Chosen<'_> {
    /// `asked` with its precision settled, and what the user should know of it. `near`, with the shape
    /// of `Recipe`, is of a scene of two scales that f32 is not enough for.
    pub(super) fn precision(&self, asked: &Settings, near: Option<(&Near, f64)>) -> (Settings, Vec<String>) {
        let double = || Settings { precision: Precision::Double, ..asked.clone() };
        let single = || match asked.precision {
            Precision::Auto => Settings { precision: Precision::Robust, ..asked.clone() },
            _ => asked.clone(),
        };
        if asked.precision == Precision::Double {
            return (asked.clone(), Vec::new());
        }
        if asked.precision != Precision::Fast && !self.single.is_empty() {
            let why = format!("the f32 arithmetic of this device is unreliable: {}", self.single.join("; "));
            return match self.sound_double {
                true => (double(), vec![format!("rendered in f64 because {why}")]),
                false => (single(), vec![format!("error bounds may not hold: {why}")]),
            };
        }
        let Some((near, shape)) = near else {
            return (single(), Vec::new());
        };
        let why = near.words(shape, asked);
        match (asked.precision, self.sound_double) {
            (Precision::Auto, true) => (double(), vec![format!("rendered in f64 because {why}")]),
            (Precision::Auto, false) => (
                single(),
                vec![format!(
                    "the image may be wrong: {why}, and this device has no sound f64; render on a device that has"
                )],
            ),
            (precision, _) => (
                single(),
                vec![format!(
                    "the image may be wrong at --precision {}: {why}; --precision f64 holds both",
                    precision.name()
                )],
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::Recipe;
    use crate::scene::Scene;
    use crate::scene::procedural::shapes::{empty, matte, polygon, room, sphere};
    use crate::settings::Precision::{Auto, Double, Fast, Robust};

    /// Small things from afar through a long lens, on a ground that reaches the eye.
    fn long_lens() -> Scene {
        let mut s = empty(vec![matte([1.0; 3], 0.5)]);
        s.spheres = vec![sphere([0.0, 0.1, 0.0], 0.1, 0)];
        s.polygons =
            vec![polygon(&[[-1e5, 0.0, -1e5], [-1e5, 0.0, 1e5], [1e5, 0.0, 1e5], [1e5, 0.0, -1e5]], 0)];
        s.camera.look_from = [0.0, 5e4, 8e4].into();
        s.camera.fov = 1e-5;
        s
    }

    fn choose(
        scene: &Scene,
        precision: Precision,
        single: &[String],
        sound_double: bool,
    ) -> (Precision, String) {
        let recipe = Recipe::of(scene);
        let asked = Settings { precision, ..Settings::of(scene) };
        let near = recipe.local_frame.near.as_ref().filter(|n| !n.single_is_enough(recipe.shape, &asked));
        let near = near.map(|near| (near, recipe.shape));
        let (settings, why) = Chosen { single, sound_double }.precision(&asked, near);
        (settings.precision, why.join("|"))
    }

    #[test]
    fn one_scale_stays_in_single_precision() {
        for asked in [Auto, Fast, Robust, Double] {
            let want = if asked == Auto { Robust } else { asked };
            assert_eq!(choose(&room(), asked, &[], true), (want, String::new()));
        }
    }

    #[test]
    fn two_scales_take_double_precision_or_say_what_they_lack() {
        let (precision, why) = choose(&long_lens(), Auto, &[], true);
        assert!(
            precision == Double && why.starts_with("rendered in f64 because the scene has two scales"),
            "{why}"
        );
        let (precision, why) = choose(&long_lens(), Auto, &[], false);
        assert!(precision == Robust && why.contains("may be wrong") && why.contains("no sound f64"), "{why}");
        for asked in [Fast, Robust] {
            let (precision, why) = choose(&long_lens(), asked, &[], true);
            assert!(
                precision == asked && why.contains(asked.name()) && why.contains("--precision f64"),
                "{why}"
            );
        }
        assert_eq!(choose(&long_lens(), Double, &[], true), (Double, String::new()));
    }

    #[test]
    fn unsound_single_precision_is_left() {
        let faults = ["sums".to_owned()];
        for asked in [Auto, Robust] {
            let (precision, why) = choose(&room(), asked, &faults, true);
            assert!(precision == Double && why.contains("unreliable: sums"), "{why}");
            let (precision, why) = choose(&room(), asked, &faults, false);
            assert!(precision == Robust && why.contains("may not hold"), "{why}");
        }
        assert_eq!(choose(&room(), Fast, &faults, true), (Fast, String::new()));
    }
}
