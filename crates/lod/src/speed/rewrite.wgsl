// Speed Strips, far moves, second half: every strip anew, without the indices that are removed at
// the LOD, one thread per strip. Twin: `fill` in cursor.rs.

struct Parameters {
    strips: u32,
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> starts: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> entries: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> removal_lods: array<u32>;
// For each index the first LOD without it.
@group(0) @binding(4) var<storage, read> index_removal_lods: array<u32>;
@group(0) @binding(5) var<storage, read> values: array<u32>;
@group(0) @binding(6) var<storage, read_write> strips: array<u32>;
@group(0) @binding(7) var<storage, read_write> heads: array<vec2<u32>>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    var limit = p.lod;
    if (p.lod >= removal_lods[s]) { limit = max(removal_lods[s], 1u) - 1u; }
    var write = starts[s].x;
    for (var i = starts[s].x; i < starts[s + 1u].x; i++) {
        if (index_removal_lods[i] > limit) {
            strips[write] = values[i];
            write++;
        }
    }
    var low = starts[s].y;
    var high = starts[s + 1u].y;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (entries[middle].x < p.lod) { low = middle + 1u; } else { high = middle; }
    }
    heads[s] = vec2<u32>(low, write - starts[s].x);
}
