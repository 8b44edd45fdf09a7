//! What is timed.

/// What a scene's default render is held against within this program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Second {
    /// Nothing: its passes are told, and `--against` has another program draw it.
    Nothing,
    /// The other of brute force and hierarchy.
    OtherWalk,
    /// The kernels' twins on the CPU.
    Twins,
}

/// A scene at a size.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// A name of `benches/scenes.sh`.
    pub scene: &'static str,
    /// Pixels.
    pub size: [u32; 2],
    /// Per pixel.
    pub samples: u32,
    /// Rays in the longest path.
    pub depth: u32,
    /// Held against this.
    pub second: Second,
    /// Part of a run without names: so chosen that the whole takes a few minutes on two cores.
    pub usual: bool,
}

const fn case(scene: &'static str, size: [u32; 2], samples: u32, depth: u32, second: Second) -> Case {
    Case { scene, size, samples, depth, second, usual: true }
}

const fn large(scene: &'static str) -> Case {
    Case { usual: false, ..case(scene, [512, 512], 1, 4, Second::Nothing) }
}

/// All cases; those of one scene stand together.
pub const CASES: &[Case] = &[
    case("cornell", [600, 500], 20, 4, Second::Nothing),
    case("cornell", [300, 250], 4, 4, Second::OtherWalk),
    case("cornell", [120, 100], 1, 4, Second::Twins),
    case("flake2", [256, 256], 1, 5, Second::OtherWalk),
    case("flake2", [96, 96], 1, 5, Second::Twins),
    case("flake", [512, 512], 1, 5, Second::Nothing),
    case("mesh1k", [96, 96], 1, 4, Second::OtherWalk),
    case("mesh70k", [512, 512], 1, 4, Second::Nothing),
    case("mesh70k", [128, 128], 1, 4, Second::Twins),
    large("mesh280k"),
    large("mesh1m"),
];
