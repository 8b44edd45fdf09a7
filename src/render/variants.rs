//! Kernels compiled so far, for renders that need the same ones again.

use crate::kernel::table::Kernel;
use crate::vk::Pipelines;
use std::rc::Rc;

/// Variants that are kept; what was used longest ago goes first. A render to an error takes up to five (two precisions, each
/// of the image, of listed pixels and of first surfaces), and each may be tens of megabytes of a driver's memory: a
/// renderer that many scenes pass through would keep those of all.
const MOST: usize = 12;

/// What kernels are compiled for: double precision or not, which they are, specialisation constants by id.
pub(super) type Variant = (bool, Vec<Kernel>, Vec<(u32, u32)>);

/// Compiled kernels by variant, the last used at the end.
pub(super) struct Variants<T = Pipelines>(Vec<(Variant, Rc<T>)>);

impl<T> Default for Variants<T> {
    fn default() -> Self {
        Variants(Vec::new())
    }
}

impl<T> Variants<T> {
    /// The kernels of a variant, if they are still there.
    pub(super) fn get(&mut self, variant: &Variant) -> Option<Rc<T>> {
        let at = self.0.iter().position(|(known, _)| known == variant)?;
        // The last used is at the end.
        self.0[at..].rotate_left(1);
        self.0.last().map(|(_, kernels)| Rc::clone(kernels))
    }

    /// Keeps the kernels of a new variant. Those that a render still holds live on until it ends.
    pub(super) fn keep(&mut self, variant: Variant, kernels: Rc<T>) {
        if self.0.len() == MOST {
            self.0.remove(0);
        }
        self.0.push((variant, kernels));
    }

    /// Forgets all.
    #[cfg(any(test, feature = "defects"))]
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_used_longest_ago_goes_first() {
        let variant = |n: u32| (false, vec![Kernel::Generate], vec![(0, n)]);
        let mut variants: Variants<u32> = Variants::default();
        for n in 0..MOST as u32 {
            variants.keep(variant(n), Rc::new(n));
        }
        assert_eq!(variants.get(&variant(0)).as_deref(), Some(&0));
        variants.keep(variant(99), Rc::new(99));
        assert_eq!(variants.get(&variant(1)), None);
        for n in (2..MOST as u32).chain([0, 99]) {
            assert_eq!(variants.get(&variant(n)).as_deref(), Some(&n));
        }
        assert_eq!(variants.0.len(), MOST);
        variants.clear();
        assert_eq!(variants.get(&variant(0)), None);
    }
}
