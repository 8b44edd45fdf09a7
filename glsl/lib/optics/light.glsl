// Light that reaches a surface from the lights, and what the ray adds to its sample.
// Needs what traverse.glsl needs, READS(camera), READS(lights), UPDATES(contributions), UPDATES(sample_radiance), UPDATES(paths),
// UPDATES(depth_counts). Where `walk` has searched for occluders (ANSWERED): READS(hits), and of traverse.glsl the ray and the counts alone.
#include "optics/surface.glsl"

// Largest t of an occluder: what is nearer to the light than a gap that can be resolved, twice the
// spawn offset of a surface as large as the scene (8u + 48u in a frame of radius 1), is at the light.
real before_light(real3 light, real3 segment) {
    real m = max_component(light);
    real share = (64.0 * U) * (m > 1.0 ? m : real(1.0)) / max_component(segment);
    return share < 0.5 ? 1.0 - share : real(0.5);
}

// The way from a surface to a light.
struct ShadowRay {
    bool faces;     // the surface faces the light, and light matters to it
    real along;     // along the normal
    real squared;   // distance
    bool clamped;   // the light is nearer than the spawn offset
    TraversalRay ray;
    real limit;     // 0 where the surface does not face the light
};

ShadowRay shadow_ray(Surface s, bool lit_at_all, Light light) {
    real3 to_light = light.position - s.position;
    real along = dot3(to_light, s.normal);
    bool faces = lit_at_all && along > 0.0 && dot3(to_light, s.offset) > 0.0;
    real squared = dot3(to_light, to_light);
    // A light nearer than the spawn offset cannot be resolved; its distance is clamped (numerics.md, Shading).
    real least_squared = dot3(s.offset, s.offset);
    bool clamped = faces && squared < least_squared;
    squared = clamped ? least_squared : squared;
    real3 away = origin_fixed != 0u ? to_light / sqrt(squared) : s.offset;
    // What faces no light has no ray; any finite one stands in for it.
    real3 origin = faces ? spawn_origin(s.position, s.offset, away, camera[0].origin_shift) : real3(0.0);
    real3 direction = faces ? light.position - origin : real3(1.0);
    // The whole segment is one unit of t: occluders lie strictly between (numerics.md, Spawn origins).
    TraversalRay r = make_traversal_ray(origin, direction, origin_fixed != 0u ? NONE : s.primitive);
    real limit = faces ? before_light(light.position, direction) : real(0.0);
    return ShadowRay(faces, along, squared, clamped, r, limit);
}

// Whether light matters to a surface of material `m`: it has a colour of its own, which another solid does not hide.
float own_share(Surface s, Material m) {
    return s.primitive != NONE && (s.flags & PASSES) == 0u ? 1.0 - m.secondary : 0.0;
}
bool may_be_lit(float own, Material m) {
    return own > 0.0 && (m.diffuse.x > 0.0 || m.diffuse.y > 0.0 || m.diffuse.z > 0.0);
}

#ifndef IN_PARTS
// Light number `l` through `light`, if nothing is between: intensity * cos / distance^2. On a software
// device no branch around the tests: loads outside control flow are cheaper (brute_force.glsl), and packets are whole.
vec3 direct_light(uint i, Surface s, bool lit_at_all, uint l, Light light, inout uint shadow_rays) {
    ShadowRay to = shadow_ray(s, lit_at_all, light);
    if (to.clamped) atomicAdd(counters[COUNTER_CLAMPED_LIGHTS], 1u);
    bool blocked = false;
#ifdef ANSWERED
    // `walk` has searched, and left a bit for each light of the pass.
    blocked = (hits[i].primitive >> (l - push.light_begin) & 1u) != 0u;
#else
    if ((!by_hierarchy && texels != 0u) || lanes != 0u || to.faces) blocked = closest_hit(to.ray, to.limit, true).primitive != NONE;
#endif
    shadow_rays += to.faces ? 1u : 0u;
    return to.faces && !blocked ? light.intensity * float((to.along / sqrt(to.squared)) / to.squared) : vec3(0.0);
}
#endif

// Where a primitive is in the scene's own order, which is no matter of search or precision: surveys of both are compared.
uint id_of(uint primitive) {
    if (primitive == NONE) return NONE;
    return primitive < triangle_count ? load_triangles(primitive).id : load_spheres(primitive - triangle_count).id;
}

#ifndef IN_PARTS
// What a ray that met surface `s` sees: light, or what `surface_layer` asks of the surface.
vec3 sight(Surface s, Material m, vec3 light) {
    bool hit = s.primitive != NONE;
    if (surface_layer == LAYER_NORMAL) return hit ? vec3(s.normal) : vec3(0.0);
    if (surface_layer == LAYER_PLACE) {
        real along = dot3(s.position - camera[0].origin, camera[0].forward) + camera[0].advance;
        return hit ? vec3(float(along), 1.0, float(s.material)) : vec3(0.0);
    }
    vec3 background = vec3(camera[0].background_r, camera[0].background_g, camera[0].background_b);
    return hit ? own_share(s, m) * (m.diffuse * (m.ambient + light)) : background;
}

// Own colour of surface `s`, of material `m`, that ray `i` struck, by the lights [light_begin, light_end) of the push
// constants: into the ray's sample, or into contributions where `gather` adds them up or further passes take further
// lights. `first`, `last`: of the passes. `mine`: the invocation has a ray of its own, to be counted and written.
void light_up(uint i, bool mine, Ray ray, Surface s, Material m, bool first, bool last) {
    bool hit = s.primitive != NONE;
    float own = own_share(s, m);
    bool lit_at_all = mine && may_be_lit(own, m);
    vec3 light = first ? vec3(0.0) : contributions[i].light;
    uint shadow_rays = 0u, seen = 0u;
    if (light_count != 0u) {
        // The first light is loaded outside of the loop, which is none where there is one light: then all lanes have
        // it, and the shapes that brute force tests, from one load each.
        uint l = push.light_begin;
        bool several = light_count > 1u && (by_hierarchy || fused != 0u); // brute force takes one light a pass
        Light next = lights[l];
        do {
            vec3 more = direct_light(i, s, lit_at_all, l, next, shadow_rays);
            light += more;
            seen = seen << 1u | (more == vec3(0.0) ? 0u : 1u);
            l++;
            if (several) next = lights[min(l, light_count - 1u)];
        } while (several && l < push.light_end);
    }
    uint counted = shadow_rays;
#ifdef LANES
    // One lane counts for all: of atomics on one word each waits for the one before.
    uint all = sum_lanes(shadow_rays);
    counted = gl_SubgroupInvocationID == 0u ? all : 0u;
#endif
    if (counted > 0u) atomicAdd(depth_counts[push.depth - 1u].shadow, counted);
    if (!mine) return;
    note_tests(ray.sample_index, RAY_SHADOW);
    if (survey != 0u) {
        uint sample_index = ray.sample_index;
        uint kind = hit ? s.flags & ((1u << PREFIX_SHIFT) - 1u) : 0u;
        atomicAdd(paths[sample_index].hash, pcg4d(uvec4(id_of(s.primitive), kind, push.depth, push.light_begin << 8u | seen)).x);
        if (counting == 0u) atomicAdd(paths[sample_index].rays, shadow_rays + (first ? 1u : 0u));
        atomicMax(paths[sample_index].depth, push.depth);
    }
    if (!last) {
        contributions[i].light = light;
        return;
    }
    vec3 weighted = ray.throughput * sight(s, m, light);
    // At depth 1 a sample has one ray, which begins its sum.
    bool begins = push.depth == 1u;
    if (branching != 0u && !begins) {
        contributions[i] = Contribution(weighted, ray.sample_index);
    } else {
        vec3 sum = branching != 0u || begins ? vec3(0.0) : sample_radiance[ray.sample_index];
        sample_radiance[ray.sample_index] = sum + weighted;
    }
}
#endif
