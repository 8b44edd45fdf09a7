//! How scenes and the files that they name are read.

use glam::DVec3;
use std::str::FromStr;

/// How a scene is read; [`Scene::load_with`](super::Scene::load_with) takes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Whatever would be assumed with a note ([`Scene::notes`](super::Scene::notes)) is an error instead, and MTL's `Ka` is
    /// followed to the letter.
    pub strict: bool,
    /// Names and values: `${name}` in a scene's text stands for the value. Every name must occur there.
    pub variables: Vec<(String, String)>,
    /// Width and height in pixels for which a model that is read by itself is framed; those of its own camera, or
    /// 600 x 500, if absent. A scene's text has its own.
    pub size: Option<[u32; 2]>,
    /// What points up in a model that is read by itself, whose own cameras are then left out; its format's habit if absent.
    pub up: Option<Axis>,
}

/// A direction along an axis of the coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis {
    /// 0, 1 or 2 for x, y or z.
    axis: usize,
    negative: bool,
}

impl Axis {
    /// y.
    pub(super) const Y: Axis = Axis { axis: 1, negative: false };
    /// z.
    pub(super) const Z: Axis = Axis { axis: 2, negative: false };

    /// Its unit vector.
    pub fn vector(self) -> DVec3 {
        let axis = DVec3::AXES[self.axis];
        if self.negative { -axis } else { axis }
    }

    /// As the command line spells it.
    pub fn name(self) -> &'static str {
        [["x", "-x"], ["y", "-y"], ["z", "-z"]][self.axis][usize::from(self.negative)]
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Axis, String> {
        let all = (0..3).flat_map(|axis| [false, true].map(|negative| Axis { axis, negative }));
        all.into_iter().find(|axis| axis.name() == text).ok_or_else(|| "write x, y, z, -x, -y or -z".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_read_as_written() {
        for (name, vector) in [("x", DVec3::X), ("-y", DVec3::NEG_Y), ("z", DVec3::Z), ("-z", DVec3::NEG_Z)] {
            let axis: Axis = name.parse().unwrap();
            assert_eq!((axis.name(), axis.vector()), (name, vector));
        }
        assert!("up".parse::<Axis>().is_err());
    }
}
