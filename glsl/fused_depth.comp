// One depth of every ray in the queue: closest hit, surface, children and own colour, what `intersect`,
// `shade`, `spawn` and `shadow` do, in one. For software devices, on which queues between kernels are dear.
// Reads queue, ray_indices, rays, media and the scene. Writes next_rays, next_media and child_masks:
// the children of ray i at places of its own, and which there are. Adds its colour to
// sample_radiance, or leaves it to `gather` in contributions. Counts what those kernels count.
// One invocation per ray; those of a subgroup work together.
#version 460
#include "base/prelude.glsl"
#include "base/fetch.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
FETCHES_4(triangles)
FETCHES_1(flat_normals)
READS(corner_normals)
FETCHES_2(spheres)
READS(extended_spheres)
FETCHES_NODES
FETCHES_2(materials)
READS(lights)
READS(solid_iors)
READS(solid_priorities)
FETCHES_3(rays)
STORES_3(next_rays)
READS(media)
WRITES(next_media)
READS(queue)
WRITES(child_masks)
READS(ray_indices)
UPDATES(contributions)
UPDATES(sample_radiance)
UPDATES(paths)
UPDATES(depth_counts)
UPDATES(counters)
#include "base/sampler.glsl"
#include "traverse/traverse.glsl"
#include "optics/strike.glsl"
#include "optics/spawn.glsl"
#include "optics/light.glsl"
#include "base/children.glsl"

void main() {
    uint item = item_index();
    bool mine = item < queue[0].count;
    // The last group's spare invocations take its last ray, to the limit 0, and write and count nothing.
    uint i = min(item, queue[0].count - 1u);
    uint place = push.depth == 1u ? i : ray_indices[i];
    Ray ray = load_rays(place);
    TraversalRay r = make_traversal_ray(ray.origin, ray.direction, ray.skip);
    Hit h = closest_hit(r, mine ? FAR : real(0.0), false);
    if (mine) note_tests(ray.sample_index, ray.kind);
    Material m;
    Surface s = strike(place, ray, h, m);
    light_up(i, mine, ray, s, m, true, true);
    spawn(s, ray, m.secondary, place, i * CHILDREN_MOST);
    // Which children the rays of the subgroup have, a bit each.
    uint bits = ((s.flags & CHILD_REFLECTED) != 0u ? REFLECTED_BIT : 0u) | ((s.flags & CHILD_REFRACTED) != 0u ? REFRACTED_BIT : 0u);
    bits = any_lane(bits << gl_SubgroupInvocationID);
    // Rows of a folded dispatch may end in groups without rays.
    if (gl_SubgroupInvocationID == 0u && group_index() * workgroup < queue[0].count) child_masks[item / lanes] = bits;
}
