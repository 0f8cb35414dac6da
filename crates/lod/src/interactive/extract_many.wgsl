// The continuous extraction pass of extract.wgsl for many instances of one mesh at once, each at a
// LOD of its own. One thread per vertex that may change, of all instances that move.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    // Instances that move.
    moves: u32,
    // Threads of all of them.
    threads: u32,
    // Vertices of the mesh.
    vertices: u32,
    // Words of a vertex record; the first three are the position.
    stride: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Where each vertex's list starts in `entries`, and where the last one ends.
@group(0) @binding(1) var<storage, read> offsets: array<u32>;
// All lists, one behind the other: numbers of vertices.
@group(0) @binding(2) var<storage, read> entries: array<u32>;
// Vertex records of LOD 0, never changed.
@group(0) @binding(3) var<storage, read> source: array<u32>;
// For each move x: its first thread, y: the instance, z: the new LOD. Threads of a move are the
// vertices below max(old LOD, new LOD).
@group(0) @binding(4) var<storage, read> moves: array<vec4<u32>>;
// For each vertex of each instance the place in the vertex's list of what it currently is.
@group(0) @binding(5) var<storage, read_write> current: array<u32>;
// Vertex records as they are drawn, instance by instance.
@group(0) @binding(6) var<storage, read_write> drawn: array<u32>;
// One word: 0, or 1 + the largest vertex whose place is outside of its list.
@group(0) @binding(7) var<storage, read_write> error_flag: array<atomic<u32>>;

// The move that a thread belongs to: the last one that starts at it or before.
fn move_of(thread: u32) -> vec4<u32> {
    var low = 0u;
    var high = p.moves;
    while (high - low > 1u) {
        let middle = low + (high - low) / 2u;
        if (moves[middle].x <= thread) { low = middle; } else { high = middle; }
    }
    return moves[low];
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let i = number_of(thread);
    if (i >= p.threads) { return; }
    let own = move_of(i);
    let v = i - own.x;
    let at_instance = own.y * p.vertices + v;
    let first = offsets[v];
    let last = offsets[v + 1u] - 1u;
    let before = first + current[at_instance];
    if (before > last) { atomicMax(&error_flag[0], v + 1u); return; }
    var at = before;
    while (at < last && entries[at] < own.z) { at++; }
    while (at > first && entries[at - 1u] >= own.z) { at--; }
    if (at == before) { return; }
    current[at_instance] = at - first;
    let from_record = entries[at] * p.stride;
    let to_record = at_instance * p.stride;
    for (var word = 0u; word < p.stride; word++) {
        drawn[to_record + word] = source[from_record + word];
    }
}
