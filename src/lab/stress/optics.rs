//! Closed forms of refraction, and records of rays at surfaces in the kernels.

use super::case::{Figure, Harness};
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::{Fresnel, Scene};
use glam::DVec3;

/// A ray at a surface: inputs and results of the kernels.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Direction of the ray as given.
    pub incident: DVec3,
    /// Shading normal on the ray's side, as the kernel has it.
    pub normal: DVec3,
    /// Index on the ray's side.
    pub n1: f64,
    /// Index on the other side.
    pub n2: f64,
    /// n1 / n2.
    pub eta: f64,
    /// Reflectance.
    pub share: f64,
    /// Direction of the refracted ray.
    pub transmitted: Option<DVec3>,
    /// Weights of the reflected and the refracted ray.
    pub weights: [f64; 2],
}

impl Crossing {
    /// Cosine of incidence of the exact direction.
    pub fn cosine(&self) -> f64 {
        (-self.incident.normalize().dot(self.normal.normalize())).clamp(0.0, 1.0)
    }

    /// Component of the unit incident direction along the surface.
    pub fn along(&self) -> DVec3 {
        let (d, n) = (self.incident.normalize(), self.normal.normalize());
        d - n * d.dot(n)
    }

    /// 1 - (eta sin)^2.
    pub fn squared_cosine_beyond(&self) -> f64 {
        1.0 - self.eta * self.eta * self.along().length_squared()
    }
}

/// Traces rays against solids of one index in air and records each crossing. A ray's list of media
/// determines its side: a ray inside a solid leaves it.
pub fn crossings(
    h: &mut Harness<'_>,
    scene: &Scene,
    rays: &[ProbeRay],
) -> Result<Vec<Crossing>, RenderError> {
    let n = scene.materials.first().map_or(1.0, |m| f64::from(m.ior as f32));
    let probed = h.probe(scene, rays)?;
    let mut of_ray = vec![None; rays.len()];
    let mut found: Vec<Crossing> = Vec::new();
    for (ray, hit) in probed.hits.iter().enumerate() {
        let Some(hit) = hit else { continue };
        let inside = rays[ray].media.is_some_and(|m| m[0] != 0);
        let (n1, n2) = if inside { (n, 1.0) } else { (1.0, n) };
        of_ray[ray] = Some(found.len());
        found.push(Crossing {
            incident: rays[ray].direction,
            normal: hit.normal,
            n1,
            n2,
            eta: n1 / n2,
            share: hit.share,
            transmitted: None,
            weights: [0.0; 2],
        });
    }
    for child in &probed.children {
        if let Some(i) = of_ray[child.parent] {
            found[i].weights[usize::from(child.refracted)] = f64::from(child.throughput[0]);
            if child.refracted {
                found[i].transmitted = Some(child.direction);
            }
        }
    }
    Ok(found)
}

/// Reflectance from index `n1` to `n2` at cosine `c` of incidence.
pub fn fresnel(law: Fresnel, n1: f64, n2: f64, c: f64) -> f64 {
    let eta = n1 / n2;
    let k = 1.0 - eta * eta * (1.0 - c) * (1.0 + c);
    if k < 0.0 {
        return 1.0;
    }
    fresnel_at(law, n1, n2, c, k.sqrt())
}

/// The same with the cosine of refraction given: Born and Wolf, Principles of Optics, 1.5.2;
/// Schlick 1994, eq. 24, with the cosine on the less dense side.
pub fn fresnel_at(law: Fresnel, n1: f64, n2: f64, c: f64, ct: f64) -> f64 {
    match law {
        Fresnel::Constant(share) => share,
        _ if n1 == n2 => 0.0,
        Fresnel::Schlick => {
            let r0 = ((n1 - n2) / (n1 + n2)).powi(2);
            r0 + (1.0 - r0) * (1.0 - if n1 > n2 { ct } else { c }).powi(5)
        }
        Fresnel::Exact => {
            let s = (n1 * c - n2 * ct) / (n1 * c + n2 * ct);
            let p = (n2 * c - n1 * ct) / (n2 * c + n1 * ct);
            (s * s + p * p) / 2.0
        }
    }
}

/// The figure with `value` if that is larger or NaN.
pub fn worst(figure: Figure, value: f64, unit: impl Into<String>) -> Figure {
    if value <= figure.value || figure.value.is_nan() {
        figure
    } else {
        Figure { value, unit: unit.into(), ..figure }
    }
}

/// The first two of a list of media.
pub fn least(media: &[u32]) -> [u32; 2] {
    std::array::from_fn(|i| media.get(i).copied().unwrap_or(0))
}

/// The refracted child of each ray as the next ray; `None` where there is none.
pub fn follow(
    h: &mut Harness<'_>,
    scene: &Scene,
    rays: &[ProbeRay],
) -> Result<Vec<Option<ProbeRay>>, RenderError> {
    let probed = h.probe(scene, rays)?;
    let mut next = vec![None; rays.len()];
    for c in probed.children.iter().filter(|c| c.refracted) {
        next[c.parent] = Some(ProbeRay {
            origin: c.origin,
            direction: c.direction,
            skip: c.skip,
            media: Some(least(&c.media)),
        });
    }
    Ok(next)
}
