// Construction pass, second half (thesis of Ripollés, 5.2.2): writes each vertex's collapse
// list: the vertex, its target, the target's target, and so on. One thread per vertex. CPU code
// that does the same: lists.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters { vertices: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
// Collapse k (record k of the sequence) makes vertex k its target, collapse_to[k].
@group(0) @binding(1) var<storage, read> collapse_to: array<u32>;
// Where each vertex's list starts in `entries`, and where the last one ends.
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
// All lists, one behind the other: numbers of vertices.
@group(0) @binding(3) var<storage, read_write> entries: array<u32>;
// For each vertex the offset in `entries` of what it currently is: at LOD 0 its first entry.
@group(0) @binding(4) var<storage, read_write> current: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let v = number_of(thread);
    if (v >= p.vertices) { return; }
    let first = offsets[v];
    current[v] = first;
    entries[first] = v;
    var entry = v;
    for (var i = first + 1u; i < offsets[v + 1u]; i++) {
        entry = collapse_to[entry];
        entries[i] = entry;
    }
}
