//! A fill of NFF as a material.

use crate::scene::material::{IOR, IOR_RANGE};
use crate::scene::table::within_f32;
use crate::scene::{Fresnel, Material};
use glam::DVec3;

/// `f r g b Kd Ks Shine T ior`, without the highlight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fill {
    /// r, g, b.
    pub color: DVec3,
    /// Weight of the diffuse term.
    pub kd: f64,
    /// Weight of the reflected ray.
    pub ks: f64,
    /// Weight of the refracted ray.
    pub transmits: f64,
    /// Index of refraction inside; only read if the fill transmits.
    pub ior: f64,
}

impl Fill {
    /// What makes the fill impossible, and a remedy.
    pub fn fault(&self) -> Option<(&'static str, &'static str)> {
        let weights = [self.kd, self.ks, self.transmits];
        (!weights.into_iter().all(within_f32))
            .then_some(("a fill with a negative weight", "write Kd, Ks and T from 0 to 1"))
    }

    /// What has to be assumed for [`Fill::material`].
    pub fn assumed(&self) -> Option<&'static str> {
        if self.transmits > 0.0 && !IOR_RANGE.contains(&self.ior) {
            return Some("transmitting fills without an index of refraction have that of the air, 1");
        }
        let spent = self.ks + self.transmits;
        (spent > 1.0 || spent == 1.0 && self.kd > 0.0)
            .then_some("fills with Ks + T of 1 or more, beside Kd, are dimmed to a sum Kd + Ks + T of 1")
    }

    /// The `number`th material of the file. Haines' colour is Kd c light + Ks reflected + T refracted; this program's
    /// (1 - s) diffuse light + s (f reflected + (1 - f) refracted). They agree for s = Ks + T, f = Ks / s and
    /// diffuse = Kd c / (1 - s): a mirror has a diffuse part still, so shadow rays start at it, and a glass without Ks
    /// refracts all. There is no ambient light.
    pub fn material(&self, number: usize) -> Material {
        let Fill { mut kd, mut ks, mut transmits, .. } = *self;
        let spent = ks + transmits;
        if spent > 1.0 || spent == 1.0 && kd > 0.0 {
            let all = kd + spent;
            (kd, ks, transmits) = (kd / all, ks / all, transmits / all);
        }
        let secondary = (ks + transmits).min(1.0);
        let own = 1.0 - secondary;
        let bends = transmits > 0.0 && IOR_RANGE.contains(&self.ior);
        Material {
            name: format!("fill {number}"),
            diffuse: if own > 0.0 { self.color * (kd / own) } else { self.color },
            ambient: 0.0,
            secondary,
            fresnel: Fresnel::Constant(if secondary > 0.0 { ks / (ks + transmits) } else { 1.0 }),
            ior: match (transmits > 0.0, bends) {
                (false, _) => IOR,
                (true, true) => self.ior,
                (true, false) => 1.0,
            },
            priority: 0,
            undrawn: None,
        }
    }
}
