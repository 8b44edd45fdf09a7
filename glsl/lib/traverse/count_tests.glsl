// Box and primitive tests of the traversals, where `counting` is set. Elsewhere the driver removes all of it.
//
// Only rays that look for a hit count: those that are finite and have a limit above 0, and shadow rays until
// their first hit.
// - Box test: the box of one child that is there, for one such ray. A ray by itself tests the children of each
//   node that it enters. A packet tests those of each node that it enters with all its rays, whichever of them
//   meet the node.
// - Primitive test: one primitive, for one such ray. The filter and the whole test of a primitive are one test.
//   Filters run for all primitives before the first whole test.
//
// Needs UPDATES(paths), UPDATES(counters).

// Of this invocation since they were last noted: boxes, primitives.
uvec2 tests = uvec2(0u);

void count_boxes(uint n) {
    if (counting != 0u) tests.x += n;
}
void count_primitives(uint n) {
    if (counting != 0u) tests.y += n;
}

// Adds to a number of two words, low word first.
void add_count(uint at, uint n) {
    if (n == 0u) return;
    uint before = atomicAdd(counters[at], n);
    if (before + n < before) atomicAdd(counters[at + 1u], 1u);
}

// Adds the tests to those of this depth and kind of ray, and of the sample in a survey.
void note_tests(uint sample_index, uint kind) {
    if (counting == 0u) return;
    uint at = COUNTERS + TEST_WORDS * (RAY_KINDS * (push.depth - 1u) + kind);
    add_count(at, tests.x);
    add_count(at + 2u, tests.y);
    if (survey != 0u) atomicAdd(paths[sample_index].rays, tests.x + tests.y);
    tests = uvec2(0u);
}
