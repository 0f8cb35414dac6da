// The continuous extraction pass (thesis 5.2.3, algorithm 5): every vertex moves along its collapse
// list to the first entry of at least `lod`, coarser or finer, and shows that entry's record. Twin:
// extract.rs. Vertices from max(old LOD, new LOD) on show themselves before and after: no thread is
// needed for them.

struct Parameters {
    // max(old LOD, new LOD), at most the number of vertices.
    touched: u32,
    lod: u32,
    // Words of a vertex record.
    stride: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> offsets: array<u32>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
// Records of the mesh, never changed.
@group(0) @binding(3) var<storage, read> source: array<u32>;
// Where in `entries` each vertex is.
@group(0) @binding(4) var<storage, read_write> current: array<u32>;
// Records as they are drawn.
@group(0) @binding(5) var<storage, read_write> vertices: array<u32>;
// Set to a vertex's number plus one if its state makes no sense.
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
    // The loops are what algorithm 5 lacks: a jump may pass several entries.
    while (at < last && entries[at] < p.lod) { at++; }
    while (at > first && entries[at - 1u] >= p.lod) { at--; }
    // What does not change is not written.
    if (at == before) { return; }
    current[v] = at;
    let from_record = entries[at] * p.stride;
    let to_record = v * p.stride;
    // The position, and whatever else a record has.
    vertices[to_record] = source[from_record];
    vertices[to_record + 1u] = source[from_record + 1u];
    vertices[to_record + 2u] = source[from_record + 2u];
    for (var word = 3u; word < p.stride; word++) {
        vertices[to_record + word] = source[from_record + word];
    }
}
