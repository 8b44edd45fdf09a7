//! Reflection, refraction and Fresnel reflectance at one surface.

use crate::scene::Fresnel;
use glam::DVec3;

/// u of `f64`.
const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Cosine of incidence: `normal` is turned toward the ray.
pub(super) fn cos_incident(direction: DVec3, normal: DVec3) -> f64 {
    (-direction.dot(normal)).clamp(0.0, 1.0)
}

/// Mirror direction, unit length.
pub(super) fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - normal * (2.0 * direction.dot(normal))).normalize()
}

/// Direction beyond the surface by Snell's law, from index `n1` into `n2`; `None` on total internal
/// reflection. Equal indices change nothing.
pub(super) fn refract(direction: DVec3, normal: DVec3, n1: f64, n2: f64) -> Option<DVec3> {
    if n1 == n2 {
        return Some(direction);
    }
    let (eta, cos_i) = (n1 / n2, cos_incident(direction, normal));
    let tangent = (direction + normal * cos_i) * eta;
    let k = 1.0 - tangent.length_squared();
    (k >= 0.0).then(|| (tangent - normal * k.sqrt()).normalize())
}

/// Bends `direction` until it is off the surface on the side `away` points to. Needed where the shading
/// normal is not the geometric one, and for grazing rays, whose cosine rounds away (3u).
pub(super) fn keep_side(direction: DVec3, away: DVec3) -> DVec3 {
    let least = 4.0 * UNIT_ROUNDOFF;
    let cos = direction.dot(away);
    if cos >= least { direction } else { (direction + away * (least - cos)).normalize() }
}

/// Share of reflection at a surface between indices `n1` (this side) and `n2`; 1 on total internal
/// reflection, whatever the model.
pub(super) fn reflectance(model: Fresnel, cos_i: f64, n1: f64, n2: f64) -> f64 {
    let Some(cos_t) = cos_transmitted(cos_i, n1, n2) else { return 1.0 };
    match model {
        Fresnel::Constant(share) => share,
        _ if n1 == n2 => 0.0,
        // Schlick 1994, eq. 24; the cosine is the one on the less dense side.
        Fresnel::Schlick => {
            let r0 = ((n1 - n2) / (n1 + n2)).powi(2);
            let cos = if n1 > n2 { cos_t } else { cos_i };
            r0 + (1.0 - r0) * (1.0 - cos).powi(5)
        }
        // Born and Wolf, *Principles of Optics*, 1.5.2: the mean of both polarisations.
        Fresnel::Exact => {
            let s = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t);
            let p = (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t);
            (s * s + p * p) / 2.0
        }
    }
}

fn cos_transmitted(cos_i: f64, n1: f64, n2: f64) -> Option<f64> {
    let eta = n1 / n2;
    let k = 1.0 - eta * eta * ((1.0 - cos_i) * (1.0 + cos_i));
    (n1 == n2 || k >= 0.0).then(|| if n1 == n2 { cos_i } else { k.sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_at_known_angles() {
        let exact = |cos: f64, n1: f64, n2: f64| reflectance(Fresnel::Exact, cos, n1, n2);
        assert!((exact(1.0, 1.0, 1.5) - 0.04).abs() < 1e-15);
        let at_45 = 0.5 * (0.092_013_363_045_524_42_f64.powi(2) + 0.303_337_045_290_423_5_f64.powi(2));
        assert!((exact(0.5f64.sqrt(), 1.0, 1.5) - at_45).abs() < 1e-15);
        assert_eq!(exact(0.0, 1.0, 1.5), 1.0);
        assert_eq!(exact(0.3, 1.5, 1.5), 0.0);
        assert_eq!(exact(0.1, 1.5, 1.0), 1.0);
        // At Brewster's angle only s light is reflected.
        let brewster = 1.5f64.atan();
        let s = (brewster.cos() - 1.5 * brewster.sin()) / (brewster.cos() + 1.5 * brewster.sin());
        assert!((exact(brewster.cos(), 1.0, 1.5) - s * s / 2.0).abs() < 1e-15);
    }

    #[test]
    fn reflectance_is_the_same_from_both_sides() {
        for model in [Fresnel::Exact, Fresnel::Schlick] {
            for i in 1..=100 {
                let cos_i = f64::from(i) / 100.0;
                let cos_t = cos_transmitted(cos_i, 1.0, 1.5).unwrap();
                let (out, back) = (reflectance(model, cos_i, 1.0, 1.5), reflectance(model, cos_t, 1.5, 1.0));
                assert!((out - back).abs() < 1e-13, "{model:?} {cos_i} {out} {back}");
            }
        }
        assert_eq!(reflectance(Fresnel::Schlick, 0.2, 1.3, 1.3), 0.0);
        assert_eq!(reflectance(Fresnel::Constant(0.3), 0.2, 1.3, 1.3), 0.3);
        assert_eq!(reflectance(Fresnel::Constant(0.3), 0.1, 1.5, 1.0), 1.0);
    }

    #[test]
    fn refraction_obeys_snell_and_runs_backwards() {
        for i in 0..90 {
            let angle = f64::from(i).to_radians();
            let d = DVec3::new(angle.sin(), -angle.cos(), 0.0);
            let t = refract(d, DVec3::Y, 1.0, 1.5).unwrap();
            assert!((t.x * 1.5 - d.x).abs() < 4e-16 && (t.length() - 1.0).abs() < 4e-16);
            let back = refract(-t, DVec3::NEG_Y, 1.5, 1.0).unwrap();
            assert!((back + d).length() < 1e-14 / angle.cos(), "{i}");
        }
    }

    #[test]
    fn bent_directions_leave_the_surface() {
        let away = DVec3::new(0.0, 0.6, 0.8);
        for d in [-away, DVec3::X, DVec3::NEG_Y] {
            let d = (d + DVec3::X).normalize();
            assert!(keep_side(d, away).dot(away) > 0.0);
        }
        assert_eq!(keep_side(DVec3::Z, away), DVec3::Z);
    }
}
