// Degenerate filter, first of three: which triangles are drawn. One thread looks at eight. Twin:
// filter.rs. A triangle is not drawn if two of its corners are drawn at one position, which is so
// exactly if they share the entry they show, the one they move towards, and how far they are.

// Words of a vertex record; the first three are the position.
override stride: u32 = 3u;

struct Parameters {
    // Number of triangles, divided by eight and rounded up.
    eights: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Eight triangles are six vectors; the last ones are filled up with zeros, which no triangle that
// is drawn has.
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> vertices: array<u32>;
// A bit for each of a thread's triangles.
@group(0) @binding(3) var<storage, read_write> live: array<u32>;
// Their number, and 0 behind the last: after the prefix sums, where each thread's triangles go, and
// how many there are.
@group(0) @binding(4) var<storage, read_write> places: array<u32>;

// Coordinates are the same if their bits are, or if both are zero of either sign.
fn same(x: vec3<u32>, y: vec3<u32>) -> vec3<bool> {
    return (x == y) | (((x | y) << vec3<u32>(1u)) == vec3<u32>(0u));
}

// 1 unless two corners are at one position. Most triangles are decided by the first coordinate.
fn drawn(t: vec3<u32>) -> u32 {
    let at = t * stride;
    var equal = vec3<bool>(true);
    for (var i = 0u; i < 3u; i++) {
        let c = vec3<u32>(vertices[at.x + i], vertices[at.y + i], vertices[at.z + i]);
        equal = equal & same(c, c.yzx);
        if (!any(equal)) { return 1u; }
    }
    return 0u;
}

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
    places[i] = countOneBits(bits);
}
