// What this device's arithmetic is worth: operands and results for the host to judge.
// Writes self_test: SELF_TEST_ROW numbers per item.
// One invocation per item.
#version 460
#include "base/prelude.glsl"
#include "base/numeric.glsl"
#include "shape/double_length.glsl"
#include "base/sampler.glsl"
layout(local_size_x_id = 0) in;

WRITES(self_test)

// A number with a random sign, random digits and a binary exponent in [-20, 20).
real random_number(uint item, uint which) {
    uvec4 h = pcg4d(uvec4(item, which, push.seed, 0u));
    real digits = 1.0 + (real(h.x) + real(h.y) * 2.3283064365386963e-10) * 2.3283064365386963e-10; // 2^-32
    return ((h.z & 1u) != 0u ? -digits : digits) * real(exp2(float(int(h.w % 40u) - 20)));
}

void main() {
    uint i = item_index();
    if (i >= push.items) return;
    uint to = i * SELF_TEST_ROW;
    real a = random_number(i, 0u), b = random_number(i, 1u);
    real p = a * b;
    self_test[to] = a;
    self_test[to + 1u] = b;
    self_test[to + 2u] = a + b;
    self_test[to + 3u] = p;
    self_test[to + 4u] = a / b;
    self_test[to + 5u] = sqrt(abs(a));
    self_test[to + 6u] = two_sum(a, b).lo;
    self_test[to + 7u] = product_error(a, b, p);
    // Zero, unless the driver fused what it was told not to.
    self_test[to + 8u] = a * b - p;
    // Made at run time, so that nothing is folded: 0 / 0 and 1 / 0.
    real zero = a - a;
    self_test[to + 9u] = is_not_finite(zero / zero) && is_not_finite(1.0 / zero) && !is_not_finite(a) ? real(1.0) : real(0.0);
    // The least normal number of f32, halved: 0 if denormals are flushed.
    self_test[to + 10u] = (real(1.17549435e-38) + zero) * 0.5;
}
