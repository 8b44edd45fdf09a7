//! Twin of `glsl/lib/optics/fresnel.glsl`.

use super::super::real::{Real, Real3, real};
use super::super::structs::Material;
use super::numeric::{dot3, safe_normalize};
use crate::kernel::abi::{FRESNEL_CONSTANT, FRESNEL_EXACT};

fn along_surface(d: Real3, n: Real3, c: Real) -> Real3 {
    d + c * n
}

fn transmitted_cosine_squared(scaled: Real3) -> Real {
    1.0 - dot3(scaled, scaled)
}

fn fresnel_exact(n1: Real, n2: Real, c: Real, ct: Real) -> Real {
    let rs = (n1 * c - n2 * ct) / (n1 * c + n2 * ct);
    let rp = (n2 * c - n1 * ct) / (n2 * c + n1 * ct);
    (rs * rs + rp * rp) * 0.5
}

fn fresnel_schlick(n1: Real, n2: Real, c: Real, ct: Real) -> Real {
    let r = (n1 - n2) / (n1 + n2);
    let r0 = r * r;
    let m = 1.0 - if n1 > n2 { ct } else { c };
    let m2 = m * m;
    r0 + (1.0 - r0) * (m2 * m2 * m)
}

/// Share of reflection between indices n1 (here) and n2 (beyond), at cosine c.
pub fn reflection_share(m: &Material, n1: Real, n2: Real, d: Real3, n: Real3, c: Real) -> Real {
    let eta = n1 / n2;
    let k = transmitted_cosine_squared(eta * along_surface(d, n, c));
    if k < 0.0 {
        return 1.0;
    }
    if m.fresnel_kind == FRESNEL_CONSTANT {
        return real(m.fresnel);
    }
    if n1 == n2 {
        return 0.0;
    }
    let ct = k.sqrt();
    if m.fresnel_kind == FRESNEL_EXACT {
        fresnel_exact(n1, n2, c, ct)
    } else {
        fresnel_schlick(n1, n2, c, ct)
    }
}

/// Direction of the refracted ray; n on the ray's side, c = -n.d >= 0.
pub fn refracted(d: Real3, n: Real3, eta: Real, c: Real) -> Real3 {
    let scaled = eta * along_surface(d, n, c);
    let k = transmitted_cosine_squared(scaled);
    safe_normalize(scaled - (if k > 0.0 { k } else { 0.0 }).sqrt() * n)
}

/// Direction of the reflected ray.
pub fn reflected(d: Real3, n: Real3, c: Real) -> Real3 {
    safe_normalize(d + (2.0 * c) * n)
}
