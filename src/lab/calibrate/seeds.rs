//! Sampler seeds of truths and trials. No truth shares a seed with a trial.

use crate::scene::procedural::families::draw::Draw;

/// Seed of renders that are not judged.
pub(super) const WARM: u32 = 0;

/// Seeds of trials: 1, 2, ...
pub(super) fn trials(count: u32) -> std::ops::RangeInclusive<u32> {
    1..=count
}

/// Seed `k` of a truth: at least 2^31, above those of all trials; its other bits are hashed, so that a sampler whose
/// neighbouring seeds are alike does no harm.
pub(super) fn truth(k: u32) -> u32 {
    (Draw::new("truth", k, 0).word() >> 32) as u32 | 1 << 31
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn truths_have_seeds_of_their_own() {
        let truths: BTreeSet<u32> = (0..1000).map(truth).collect();
        assert_eq!(truths.len(), 1000);
        assert!(truths.iter().all(|seed| !trials(1 << 20).contains(seed)));
    }
}
