// Elements of buffers that each invocation looks up or stores at an address of its own. Looked up: from the texel view where
// `texels` says so (src/plan/mod.rs), else from the storage buffer; the same bits either way. Views are of
// unsigned words: a float format might flush what is not a normal number. Define nothing before
// including it; then FETCHES_n(x) in place of READS(x), n = texels of an element. Stored: STORES_n(x) in
// place of WRITES(x), as whole texels, where a struct would go out word by word.

#ifdef REAL_IS_DOUBLE
#define FETCHES_1(x) READS(x) ELEMENT_##x load_##x(uint i) { return x[i]; }
#define FETCHES_2(x) FETCHES_1(x)
#define FETCHES_3(x) FETCHES_1(x)
#define FETCHES_4(x) FETCHES_1(x)
#define FETCHES_7(x) FETCHES_1(x)
#define FETCHES_NODES FETCHES_7(nodes)
#define STORES_1(x) WRITES(x) void store_##x(uint i, ELEMENT_##x v) { x[i] = v; }
#define STORES_3(x) STORES_1(x)
#define STORES_4(x) STORES_1(x)
#else
#define FETCHES(x, unpacked) READS(x) TEXELS(x) ELEMENT_##x load_##x(uint i) { \
    ELEMENT_##x v; \
    if (texels != 0u) unpacked; else v = x[i]; \
    return v; \
}
#define TEXEL(x, n, k) texelFetch(x##_texels, int(i * n + k))
#define FETCHES_1(x) FETCHES(x, unpack(TEXEL(x, 1u, 0u), v))
#define FETCHES_2(x) FETCHES(x, unpack(TEXEL(x, 2u, 0u), TEXEL(x, 2u, 1u), v))
#define FETCHES_3(x) FETCHES(x, unpack(TEXEL(x, 3u, 0u), TEXEL(x, 3u, 1u), TEXEL(x, 3u, 2u), v))
#define FETCHES_4(x) FETCHES(x, unpack(TEXEL(x, 4u, 0u), TEXEL(x, 4u, 1u), TEXEL(x, 4u, 2u), TEXEL(x, 4u, 3u), v))
#define FETCHES_7(x) FETCHES(x, unpack(TEXEL(x, 7u, 0u), TEXEL(x, 7u, 1u), TEXEL(x, 7u, 2u), TEXEL(x, 7u, 3u), TEXEL(x, 7u, 4u), TEXEL(x, 7u, 5u), TEXEL(x, 7u, 6u), v))

#define STORES(x) layout(scalar, set = 0, binding = BINDING_##x) writeonly restrict buffer x##_block { uvec4 x##_stored[]; };
#define STORES_1(x) STORES(x) void store_##x(uint i, ELEMENT_##x v) { \
    uvec4 a; \
    pack(v, a); \
    x##_stored[i] = a; \
}
#define STORES_3(x) STORES(x) void store_##x(uint i, ELEMENT_##x v) { \
    uvec4 a, b, c; \
    pack(v, a, b, c); \
    x##_stored[3u * i] = a; \
    x##_stored[3u * i + 1u] = b; \
    x##_stored[3u * i + 2u] = c; \
}
#define STORES_4(x) STORES(x) void store_##x(uint i, ELEMENT_##x v) { \
    uvec4 a, b, c, d; \
    pack(v, a, b, c, d); \
    x##_stored[4u * i] = a; \
    x##_stored[4u * i + 1u] = b; \
    x##_stored[4u * i + 2u] = c; \
    x##_stored[4u * i + 3u] = d; \
}

#ifdef LANES
#define FETCHES_NODES FETCHES_1(compressed_nodes)
#else
#define FETCHES_NODES FETCHES_7(nodes)
#endif

uint word(float x) {
    return floatBitsToUint(x);
}
float number(uint word) {
    return uintBitsToFloat(word);
}
vec3 numbers(uint x, uint y, uint z) {
    return vec3(number(x), number(y), number(z));
}
void unpack(uvec4 a, uvec4 b, uvec4 c, uvec4 d, out Triangle v) {
    v = Triangle(numbers(a.x, a.y, a.z), number(a.w), numbers(b.x, b.y, b.z), number(b.w), numbers(c.x, c.y, c.z), number(c.w), d.x, d.y, d.z, d.w);
}
void unpack(uvec4 a, out FlatNormal v) {
    v = FlatNormal(numbers(a.x, a.y, a.z), number(a.w));
}
void unpack(uvec4 a, uvec4 b, out Sphere v) {
    v = Sphere(numbers(a.x, a.y, a.z), number(a.w), b.x, b.y, b.z, b.w);
}
void unpack(uvec4 a, uvec4 b, uvec4 c, uvec4 d, uvec4 e, uvec4 f, uvec4 g, out Node v) {
    v = Node(numbers(a.x, a.y, a.z), numbers(a.w, b.x, b.y), numbers(b.z, b.w, c.x), numbers(c.y, c.z, c.w),
             numbers(d.x, d.y, d.z), numbers(d.w, e.x, e.y), numbers(e.z, e.w, f.x), numbers(f.y, f.z, f.w),
             g.x, g.y, g.z, g.w);
}
void unpack(uvec4 a, out CompressedChild v) {
    v = CompressedChild(a.x, a.y, a.z, a.w);
}
void unpack(uvec4 a, uvec4 b, out Material v) {
    v = Material(numbers(a.x, a.y, a.z), number(a.w), number(b.x), number(b.y), b.z, number(b.w));
}
void unpack(uvec4 a, uvec4 b, uvec4 c, out Ray v) {
    v = Ray(numbers(a.x, a.y, a.z), numbers(a.w, b.x, b.y), b.z, b.w, numbers(c.x, c.y, c.z), c.w);
}
void unpack(uvec4 a, out Hit v) {
    v = Hit(number(a.x), number(a.y), number(a.z), a.w);
}
void unpack(uvec4 a, uvec4 b, uvec4 c, uvec4 d, out Surface v) {
    v = Surface(numbers(a.x, a.y, a.z), numbers(a.w, b.x, b.y), numbers(b.z, b.w, c.x), c.y, c.z, c.w, number(d.x), number(d.y), number(d.z), d.w);
}
void pack(Ray v, out uvec4 a, out uvec4 b, out uvec4 c) {
    a = uvec4(floatBitsToUint(v.origin), word(v.direction.x));
    b = uvec4(floatBitsToUint(v.direction.yz), v.sample_index, v.skip);
    c = uvec4(floatBitsToUint(v.throughput), v.kind);
}
void pack(Hit v, out uvec4 a) {
    a = uvec4(word(v.t), word(v.u), word(v.v), v.primitive);
}
void pack(Surface v, out uvec4 a, out uvec4 b, out uvec4 c, out uvec4 d) {
    a = uvec4(floatBitsToUint(v.position), word(v.offset.x));
    b = uvec4(floatBitsToUint(v.offset.yz), floatBitsToUint(v.normal.xy));
    c = uvec4(word(v.normal.z), v.primitive, v.material, v.flags);
    d = uvec4(word(v.share), word(v.eta), word(v.cosine), v.solid);
}
#endif
