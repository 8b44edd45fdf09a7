//! Features that kernels can support although the scene does not use them: they then contain the
//! code and buffers, and the image is the same, bit for bit. Used to measure the cost of a feature
//! and to test the specialised kernels.

use std::fmt;
use std::str::FromStr;

macro_rules! features {
    ($($(#[$meta:meta])* $name:ident, $word:literal, $what:literal;)*) => {
        /// A feature that kernels can be compiled without. Switching on one that the scene uses has
        /// no effect.
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

            /// What switching it on adds.
            pub fn what(self) -> &'static str {
                match self { $(Feature::$name => $what,)* }
            }
        }
    };
}

features! {
    /// Adds a triangle far outside the scene.
    Triangles, "triangles", "a triangle that no ray meets";
    /// Adds a sphere far outside the scene.
    Spheres, "spheres", "a sphere that no ray meets";
    /// Adds the double-length sphere test, and a sphere that needs it if there is none.
    ExtendedSpheres, "wide-spheres", "the test for spheres too large or small for single precision";
    /// Adds interpolated normals, although no vertex has one.
    SmoothNormals, "smooth-normals", "normals at the vertices of triangles";
    /// Adds a second light of intensity 0; its shadow rays are traced.
    Lights, "lights", "a second light, with its shadow rays";
    /// Adds the list of solids around each ray, with room for one.
    Refraction, "refraction", "a record of the solid around each ray";
    /// The same with room for two.
    NestedMedia, "nested-media", "a record of two solids around each ray";
    /// Adds the queues and sums that branching rays need.
    Branching, "branching", "queues and sums for several rays per sample";
    /// Adds passes for secondary rays, although nothing spawns them.
    Secondary, "secondary", "passes down to the depth asked for";
    /// Builds a hierarchy, however few the primitives.
    Hierarchy, "hierarchy", "a hierarchy instead of testing all primitives";
    /// Puts every primitive into the hierarchy.
    MixedLeaves, "mixed-leaves", "all primitives in the hierarchy, also the few of one kind";
    /// Traverses ray by ray, without packets.
    LoneRays, "lone-rays", "traversal ray by ray, without packets";
    /// Loads from storage buffers instead of texel views.
    Storage, "storage", "loads from storage buffers instead of texel views";
    /// Runs one kernel per stage instead of the fused kernel.
    SplitKernels, "split-kernels", "one kernel per stage instead of the fused kernel";
}

impl fmt::Display for Feature {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// A set of features to switch on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ForcedFeatures(u32);

impl ForcedFeatures {
    /// Every feature.
    pub fn all() -> ForcedFeatures {
        Feature::ALL.iter().fold(ForcedFeatures::default(), |set, f| set.with(*f))
    }

    /// This set and `feature`.
    #[must_use]
    pub fn with(self, feature: Feature) -> ForcedFeatures {
        ForcedFeatures(self.0 | 1 << feature as u32)
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

impl FromStr for ForcedFeatures {
    type Err = String;

    /// Words separated by commas; `all` is every feature.
    fn from_str(text: &str) -> Result<ForcedFeatures, String> {
        let known = || Feature::ALL.iter().map(|f| f.name()).collect::<Vec<_>>().join(", ");
        text.split(',').try_fold(ForcedFeatures::default(), |set, word| match word.trim() {
            "all" => Ok(ForcedFeatures::all()),
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
        let set: ForcedFeatures = "spheres, hierarchy".parse().unwrap();
        assert_eq!(set, ForcedFeatures::default().with(Feature::Spheres).with(Feature::Hierarchy));
        assert!(set.has(Feature::Spheres) && !set.has(Feature::Triangles) && !set.is_empty());
        assert_eq!("all".parse(), Ok(ForcedFeatures::all()));
        assert!(
            Feature::ALL.iter().all(|f| ForcedFeatures::all().has(*f)
                && f.name().parse() == Ok(ForcedFeatures::default().with(*f)))
        );
        assert!("sphere".parse::<ForcedFeatures>().unwrap_err().contains("spheres"));
    }
}
