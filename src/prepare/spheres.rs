//! A scene's spheres for the kernels. Those that single precision cannot hold are extended spheres: double-length
//! numbers beside a sphere that stands for the box alone.

use super::bvh::Prim;
use super::local_frame::LocalFrame;
use super::rounding::{Rounding, extended_sphere};
use super::solids::Solid;
use crate::kernel::abi::{self, double};
use crate::scene::Scene;
use crate::scene::bounds::Bounds;
use crate::settings::Precision;
use glam::DVec3;
use std::ops::RangeInclusive;

/// Spheres in the scene's order.
pub(super) struct Spheres {
    pub(super) shapes: Vec<double::Sphere>,
    pub(super) extended: Vec<double::ExtendedSphere>,
    pub(super) prims: Vec<Prim>,
    /// All boxes of `prims` are those of the shapes, not rounded further.
    pub(super) exact: bool,
}

impl Spheres {
    /// Numbers spheres from `first_id` on and adds those that refract to `solids`. Local radii outside
    /// `single_radii` make extended spheres.
    pub(super) fn new(
        scene: &Scene,
        frame: &LocalFrame,
        round: Rounding,
        eye: DVec3,
        single_radii: &RangeInclusive<f64>,
        first_id: u32,
        solids: &mut Vec<Solid>,
    ) -> Spheres {
        let mut all = Spheres {
            shapes: Vec::with_capacity(scene.spheres.len()),
            extended: Vec::new(),
            prims: Vec::with_capacity(scene.spheres.len()),
            exact: true,
        };
        for (i, s) in scene.spheres.iter().enumerate() {
            let (center, radius) = (frame.point(s.center), frame.length(s.radius));
            let material = &scene.materials[s.material];
            let solid = if material.refracts() {
                solids.push(Solid {
                    bounds: Bounds::of_sphere(center, radius),
                    ior: material.ior,
                    priority: material.priority,
                    contains_eye: eye.distance(center) < radius,
                });
                solids.len() as u32
            } else {
                0
            };
            let rounded = round.point(center);
            let is_extended = round.precision != Precision::Fast && !single_radii.contains(&radius);
            let (radius, wide) = if is_extended {
                all.extended.push(extended_sphere(center, radius, round));
                // Used for its box alone, so it must hold the exact sphere: a relative 2^-20 covers the
                // roundings of centre and radius.
                let far = rounded.abs().max_element();
                (-round.number((radius + far) * 2f64.powi(-20) + radius), all.extended.len() as u32 - 1)
            } else {
                (round.number(radius), abi::NONE)
            };
            let (id, material) = (first_id + i as u32, s.material as u32);
            let shape = double::Sphere { center: rounded.to_array(), radius, material, solid, wide, id };
            let (prim, same) = Prim::of(id, &bounds(&shape, round), true);
            all.exact &= same;
            all.prims.push(prim);
            all.shapes.push(shape);
        }
        all
    }
}

/// The box of a sphere as the kernels compute it.
pub(super) fn bounds(s: &double::Sphere, round: Rounding) -> Bounds {
    round.sphere_box(DVec3::from_array(s.center), s.radius.abs())
}
