// Reflection and refraction rays of a surface, and the solids they are in. Whitted, CACM 23(6), 1980.
// Needs READS(camera), READS(media), STORES_3(next_rays), WRITES(next_media), UPDATES(counters).
#include "optics/surface.glsl"
#include "optics/fresnel.glsl"

// A shading normal may mirror a ray below the surface: bend it back until it just leaves (numerics.md, Shading).
real3 above(real3 direction, real3 offset) {
    if (smooth_normals == 0u) return direction;
    real3 n = safe_normalize(offset);
    real height = dot3(direction, n);
    return height < 4.0 * U ? safe_normalize(direction + (4.0 * U - height) * n) : direction;
}

void keep_media(uint from, uint to) {
    for (uint j = 0u; j < media_capacity; j++) {
        next_media[to * media_capacity + j] = media[from * media_capacity + j];
    }
}

// The list without `solid`, or with it as the last.
void change_media(uint from, uint to, uint solid, bool leaves) {
    uint n = 0u;
    for (uint j = 0u; j < media_capacity; j++) {
        uint m = media[from * media_capacity + j];
        if (m != 0u && m != solid) next_media[to * media_capacity + n++] = m;
    }
    if (!leaves) {
        if (n < media_capacity) {
            next_media[to * media_capacity + n++] = solid;
        } else {
            atomicAdd(counters[COUNTER_MEDIA_OVERFLOW], 1u);
        }
    }
    for (; n < media_capacity; n++) next_media[to * media_capacity + n] = 0u;
}

// `Ray::kind`.
uint kind_of(uint kind) {
    return counting != 0u ? kind : 0u;
}

// Children of `ray` at surface `s`, from place `to` on, reflection first. `from` is the place of the ray's
// list of solids, `secondary` the material's weight.
void spawn(Surface s, Ray ray, float secondary, uint from, uint to) {
    real3 d = ray.direction;
    vec3 throughput = ray.throughput;
    if ((s.flags & PASSES) == 0u) throughput *= secondary;
    uint skip = origin_fixed != 0u ? NONE : s.primitive;
    float shift = camera[0].origin_shift;
    if ((s.flags & CHILD_REFLECTED) != 0u) {
        real3 w = above(reflected(d, s.normal, s.cosine), s.offset);
        store_next_rays(to, Ray(spawn_origin(s.position, s.offset, w, shift), w, ray.sample_index, skip, s.share * throughput, kind_of(RAY_REFLECTION)));
        keep_media(from, to);
        to++;
    }
    if ((s.flags & CHILD_REFRACTED) != 0u) {
        real3 w = s.eta == 1.0 ? d : refracted(d, s.normal, s.eta, s.cosine);
        store_next_rays(to, Ray(spawn_origin(s.position, s.offset, w, shift), w, ray.sample_index, skip, (1.0 - s.share) * throughput, kind_of(RAY_REFRACTION)));
        if (s.solid != 0u) {
            change_media(from, to, s.solid, (s.flags & LEAVES) != 0u);
        } else {
            keep_media(from, to);
        }
    }
}
