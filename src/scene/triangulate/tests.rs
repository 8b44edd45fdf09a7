//! Judged by what needs no triangulation: the border's area, its winding number about points, and its sides.

use super::*;
use std::collections::HashMap;

/// Numbers in [0, 1) of no pattern (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// How often the closed border turns about `p`, from the sides that cross the line to its right.
fn winding(border: &[DVec3], p: DVec3) -> i32 {
    let n = border.len();
    (0..n)
        .map(|i| {
            let (a, b) = (border[i] - p, border[(i + 1) % n] - p);
            let side = a.x * b.y - a.y * b.x;
            match (a.y <= 0.0, b.y <= 0.0) {
                (true, false) if side > 0.0 => 1,
                (false, true) if side < 0.0 => -1,
                _ => 0,
            }
        })
        .sum()
}

fn triangles(border: &[DVec3]) -> Vec<[u32; 3]> {
    match cut(border).unwrap_or_else(|fault| panic!("{fault:?}")) {
        Cut::Fan => (1..border.len() as u32 - 1).map(|i| [0, i, i + 1]).collect(),
        Cut::Triangles(triangles) => triangles,
    }
}

/// Checks a cut of a border in the plane z = 0: areas, points, and sides.
fn check(border: &[DVec3]) {
    let cut = triangles(border);
    let corners = |t: &[u32; 3]| t.map(|i| border[i as usize]);
    let double_area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).z;
    let whole = area(border).z;
    let sense = whole.signum();
    let sum: f64 = cut.iter().map(|t| double_area(corners(t))).sum();
    assert!((sum - whole).abs() <= 1e-9 * whole.abs(), "{sum} of {whole}");
    assert!(cut.iter().all(|t| double_area(corners(t)) * sense >= 0.0));

    let lo = border.iter().fold(DVec3::INFINITY, |l, p| l.min(*p));
    let hi = border.iter().fold(DVec3::NEG_INFINITY, |h, p| h.max(*p));
    let mut random = Random(border.len() as u64);
    for _ in 0..300 {
        let p = lo + (hi - lo) * DVec3::new(random.next(), random.next(), 0.0);
        let covered: i32 = cut.iter().map(|t| winding(&corners(t), p)).sum();
        assert_eq!(covered, winding(border, p), "{p} of {border:?}");
    }
    assert_sides(border, &cut);
}

/// Every side of the border is a side of exactly one triangle; every other side is shared by two, in opposite senses.
/// Corners at one point count as one.
fn assert_sides(border: &[DVec3], cut: &[[u32; 3]]) {
    let mut sides: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
    let key = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut count = |a: DVec3, b: DVec3, by: i32| {
        if key(a) < key(b) {
            *sides.entry([key(a), key(b)]).or_default() += by;
        } else if key(a) > key(b) {
            *sides.entry([key(b), key(a)]).or_default() -= by;
        }
    };
    for t in cut {
        (0..3).for_each(|i| count(border[t[i] as usize], border[t[(i + 1) % 3] as usize], 1));
    }
    (0..border.len()).for_each(|i| count(border[i], border[(i + 1) % border.len()], -1));
    assert!(sides.values().all(|n| *n == 0), "{border:?} {cut:?}");
}

fn flat(corners: &[[f64; 2]]) -> Vec<DVec3> {
    corners.iter().map(|c| DVec3::new(c[0], c[1], 0.0)).collect()
}

/// In all rotations, and both senses.
fn check_all(corners: &[[f64; 2]]) {
    let mut border = flat(corners);
    for _ in 0..border.len() {
        border.rotate_left(1);
        check(&border);
    }
    border.reverse();
    check(&border);
}

#[test]
fn concave_ones() {
    check_all(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5]]);
    check_all(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]]);
    let comb: Vec<[f64; 2]> = (0..40)
        .flat_map(|i| [[f64::from(i), 0.0], [f64::from(i) + 0.5, 5.0 + f64::from(i % 3)]])
        .chain([[40.0, -1.0], [0.0, -1.0]])
        .collect();
    check_all(&comb);
}

#[test]
fn corners_in_a_straight_side_stay() {
    let square =
        [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.7, 1.0], [0.2, 1.0], [0.0, 1.0], [0.0, 0.1]];
    check_all(&square);
    // All but one in one line.
    check_all(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [1.0, 1.0]]);
    let with_area = |corners: &[DVec3]| {
        let of = |t: &[u32; 3]| area(&t.map(|i| corners[i as usize])).length();
        triangles(corners).iter().filter(|t| of(t) > 1e-3).count()
    };
    let mut border = flat(&square);
    for _ in 0..8 {
        border.rotate_left(1);
        assert_eq!(with_area(&border), 6);
    }
}

/// Turned in space, corners in a straight side are off it by roundings; no triangle is left without area.
#[test]
fn corners_nearly_in_a_straight_side_make_no_slivers() {
    let turn = crate::scene::rotation(DVec3::new(17.0, 29.0, 71.0));
    for n in [3, 7] {
        // A regular polygon with the thirds of each side as corners.
        let corner = |i: usize| {
            let angle = 2.0 * std::f64::consts::PI * (i % n) as f64 / n as f64;
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let third = |i: usize, k: usize| corner(i).lerp(corner(i + 1), k as f64 / 3.0);
        let mut border: Vec<DVec3> = (0..n).flat_map(|i| (0..3).map(move |k| turn * third(i, k))).collect();
        for _ in 0..border.len() {
            border.rotate_left(1);
            for t in triangles(&border) {
                let [a, b, c] = t.map(|i| border[i as usize]);
                let longest =
                    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
                assert!((b - a).cross(c - a).length() > 1e-5 * longest, "{t:?}");
            }
        }
    }
}

#[test]
fn repeated_corners_and_holes() {
    check_all(&[[0.0, 0.0], [0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [2.0, 2.0], [1.0, 0.5]]);
    // A square hole, reached along one line and left along the same.
    check_all(&[
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ]);
    // Two triangles that share one corner, and a line to nowhere.
    check_all(&[[0.0, 0.0], [2.0, -1.0], [2.0, 1.0], [0.0, 0.0], [-2.0, 1.0], [-2.0, -1.0]]);
    check_all(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [3.0, 1.5], [2.0, 1.0], [0.0, 1.0]]);
}

#[test]
fn what_is_no_border_is_refused() {
    let fault = |c: &[[f64; 2]]| cut(&flat(c)).unwrap_err();
    assert_eq!(fault(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), Fault::NoArea);
    assert_eq!(fault(&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [1.0, 3.0]]), Fault::Crosses(0, 2));
    let star: Vec<[f64; 2]> =
        (0..5).map(|i| f64::from(i) * 0.8 * std::f64::consts::PI).map(|a| [a.cos(), a.sin()]).collect();
    assert!(matches!(fault(&star), Fault::Crosses(..)));
    // Two loops of opposite sense that meet in one corner.
    let eight = [[0.0, 0.0], [2.0, -1.0], [2.0, 1.0], [0.0, 0.0], [-1.0, -0.5], [-1.0, 0.5]];
    assert!(matches!(fault(&eight), Fault::Overlaps(_)));
}

#[test]
fn fans_that_are_right_stay() {
    for n in [4usize, 5, 100, 10_000, 200_000] {
        let angle = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / n as f64;
        let disc: Vec<DVec3> = (0..n).map(|i| DVec3::new(angle(i).cos(), 2.0, angle(i).sin())).collect();
        assert_eq!(cut(&disc), Ok(Cut::Fan), "{n}");
    }
    // Seen from the dent all corners are in sight.
    assert_eq!(cut(&flat(&[[1.0, 0.5], [0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])), Ok(Cut::Fan));
    assert_eq!(cut(&flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])), Ok(Cut::Fan));
}

/// Random borders that do not cross themselves: corners by angle about the middle at any distance, some of them doubled,
/// some within a straight side.
#[test]
fn random_borders() {
    let mut random = Random(7);
    for n in 4..200usize {
        let mut border = Vec::new();
        for i in 0..n {
            let angle = 2.0 * std::f64::consts::PI * (i as f64 + 0.9 * random.next()) / n as f64;
            let radius = 0.2 + random.next();
            border.push([angle.cos() * radius, angle.sin() * radius]);
        }
        let border: Vec<[f64; 2]> = (0..n)
            .flat_map(|i| {
                let (a, b) = (border[i], border[(i + 1) % n]);
                let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
                [Some(a), (i % 5 == 0).then_some(a), (i % 3 == 0).then_some(middle)]
            })
            .flatten()
            .collect();
        let border = flat(&border);
        check(&border);
        check(&border.iter().rev().copied().collect::<Vec<_>>());
    }
}

/// A spiral of 10,000 corners: few are ears at first.
#[test]
fn a_long_spiral() {
    let arm = |side: f64| {
        (0..5000).map(move |i| {
            let angle = f64::from(i) * 0.02;
            let radius = 1.0 + angle + side;
            [angle.cos() * radius, angle.sin() * radius]
        })
    };
    let border: Vec<[f64; 2]> = arm(0.0).chain(arm(2.0).collect::<Vec<_>>().into_iter().rev()).collect();
    check(&flat(&border));
}
