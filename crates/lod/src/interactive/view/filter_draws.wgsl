// Degenerate filter, last of three: the arguments of one indirect draw per submesh. Twin:
// filter.rs.

struct Parameters { submeshes: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
// First triangle and number of triangles of each submesh.
@group(0) @binding(1) var<storage, read> submeshes: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> live: array<u32>;
@group(0) @binding(3) var<storage, read> places: array<u32>;
// Five words per submesh: index count, instance count, first index, base vertex, first instance.
@group(0) @binding(4) var<storage, read_write> draws: array<u32>;

// How many triangles before this one are drawn.
fn before(triangle: u32) -> u32 {
    let count = places[triangle / 8u];
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
