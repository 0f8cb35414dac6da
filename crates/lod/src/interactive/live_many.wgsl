// The count of live triangles of live.wgsl for many instances of one mesh at once. One thread per
// submesh of each instance that moves.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

// The word of a vertex record that tells vertices apart which lie together and part in motion; 0 if
// there are none.
override place: u32 = 0u;

struct Parameters {
    // Instances that move.
    moves: u32,
    submeshes: u32,
    // Vertices of the mesh.
    vertices: u32,
    // Words of a vertex record; the first three are the position.
    stride: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// For each submesh x: its first triangle, y: its number of triangles.
@group(0) @binding(1) var<storage, read> submeshes: array<vec2<u32>>;
// Three vertices per triangle, the same for all instances.
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
// Vertex records as they are drawn, instance by instance.
@group(0) @binding(3) var<storage, read> drawn: array<u32>;
// For each move y: the instance.
@group(0) @binding(4) var<storage, read> moves: array<vec4<u32>>;
// Five words per submesh of each instance, the arguments of an indexed indirect draw: index count,
// instance count, first index, base vertex, first instance.
@group(0) @binding(5) var<storage, read_write> draws: array<u32>;

// Whether two records hold one position. Coordinates are equal if their bits are, or if both are
// zero, of either sign.
fn same(a: u32, b: u32) -> bool {
    for (var c = 0u; c < 3u; c++) {
        let x = drawn[a * p.stride + c];
        let y = drawn[b * p.stride + c];
        if (x != y && ((x | y) << 1u) != 0u) { return false; }
    }
    return place == 0u || drawn[a * p.stride + place] == drawn[b * p.stride + place];
}

fn dead(triangle: u32, base: u32) -> bool {
    let a = base + triangles[3u * triangle];
    let b = base + triangles[3u * triangle + 1u];
    let c = base + triangles[3u * triangle + 2u];
    return same(a, b) || same(b, c) || same(c, a);
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let i = number_of(thread);
    if (i >= p.moves * p.submeshes) { return; }
    let instance = moves[i / p.submeshes].y;
    let s = i % p.submeshes;
    let base = instance * p.vertices;
    let first = submeshes[s].x;
    // Triangles before `low` are live, those from `high` on are dead.
    var low = first;
    var high = first + submeshes[s].y;
    while (low < high) {
        let middle = low + (high - low) / 2u;
        if (dead(middle, base)) { high = middle; } else { low = middle + 1u; }
    }
    let arguments = 5u * (instance * p.submeshes + s);
    draws[arguments] = 3u * (low - first);
    draws[arguments + 1u] = 1u;
    draws[arguments + 2u] = 3u * first;
    draws[arguments + 3u] = base;
    draws[arguments + 4u] = 0u;
}
