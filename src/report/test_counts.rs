//! Box and primitive tests by depth and kind of ray, and their text for people.

use super::RayInfo;
use super::table::{Align, Table};
use crate::kernel::abi;
use crate::units::{grouped, number};
use serde::{Deserialize, Serialize};

/// Box tests and primitive tests of each kind of ray: primary, reflection, refraction, shadow.
pub type KindTests = [[u64; 2]; abi::RAY_KINDS as usize];

/// Names of the kinds, in the order of their numbers.
const KINDS: [&str; abi::RAY_KINDS as usize] = ["primary", "reflection", "refraction", "shadow"];

/// The tests of each depth out of the words of `counters`; none if it has no words for them.
pub(crate) fn tests_of(counters: &[u32]) -> Vec<KindTests> {
    let words = counters.get(abi::COUNTERS as usize..).unwrap_or_default();
    let number = |at: usize| u64::from(words[at + 1]) << 32 | u64::from(words[at]);
    let (kinds, each) = (abi::RAY_KINDS as usize, abi::TEST_WORDS as usize);
    let of_kind = |at: usize| [number(at), number(at + 2)];
    let of_depth = |depth: usize| std::array::from_fn(|kind| of_kind(each * (kinds * depth + kind)));
    (0..words.len() / (each * kinds)).map(of_depth).collect()
}

/// Tests of a render.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TestCounts {
    /// Box tests of all rays.
    pub boxes: u64,
    /// Primitive tests of all rays.
    pub primitives: u64,
    /// One row for each kind of ray at each depth that has such rays.
    pub by_kind: Vec<KindCounts>,
}

/// Tests of one kind of ray at one depth.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KindCounts {
    /// From 1; of shadow rays, that of the ray whose hit they start from.
    pub depth: u32,
    /// `primary`, `reflection`, `refraction` or `shadow`.
    pub kind: String,
    /// Rays.
    pub rays: u64,
    /// Boxes of the hierarchy tested against them.
    pub boxes: u64,
    /// Primitives tested against them.
    pub primitives: u64,
}

impl TestCounts {
    /// From the rays and tests of each depth.
    pub fn of(rays: &RayInfo, tests: &[KindTests]) -> TestCounts {
        let mut counts = TestCounts::default();
        for (depth, tests) in rays.by_depth.iter().zip(tests) {
            let rays = [depth.primary, depth.reflection, depth.refraction, depth.shadow];
            for ((kind, rays), [boxes, primitives]) in KINDS.iter().zip(rays).zip(*tests) {
                counts.boxes += boxes;
                counts.primitives += primitives;
                if rays > 0 {
                    let (depth, kind) = (depth.depth, (*kind).to_owned());
                    counts.by_kind.push(KindCounts { depth, kind, rays, boxes, primitives });
                }
            }
        }
        counts
    }
}

/// The counts for people: a row for each kind of ray at each depth, and one for all.
pub fn text(counts: &TestCounts) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[
        ("depth", Right),
        ("rays", Left),
        ("count", Right),
        ("box tests", Right),
        ("a ray", Right),
        ("primitive tests", Right),
        ("a ray", Right),
    ]);
    let mut row = |depth: String, kind: &str, rays: u64, [boxes, primitives]: [u64; 2]| {
        let each = |n: u64| number((100.0 * n as f64 / rays.max(1) as f64).round() / 100.0);
        let (boxes, per_box) = (grouped(boxes), each(boxes));
        let (primitives, per_primitive) = (grouped(primitives), each(primitives));
        table.row([depth, kind.to_owned(), grouped(rays), boxes, per_box, primitives, per_primitive]);
    };
    for k in &counts.by_kind {
        row(k.depth.to_string(), &k.kind, k.rays, [k.boxes, k.primitives]);
    }
    let rays = counts.by_kind.iter().map(|k| k.rays).sum();
    row("all".into(), "", rays, [counts.boxes, counts.primitives]);
    table.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_rows_of_the_kinds_that_have_rays() {
        let mut counters = vec![9; abi::COUNTERS as usize];
        assert!(tests_of(&counters).is_empty());
        // Two depths; the primary rays' box tests need both words.
        counters.extend([5, 1, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 4, 0]);
        counters.extend([0, 0, 0, 0, 0, 0, 0, 0, 11, 0, 12, 0, 0, 0, 0, 0]);
        let tests = tests_of(&counters);
        assert_eq!(tests, [[[(1 << 32) + 5, 7], [0, 0], [0, 0], [3, 4]], [[0, 0], [0, 0], [11, 12], [0, 0]]]);
        let rays = RayInfo::of(&[[2, 0, 0, 1], [3, 0, 3, 0]]);
        let counts = TestCounts::of(&rays, &tests);
        assert_eq!((counts.boxes, counts.primitives), ((1 << 32) + 19, 23));
        let rows: Vec<_> = counts.by_kind.iter().map(|k| (k.depth, k.kind.as_str(), k.rays)).collect();
        assert_eq!(rows, [(1, "primary", 2), (1, "shadow", 1), (2, "refraction", 3)]);
        let text = text(&counts);
        let last: Vec<&str> = text.lines().last().unwrap().split_whitespace().collect();
        assert_eq!(last, ["all", "6", "4,294,967,315", "715828000", "23", "3.83"]);
    }
}
