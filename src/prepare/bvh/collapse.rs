//! Which nodes of the binary hierarchy remain as nodes of many children: those that make the sum of all
//! nodes' surfaces least (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, section 3.1; leaves stay as they are).

use super::compressed::CHILDREN;
use super::pairs::{Child, Pair};
use crate::kernel::abi::LEAF_BIT;

/// For each node of the binary hierarchy and number of places, how many of them go to its first child; 0
/// where it takes one place itself.
pub(super) struct Collapse<'a> {
    pairs: &'a [Pair],
    width: usize,
    /// By places less one.
    shares: Vec<[u8; CHILDREN]>,
}

impl Collapse<'_> {
    /// For nodes of up to `width` children, 2 to CHILDREN.
    pub fn new(pairs: &[Pair], width: usize) -> Collapse<'_> {
        let mut shares = vec![[0; CHILDREN]; pairs.len()];
        // Least sums below a node that has so many places, less one, of its parent's; leaves count nothing.
        let mut sums = vec![[0f32; CHILDREN]; pairs.len()];
        let below = |pair: &Pair| pair.map(|c| c.link).into_iter().filter(|link| link & LEAF_BIT == 0);
        let mut order: Vec<u32> = Vec::with_capacity(pairs.len());
        order.push(0);
        let mut next = 0;
        while let Some(at) = order.get(next) {
            order.extend(below(&pairs[*at as usize]));
            next += 1;
        }
        // Children before their parents.
        for at in order.into_iter().rev().map(|at| at as usize) {
            let mut of = |child: &Child| {
                let mut least = [0.0; CHILDREN];
                if child.link & LEAF_BIT == 0 {
                    let below = child.link as usize;
                    // As a node it costs its surface beside what is below it.
                    let own = sums[below][width - 1] + child.half_area() as f32;
                    for places in 1..width {
                        let parted = sums[below][places - 1];
                        let parts = places > 1 && parted < own;
                        shares[below][places - 1] *= u8::from(parts);
                        least[places - 1] = if parts { parted } else { own };
                    }
                }
                least
            };
            let [a, b] = pairs[at].each_ref().map(&mut of);
            for places in 2..=width {
                let sum = |first: usize| a[first - 1] + b[places - first - 1];
                let best = (1..places).min_by(|x, y| sum(*x).total_cmp(&sum(*y))).unwrap_or(1);
                shares[at][places - 1] = best as u8;
                sums[at][places - 1] = sum(best);
            }
        }
        Collapse { pairs, width, shares }
    }

    /// Children of the node that is made of pair `at`, and their number.
    pub fn children(&self, at: usize) -> ([Child; CHILDREN], usize) {
        let (mut children, mut count) = ([Child::ABSENT; CHILDREN], 0);
        // Each part waits for those before it, of a share at least.
        let (mut work, mut waiting) = ([(Child::ABSENT, 0); CHILDREN + 1], 0);
        let mut part = Some((at, self.width));
        loop {
            if let Some((at, places)) = part.take() {
                let first = usize::from(self.shares[at][places - 1]);
                let [a, b] = self.pairs[at];
                (work[waiting], work[waiting + 1]) = ((b, places - first), (a, first));
                waiting += 2;
            }
            if waiting == 0 {
                return (children, count);
            }
            waiting -= 1;
            let (child, places) = work[waiting];
            let below = child.link as usize;
            if child.link & LEAF_BIT == 0 && places > 1 && self.shares[below][places - 1] != 0 {
                part = Some((below, places));
            } else {
                children[count] = child;
                count += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::sampler::pcg4d;

    /// A binary hierarchy whose children are leaves or further pairs by chance, of boxes of any size.
    fn hierarchy(seed: u32, inner: u32) -> Vec<Pair> {
        let mut pairs = vec![[Child::ABSENT; 2]];
        let mut open = std::collections::VecDeque::from([(0, 0), (0, 1)]);
        while let Some((at, side)) = open.pop_front() {
            let [x, y, z, chance] = pcg4d([seed, at as u32, side as u32, inner]);
            let mut child = Child { lo: [0.0; 3], hi: [x, y, z].map(|c| c as f32 / 4e9), ..Child::ABSENT };
            let next = pairs.len();
            if next <= inner as usize && (chance % 3 != 0 || open.is_empty()) {
                child.link = next as u32;
                pairs.push([Child::ABSENT; 2]);
                open.extend([(next, 0), (next, 1)]);
            }
            pairs[at][side] = child;
        }
        pairs
    }

    fn is_inner(child: &&Child) -> bool {
        child.link & LEAF_BIT == 0
    }

    /// Surfaces below the node made of pair `at`, whichever of all its possible children make them least.
    fn least(pairs: &[Pair], at: usize, width: usize) -> f64 {
        let (mut best, mut work) = (f64::INFINITY, vec![pairs[at].to_vec()]);
        while let Some(children) = work.pop() {
            let below = |c: &Child| c.half_area() + least(pairs, c.link as usize, width);
            best = best.min(children.iter().filter(is_inner).map(below).sum());
            for i in (0..children.len()).filter(|i| children.len() < width && is_inner(&&children[*i])) {
                let mut opened = children.clone();
                opened.splice(i..=i, pairs[children[i].link as usize]);
                work.push(opened);
            }
        }
        best
    }

    fn taken(collapse: &Collapse, at: usize) -> f64 {
        let (children, count) = collapse.children(at);
        assert!(count <= collapse.width);
        let below = |c: &Child| c.half_area() + taken(collapse, c.link as usize);
        children[..count].iter().filter(is_inner).map(below).sum()
    }

    #[test]
    fn no_other_choice_of_nodes_has_less_surface() {
        for (seed, width) in (0..60).zip([2, 3, 4, 8].into_iter().cycle()) {
            let pairs = hierarchy(seed, 7);
            let (found, best) = (taken(&Collapse::new(&pairs, width), 0), least(&pairs, 0, width));
            assert!((found - best).abs() <= 1e-5 * best, "{seed}, {width}: {found} for {best}");
            // More children leave fewer nodes.
            assert!(best <= taken(&Collapse::new(&pairs, 2), 0) * 1.00001);
        }
    }
}
