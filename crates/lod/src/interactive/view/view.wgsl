// The view-dependent extraction pass (thesis 5.3, algorithm 6), one thread per vertex: shows the first entry of the
// collapse list of at least the group's LOD, and moves its position towards the entry at which the group's next step
// leads. Twin: view/mod.rs.

struct Parameters {
    vertices: u32,
    // Words of a vertex record.
    stride: u32,
    // 1 to interpolate positions.
    morph: u32,
    // 0, which the compiler does not know: see `r`.
    zero: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> group_of: array<u32>;
@group(0) @binding(2) var<storage, read> shown: array<u32>;
@group(0) @binding(3) var<storage, read> ways: array<u32>;
@group(0) @binding(4) var<storage, read> offsets: array<u32>;
@group(0) @binding(5) var<storage, read> entries: array<u32>;
@group(0) @binding(6) var<storage, read> source: array<u32>;
@group(0) @binding(7) var<storage, read_write> vertices: array<u32>;

// Keeps the compiler from joining or reordering what is rounded in between.
fn r(v: f32) -> f32 { return bitcast<f32>(bitcast<u32>(v) ^ p.zero); }

// The first entry of vertex v's list of at least `lod`.
fn entry(v: u32, lod: u32) -> u32 {
    if (v >= lod) { return v; }
    var low = offsets[v] + 1u;
    var high = offsets[v + 1u] - 1u;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (entries[middle] < lod) { low = middle + 1u; } else { high = middle; }
    }
    return entries[low];
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) g: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>) {
    let v = g.x + g.y * size.x * 256u;
    if (v >= p.vertices) { return; }
    let group = group_of[v];
    // Vertices that no triangle of LOD 0 uses are never drawn as themselves.
    if (group == 0xffffffffu) { return; }
    let from_record = entry(v, shown[group]) * p.stride;
    let to_record = v * p.stride;
    for (var word = 0u; word < p.stride; word++) {
        vertices[to_record + word] = source[from_record + word];
    }
    if (p.morph == 0u) { return; }
    let next = entry(v, ways[2u * group]) * p.stride;
    let t = f32(ways[2u * group + 1u]) * (1.0 / 65536.0);
    for (var word = 0u; word < 3u; word++) {
        let a = bitcast<f32>(source[from_record + word]);
        let b = bitcast<f32>(source[next + word]);
        // Exactly at the entry: its bits, also those of a zero.
        if (t != 0.0) { vertices[to_record + word] = bitcast<u32>(r(a + r(t * r(b - a)))); }
    }
}
