//! Snell's and Fresnel's laws at one surface.

use super::case::{Case, Figure, Harness, Random};
use super::optics::{Crossing, crossings, fresnel, least, worst};
use crate::lab::probe::{ProbeHit, ProbeRay};
use crate::render::RenderError;
use crate::scene::procedural::shapes::{cuboid, empty, glass, polygon, sphere};
use crate::scene::{Fresnel, Scene};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "equal-indices",
        does: "glass of index 1 in air, and of 1.5 inside 1.5: rays continue unchanged, bit for bit, with full weight",
        stands_for: "visible outlines of objects whose index equals that of their surroundings",
        bound: "exact: for equal indices the ray is not recomputed (numerics.md, Refraction)",
        run: equal_indices,
    },
    Case {
        name: "critical-angle",
        does: "rays at the critical angle -+ 10^-k, k = 1..8 (16 in f64), from indices 1.33, 1.5, 2.42 and 1000",
        stands_for: "dark or bright rings where total internal reflection is missed or starts too early",
        bound: "right decision for |k| > K, cosine within min(sqrt K, K / cos) + (4 eta + 8) u, with \
                K = (4 eta + 16) u from the roundings of d + c n, scaled by eta and squared (numerics.md, Refraction)",
        run: critical_angle,
    },
    Case {
        name: "snell",
        does: "random rays and normals from both sides, indices 10^U(-3, 3): Snell's law for vectors",
        stands_for: "refracted rays that leave the plane of incidence or lose their unit length at extreme indices",
        bound: "unit length within 4u; |T_tan - eta I_tan| <= (6 max(1, eta) + 10) u, from the roundings of \
                eta (d + c n) and of the normalisation (numerics.md, Refraction)",
        run: snell,
    },
    Case {
        name: "fresnel",
        does: "reflectance from both sides, exact and Schlick, indices 1e-3 to 1e3, from normal to grazing incidence",
        stands_for: "Schlick with the wrong cosine inside glass (off by up to 0.96), no full reflection at grazing angles",
        bound: "16u + 2^-24 (stored in f32) + the change of the reflectance by the rounding of its cosines (numerics.md, Refraction)",
        run: fresnel_share,
    },
    Case {
        name: "thin-sheet",
        does: "a sheet of glass reflects the same in scenes with and without a solid",
        stands_for: "kernels specialised so far that they lose code that is still needed",
        bound: "as for `fresnel`, and the refracted ray does not change",
        run: thin_sheet,
    },
];

/// A block of glass around the origin, its faces 8 x 8 x 1 from it.
fn block(ior: f64, law: Fresnel) -> Scene {
    let mut s = empty(vec![glass(ior, law)]);
    s.meshes = vec![cuboid(DVec3::new(-8.0, -8.0, -1.0), DVec3::new(8.0, 8.0, 1.0), 0)];
    s
}

fn equal_indices(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut air = empty(vec![glass(1.0, Fresnel::Exact)]);
    air.spheres = vec![sphere([0.0; 3], 1.0, 0)];
    air.meshes = vec![cuboid(DVec3::new(2.0, -1.0, -1.0), DVec3::new(4.0, 1.0, 1.0), 0)];
    let mut immersed = block(1.5, Fresnel::Exact);
    immersed.materials.push(glass(1.5, Fresnel::Schlick));
    immersed.spheres = vec![sphere([0.1, 0.2, 0.0], 0.5, 1)];
    let (mut wrong, mut crossed) = (0, 0);
    for (scene, media) in [(air, [0, 0]), (immersed, [1, 0])] {
        let mut random = Random::new(31);
        let frame = h.local_frame(&scene);
        let rays: Vec<ProbeRay> = (0..8000)
            .map(|i| {
                let from = if media[0] == 0 { random.direction() * 3.0 } else { DVec3::splat(-0.6) };
                let at = if media[0] == 0 && i % 2 == 0 { DVec3::X * 3.0 } else { DVec3::ZERO };
                let d = h.round((at + random.direction() * 0.9 - from).normalize());
                ProbeRay { media: Some(media), ..ProbeRay::new(h.round(frame.point(from)), d) }
            })
            .collect();
        let mut step = rays;
        for _ in 0..2 {
            let probed = h.probe(&scene, &step)?;
            let on_sphere = |hit: &ProbeHit| media[0] == 0 || hit.id >= 12;
            wrong += probed.hits.iter().flatten().filter(|h| on_sphere(h) && h.share != 0.0).count();
            let children: Vec<_> = probed
                .children
                .iter()
                .filter(|c| probed.hits[c.parent].as_ref().is_some_and(on_sphere))
                .collect();
            crossed += children.len();
            wrong += children
                .iter()
                .filter(|c| {
                    !c.refracted || c.direction != step[c.parent].direction || c.throughput != [1.0; 3]
                })
                .count();
            step = children
                .iter()
                .map(|c| ProbeRay {
                    origin: c.origin,
                    direction: c.direction,
                    skip: c.skip,
                    media: Some(least(&c.media)),
                })
                .collect();
        }
    }
    Ok(Figure::count(wrong + usize::from(crossed == 0), crossed, "rays changed"))
}

/// Allowed error of the squared cosine of refraction for a relative index `eta`.
fn squared_cosine_error(u: f64, eta: f64) -> f64 {
    (4.0 * eta.max(1.0) + 16.0) * u
}

/// Allowed error of the cosine of refraction.
fn cosine_error(u: f64, eta: f64, k: f64) -> f64 {
    let e = squared_cosine_error(u, eta);
    e.sqrt().min(e / k.max(0.0).sqrt())
}

fn critical_angle(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let steps = if u < 1e-10 { 16 } else { 8 };
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for n in [1.33, 1.5, 2.42, 1000.0] {
        // A constant reflectance: any other law reaches 1 at the critical angle.
        let scene = block(n, Fresnel::Constant(0.25));
        let critical = (1.0 / f64::from(n as f32)).asin();
        let mut random = Random::new(32);
        let mut rays = Vec::new();
        for k in 1..=steps {
            for i in 0..200 {
                let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                let angle = critical + side * 10f64.powi(-k);
                let turn = random.range(0.0, std::f64::consts::TAU);
                let d = DVec3::new(
                    angle.sin() * turn.cos(),
                    angle.sin() * turn.sin(),
                    angle.cos().copysign(turn - 3.0),
                );
                if angle > 0.0 {
                    rays.push(ProbeRay { media: Some([1, 0]), ..ProbeRay::new(DVec3::ZERO, h.round(d)) });
                }
            }
        }
        for c in crossings(h, &scene, &rays)? {
            let k = c.squared_cosine_beyond();
            if k.abs() > squared_cosine_error(u, c.eta) && (c.share == 1.0) != (k < 0.0) {
                let unit = format!("wrong decision at k = {k:e}, index {n}");
                return Ok(Figure::new(f64::INFINITY, 1.0, unit));
            }
            if let (Some(t), true) = (c.transmitted, k > 0.0) {
                let error = (-t.dot(c.normal) - k.sqrt()).abs();
                let bound = cosine_error(u, c.eta, k) + (4.0 * c.eta + 8.0) * u;
                figure = worst(figure, error / bound, format!("of the allowed error (index {n})"));
            }
        }
    }
    Ok(figure)
}

/// Random rays at a unit sphere of index `n`, from outside and from inside.
fn random_crossings(
    h: &mut Harness<'_>,
    n: f64,
    law: Fresnel,
    count: usize,
) -> Result<Vec<Crossing>, RenderError> {
    let mut scene = empty(vec![glass(n, law)]);
    scene.spheres = vec![sphere([0.0; 3], 1.0, 0)];
    let mut random = Random::new(33);
    let frame = h.local_frame(&scene);
    let rays: Vec<ProbeRay> = (0..count)
        .map(|i| {
            let inside = i % 2 == 0;
            let from = random.direction() * if inside { random.unit() } else { 1.5 };
            let d = if inside { random.direction() } else { random.direction() * random.unit() - from };
            let media = Some(if inside { [1, 0] } else { [0, 0] });
            ProbeRay { media, ..ProbeRay::new(h.round(frame.point(from)), h.round(d.normalize())) }
        })
        .collect();
    crossings(h, &scene, &rays)
}

fn snell(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for i in 0..13 {
        let n = 10f64.powf(-3.0 + 0.5 * f64::from(i));
        for c in random_crossings(h, n, Fresnel::Constant(0.25), 4000)? {
            let Some(t) = c.transmitted else { continue };
            let off = (t.length() - 1.0).abs() / (4.0 * u);
            figure = worst(figure, off, format!("of the allowed error (unit length, index {n:.3})"));
            let along = t - c.normal * t.dot(c.normal);
            let k = c.squared_cosine_beyond();
            if k > squared_cosine_error(u, c.eta) {
                let error = (along - c.eta * c.along()).length() / ((6.0 * c.eta.max(1.0) + 10.0) * u);
                figure = worst(
                    figure,
                    error,
                    format!("of the allowed error (Snell, index {n:.3}, eta {:.3})", c.eta),
                );
            }
            let sum = c.weights.iter().sum::<f64>();
            figure = worst(
                figure,
                (sum - 1.0).abs() / 2f64.powi(-23),
                format!("of the allowed error (weights, index {n:.3})"),
            );
            figure =
                worst(figure, if t.dot(c.normal) < 4.0 * u { 0.0 } else { 2.0 }, "a ray on the wrong side");
        }
    }
    Ok(figure)
}

/// Largest change of the reflectance by the rounding of its cosines.
fn sensitivity(law: Fresnel, c: &Crossing, u: f64) -> f64 {
    let at = fresnel(law, c.n1, c.n2, c.cosine());
    let moved = |by: f64| (fresnel(law, c.n1, c.n2, (c.cosine() + by).clamp(0.0, 1.0)) - at).abs();
    let cosine = moved(4.0 * u).max(moved(-4.0 * u));
    let k = c.squared_cosine_beyond();
    let beyond = |by: f64| {
        let ct = (k.max(0.0).sqrt() + by).max(0.0);
        (super::optics::fresnel_at(law, c.n1, c.n2, c.cosine(), ct) - at).abs()
    };
    let e = cosine_error(u, c.eta, k);
    cosine + if k > -squared_cosine_error(u, c.eta) { beyond(e).max(beyond(-e)) } else { 0.0 }
}

fn share_figure(figure: Figure, law: Fresnel, c: &Crossing, u: f64) -> Figure {
    let error = (c.share - fresnel(law, c.n1, c.n2, c.cosine())).abs();
    let bound = 16.0 * u + 2f64.powi(-24) + sensitivity(law, c, u);
    worst(figure, error / bound, format!("of the allowed error ({law:?}, {} to {})", c.n1, c.n2))
}

fn fresnel_share(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for law in [Fresnel::Exact, Fresnel::Schlick] {
        for n in [1e-3, 0.5, 1.000_1, 1.33, 1.5, 2.42, 1e3] {
            for c in random_crossings(h, n, law, 2000)? {
                figure = share_figure(figure, law, &c, u);
            }
        }
    }
    // Published values: normal incidence, 45 degrees (Mitsuba's test_fresnel), Brewster.
    let scene = block(1.5, Fresnel::Exact);
    let above = h.local(&scene, DVec3::Z * 4.0);
    let at = |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, -degrees.to_radians().cos());
    let brewster = 1.5f64.atan();
    let s = (brewster.cos() - 1.5 * brewster.sin()) / (brewster.cos() + 1.5 * brewster.sin());
    let at_45 = 0.5 * (0.092_013_363_045_524_42_f64.powi(2) + 0.303_337_045_290_423_5_f64.powi(2));
    let known = [(0.0, 0.04), (45.0, at_45), (brewster.to_degrees(), s * s / 2.0)];
    let rays: Vec<_> = known.iter().map(|(a, _)| ProbeRay::new(above, h.round(at(*a)))).collect();
    for (c, (degrees, share)) in crossings(h, &scene, &rays)?.iter().zip(known) {
        let bound = 16.0 * u + 2f64.powi(-24) + sensitivity(Fresnel::Exact, c, u);
        figure = worst(
            figure,
            (c.share - share).abs() / bound,
            format!("of the allowed error (at {degrees} degrees)"),
        );
    }
    Ok(figure)
}

fn thin_sheet(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for law in [Fresnel::Exact, Fresnel::Schlick] {
        for (ior, solid) in [(1.5, false), (1.5, true), (0.6, true), (1000.0, false)] {
            let mut scene = empty(vec![glass(ior, law)]);
            let r = 4.0;
            scene.polygons = vec![polygon(&[[-r, -r, 0.0], [r, -r, 0.0], [r, r, 0.0], [-r, r, 0.0]], 0)];
            if solid {
                // Symmetric about the sheet, so that the local frame is the same.
                scene.spheres = vec![sphere([0.0; 3], 0.001, 0)];
            }
            let mut random = Random::new(34);
            let rays: Vec<ProbeRay> = (0..1000)
                .map(|i| {
                    // To grazing: cosines down to 2^-20.
                    let c = 2f64.powf(-20.0 * f64::from(i) / 1000.0);
                    let turn = random.range(0.0, std::f64::consts::TAU);
                    let s = (1.0 - c * c).sqrt();
                    let d = h.round(DVec3::new(s * turn.cos(), s * turn.sin(), -c));
                    let past = DVec3::new(0.01, 0.02, 0.0);
                    ProbeRay { media: Some([0, 0]), ..ProbeRay::new(h.round(past - d * 0.25), d) }
                })
                .collect();
            for mut c in crossings(h, &scene, &rays)? {
                (c.n1, c.n2) = (1.0, f64::from(ior as f32));
                let straight = c.transmitted.is_none_or(|t| t == c.incident);
                c.eta = 1.0 / c.n2;
                figure = share_figure(figure, law, &c, u);
                figure = worst(figure, if straight { 0.0 } else { 2.0 }, "a ray bent by a sheet");
            }
            if law == Fresnel::Schlick {
                figure = inside_sheet(h, figure, ior)?;
            }
        }
    }
    Ok(figure)
}

/// A sheet of index 1 inside glass, where Schlick's cosine is that of refraction.
fn inside_sheet(h: &mut Harness<'_>, figure: Figure, ior: f64) -> Result<Figure, RenderError> {
    let mut scene = block(ior, Fresnel::Schlick);
    scene.materials.push(glass(1.0, Fresnel::Schlick));
    let r = 4.0;
    scene.polygons = vec![polygon(&[[-r, -r, 0.0], [r, -r, 0.0], [r, r, 0.0], [-r, r, 0.0]], 1)];
    let from = h.local(&scene, DVec3::Z * 0.5);
    let mut random = Random::new(35);
    let rays: Vec<ProbeRay> = (0..500)
        .map(|_| {
            let d = random.direction();
            let d = h.round(DVec3::new(d.x, d.y, -d.z.abs().max(0.3)).normalize());
            ProbeRay { media: Some([1, 0]), ..ProbeRay::new(from, d) }
        })
        .collect();
    let mut figure = figure;
    for mut c in crossings(h, &scene, &rays)? {
        (c.n1, c.n2) = (f64::from(ior as f32), 1.0);
        c.eta = c.n1;
        figure = share_figure(figure, Fresnel::Schlick, &c, h.u());
    }
    Ok(figure)
}
