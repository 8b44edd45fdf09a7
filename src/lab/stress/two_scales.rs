//! Two scales in one scene: near things beside a moon, on a ground of kilometres, through a long lens.

use super::case::{Case, Figure, Harness};
use crate::compare::metrics::{edge_length, mismatch_bound, pixel_error};
use crate::reference::oracle::Oracle;
use crate::render::RenderError;
use crate::scene::procedural::shapes::{
    cuboid, empty, glass, light, matte, mesh, mirror, polygon, room, sphere,
};
use crate::scene::{Fresnel, Material, Scene};
use crate::settings::Settings;
use glam::{DQuat, DVec3};

const BOUND: &str = "M + 3 sqrt M + 3 pixels against the oracle in world coordinates, M = 2 * edge length * 64u * 3 / \
                     pixel's angle (numerics.md, Two scales)";

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "far-body",
        does: "a room seen from inside, and out of view a moon, a ball, a triangle, a mesh at 10^5 to 10^20 m",
        stands_for: "one grid for all coordinates: a moon in the file ruins the living room",
        bound: BOUND,
        run: far_body,
    },
    Case {
        name: "wide-ground",
        does: "things of 20 cm on grounds of 10^3 to 10^7 m: polygons, level and tilted, and a smooth mesh",
        stands_for: "large polygons under small things, whose hit points are as coarse as the polygon is large",
        bound: BOUND,
        run: wide_ground,
    },
    Case {
        name: "ball-as-ground",
        does: "the same things on spheres of radius 30 to 10^7 m, a moon beside",
        stands_for: "between the radii that a scene's frame takes in and those of planets, neither test has digits",
        bound: BOUND,
        run: ball_as_ground,
    },
    Case {
        name: "far-light",
        does: "the same on a ground of 10^5 m in the light of a lamp at 10^3 to 10^11 m",
        stands_for: "shadow rays whose length dwarfs what they start at",
        bound: BOUND,
        run: far_light,
    },
    Case {
        name: "long-lens",
        does: "the same from 10^5 m through a lens of 3e-5 degrees, other bodies beside and behind the eye",
        stands_for: "primary rays that start where coordinates are coarse, and lose the pixel on their way",
        bound: BOUND,
        run: long_lens,
    },
    Case {
        name: "two-scales-in-mirrors",
        does: "the same on a mirroring ground of 10^5 m, and the room with a mirror wall and a moon",
        stands_for: "secondary rays that start on large or far shapes",
        bound: BOUND,
        run: in_mirrors,
    },
    Case {
        name: "two-scales-in-glass",
        does: "the same on a ground of 10^5 m through a ball and a pane of glass",
        stands_for: "refracted rays that start on large or far shapes",
        bound: BOUND,
        run: in_glass,
    },
];

/// Pictures against the oracle's. An edge moves by at most 64u (s + e): two spawn offsets of a shape of extent e at
/// distance s, of which the seen distance is at least a third (`prepare::cut`: e is at most two distances).
fn judge(h: &mut Harness<'_>, scenes: &[(String, Scene)]) -> Result<Figure, RenderError> {
    let mut worst: Option<Figure> = None;
    for (what, scene) in scenes {
        let settings: Settings = h.settings(scene);
        let truth = Oracle::new(scene).render(&settings);
        let edges = edge_length(&truth.first_hit, settings.width as usize).unwrap_or(0);
        let pixel = 2.0 * (scene.camera.fov / 2.0).tan() / f64::from(settings.height);
        let bound = mismatch_bound(64.0 * h.u() * 3.0 / sight(scene, pixel), edges, settings.samples);
        let seen = h.picture(scene)?.linear;
        let changed = seen
            .iter()
            .zip(&truth.linear)
            .filter(|(a, b)| {
                a.iter().any(|x| !x.is_finite()) || pixel_error(*a, &b.as_vec3().to_array()).1 > 1
            })
            .count();
        let unit = format!("of {} pixels changed by more than one code ({what})", seen.len());
        let figure = Figure::new(changed as f64, bound, unit);
        worst = Some(match worst {
            None => figure,
            Some(worst) => worst.worse(figure),
        });
    }
    Ok(worst.unwrap_or_else(|| Figure::none(0, "pictures")))
}

/// Angle of a pixel, or, under a long lens, its size beside the things that it is aimed at.
fn sight(scene: &Scene, pixel: f64) -> f64 {
    let away = scene.camera.look_at.distance(scene.camera.look_from);
    pixel * away.max(1.0)
}

/// The room seen from within.
fn inside() -> Scene {
    let mut s = room();
    s.camera.look_from = DVec3::new(0.3, 0.2, 4.5);
    s.camera.look_at = DVec3::new(0.0, -1.5, -2.0);
    s.camera.fov = 1.2;
    s
}

/// Things of 20 cm about the origin, nothing under them.
fn things() -> Scene {
    let mut s = empty(vec![
        matte([0.8, 0.8, 0.8], 0.1),
        matte([0.8, 0.2, 0.1], 0.1),
        mirror(0.8, 0.1),
        Material { diffuse: DVec3::new(0.8, 0.9, 1.0), ..glass(1.5, Fresnel::Exact) },
    ]);
    s.spheres = vec![sphere([0.0, 0.1, 0.0], 0.1, 2), sphere([0.25, 0.08, 0.1], 0.08, 3)];
    s.meshes = vec![
        cuboid(DVec3::new(-0.33, 0.0, -0.03), DVec3::new(-0.17, 0.2, 0.13), 1),
        cuboid(DVec3::new(0.0, 0.0, 0.26), DVec3::new(0.1, 0.1, 0.34), 0),
    ];
    s.polygons = vec![polygon(&[[-0.4, 0.01, -0.3], [0.1, 0.02, -0.35], [-0.1, 0.4, -0.4]], 0)];
    s.lights = vec![light([1.0, 2.0, 1.0], 3.0)];
    s.camera.look_from = DVec3::new(0.5, 0.35, 0.9);
    s.camera.look_at = DVec3::new(0.0, 0.1, 0.0);
    s.render.depth = 5;
    s.render.background = DVec3::new(0.1, 0.2, 0.4);
    s
}

/// A square ground of side `far - near` at height y.
fn ground(near: f64, far: f64, y: f64, material: usize) -> crate::scene::Polygon {
    polygon(&[[near, y, near], [near, y, far], [far, y, far], [far, y, near]], material)
}

/// `scene` turned about an axis of no importance.
fn turned(scene: &Scene) -> Scene {
    let mut s = scene.clone();
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let map = |v: &mut DVec3| *v = turn * *v;
    [&mut s.camera.look_from, &mut s.camera.look_at, &mut s.camera.up].into_iter().for_each(map);
    s.lights.iter_mut().map(|l| &mut l.position).for_each(map);
    s.spheres.iter_mut().map(|o| &mut o.center).for_each(map);
    s.polygons.iter_mut().for_each(|p| {
        p.vertices.iter_mut().for_each(map);
        p.normal = turn * p.normal;
    });
    s.meshes.iter_mut().flat_map(|m| m.vertices.iter_mut().chain(&mut m.normals)).for_each(map);
    s
}

fn far_body(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let with = |what: &str, add: &dyn Fn(&mut Scene)| {
        let mut s = inside();
        add(&mut s);
        (what.to_owned(), s)
    };
    let at = |d: f64| DVec3::new(d, 0.03 * d, 0.2 * d);
    let scenes = [
        with("moon", &|s| s.spheres.push(sphere([3.8e8, 1e7, 0.0], 1.74e6, 2))),
        with("ball", &|s| s.spheres.push(sphere([-1e5, 0.0, 3e4], 1.0, 2))),
        with("triangle", &|s| {
            s.polygons.push(polygon(&[[1e5, 0.0, 0.0], [1e5, 1.0, 0.0], [1e5, 0.0, 1.0]], 2))
        }),
        with("mesh", &|s| s.meshes.push(cuboid(at(1e9), at(1e9) + DVec3::splat(1e6), 2))),
        with("ball at 1e20", &|s| s.spheres.push(sphere([1e20, 0.0, 3e19], 1e7, 2))),
    ];
    judge(h, &scenes)
}

fn wide_ground(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scenes = Vec::new();
    for (near, far) in [(-1.0, 1e5), (-1e3, 1e3), (-1e7, 1e7)] {
        let mut s = things();
        s.polygons.push(ground(near, far, 0.0, 0));
        scenes.push((format!("{near} to {far}, turned"), turned(&s)));
        scenes.push((format!("{near} to {far}"), s));
    }
    // A shallow dome of smooth triangles.
    let (mut s, r) = (things(), 1e5);
    let ring = |i: usize| DVec3::new(r * (f64::from(i as u8)).cos(), -2.0, r * (f64::from(i as u8)).sin());
    let corners: Vec<DVec3> = std::iter::once(DVec3::new(0.0, -0.001, 0.0)).chain((0..7).map(ring)).collect();
    let faces: Vec<[u32; 3]> = (1..7).map(|i| [0, i + 1, i]).collect();
    let mut dome = mesh(corners.clone(), &faces, 0);
    dome.normals = corners.iter().map(|c| (DVec3::Y + *c * (0.3 / r)).normalize()).collect();
    dome.faces.iter_mut().for_each(|f| f.normals = Some(f.vertices));
    s.meshes.push(dome);
    scenes.push(("smooth mesh".into(), s));
    judge(h, &scenes)
}

fn ball_as_ground(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let on = |radius: f64, moon: bool| {
        let mut s = things();
        s.spheres.push(sphere([0.0, -radius, 0.0], radius, 0));
        if moon {
            s.spheres.push(sphere([3.8e8, 1e8, 0.0], 1.7e6, 0));
        }
        (format!("radius {radius}{}", if moon { " and a moon" } else { "" }), s)
    };
    judge(
        h,
        &[on(30.0, false), on(1e3, false), on(1e3, true), on(1e5, true), on(6.4e6, true), on(1e7, false)],
    )
}

fn far_light(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let lit = |d: f64| {
        let mut s = things();
        s.polygons.push(ground(-1e5, 1e5, 0.0, 0));
        s.lights = vec![light([0.6 * d, 0.7 * d, 0.3 * d], d * d)];
        (format!("lamp at {d} m"), s)
    };
    judge(h, &[1e3, 1e5, 1e8, 1e11].map(lit))
}

fn long_lens(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let from_afar = |what: &str, add: &dyn Fn(&mut Scene)| {
        let mut s = things();
        s.polygons.push(ground(-1.0, 1.0, 0.0, 0));
        s.camera.look_from = DVec3::new(3e4, 4e4, 8.66e4);
        s.camera.fov = 1e-5;
        add(&mut s);
        (what.to_owned(), s)
    };
    let beside = [[3e4, 4e4, 8.67e4], [3e4, 4e4, 8.68e4], [3e4, 4.01e4, 8.67e4]];
    let scenes = [
        from_afar("alone", &|_| {}),
        from_afar("triangle beside the eye", &|s| s.polygons.push(polygon(&beside, 0))),
        from_afar("moon", &|s| s.spheres.push(sphere([-3.8e8, 1e7, 0.0], 1.74e6, 0))),
    ];
    judge(h, &scenes)
}

fn in_mirrors(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut on_mirror = things();
    on_mirror.polygons.push(ground(-1e5, 1e5, 0.0, 2));
    let mut beside_moon = inside();
    beside_moon.spheres.push(sphere([3.8e8, 1e7, 0.0], 1.74e6, 2));
    judge(h, &[("mirroring ground".into(), on_mirror), ("mirror wall and moon".into(), beside_moon)])
}

fn in_glass(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let through = |what: &str, add: &dyn Fn(&mut Scene)| {
        let mut s = things();
        s.polygons.push(ground(-1e5, 1e5, 0.0, 0));
        add(&mut s);
        (what.to_owned(), s)
    };
    let scenes = [
        through("ball", &|s| s.spheres.push(sphere([0.25, 0.2, 0.45], 0.12, 3))),
        through("pane", &|s| {
            s.meshes.push(cuboid(DVec3::new(-0.5, 0.05, 0.5), DVec3::new(0.8, 0.6, 0.52), 3));
        }),
    ];
    judge(h, &scenes)
}
