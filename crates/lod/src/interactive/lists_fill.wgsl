// Construction pass, second half (thesis 5.2.2): every vertex writes its collapse list: itself,
// what it becomes, what that becomes, and so on. Twin: lists.rs.

struct Parameters { vertices: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> collapse_to: array<u32>;
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
@group(0) @binding(3) var<storage, read_write> entries: array<u32>;
// The current collapse of each vertex: LOD 0, its first entry.
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
