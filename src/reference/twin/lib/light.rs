//! Twin of `glsl/lib/optics/light.glsl`.

use super::super::real::{Real, Real3, U, Vec3, float};
use super::super::structs::{Camera, Contribution, DepthCount, Light, Material, Path, Push, Ray, Surface};
use super::count_tests::{Query, note_tests};
use super::numeric::{dot3, max_component};
use super::surface::spawn_origin;
use super::traverse::{Shapes, TraversalRay, make_traversal_ray};
use crate::kernel::abi::{COUNTER_CLAMPED_LIGHTS, NONE, PASSES, PREFIX_SHIFT, RAY_SHADOW};
use crate::settings::sampler::pcg4d;

fn before_light(light: Real3, segment: Real3) -> Real {
    let m = max_component(light);
    let share = (64.0 * U) * if m > 1.0 { m } else { 1.0 } / max_component(segment);
    if share < 0.5 { 1.0 - share } else { 0.5 }
}

fn direct_light(
    shapes: &Shapes<'_>,
    light: &Light,
    s: &Surface,
    shift: f32,
    shadow_rays: &mut u32,
    query: &mut Query,
    counters: &mut [u32],
) -> Vec3 {
    let (position, offset, normal) = (Real3::from(s.position), Real3::from(s.offset), Real3::from(s.normal));
    let fixed = shapes.spec.origin_fixed != 0;
    let target = Real3::from(light.position);
    let to_light = target - position;
    let along = dot3(to_light, normal);
    if !(along > 0.0 && dot3(to_light, offset) > 0.0) {
        return Vec3::ZERO;
    }
    *shadow_rays += 1;
    let mut squared = dot3(to_light, to_light);
    let least_squared = dot3(offset, offset);
    if squared < least_squared {
        counters[COUNTER_CLAMPED_LIGHTS as usize] += 1;
        squared = least_squared;
    }
    let away = if fixed { to_light / squared.sqrt() } else { offset };
    let origin = spawn_origin(position, offset, away, fixed, shift);
    let segment = target - origin;
    let r = make_traversal_ray(origin, segment, if fixed { NONE } else { s.primitive });
    (query.ray, query.limit) = (r, before_light(target, segment));
    if shapes.closest_hit(&r, query.limit, true, counters).primitive != NONE {
        return Vec3::ZERO;
    }
    Vec3::from(light.intensity) * float((along / squared.sqrt()) / squared)
}

/// What lights shine on, and what comes of it.
pub struct Lit<'a> {
    /// What may be in the way.
    pub shapes: Shapes<'a>,
    /// Of the pass.
    pub push: &'a Push,
    /// Background, and the fixed shift of origins.
    pub camera: &'a Camera,
    /// All of them.
    pub lights: &'a [Light],
    /// By ray.
    pub contributions: &'a mut [Contribution],
    /// By sample.
    pub sample_radiance: &'a mut [[f32; 3]],
    /// By sample.
    pub paths: &'a mut [Path],
    /// By depth.
    pub depth_counts: &'a mut [DepthCount],
    /// By `COUNTER_…`.
    pub counters: &'a mut [u32],
    /// Traversals for each light of the pass, ray by ray, where tests are counted.
    pub queries: &'a mut Vec<Query>,
}

/// A traversal for a lane that faces no light.
fn no_query(sample_index: u32) -> Query {
    let ray: TraversalRay = make_traversal_ray(Real3::ZERO, Real3::ONE, NONE);
    Query { ray, limit: 0.0, any: true, sample_index, kind: RAY_SHADOW }
}

/// Lights of a pass.
pub fn lights_of(push: &Push) -> usize {
    (push.light_end - push.light_begin) as usize
}

impl Lit<'_> {
    /// Adds the tests of all traversals, if they are counted.
    pub fn note_tests(&mut self) {
        if self.shapes.spec.counting != 0 {
            let rounds = lights_of(self.push);
            note_tests(&self.shapes, self.push, self.queries, rounds, self.paths, self.counters);
        }
    }

    /// Lights of this pass on surface `s` of ray `i`, of material `m`.
    pub fn light_up(&mut self, i: usize, ray: &Ray, s: &Surface, m: &Material, first: bool, last: bool) {
        let (spec, push) = (self.shapes.spec, self.push);
        let hit = s.primitive != NONE;
        let diffuse = Vec3::from(m.diffuse);
        let own = if hit && s.flags & PASSES == 0 { 1.0 - m.secondary } else { 0.0 };
        let (mut shadow_rays, mut seen) = (0, 0u32);
        let mut light = if first { Vec3::ZERO } else { self.contributions[i].light.into() };
        let first_query = self.queries.len();
        self.queries.resize(first_query + lights_of(push), no_query(ray.sample_index));
        if own > 0.0 && (diffuse.x > 0.0 || diffuse.y > 0.0 || diffuse.z > 0.0) {
            let lights = &self.lights[push.light_begin as usize..push.light_end as usize];
            for (source, query) in lights.iter().zip(&mut self.queries[first_query..]) {
                let shift = self.camera.origin_shift;
                let more =
                    direct_light(&self.shapes, source, s, shift, &mut shadow_rays, query, self.counters);
                light += more;
                seen = seen << 1 | u32::from(!(more.x == 0.0 && more.y == 0.0 && more.z == 0.0));
            }
            self.depth_counts[push.depth as usize - 1].shadow += shadow_rays;
        }
        let sample_index = ray.sample_index;
        if spec.survey != 0 {
            let kind = if hit { s.flags & ((1 << PREFIX_SHIFT) - 1) } else { 0 };
            let id = if hit { self.shapes.primitive_id(s.primitive) } else { NONE };
            let hash = pcg4d([id, kind, push.depth, push.light_begin << 8 | seen])[0];
            let path = &mut self.paths[sample_index as usize];
            path.hash = path.hash.wrapping_add(hash);
            path.rays += if spec.counting == 0 { shadow_rays + u32::from(first) } else { 0 };
            path.depth = path.depth.max(push.depth);
        }
        if !last {
            self.contributions[i].light = light.into();
            return;
        }
        let c = self.camera;
        let background = Vec3::new(c.background_r, c.background_g, c.background_b);
        let color = if hit { own * (diffuse * (Vec3::splat(m.ambient) + light)) } else { background };
        let weighted = Vec3::from(ray.throughput) * color;
        let begins = push.depth == 1;
        if spec.branching != 0 && !begins {
            self.contributions[i] = Contribution { light: weighted.into(), sample_index };
        } else {
            let total = &mut self.sample_radiance[sample_index as usize];
            let sum = if begins { Vec3::ZERO } else { Vec3::from(*total) };
            *total = (sum + weighted).into();
        }
    }
}
