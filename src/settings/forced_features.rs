//! Features that a scene lacks, switched on all the same: the kernels then have the code and the buffers
//! for them, and the image is the same, bit for bit. That is how their price is measured, and how the
//! specialised kernels are tested.

use std::fmt;
use std::str::FromStr;

macro_rules! features {
    ($($(#[$meta:meta])* $name:ident, $word:literal, $what:literal;)*) => {
        /// What kernels can do without. In a scene that has it, switching it on means nothing.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(u32)]
        pub enum Feature { $($(#[$meta])* $name,)* }

        impl Feature {
            /// All of them.
            pub const ALL: &[Feature] = &[$(Feature::$name,)*];

            /// As the command line and the report spell it.
            pub fn name(self) -> &'static str {
                match self { $(Feature::$name => $word,)* }
            }

            /// What is there once it is switched on.
            pub fn what(self) -> &'static str {
                match self { $(Feature::$name => $what,)* }
            }
        }
    };
}

features! {
    /// A triangle far outside the scene.
    Triangles, "triangles", "a triangle that no ray meets";
    /// A sphere far outside the scene.
    Spheres, "spheres", "a sphere that no ray meets";
    /// The test in double length, and such a sphere if there is none.
    WideSpheres, "wide-spheres", "the test of spheres beyond single precision";
    /// Corner normals, all of them absent.
    SmoothNormals, "smooth-normals", "normals at the corners of triangles";
    /// A second light, of no intensity: its shadow rays are traced.
    Lights, "lights", "a second light, with its shadow rays";
    /// Lists of the solids that rays are in.
    Refraction, "refraction", "for each ray the solid it is in";
    /// The same of two solids.
    NestedMedia, "nested-media", "for each ray two solids it is in";
    /// Sums over several rays of a sample, and room for them.
    Branching, "branching", "queues and sums for several rays of one sample";
    /// Passes for rays that nothing spawns.
    Secondary, "secondary", "passes to the depth asked for";
    /// A hierarchy, however few the primitives.
    Hierarchy, "hierarchy", "a hierarchy, not every primitive";
    /// Everything in the hierarchy.
    MixedLeaves, "mixed-leaves", "the few of the other kind in the hierarchy too";
    /// Each ray on its own way through the hierarchy.
    LoneRays, "lone-rays", "a walk for each ray, not one for the rays of a subgroup";
    /// Loads from storage buffers, not from texel views.
    Storage, "storage", "loads from storage buffers, not texel views";
    /// A kernel for each stage, also where one for all is faster.
    SplitKernels, "split-kernels", "a kernel for each stage, not one for all";
    /// Shapes from buffers, not from constants.
    LoadedShapes, "loaded-shapes", "shapes from buffers, not constants";
}

impl fmt::Display for Feature {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// A set of features to switch on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct General(u32);

impl General {
    /// Every feature.
    pub fn all() -> General {
        Feature::ALL.iter().fold(General::default(), |set, f| set.with(*f))
    }

    /// This set and `feature`.
    #[must_use]
    pub fn with(self, feature: Feature) -> General {
        General(self.0 | 1 << feature as u32)
    }

    /// True if `feature` is switched on.
    pub fn has(self, feature: Feature) -> bool {
        self.0 >> feature as u32 & 1 == 1
    }

    /// True if nothing is switched on.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl FromStr for General {
    type Err = String;

    /// Words separated by commas; `all` is every feature.
    fn from_str(text: &str) -> Result<General, String> {
        let known = || Feature::ALL.iter().map(|f| f.name()).collect::<Vec<_>>().join(", ");
        text.split(',').try_fold(General::default(), |set, word| match word.trim() {
            "all" => Ok(General::all()),
            word => match Feature::ALL.iter().find(|f| f.name() == word) {
                Some(feature) => Ok(set.with(*feature)),
                None => Err(format!("write all, or any of {}", known())),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_features() {
        let set: General = "spheres, hierarchy".parse().unwrap();
        assert_eq!(set, General::default().with(Feature::Spheres).with(Feature::Hierarchy));
        assert!(set.has(Feature::Spheres) && !set.has(Feature::Triangles) && !set.is_empty());
        assert_eq!("all".parse(), Ok(General::all()));
        assert!(
            Feature::ALL
                .iter()
                .all(|f| General::all().has(*f) && f.name().parse() == Ok(General::default().with(*f)))
        );
        assert!("sphere".parse::<General>().unwrap_err().contains("spheres"));
    }
}
