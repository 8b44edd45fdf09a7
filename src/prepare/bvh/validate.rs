//! Whether a hierarchy is sound.

use super::wide::Form;
use super::{Bvh, Item};
use crate::kernel::abi::{LEAF_BIT, LEAF_FIRST_BITS};

impl Bvh {
    /// Checks the structure of each form that is there: every item in exactly one leaf, leaves of one kind, every
    /// box around its items, levels within the stack.
    pub fn validate(&self, items: &[Item]) -> Result<(), String> {
        if self.nodes.is_empty() && self.compressed.is_empty() {
            return Err("no nodes at all".into());
        }
        self.validate_form(&self.nodes, self.stack, items)?;
        self.validate_form(&self.compressed, self.packet_stack, items)
    }

    fn validate_form<N: Form>(&self, nodes: &[N], stack: usize, items: &[Item]) -> Result<(), String> {
        if nodes.is_empty() {
            return Ok(());
        }
        if stack > N::STACK {
            return Err(format!("{stack} entries pass the stack of {}", N::STACK));
        }
        let mut seen = vec![false; items.len()];
        let mut work = vec![(0u32, 1usize)];
        while let Some((at, level)) = work.pop() {
            if level > self.depth {
                return Err(format!("node {at} lies at level {level}, deeper than {}", self.depth));
            }
            let n = nodes.get(at as usize).ok_or(format!("node {at} does not exist"))?;
            for (child, lo, hi) in n.children() {
                for item in self.items_below(nodes, child)? {
                    let b = items[item as usize].bounds;
                    if (0..3).any(|a| b.lo[a] < lo[a] || b.hi[a] > hi[a]) {
                        return Err(format!("item {item} sticks out of its box below node {at}"));
                    }
                }
                if child & LEAF_BIT == 0 {
                    work.push((child, level + 1));
                    continue;
                }
                let mut kinds = [false; 2];
                for item in self.items_below(nodes, child)? {
                    kinds[usize::from(items[item as usize].is_sphere)] = true;
                    if std::mem::replace(&mut seen[item as usize], true) {
                        return Err(format!("item {item} is in two leaves"));
                    }
                }
                if kinds == [true; 2] {
                    return Err(format!("a leaf below node {at} mixes kinds"));
                }
            }
        }
        match seen.iter().position(|s| !s) {
            Some(item) => Err(format!("item {item} is in no leaf")),
            None => Ok(()),
        }
    }

    fn items_below<N: Form>(&self, nodes: &[N], child: u32) -> Result<Vec<u32>, String> {
        let (mut found, mut work) = (Vec::new(), vec![child]);
        while let Some(c) = work.pop() {
            if c & LEAF_BIT != 0 {
                let first = (c & ((1 << LEAF_FIRST_BITS) - 1)) as usize;
                let count = ((c & !LEAF_BIT) >> LEAF_FIRST_BITS) as usize + 1;
                let run = self.order.get(first..first + count).ok_or("a leaf reaches past the items")?;
                found.extend_from_slice(run);
            } else {
                let n = nodes.get(c as usize).ok_or(format!("node {c} does not exist"))?;
                work.extend(n.children().map(|(child, ..)| child));
            }
        }
        Ok(found)
    }
}
