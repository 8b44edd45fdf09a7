//! Closed surfaces that light passes, and how many of them a ray can be in.

use super::MEDIA_MAX;
use crate::scene::bounds::Bounds;

/// A closed surface that light passes.
pub(super) struct Solid {
    pub bounds: Bounds,
    pub ior: f64,
    pub priority: i32,
    pub contains_eye: bool,
}

/// How many solids a ray can be in at once, and those the eye is in, outermost (largest) first.
pub(super) fn media(solids: &[Solid]) -> (u32, Vec<u32>) {
    if solids.is_empty() {
        return (0, Vec::new());
    }
    // A ray is at once only in solids that all touch one of them. Past this size the quadratic
    // search costs more than the words it saves.
    let at_once = if solids.len() <= 4096 {
        let touching = |s: &Solid| solids.iter().filter(|o| o.bounds.touches(&s.bounds)).count() as u32;
        solids.iter().map(touching).max().unwrap_or(1)
    } else {
        MEDIA_MAX
    };
    let capacity = at_once.min(MEDIA_MAX);
    let mut holding: Vec<usize> = (0..solids.len()).filter(|i| solids[*i].contains_eye).collect();
    let size = |i: usize| (solids[i].bounds.hi - solids[i].bounds.lo).length();
    holding.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
    let mut eye: Vec<u32> = holding.iter().map(|i| *i as u32 + 1).take(capacity as usize).collect();
    eye.resize(capacity as usize, 0);
    (capacity, eye)
}
