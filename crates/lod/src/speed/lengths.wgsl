// Speed Strips: the number of indices that each strip draws, with the restart index that closes it;
// 0 if it draws nothing. One thread per strip. Prefix sums make this the offset of each in the
// index buffer.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    strips: u32,
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// For each strip the first LOD at which it draws nothing.
@group(0) @binding(1) var<storage, read> removal_lods: array<u32>;
// For each strip x: its first entry that is not applied, y: its present number of indices.
@group(0) @binding(2) var<storage, read> strip_states: array<vec2<u32>>;
// A length for each strip, then 0.
@group(0) @binding(3) var<storage, read_write> lengths: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    // The word behind the last strip: after the prefix sums it says where the last one ends.
    if (s > p.strips) { return; }
    var length = 0u;
    if (s < p.strips && p.lod < removal_lods[s]) { length = strip_states[s].y + 1u; }
    lengths[s] = length;
}
