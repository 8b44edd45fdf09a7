// A ray made ready for tests of primitives and boxes.

// Larger than any t in the local frame, yet finite.
const real FAR = 3.0e38;

const bool by_hierarchy = use_bvh != 0u;

struct TraversalRay {
    real3 origin;
    real3 direction;
    real3 inverse; // of the direction, bounded
    Shear shear;
    uint skip; // primitive the ray starts on, or NONE
};

TraversalRay make_traversal_ray(real3 origin, real3 direction, uint skip) {
    return TraversalRay(origin, direction, safe_reciprocal(direction), make_shear(direction), skip);
}
