// The surface that a ray struck: position, normal, medium change, share of reflection, and which children
// the ray has. Whitted, CACM 23(6), 1980.
// Needs FETCHES_4(triangles), FETCHES_1(flat_normals), READS(corner_normals), FETCHES_2(spheres),
// READS(extended_spheres), FETCHES_2(materials), READS(solid_iors), READS(solid_priorities), READS(media), UPDATES(paths).
#include "optics/surface.glsl"
#include "optics/media.glsl"
#include "optics/fresnel.glsl"

float greatest(vec3 v) {
    return max(v.x, max(v.y, v.z));
}

// Notes the throughput of a ray that is not traced, rounded up.
void note_cut(uint sample_index, float throughput) {
    if (survey != 0u) atomicAdd(paths[sample_index].cut, uint(throughput * float(CUT_ONE)) + 1u);
}

// `kind` if a child of this throughput is traced.
uint child(uint sample_index, uint kind, float throughput) {
    if (!(throughput > 0.0)) return 0u;
    if (push.depth < push.last_depth && !(throughput < push.cutoff)) return kind;
    note_cut(sample_index, throughput);
    return 0u;
}

// What ray `i` met at `h`, of material `m`.
Surface strike(uint i, Ray ray, Hit h, out Material m) {
    Surface s;
    s.primitive = h.primitive;
    s.flags = 0u;
    if (h.primitive == NONE) return s;

    real3 o = ray.origin, d = ray.direction;
    Point p;
    if (h.primitive < triangle_count) {
        Triangle t = load_triangles(h.primitive);
        p = triangle_point(t, load_flat_normals(h.primitive).normal, h.u, h.v);
        if (smooth_normals != 0u) {
            p.normal = smooth_normal(corner_normals[h.primitive], p.normal, p.geometric, h.u, h.v);
        }
        s.material = t.material;
        s.solid = t.solid;
    } else {
        uint j = h.primitive - triangle_count;
        Sphere sphere = load_spheres(j);
        uint wide = sphere.wide;
        p = extended_spheres_used != 0u && wide != NONE ? wide_sphere_point(extended_spheres[wide], o, d, h.t)
                                                    : sphere_point(sphere, o, d, h.t);
        s.material = sphere.material;
        s.solid = sphere.solid;
    }
    bool behind = dot3(d, p.geometric) > 0.0;
    s.position = p.position;
    s.offset = behind ? -p.offset : p.offset;
    s.normal = behind ? -p.normal : p.normal;
    // A shading normal may lean away from the ray; the geometric one never does.
    real c = -dot3(d, s.normal);
    if (c < 0.0) {
        s.normal = behind ? -p.geometric : p.geometric;
        c = -dot3(d, s.normal);
    }
    s.cosine = c < 1.0 ? (c > 0.0 ? c : 0.0) : 1.0;

    m = load_materials(s.material);
    real here = 1.0, beyond = 1.0;
    s.eta = 1.0;
    // Not only where there are solids: a thin sheet reflects by its index in a scene without any.
    if (m.secondary > 0.0 && !(m.fresnel_kind == FRESNEL_CONSTANT && m.fresnel >= 1.0)) {
        uint inside = medium(i, 0u);
        if (s.solid != 0u) {
            s.flags |= is_inside(i, s.solid) ? LEAVES : 0u;
            uint others = medium(i, s.solid);
            if (others != 0u && solid_priorities[others] > solid_priorities[s.solid]) {
                // Another solid's matter fills both sides: nothing is here for light.
                s.share = 0.0;
                bool last = push.depth == push.last_depth;
                s.flags |= PASSES | (last ? 0u : CHILD_REFRACTED);
                if (last) note_cut(ray.sample_index, greatest(ray.throughput));
                return s;
            }
            // Entering: of equal priority, the solid entered last is the medium.
            here = solid_iors[inside];
            beyond = solid_iors[(s.flags & LEAVES) != 0u ? others : s.solid];
            s.eta = here / beyond;
        } else {
            here = solid_iors[inside];
            beyond = m.ior; // a thin sheet: reflects like its material, refracts nothing
        }
    }
    s.share = float(reflection_share(m, here, beyond, d, s.normal, s.cosine));
    float w = greatest(ray.throughput);
    if (m.secondary > 0.0) {
        w *= m.secondary;
        s.flags |= child(ray.sample_index, CHILD_REFLECTED, s.share * w) | child(ray.sample_index, CHILD_REFRACTED, (1.0 - s.share) * w);
    }
    return s;
}
