// Speed Strips, far moves, second half: writes every strip anew, without the indices that are
// removed at the LOD. One thread per strip. CPU code that does the same: `fill` in cursor.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    strips: u32,
    // The new LOD: records below it are applied, all others are not.
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// For each strip x: where its indices start in `strips`, y: where its entries start in `entries`;
// and where those of the last strip end.
@group(0) @binding(1) var<storage, read> starts: array<vec2<u32>>;
// An entry (a record that changes a strip) has its record in x.
@group(0) @binding(2) var<storage, read> entries: array<vec4<u32>>;
// For each strip the first LOD at which it draws nothing.
@group(0) @binding(3) var<storage, read> removal_lods: array<u32>;
// For each index of the strips of LOD 0 the first LOD without it.
@group(0) @binding(4) var<storage, read> index_removal_lods: array<u32>;
// What each index of the strips of LOD 0 has become: the result of `values`.
@group(0) @binding(5) var<storage, read> values: array<u32>;
// The indices of all strips; each has the room that it needs at LOD 0.
@group(0) @binding(6) var<storage, read_write> strips: array<u32>;
// For each strip x: its first entry that is not applied, y: its present number of indices.
@group(0) @binding(7) var<storage, read_write> strip_states: array<vec2<u32>>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    // A dead strip stays as it was at the last LOD at which it drew something.
    var limit = p.lod;
    if (p.lod >= removal_lods[s]) { limit = max(removal_lods[s], 1u) - 1u; }
    var write = starts[s].x;
    for (var i = starts[s].x; i < starts[s + 1u].x; i++) {
        if (index_removal_lods[i] > limit) {
            strips[write] = values[i];
            write++;
        }
    }
    // Bisection for the first entry that is not applied.
    var low = starts[s].y;
    var high = starts[s + 1u].y;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (entries[middle].x < p.lod) { low = middle + 1u; } else { high = middle; }
    }
    strip_states[s] = vec2<u32>(low, write - starts[s].x);
}
