//! Twin of `glsl/lib/optics/light.glsl`.

use super::super::real::{Real, Real3, U, Vec3, float};
use super::super::structs::{
    Camera, Contribution, DepthCount, Hit, Light, Material, Path, Push, Ray, Surface,
};
use super::count_tests::{Query, note_tests};
use super::numeric::{dot3, max_component};
use super::surface::spawn_origin;
use super::traverse::{Shapes, TraversalRay, make_traversal_ray};
use crate::kernel::abi::{
    COUNTER_CLAMPED_LIGHTS, LAYER_NORMAL, LAYER_PLACE, NONE, PASSES, PREFIX_SHIFT, RAY_SHADOW, Specialisation,
};
use crate::settings::sampler::pcg4d;

fn before_light(light: Real3, segment: Real3) -> Real {
    let m = max_component(light);
    let share = (64.0 * U) * if m > 1.0 { m } else { 1.0 } / max_component(segment);
    if share < 0.5 { 1.0 - share } else { 0.5 }
}

/// The way from a surface to a light that it faces.
pub struct ShadowRay {
    along: Real,
    squared: Real,
    clamped: bool,
    /// The ray.
    pub ray: TraversalRay,
    /// Its greatest t.
    pub limit: Real,
}

/// `None` where the surface does not face the light.
pub fn shadow_ray(spec: &Specialisation, light: &Light, s: &Surface, shift: f32) -> Option<ShadowRay> {
    let (position, offset, normal) = (Real3::from(s.position), Real3::from(s.offset), Real3::from(s.normal));
    let fixed = spec.origin_fixed != 0;
    let target = Real3::from(light.position);
    let to_light = target - position;
    let along = dot3(to_light, normal);
    if !(along > 0.0 && dot3(to_light, offset) > 0.0) {
        return None;
    }
    let least_squared = dot3(offset, offset);
    let distance = dot3(to_light, to_light);
    let clamped = distance < least_squared;
    let squared = if clamped { least_squared } else { distance };
    let away = if fixed { to_light / squared.sqrt() } else { offset };
    let origin = spawn_origin(position, offset, away, fixed, shift);
    let segment = target - origin;
    let ray = make_traversal_ray(origin, segment, if fixed { NONE } else { s.primitive });
    Some(ShadowRay { along, squared, clamped, ray, limit: before_light(target, segment) })
}

/// Share of the surface's own colour, 0 where another solid hides the surface.
fn own_share(s: &Surface, m: &Material) -> f32 {
    if s.primitive != NONE && s.flags & PASSES == 0 { 1.0 - m.secondary } else { 0.0 }
}

/// Whether light matters to a surface.
pub fn may_be_lit(s: &Surface, m: &Material) -> bool {
    own_share(s, m) > 0.0 && m.diffuse.iter().any(|c| *c > 0.0)
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
    /// By ray, what `walk` has found: a bit for each light of the pass that is hidden. None where `light_up` searches.
    pub answers: Option<&'a [Hit]>,
    /// Traversals for each light of the pass, ray by ray, where tests are counted.
    pub queries: &'a mut Vec<Query>,
}

/// A traversal for a lane that faces no light.
pub fn no_query(sample_index: u32) -> Query {
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
        if self.shapes.spec.counting != 0 && self.answers.is_none() {
            let rounds = lights_of(self.push);
            note_tests(&self.shapes, self.push, self.queries, rounds, self.paths, self.counters);
        }
    }

    /// Light number `at` of this pass on surface `s` of ray `i`, if nothing is between.
    fn direct_light(
        &mut self,
        i: usize,
        s: &Surface,
        at: usize,
        shadow_rays: &mut u32,
        query: usize,
    ) -> Vec3 {
        let light = &self.lights[self.push.light_begin as usize + at];
        let Some(to) = shadow_ray(self.shapes.spec, light, s, self.camera.origin_shift) else {
            return Vec3::ZERO;
        };
        *shadow_rays += 1;
        self.counters[COUNTER_CLAMPED_LIGHTS as usize] += u32::from(to.clamped);
        let query = &mut self.queries[query];
        (query.ray, query.limit) = (to.ray, to.limit);
        let blocked = match self.answers {
            Some(hits) => hits[i].primitive >> at & 1 != 0,
            None => self.shapes.closest_hit(&to.ray, to.limit, true, self.counters).primitive != NONE,
        };
        if blocked {
            return Vec3::ZERO;
        }
        Vec3::from(light.intensity) * float((to.along / to.squared.sqrt()) / to.squared)
    }

    /// What a ray that met surface `s` sees.
    fn sight(&self, s: &Surface, m: &Material, light: Vec3) -> Vec3 {
        let (c, hit) = (self.camera, s.primitive != NONE);
        match self.shapes.spec.surface_layer {
            LAYER_NORMAL | LAYER_PLACE if !hit => Vec3::ZERO,
            LAYER_NORMAL => Vec3::from_array(s.normal.map(float)),
            LAYER_PLACE => {
                let from = Real3::from(s.position) - Real3::from(c.origin);
                let along = dot3(from, Real3::from(c.forward)) + c.advance;
                Vec3::new(float(along), 1.0, s.material as f32)
            }
            _ if !hit => Vec3::new(c.background_r, c.background_g, c.background_b),
            _ => own_share(s, m) * (Vec3::from(m.diffuse) * (Vec3::splat(m.ambient) + light)),
        }
    }

    /// Lights of this pass on surface `s` of ray `i`, of material `m`.
    pub fn light_up(&mut self, i: usize, ray: &Ray, s: &Surface, m: &Material, first: bool, last: bool) {
        let (spec, push) = (self.shapes.spec, self.push);
        let hit = s.primitive != NONE;
        let (mut shadow_rays, mut seen) = (0, 0u32);
        let mut light = if first { Vec3::ZERO } else { self.contributions[i].light.into() };
        let first_query = self.queries.len();
        self.queries.resize(first_query + lights_of(push), no_query(ray.sample_index));
        if may_be_lit(s, m) {
            for at in 0..lights_of(push) {
                let more = self.direct_light(i, s, at, &mut shadow_rays, first_query + at);
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
        let weighted = Vec3::from(ray.throughput) * self.sight(s, m, light);
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
