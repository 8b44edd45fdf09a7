//! Greatest depth at which a scene can have rays, from its materials alone. Deeper passes are left
//! out.

use crate::scene::{Fresnel, Material};
use serde::Serialize;

/// How much of a ray's throughput the surfaces of a scene can pass on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MaxDepth {
    /// Greatest factor of any surface on the throughput of one child: 0 if none reflects or
    /// refracts. The throughput of depth d is at most its power d - 1.
    pub weight: f64,
    /// True if some surface can spawn two rays, reflected and refracted.
    pub branches: bool,
}

impl MaxDepth {
    /// From the materials of a scene. `overlapping` is true if solids may overlap: a surface inside
    /// another solid passes its ray on unchanged.
    pub fn new<'a>(
        materials: impl Iterator<Item = &'a Material>,
        overlapping: bool,
        branches: bool,
    ) -> MaxDepth {
        let weight = materials.map(weight).fold(0.0, f64::max);
        MaxDepth { weight: if overlapping && weight > 0.0 { 1.0 } else { weight }, branches }
    }

    /// No limit but the depth asked for.
    pub fn unlimited(branches: bool) -> MaxDepth {
        MaxDepth { weight: 1.0, branches }
    }

    /// Greatest depth that can have rays, at most `depth`. Children with a throughput below
    /// `cutoff` are not traced.
    pub fn last_depth(&self, depth: u32, cutoff: f32) -> u32 {
        if self.weight <= 0.0 {
            return 1;
        }
        // Kernels multiply in f32, three roundings a bounce: 2^-24 each.
        let weight = self.weight * (1.0 + 2f64.powi(-20));
        if cutoff <= 0.0 || weight >= 1.0 {
            return depth;
        }
        // Children of depth d have at most weight^d.
        let mut throughput = weight;
        (1..depth)
            .find(|_| {
                let cut = throughput < f64::from(cutoff);
                throughput *= weight;
                cut
            })
            .unwrap_or(depth)
    }

    /// The reason for [`MaxDepth::last_depth`], for people.
    pub fn words(&self, depth: u32, cutoff: f32) -> String {
        let last = self.last_depth(depth, cutoff);
        match (self.weight > 0.0, self.branches, last < depth) {
            (false, ..) => "nothing reflects or refracts".into(),
            (true, _, true) => format!(
                "a surface passes on at most {} of a ray's weight, so --cutoff {cutoff} leaves no ray beyond depth {last}",
                crate::units::number(self.weight)
            ),
            (true, false, false) => "rays do not branch; limited by the depth asked for".into(),
            (true, true, false) => {
                "rays branch, up to twice as many at each depth; limited by the depth asked for".into()
            }
        }
    }
}

fn weight(m: &Material) -> f64 {
    let share = match m.fresnel {
        Fresnel::Constant(f) => f.max(1.0 - f),
        Fresnel::Schlick | Fresnel::Exact => 1.0,
    };
    m.secondary * share
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(secondary: f64, fresnel: Fresnel) -> Material {
        Material {
            name: String::new(),
            diffuse: glam::DVec3::ONE,
            ambient: 0.0,
            secondary,
            fresnel,
            ior: 1.5,
            priority: 0,
            undrawn: None,
        }
    }

    fn max_depth(materials: &[Material]) -> MaxDepth {
        MaxDepth::new(materials.iter(), false, false)
    }

    #[test]
    fn what_hands_on_nothing_ends_at_once() {
        let matt = max_depth(&[of(0.0, Fresnel::Exact), of(0.0, Fresnel::Constant(1.0))]);
        assert_eq!((matt.last_depth(7, 0.0), matt.last_depth(1, 0.5)), (1, 1));
        let mirror = max_depth(&[of(0.0, Fresnel::Exact), of(1.0, Fresnel::Constant(1.0))]);
        assert_eq!((mirror.last_depth(7, 0.0), mirror.last_depth(7, 0.9)), (7, 7));
    }

    /// Children of depth d weigh 0.5^d: the first below 0.2 is that of depth 3, 0.125.
    #[test]
    fn a_cutoff_ends_what_surfaces_weaken() {
        let half = max_depth(&[of(0.5, Fresnel::Exact)]);
        assert_eq!((half.last_depth(9, 0.2), half.last_depth(2, 0.2), half.last_depth(9, 0.0)), (3, 2, 9));
        // Exactly the cutoff is still traced.
        assert_eq!(half.last_depth(9, 0.25), 3);
        assert_eq!(half.last_depth(9, 0.251), 2);
        // A fixed split hands on its larger share.
        assert_eq!(max_depth(&[of(1.0, Fresnel::Constant(0.5))]), half);
        // Where solids overlap, a ray may pass whole.
        assert_eq!(MaxDepth::new([of(0.5, Fresnel::Exact)].iter(), true, false).last_depth(9, 0.2), 9);
    }
}
