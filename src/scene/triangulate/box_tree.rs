//! Boxes of consecutive items, halved down to one each: finds those that touch a box.

/// Least x, least y, greatest x, greatest y.
pub(super) type Rectangle = [f64; 4];

/// A complete binary tree in an array: node 1 is the root, the children of k are 2k and 2k + 1, item i is node `leaves` + i.
/// An item that is removed has an empty box.
pub(super) struct BoxTree {
    leaves: usize,
    nodes: Vec<Rectangle>,
}

const EMPTY: Rectangle = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

fn union(a: Rectangle, b: Rectangle) -> Rectangle {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

impl BoxTree {
    /// Of `count` items with these boxes.
    pub fn new(count: usize, of: impl Fn(usize) -> Rectangle) -> BoxTree {
        let leaves = count.next_power_of_two();
        let mut nodes = vec![EMPTY; 2 * leaves];
        (0..count).for_each(|i| nodes[leaves + i] = of(i));
        (1..leaves).rev().for_each(|k| nodes[k] = union(nodes[2 * k], nodes[2 * k + 1]));
        BoxTree { leaves, nodes }
    }

    /// Takes item `i` out.
    pub fn remove(&mut self, i: usize) {
        let mut k = self.leaves + i;
        self.nodes[k] = EMPTY;
        while k > 1 {
            k /= 2;
            let both = union(self.nodes[2 * k], self.nodes[2 * k + 1]);
            if both == self.nodes[k] {
                return;
            }
            self.nodes[k] = both;
        }
    }

    /// The first item, in ascending order from `from`, whose box touches `area` and that `accept` accepts.
    pub fn find(
        &self,
        area: &Rectangle,
        from: usize,
        mut accept: impl FnMut(usize) -> bool,
    ) -> Option<usize> {
        // At most one node waits on each level.
        let (mut waiting, mut count) = ([1usize; 64], 1);
        while count > 0 {
            count -= 1;
            let k = waiting[count];
            let b = &self.nodes[k];
            // The last item below node k, which has `span` of them.
            let span = self.leaves >> k.ilog2();
            let last = (k + 1) * span - 1 - self.leaves;
            let apart = b[0] > area[2] || b[1] > area[3] || b[2] < area[0] || b[3] < area[1];
            if apart || last < from {
                continue;
            }
            if k >= self.leaves {
                if accept(k - self.leaves) {
                    return Some(k - self.leaves);
                }
                continue;
            }
            (waiting[count], waiting[count + 1]) = (2 * k + 1, 2 * k);
            count += 2;
        }
        None
    }
}
