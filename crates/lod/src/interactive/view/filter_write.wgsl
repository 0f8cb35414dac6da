// Degenerate filter, second of three kernels: writes the corners of the triangles that are drawn
// into the index buffer, without gaps and in the order of the triangles. One thread has eight. CPU
// code that does the same: filter.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    // Number of triangles, divided by eight and rounded up.
    eights: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Three vertices per triangle, so that eight triangles are six vectors.
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
// A word per eight triangles: bit j is 1 if the j-th of them is drawn.
@group(0) @binding(2) var<storage, read> live: array<u32>;
// Per eight triangles the number of triangles that are drawn before them, then the number of all.
@group(0) @binding(3) var<storage, read> drawn_before: array<u32>;
// The index buffer that is drawn.
@group(0) @binding(4) var<storage, read_write> indices: array<u32>;

// Writes triangle `t` at offset `to` if the lowest bit says that it is drawn; returns the offset of
// the next one.
fn write(to: u32, bits: u32, t: vec3<u32>) -> u32 {
    if ((bits & 1u) == 0u) { return to; }
    indices[to] = t.x;
    indices[to + 1u] = t.y;
    indices[to + 2u] = t.z;
    return to + 3u;
}

// Writes those of the four triangles in the three vectors from `first` on that are drawn, from
// offset `start` on; returns the offset of the next one.
fn four(first: u32, start: u32, bits: u32) -> u32 {
    let a = triangles[first];
    let b = triangles[first + 1u];
    let c = triangles[first + 2u];
    var to = write(start, bits, a.xyz);
    to = write(to, bits >> 1u, vec3<u32>(a.w, b.xy));
    to = write(to, bits >> 2u, vec3<u32>(b.zw, c.x));
    return write(to, bits >> 3u, c.yzw);
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let i = number_of(thread);
    if (i >= p.eights) { return; }
    let bits = live[i];
    if (bits == 0u) { return; }
    let to = four(6u * i, 3u * drawn_before[i], bits);
    _ = four(6u * i + 3u, to, bits >> 4u);
}
