// Speed Strips, far moves, first half: what every index of the strips of LOD 0 has become. One
// thread per index. A strip that draws nothing any more stays as it was at the last LOD at which it
// drew something.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    // Indices of all strips of LOD 0.
    indices: u32,
    // The new LOD: vertices below it are gone.
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// The indices of all strips of LOD 0.
@group(0) @binding(1) var<storage, read> stored: array<u32>;
// The strip of each index.
@group(0) @binding(2) var<storage, read> strip_of: array<u32>;
// For each strip the first LOD at which it draws nothing.
@group(0) @binding(3) var<storage, read> removal_lods: array<u32>;
// Record k makes vertex k its target, collapse_to[k].
@group(0) @binding(4) var<storage, read> collapse_to: array<u32>;
// What each index has become.
@group(0) @binding(5) var<storage, read_write> values: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let i = number_of(thread);
    if (i >= p.indices) { return; }
    let removal_lod = removal_lods[strip_of[i]];
    var limit = p.lod;
    if (p.lod >= removal_lod) { limit = max(removal_lod, 1u) - 1u; }
    var v = stored[i];
    while (v < limit) { v = collapse_to[v]; }
    values[i] = v;
}
