// Degenerate filter, first of three kernels: decides which triangles are drawn: all but those of
// which two corners are at one position. One thread decides eight. CPU code that does the same:
// filter.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

// Words of a vertex record; the first three are the position.
override stride: u32 = 3u;

struct Parameters {
    // Number of triangles, divided by eight and rounded up.
    eights: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Three vertices per triangle, so that eight triangles are six vectors. The last eight are filled
// up with triangles of three times vertex 0, which are never drawn.
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
// Vertex records as they are drawn.
@group(0) @binding(2) var<storage, read> vertices: array<u32>;
// A word per eight triangles: bit j is 1 if the j-th of them is drawn.
@group(0) @binding(3) var<storage, read_write> live: array<u32>;
// Per eight triangles the number that is drawn, then 0: prefix sums make this the number of
// triangles that are drawn before each eight, and of all.
@group(0) @binding(4) var<storage, read_write> drawn_before: array<u32>;

// Which coordinates are equal: those of the same bits, and zeros of either sign.
fn same(x: vec3<u32>, y: vec3<u32>) -> vec3<bool> {
    return (x == y) | (((x | y) << vec3<u32>(1u)) == vec3<u32>(0u));
}

// 1 if triangle `t` is drawn, 0 if two of its corners are at one position. Most triangles are
// decided by the first coordinate.
fn drawn(t: vec3<u32>) -> u32 {
    let offsets = t * stride;
    var equal = vec3<bool>(true);
    for (var i = 0u; i < 3u; i++) {
        let at = offsets + i;
        let c = vec3<u32>(vertices[at.x], vertices[at.y], vertices[at.z]);
        equal = equal & same(c, c.yzx);
        if (!any(equal)) { return 1u; }
    }
    return 0u;
}

// The bits of the four triangles in the three vectors from `first` on.
fn four(first: u32) -> u32 {
    let a = triangles[first];
    let b = triangles[first + 1u];
    let c = triangles[first + 2u];
    return drawn(a.xyz) | (drawn(vec3<u32>(a.w, b.xy)) << 1u)
        | (drawn(vec3<u32>(b.zw, c.x)) << 2u) | (drawn(c.yzw) << 3u);
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let i = number_of(thread);
    if (i > p.eights) { return; }
    var bits = 0u;
    if (i < p.eights) {
        bits = four(6u * i) | (four(6u * i + 3u) << 4u);
        live[i] = bits;
    }
    drawn_before[i] = countOneBits(bits);
}
