// The continuous extraction pass (thesis of Ripollés, 5.2.3, algorithm 5), one thread per
// vertex. At LOD k the vertices below k are gone, so each vertex moves along its collapse list (the
// vertex, its target, the target's target, and so on) to the first entry of at least k, coarser or
// finer, and gets that entry's vertex record (position and attributes). Vertices from
// max(old LOD, new LOD) on are themselves before and after and need no thread. CPU code that does
// the same: extract.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    // Vertices that may change: max(old LOD, new LOD), at most the number of vertices.
    touched: u32,
    // The new LOD.
    lod: u32,
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
// For each vertex the offset in `entries` of what it currently is.
@group(0) @binding(4) var<storage, read_write> current: array<u32>;
// Vertex records as they are drawn.
@group(0) @binding(5) var<storage, read_write> vertices: array<u32>;
// One word: 0, or 1 + the largest vertex whose `current` is outside of its list.
@group(0) @binding(6) var<storage, read_write> error_flag: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let v = number_of(thread);
    if (v >= p.touched) { return; }
    let first = offsets[v];
    let last = offsets[v + 1u] - 1u;
    let before = current[v];
    if (before < first || before > last) { atomicMax(&error_flag[0], v + 1u); return; }
    var at = before;
    // Loops, which algorithm 5 does not have: a jump may pass several entries.
    while (at < last && entries[at] < p.lod) { at++; }
    while (at > first && entries[at - 1u] >= p.lod) { at--; }
    if (at == before) { return; }
    current[v] = at;
    let from_record = entries[at] * p.stride;
    let to_record = v * p.stride;
    // The position, then the attributes.
    vertices[to_record] = source[from_record];
    vertices[to_record + 1u] = source[from_record + 1u];
    vertices[to_record + 2u] = source[from_record + 2u];
    for (var word = 3u; word < p.stride; word++) {
        vertices[to_record + word] = source[from_record + word];
    }
}
