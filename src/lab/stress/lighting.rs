//! Light: distances, sums of samples, recursion.

use super::case::{Case, Figure, Harness, Random};
use super::optics::{fresnel, worst};
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::procedural::shapes::{
    cuboid, empty, glass, light, matte, mesh, mirror, polygon, room, sphere,
};
use crate::scene::{Fresnel, Light, Scene};
use crate::settings::Settings;
use glam::DVec3;

/// Unit roundoff of f32: colours are single precision at every kernel precision.
const COLOUR_U: f64 = 5.960_464_477_539_063e-8;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "inverse-square",
        does: "a light at distances 2^-12 to 2^40 and at random positions over a floor; two lights of half the intensity at one position",
        stands_for: "lights with the wrong falloff, or cut off at a far plane",
        bound: "16u, from the roundings of cos / d^2 and its weights; exact at powers of two and for the two halves (numerics.md, Shading)",
        run: inverse_square,
    },
    Case {
        name: "light-contact",
        does: "lights at distances 0, 1e-30, 1e-20, 1e-10, 1e20 and 1e38 from a floor, a vertex and a sphere",
        stands_for: "white or black blots (infinity, NaN) where a light touches a surface",
        bound: "exact: every pixel is finite, and a light within the ray offset is counted (numerics.md, Shading)",
        run: light_contact,
    },
    Case {
        name: "light-segment",
        does: "the edge of the shadow on the floor, of a blocker beside a light between floor and ceiling",
        stands_for: "objects behind a light that cast shadows; shadows detached from their object",
        bound: "edge at e + (e - l) b / (h - b), within half a pixel for sampling and 64u of the scene's size (numerics.md, Closed forms)",
        run: light_segment,
    },
    Case {
        name: "constant-image",
        does: "a wall of colour 0.1 at 1, 2, 3, 16, 1000, 4096, 2^16 and 2^20 samples",
        stands_for: "images that get darker with more samples: sums in single precision",
        bound: "1 ulp of the colour (numerics.md, Accumulation)",
        run: constant_image,
    },
    Case {
        name: "facing-mirrors",
        does: "a camera between two mirrors of reflectance 0.5, 0.9 and 0.99, depth 1 to 1000",
        stands_for: "recursion silently cut by a fixed limit or a threshold on the weight",
        bound: "a (1 - rho^n) within 8u (n + 1) (numerics.md, Closed forms)",
        run: facing_mirrors,
    },
    Case {
        name: "furnace",
        does: "perfect mirror and glass spheres in a uniform background",
        stands_for: "materials that create or lose energy",
        bound: "mirror: 4u depth; glass: 1 - (1 - R) R^(depth - 2), R within 16u and its change over 32u of height (numerics.md, Closed forms)",
        run: furnace,
    },
    Case {
        name: "mirror-ball-centre",
        does: "a camera at the centre of a mirror sphere sees itself in every pixel",
        stands_for: "spheres missed from inside",
        bound: "exact: all pixels are equal (numerics.md, Closed forms)",
        run: mirror_ball,
    },
    Case {
        name: "normals-that-cancel",
        does: "vertex normals that nearly or exactly cancel, and reflected rays of length 1 to 1e-30",
        stands_for: "NaN pixels on meshes with opposed normals; vectors whose squares underflow",
        bound: "unit length within 4u, mirror direction within 8u (numerics.md, Shading)",
        run: normals_that_cancel,
    },
];

/// A white floor of half-width 1 around the origin, seen from above through one pixel.
fn floor() -> Scene {
    let mut s = empty(vec![matte([1.0; 3], 0.0)]);
    s.polygons = vec![polygon(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]], 0)];
    s.camera.fov = 0.02;
    // Wide enough that the scene has one scale (numerics.md, Two scales): the floor is exactly at height 0 of its frame.
    s
}

/// The middle of the image, one pixel.
fn middle(h: &mut Harness<'_>, scene: &Scene, depth: u32) -> Result<f64, RenderError> {
    let settings = Settings { width: 1, height: 1, depth, ..h.settings(scene) };
    Ok(h.picture_with(scene, &settings)?.linear.first().map_or(f64::NAN, |p| f64::from(p[0])))
}

fn inverse_square(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut figure = Figure::new(0.0, 16.0 * COLOUR_U, "relative error");
    // Scaled and translated, to test the local frame as well.
    let scale = 2f64.powi(40);
    for k in -12..=40 {
        let mut scene = floor();
        let d = 2f64.powi(k);
        scene.lights = vec![light([0.0, 0.0, d], 0.75 * d * d * scale * scale)];
        let scene = crate::scene::procedural::shapes::moved(
            &Scene { lights: Vec::new(), ..scene.clone() },
            scale,
            DVec3::ZERO,
        )
        .with_lights(scene.lights.iter().map(|l| Light { position: l.position * scale, ..*l }));
        let exact = middle(h, &scene, 1)? == 0.75;
        figure = worst(figure, if exact { 0.0 } else { 1.0 }, format!("relative error at distance 2^{k}"));
    }
    let mut random = Random::new(51);
    let far = DVec3::new(1e6, -3e5, 7e5) / 3.0;
    for _ in 0..24 {
        let p = DVec3::new(random.range(-3.0, 3.0), random.range(-3.0, 3.0), random.range(0.1, 4.0));
        let mut scene = floor();
        scene.lights = vec![light(p.to_array(), 1.0)];
        let scene = crate::scene::procedural::shapes::moved(&scene, 1.0, far);
        let to_light = h.local(&scene, scene.lights[0].position) - h.local(&scene, far);
        let p = to_light / h.local_frame(&scene).length(1.0);
        let expected = p.z / p.length().powi(3);
        let error = (middle(h, &scene, 1)? - expected).abs() / expected;
        figure = worst(figure, error, "relative error");
    }
    let whole = room();
    let mut halves = whole.clone();
    halves.lights.iter_mut().for_each(|l| l.intensity *= 0.5);
    halves.lights.extend_from_within(..);
    let same = h.picture(&whole)?.linear == h.picture(&halves)?.linear;
    Ok(worst(figure, if same { 0.0 } else { 1.0 }, "two lights of half the intensity differ from one"))
}

impl Scene {
    fn with_lights(self, lights: impl Iterator<Item = Light>) -> Scene {
        Scene { lights: lights.collect(), ..self }
    }
}

fn light_contact(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut wrong = 0;
    let distances = [0.0, 1e-30, 1e-20, 1e-10, 1e20, 1e38];
    let places = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-0.5, 0.3, 0.0], [0.0, 0.0, 0.5]];
    for d in distances {
        for place in places {
            let mut scene = floor();
            scene.spheres = vec![sphere([0.0, 0.0, 0.25], 0.25, 0)];
            scene.camera.fov = 0.5;
            scene.lights = vec![light([place[0], place[1], place[2] + d], 1.0)];
            let settings = Settings { width: 33, height: 33, ..h.settings(&scene) };
            let picture = h.picture_with(&scene, &settings)?;
            wrong += picture.linear.iter().flatten().filter(|x| !x.is_finite() || **x < 0.0).count();
            wrong += picture.counters.nan_rays as usize;
        }
        // At the centre of one pixel: within the ray offset, and counted.
        let mut scene = floor();
        scene.lights = vec![light([0.0, 0.0, d], 1.0)];
        let settings = Settings { width: 1, height: 1, ..h.settings(&scene) };
        let picture = h.picture_with(&scene, &settings)?;
        let near = d > 0.0 && d < 1e-15;
        wrong += usize::from(near && picture.counters.clamped_lights == 0);
        wrong += picture.linear.iter().flatten().filter(|x| !x.is_finite()).count();
    }
    Ok(Figure::none(wrong, "pixels not finite, or lights not counted"))
}

fn light_segment(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for (edge, height) in [(0.1, 0.5), (-0.3, 0.25), (0.5, 0.01), (0.2, 0.000_1)] {
        let (from, top) = (-0.75, 1.5);
        let mut scene = floor();
        let r = 1.0;
        scene
            .polygons
            .push(polygon(&[[edge, -r, height], [r, -r, height], [r, r, height], [edge, r, height]], 0));
        // Behind the light; the camera is in between, below the plane of the blocker.
        let c = 1.75;
        scene.polygons.push(polygon(&[[-r, -r, c], [-r, r, c], [r, r, c], [r, -r, c]], 0));
        scene.lights = vec![light([from, 0.0, top], 1.0)];
        let shadow = edge + (edge - from) * height / (top - height);
        // A strip of floor with pixels far smaller than all objects.
        let pixel = 2f64.powi(-15);
        let width = 256;
        let eye = height * 0.5;
        let middle = shadow + 20.25 * pixel;
        scene.camera.look_from = DVec3::new(middle, 0.0, eye);
        scene.camera.look_at = DVec3::new(middle, 0.0, 0.0);
        scene.camera.fov = 2.0 * (pixel / 2.0 / eye).atan();
        let settings = Settings { width, height: 1, ..h.settings(&scene) };
        let row = h.picture_with(&scene, &settings)?.linear;
        let lit = row.iter().filter(|p| p[0] > 0.0).count() as f64;
        let expected = f64::from(width) / 2.0 - 20.25;
        let bound = 0.5 + 64.0 * u / pixel * (1.0 + 1.0 / (top - height));
        figure = worst(
            figure,
            (lit - expected).abs() / bound,
            format!("of the allowed error (blocker at {height})"),
        );
        let ordered = row.windows(2).all(|w| w[0][0] > 0.0 || w[1][0] == 0.0);
        figure = worst(figure, if ordered { 0.0 } else { 2.0 }, "more than one shadow edge");
    }
    Ok(figure)
}

fn constant_image(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = floor();
    scene.materials[0].ambient = 0.1;
    let mut worst_ulps = Figure::new(0.0, 1.0, "ulp of the colour");
    for samples in [1u32, 2, 3, 16, 1000, 4096, 1 << 16, 1 << 20] {
        let size = if samples > 4096 { 1 } else { 5 };
        let settings = Settings { width: size, height: size, samples, ..h.settings(&scene) };
        for value in h.picture_with(&scene, &settings)?.linear.into_iter().flatten() {
            let ulps = f64::from(value.to_bits().abs_diff(0.1f32.to_bits()));
            worst_ulps = worst(worst_ulps, ulps, format!("ulp at {samples} samples"));
        }
    }
    Ok(worst_ulps)
}

fn facing_mirrors(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for rho in [0.5, 0.9, 0.99] {
        let mut scene = empty(vec![mirror(rho, 1.0)]);
        let side = |z: f64| polygon(&[[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]], 0);
        scene.polygons = vec![side(-1.0), side(1.0)];
        scene.camera.look_from = DVec3::ZERO;
        scene.camera.look_at = DVec3::NEG_Z;
        let rho = f64::from(rho as f32);
        for n in [1, 2, 3, 10, 100, 1000] {
            let expected = 1.0 - rho.powi(n);
            let error = (middle(h, &scene, n as u32)? - expected).abs();
            let bound = 8.0 * COLOUR_U * f64::from(n + 1);
            figure =
                worst(figure, error / bound, format!("of the allowed error (mirrors {rho:.2}, depth {n})"));
        }
    }
    Ok(figure)
}

fn furnace(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    let mut scene = empty(vec![mirror(1.0, 0.0)]);
    scene.spheres = vec![sphere([0.0; 3], 1.0, 0), sphere([1.5, 0.5, -0.5], 0.6, 0)];
    scene.render.background = DVec3::splat(0.3);
    scene.render.depth = 40;
    let l = f64::from(0.3f32);
    for value in h.picture(&scene)?.linear.into_iter().flatten() {
        let error = (f64::from(value) - l).abs() / (4.0 * COLOUR_U * 40.0 * l);
        figure = worst(figure, error, "of the allowed error (mirror)");
    }
    let mut scene = empty(vec![glass(1.5, Fresnel::Exact)]);
    scene.spheres = vec![sphere([0.0; 3], 1.0, 0)];
    scene.render.background = DVec3::ONE;
    for height in [0.0, 0.3, 0.6, 0.9, 0.99] {
        scene.camera.look_from = DVec3::new(height, 0.0, 5.0);
        scene.camera.look_at = DVec3::new(height, 0.0, 0.0);
        let r = |height: f64| fresnel(Fresnel::Exact, 1.0, 1.5, (1.0 - height * height).max(0.0).sqrt());
        let (at, moved) = (r(height), (r((height + 32.0 * h.u()).min(1.0)) - r(height)).abs());
        for depth in 2..10 {
            let seen = middle(h, &scene, depth as u32)?;
            let expected = 1.0 - (1.0 - at) * at.powi(depth - 2);
            // Of (1 - R) R^m the change with R is at most m + 1 times its own; the sum and the
            // weights add 4u each.
            let n = f64::from(depth);
            let bound = (16.0 * COLOUR_U + moved) * n + 8.0 * COLOUR_U * n;
            figure = worst(
                figure,
                (seen - expected).abs() / bound,
                format!("of the allowed error (glass, depth {depth})"),
            );
            figure = worst(
                figure,
                if seen <= 1.0 + 4.0 * COLOUR_U * n { 0.0 } else { 2.0 },
                "more light than the background",
            );
        }
    }
    Ok(figure)
}

fn mirror_ball(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = empty(vec![mirror(0.75, 1.0)]);
    scene.spheres = vec![sphere([0.0; 3], 3.0, 0)];
    scene.camera.look_from = DVec3::ZERO;
    scene.camera.look_at = DVec3::new(1.0, 2.0, 3.0);
    scene.camera.fov = 3.0;
    scene.render.depth = 6;
    let picture = h.picture(&scene)?.linear;
    let expected = (1.0 - 0.75f64.powi(6)) as f32;
    let wrong = picture.iter().filter(|p| **p != [expected; 3]).count();
    Ok(Figure::count(wrong, picture.len(), "pixels differ"))
}

fn normals_that_cancel(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    let mut scene = empty(vec![mirror(1.0, 0.0)]);
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let mut surface = mesh(corners, &[[0, 1, 2]], 0);
    // At the middle of the first edge two of them cancel, and the third has weight 0.
    surface.normals = vec![DVec3::X, DVec3::NEG_X, DVec3::Z];
    surface.faces[0].normals = Some([0, 1, 2]);
    scene.meshes = vec![surface, cuboid(DVec3::new(-1.0, -1.0, -2.0), DVec3::new(1.0, 1.0, -1.5), 0)];
    let mut rays = Vec::new();
    for k in 0..=60 {
        let away = if k == 0 { 0.0 } else { 2f64.powi(-k) };
        let at = h.local(&scene, DVec3::new(0.5, away * 0.25, 0.0));
        rays.push(ProbeRay::new(at + DVec3::Z * 0.25, DVec3::NEG_Z));
    }
    let probed = h.probe(&scene, &rays)?;
    for hit in probed.hits.iter() {
        let off = hit.map_or(f64::NAN, |hit| (hit.normal.length() - 1.0).abs());
        figure = worst(figure, off / (4.0 * u), "of the allowed error (normals)");
    }
    for c in &probed.children {
        figure = worst(figure, (c.direction.length() - 1.0).abs() / (4.0 * u), "of the allowed error (rays)");
    }
    let mut random = Random::new(52);
    let scene = {
        let mut s = floor();
        s.materials = vec![mirror(1.0, 0.0)];
        s
    };
    let rays: Vec<ProbeRay> = (0..1000)
        .map(|i| {
            let d = random.direction();
            let d = DVec3::new(d.x, d.y, -d.z.abs().max(0.2)).normalize();
            let length = 10f64.powf(-30.0 * f64::from(i) / 1000.0);
            ProbeRay::new(h.round(DVec3::new(0.01, 0.02, 0.0) - d * 0.125), h.round(d * length))
        })
        .collect();
    let probed = h.probe(&scene, &rays)?;
    let lost = rays.len() - probed.children.len();
    figure = worst(figure, lost as f64 * 2.0, "rays lost");
    for c in &probed.children {
        let d = (rays[c.parent].direction * 1e30).normalize();
        let expected = DVec3::new(d.x, d.y, -d.z);
        figure = worst(
            figure,
            (c.direction - expected).length() / (8.0 * u),
            "of the allowed error (mirrored rays)",
        );
    }
    Ok(figure)
}
