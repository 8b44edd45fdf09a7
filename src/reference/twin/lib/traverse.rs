//! Twin of the files of `glsl/lib/traverse`. Each ray traverses alone: those of `packet.glsl` find the same together.
//! A walk has no cap and no parts: the loops of a CPU end when they are done.

use super::super::real::{Real, Real3, U, is_not_finite};
use super::super::structs::{ExtendedSphere, Hit, Node, Sphere, Triangle};
use super::r#box::{SLAB_GROW, box_interval, enter_box, safe_reciprocal, sphere_box, triangle_box};
use super::numeric::{dot3, max_component};
use super::sphere::{hit_extended_sphere, hit_sphere};
use super::triangle::{Shear, hit_triangle, make_shear};
use crate::kernel::abi::single::CompressedChild;
use crate::kernel::abi::{
    COUNTER_NAN_RAYS, COUNTER_STACK_OVERFLOW, LEAF_BIT, LEAF_FIRST_BITS, NONE, STACK_SIZE, Specialisation,
};

/// The buffers that `traverse.glsl` needs.
#[derive(Debug, Clone, Copy)]
pub struct Shapes<'a> {
    /// Specialisation constants.
    pub spec: &'a Specialisation,
    /// Binding of this name.
    pub triangles: &'a [Triangle],
    /// Binding of this name.
    pub spheres: &'a [Sphere],
    /// Binding of this name.
    pub extended_spheres: &'a [ExtendedSphere],
    /// Binding of this name.
    pub nodes: &'a [Node],
    /// Binding of this name.
    pub compressed_nodes: &'a [CompressedChild],
}

/// A ray, made ready.
#[derive(Debug, Clone, Copy)]
pub struct TraversalRay {
    pub(super) origin: Real3,
    pub(super) direction: Real3,
    pub(super) inverse: Real3,
    shear: Shear,
    skip: u32,
}

/// Readies a ray that starts on primitive `skip`, or NONE.
pub fn make_traversal_ray(origin: Real3, direction: Real3, skip: u32) -> TraversalRay {
    TraversalRay {
        origin,
        direction,
        inverse: safe_reciprocal(direction),
        shear: make_shear(direction),
        skip,
    }
}

fn recedes(t: &Triangle, normal: Real3, r: &TraversalRay, distance: Real) -> bool {
    let a = Real3::from(t.a);
    let (e1, e2, to) = (Real3::from(t.b) - a, Real3::from(t.c) - a, a - r.origin);
    let (m1, m2) = (max_component(e1), max_component(e2));
    if distance * max_component(r.direction) > if m1 > m2 { m1 } else { m2 } {
        return false;
    }
    let (height, along) = (dot3(normal, to), dot3(normal, r.direction));
    let (unsure, parallel) = ((8.0 * U) * max_component(to), (8.0 * U) * max_component(r.direction));
    (height < -unsure && along > parallel) || (height > unsure && along < -parallel)
}

impl Shapes<'_> {
    /// A primitive's number in the scene's own order.
    pub fn primitive_id(&self, primitive: u32) -> u32 {
        let count = self.spec.triangle_count;
        if primitive < count {
            self.triangles[primitive as usize].id
        } else {
            self.spheres[(primitive - count) as usize].id
        }
    }

    fn take_hit(&self, mut h: Hit, (lo, hi): (Real3, Real3), r: &TraversalRay, best: &mut Hit) {
        if self.spec.robust != 0 {
            let (near, far) = box_interval(lo, hi, r.origin, r.inverse);
            if near > far {
                return;
            }
            h.t = if h.t < near {
                near
            } else if h.t > far {
                far
            } else {
                h.t
            };
        }
        if h.t > best.t {
            return;
        }
        if h.t < best.t
            || (best.primitive != NONE && self.primitive_id(h.primitive) < self.primitive_id(best.primitive))
        {
            *best = h;
        }
    }

    pub(super) fn test_triangle(&self, primitive: u32, r: &TraversalRay, best: &mut Hit) {
        let triangle = &self.triangles[primitive as usize];
        let (hit, t, u, v) = hit_triangle(triangle, r.origin, &r.shear, self.spec.robust != 0);
        if hit && primitive != r.skip {
            let normal = Real3::new(triangle.normal_x, triangle.normal_y, triangle.normal_z);
            if self.spec.robust != 0 && r.skip != NONE && recedes(triangle, normal, r, t) {
                return;
            }
            self.take_hit(Hit { t, u, v, primitive }, triangle_box(triangle), r, best);
        }
    }

    pub(super) fn test_sphere(&self, primitive: u32, r: &TraversalRay, best: &mut Hit) {
        let at = (primitive - self.spec.triangle_count) as usize;
        let mut s = self.spheres[at];
        let own = primitive == r.skip;
        let (hit, t) = if self.spec.extended_spheres_used != 0 && s.radius < 0.0 {
            s.radius = -s.radius;
            let w = &self.extended_spheres[s.wide as usize];
            hit_extended_sphere(w, r.origin, r.direction, own)
        } else {
            hit_sphere(&s, r.origin, r.direction, own)
        };
        if hit {
            self.take_hit(Hit { t, u: 0.0, v: 0.0, primitive }, sphere_box(&s), r, best);
        }
    }

    fn traverse_brute_force(&self, r: &TraversalRay, best: &mut Hit) {
        let count = self.spec.triangle_count;
        for i in 0..count {
            self.test_triangle(i, r, best);
        }
        for i in 0..self.spec.sphere_count {
            self.test_sphere(count + i, r, best);
        }
    }

    /// What is outside the hierarchy.
    pub(super) fn test_outside(&self, r: &TraversalRay, best: &mut Hit) {
        let count = self.spec.triangle_count;
        if self.spec.triangles_outside != 0 {
            (0..count).for_each(|i| self.test_triangle(i, r, best));
        }
        if self.spec.spheres_outside != 0 {
            (0..self.spec.sphere_count).for_each(|i| self.test_sphere(count + i, r, best));
        }
    }

    fn traverse_hierarchy(&self, r: &TraversalRay, any: bool, best: &mut Hit, counters: &mut [u32]) {
        let mut stack = [(0u32, 0.0 as Real); STACK_SIZE as usize + 1];
        let (mut top, mut current) = (0usize, 0u32);
        loop {
            if current & LEAF_BIT != 0 {
                let first = current & ((1 << LEAF_FIRST_BITS) - 1);
                let count = ((current & !LEAF_BIT) >> LEAF_FIRST_BITS) + 1;
                for i in 0..count {
                    let primitive = first + i;
                    if primitive < self.spec.triangle_count {
                        self.test_triangle(primitive, r, best);
                    } else {
                        self.test_sphere(primitive, r, best);
                    }
                }
                if any && best.primitive != NONE {
                    return;
                }
            } else {
                let n = &self.nodes[current as usize];
                let boxes = [
                    (n.lo_0, n.hi_0, n.child_0),
                    (n.lo_1, n.hi_1, n.child_1),
                    (n.lo_2, n.hi_2, n.child_2),
                    (n.lo_3, n.hi_3, n.child_3),
                ];
                let entered = |(lo, hi, child): ([Real; 3], [Real; 3], u32)| {
                    let t = enter_box(lo.into(), hi.into(), r.origin, r.inverse, best.t);
                    (t >= 0.0).then_some((child, t))
                };
                let mut children: Vec<(u32, Real)> = boxes.into_iter().filter_map(entered).collect();
                // Farthest first: the nearest is on top of the stack.
                children.sort_by(|a, b| b.1.total_cmp(&a.1));
                for child in children {
                    if top == stack.len() {
                        counters[COUNTER_STACK_OVERFLOW as usize] += 1;
                    } else {
                        stack[top] = child;
                        top += 1;
                    }
                }
            }
            let mut found = false;
            while top > 0 && !found {
                top -= 1;
                current = stack[top].0;
                found = stack[top].1 <= best.t * SLAB_GROW;
            }
            if !found {
                return;
            }
        }
    }

    /// Closest hit with 0 < t < limit. A ray that is not finite is counted and hits nothing.
    pub fn closest_hit(&self, r: &TraversalRay, limit: Real, any: bool, counters: &mut [u32]) -> Hit {
        let finite = !(is_not_finite(r.origin) || is_not_finite(r.direction));
        if !finite {
            counters[COUNTER_NAN_RAYS as usize] += 1;
        }
        let mut best = Hit { t: if finite { limit } else { 0.0 }, u: 0.0, v: 0.0, primitive: NONE };
        if self.spec.use_bvh != 0 {
            self.test_outside(r, &mut best);
            self.traverse_hierarchy(r, any, &mut best, counters);
        } else {
            self.traverse_brute_force(r, &mut best);
        }
        best
    }
}
