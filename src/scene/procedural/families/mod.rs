//! Families of scenes that are hard to sample, each with a generator: a family, a number and a seed give a scene. They
//! are what error bounds are tested with: scenes that nobody had seen while the bounds were made.
//!
//! A scene is drawn as TOML text and read by [`Scene::parse`], so that it can also be saved and rendered by itself. Sizes
//! such as the width of a wire are drawn in pixels; hence a scene also depends on the size of its image.

mod bright_dots;
mod busy;
mod combs;
mod corridor;
mod dark_dots;
mod dim;
pub(crate) mod draw;
mod glass_crowd;
mod lamps;
mod nested_glass;
mod slabs;
mod text;
mod view;
mod wires;

use crate::scene::{Scene, SceneError};
use draw::Draw;
use text::Text;

/// A family of scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// Wires at all angles, from a fiftieth of a pixel to two pixels thick.
    Wires,
    /// Stripes or steps that become thinner than a pixel towards the horizon.
    Slabs,
    /// Regular bars whose period is close to a simple multiple of the pixel.
    Combs,
    /// Dark dots smaller than a pixel before a bright wall.
    DarkDots,
    /// Dots smaller than a pixel with a radiance from 1.5 to 10,000.
    BrightDots,
    /// Lights from half a millimetre to half a metre from a surface.
    Lamps,
    /// Many glass spheres.
    GlassCrowd,
    /// Mirrors that face each other.
    Corridor,
    /// Glass in glass: shells, bubbles and drops.
    NestedGlass,
    /// Smooth images with fine detail in one per cent of the area.
    Busy,
    /// Nearly black images.
    Dim,
}

impl Family {
    /// All families.
    pub const ALL: [Family; 11] = [
        Family::Wires,
        Family::Slabs,
        Family::Combs,
        Family::DarkDots,
        Family::BrightDots,
        Family::Lamps,
        Family::GlassCrowd,
        Family::Corridor,
        Family::NestedGlass,
        Family::Busy,
        Family::Dim,
    ];

    /// Its name on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Family::Wires => "wires",
            Family::Slabs => "slabs",
            Family::Combs => "combs",
            Family::DarkDots => "dark-dots",
            Family::BrightDots => "bright-dots",
            Family::Lamps => "lamps",
            Family::GlassCrowd => "glass-crowd",
            Family::Corridor => "corridor",
            Family::NestedGlass => "nested-glass",
            Family::Busy => "busy",
            Family::Dim => "dim",
        }
    }

    /// What its scenes show.
    pub fn what(self) -> &'static str {
        match self {
            Family::Wires => "wires at all angles, 0.02 to 2 pixels thick",
            Family::Slabs => "stripes or steps that reach to the horizon",
            Family::Combs => "bars with a period close to a simple multiple of the pixel",
            Family::DarkDots => "dark dots smaller than a pixel before a bright wall",
            Family::BrightDots => "dots smaller than a pixel with a radiance from 1.5 to 10,000",
            Family::Lamps => "lights from half a millimetre to half a metre from a surface",
            Family::GlassCrowd => "many glass spheres",
            Family::Corridor => "mirrors that face each other",
            Family::NestedGlass => "glass in glass: shells, bubbles and drops",
            Family::Busy => "smooth images with fine detail in 1 % of the area",
            Family::Dim => "nearly black images",
        }
    }

    /// Scene `number` drawn with `seed` for an image of `size` (width and height in pixels), as TOML.
    pub fn text(self, number: u32, seed: u64, size: [u32; 2]) -> String {
        let mut draw = Draw::new(self.name(), number, seed);
        let mut text = Text::new(size);
        text.note(&format!("Scene {number} of the family `{}`, seed {seed}: {}.", self.name(), self.what()));
        match self {
            Family::Wires => wires::draw(&mut draw, &mut text),
            Family::Slabs => slabs::draw(&mut draw, &mut text),
            Family::Combs => combs::draw(&mut draw, &mut text),
            Family::DarkDots => dark_dots::draw(&mut draw, &mut text),
            Family::BrightDots => bright_dots::draw(&mut draw, &mut text),
            Family::Lamps => lamps::draw(&mut draw, &mut text),
            Family::GlassCrowd => glass_crowd::draw(&mut draw, &mut text),
            Family::Corridor => corridor::draw(&mut draw, &mut text),
            Family::NestedGlass => nested_glass::draw(&mut draw, &mut text),
            Family::Busy => busy::draw(&mut draw, &mut text),
            Family::Dim => dim::draw(&mut draw, &mut text),
        }
        text.finish()
    }

    /// The same as a scene.
    ///
    /// # Errors
    /// If the scene is invalid, which is a mistake in its generator.
    pub fn scene(self, number: u32, seed: u64, size: [u32; 2]) -> Result<Scene, SceneError> {
        Scene::parse(&self.text(number, seed, size), self.file(number))
    }

    /// Name of the file for scene `number`: `wires-0003.toml`.
    pub fn file(self, number: u32) -> String {
        format!("{}-{number:04}.toml", self.name())
    }
}

impl std::str::FromStr for Family {
    type Err = String;

    fn from_str(text: &str) -> Result<Family, String> {
        let names = || Family::ALL.map(Family::name).join(", ");
        Family::ALL
            .into_iter()
            .find(|f| f.name() == text)
            .ok_or_else(|| format!("`all`, or some of {}", names()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_depends_on_family_number_seed_and_size_alone() {
        for family in Family::ALL {
            let text = |number, seed, size| family.text(number, seed, size);
            assert_eq!(text(1, 2, [96, 72]), text(1, 2, [96, 72]));
            let others = [text(2, 2, [96, 72]), text(1, 3, [96, 72]), text(1, 2, [192, 144])];
            assert!(others.iter().all(|other| *other != text(1, 2, [96, 72])), "{}", family.name());
            assert_eq!(family.name().parse(), Ok(family));
        }
        assert!("wire".parse::<Family>().is_err());
    }

    #[test]
    fn every_draw_is_a_valid_scene() {
        for family in Family::ALL {
            for number in 0..60 {
                let scene = family.scene(number, 11, [96, 72]);
                let scene = scene.unwrap_or_else(|e| panic!("{} {number}: {e:?}", family.name()));
                assert!(scene.polygons.len() + scene.spheres.len() > 0);
            }
        }
    }
}
