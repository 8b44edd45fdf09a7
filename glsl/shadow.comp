// Own colour of every struck surface: ambient, and one shadow ray to each light it faces. Adds the
// weighted colour to the ray's sample, or leaves it to `gather` where several rays share a sample.
// Reads queue, rays, surfaces and the scene. Writes contributions or slots. Counts shadow rays.
// One invocation per ray and pass; a pass takes the lights [light_begin, light_end).
#version 460
#include "prelude.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
READS(triangles)
READS(triangle_infos)
READS(spheres)
READS(wide_spheres)
READS(sphere_infos)
READS(nodes)
READS(materials)
READS(lights)
READS(rays)
READS(queue)
READS(surfaces)
UPDATES(contributions)
UPDATES(slots)
UPDATES(depth_counts)
UPDATES(counters)
#include "trace.glsl"
#include "surface.glsl"

// Largest t of an occluder: what is nearer to the light than a gap that can be resolved, twice the
// spawn offset of a surface as large as the scene (8u + 48u in a frame of radius 1, numerics P4), is
// at the light.
real before_light(real3 light, real3 segment) {
    if (defect == DEFECT_TO_THE_LIGHT) return 1.0;
    real m = max_component(light);
    real share = (64.0 * U) * (m > 1.0 ? m : real(1.0)) / max_component(segment);
    return share < 0.5 ? 1.0 - share : real(0.5);
}

// Light through the unshadowed lights of this pass: sum of intensity * cos / distance^2.
vec3 direct_light(Surface s, inout uint shadow_rays) {
    vec3 sum = vec3(0.0);
    // A light nearer than the spawn offset cannot be resolved; its distance is clamped (numerics 2.6).
    real least = dot3(s.offset, s.offset);
    for (uint l = push.light_begin; l < push.light_end; l++) {
        real3 to_light = lights[l].position - s.position;
        real along = dot3(to_light, s.normal);
        if (!(along > 0.0) || !(dot3(to_light, s.offset) > 0.0)) continue;
        shadow_rays++;
        real squared = dot3(to_light, to_light);
        if (squared < least && defect != DEFECT_LIGHT_CONTACT) {
            atomicAdd(counters[COUNTER_CLAMPED_LIGHTS], 1u);
            squared = least;
        }
        real3 origin = spawn_origin(s.position, s.offset, origin_fixed != 0u ? to_light / sqrt(squared) : s.offset, camera[0].origin_shift);
        uint skip = origin_fixed != 0u ? NONE : s.primitive;
        // The whole segment is one unit of t: occluders lie strictly between (numerics 1, shadow ray),
        // so a surface that the light lies on must not count for t rounding below 1.
        real3 segment = lights[l].position - origin;
        TraceRay r = make_trace_ray(origin, segment, skip);
        if (closest_hit(r, before_light(lights[l].position, segment), true).primitive == NONE) {
            sum += lights[l].intensity * float((along / sqrt(squared)) / squared);
        }
    }
    return sum;
}

void main() {
    uint i = item_index();
    if (i >= queue[0].count) return;
    bool first = push.light_begin == 0u, last = push.light_end == light_count;
    uint primitive = surfaces[i].primitive;
    vec3 color = vec3(0.0);
    if (primitive == NONE) {
        if (!first) return;
        color = vec3(camera[0].background_r, camera[0].background_g, camera[0].background_b);
        last = true;
    } else {
        Surface s = surfaces[i];
        Material m = materials[s.material];
        vec3 light = first ? vec3(m.ambient) : contributions[i];
        // Where another solid hides the surface, it has no colour of its own.
        float own = (s.flags & PASSES) != 0u ? 0.0 : 1.0 - m.secondary;
        uint shadow_rays = 0u;
        if (own > 0.0 && (m.diffuse.x > 0.0 || m.diffuse.y > 0.0 || m.diffuse.z > 0.0)) {
            light += direct_light(s, shadow_rays);
            if (shadow_rays > 0u) atomicAdd(depth_counts[push.depth - 1u].shadow, shadow_rays);
        }
        color = last ? own * (m.diffuse * light) : light;
    }
    if (!last) {
        contributions[i] = color;
        return;
    }
    vec3 weighted = rays[i].throughput * color;
    if (branching != 0u) {
        contributions[i] = weighted;
    } else {
        slots[rays[i].slot] += weighted;
    }
}
