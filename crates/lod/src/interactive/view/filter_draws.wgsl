// Degenerate filter, last of three kernels: the arguments of one indirect draw per submesh. One
// thread per submesh. CPU code that does the same: filter.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters { submeshes: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
// For each submesh x: its first triangle, y: its number of triangles.
@group(0) @binding(1) var<storage, read> submeshes: array<vec2<u32>>;
// A word per eight triangles: bit j is 1 if the j-th of them is drawn.
@group(0) @binding(2) var<storage, read> live: array<u32>;
// Per eight triangles the number of triangles that are drawn before them, then the number of all.
@group(0) @binding(3) var<storage, read> drawn_before: array<u32>;
// Five words per submesh, the arguments of an indexed indirect draw: index count, instance count,
// first index, base vertex, first instance.
@group(0) @binding(4) var<storage, read_write> draws: array<u32>;

// The number of triangles before this one that are drawn.
fn before(triangle: u32) -> u32 {
    let count = drawn_before[triangle / 8u];
    let rest = triangle % 8u;
    if (rest == 0u) { return count; }
    return count + countOneBits(live[triangle / 8u] & ((1u << rest) - 1u));
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.submeshes) { return; }
    let first = before(submeshes[s].x);
    draws[5u * s] = 3u * (before(submeshes[s].x + submeshes[s].y) - first);
    draws[5u * s + 1u] = 1u;
    draws[5u * s + 2u] = 3u * first;
    draws[5u * s + 3u] = 0u;
    draws[5u * s + 4u] = 0u;
}
