// How many triangles of each submesh are drawn, as arguments of an indexed indirect draw. A
// triangle is dead if two of its corners are drawn at one position, else live. Triangles are sorted
// so that the live ones of every LOD come first in their submesh: bisection finds their number, one
// thread per submesh. Nothing is stored for this and nothing is read back.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

// The word of a vertex record that tells vertices apart which lie together and part in motion; 0 if
// there are none.
override place: u32 = 0u;

struct Parameters {
    submeshes: u32,
    // Words of a vertex record; the first three are the position.
    stride: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// For each submesh x: its first triangle, y: its number of triangles.
@group(0) @binding(1) var<storage, read> submeshes: array<vec2<u32>>;
// Three vertices per triangle.
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
// Vertex records as they are drawn.
@group(0) @binding(3) var<storage, read> vertices: array<u32>;
// Five words per submesh, the arguments of an indexed indirect draw: index count, instance count,
// first index, base vertex, first instance.
@group(0) @binding(4) var<storage, read_write> draws: array<u32>;

// Whether two vertices are at one position. Coordinates are equal if their bits are, or if both are
// zero, of either sign.
fn same(a: u32, b: u32) -> bool {
    for (var c = 0u; c < 3u; c++) {
        let x = vertices[a * p.stride + c];
        let y = vertices[b * p.stride + c];
        if (x != y && ((x | y) << 1u) != 0u) { return false; }
    }
    return place == 0u || vertices[a * p.stride + place] == vertices[b * p.stride + place];
}

fn dead(triangle: u32) -> bool {
    let a = triangles[3u * triangle];
    let b = triangles[3u * triangle + 1u];
    let c = triangles[3u * triangle + 2u];
    return same(a, b) || same(b, c) || same(c, a);
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.submeshes) { return; }
    let first = submeshes[s].x;
    // Triangles before `low` are live, those from `high` on are dead.
    var low = first;
    var high = first + submeshes[s].y;
    while (low < high) {
        let middle = low + (high - low) / 2u;
        if (dead(middle)) { high = middle; } else { low = middle + 1u; }
    }
    draws[5u * s] = 3u * (low - first);
    draws[5u * s + 1u] = 1u;
    draws[5u * s + 2u] = 3u * first;
    draws[5u * s + 3u] = 0u;
    draws[5u * s + 4u] = 0u;
}
