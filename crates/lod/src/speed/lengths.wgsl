// Speed Strips: how many indices each strip draws with the restart index behind it; 0 once it is
// dead.

struct Parameters {
    strips: u32,
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> removal_lods: array<u32>;
@group(0) @binding(2) var<storage, read> heads: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> lengths: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    // One more than there are strips: after the prefix sums it says where the last one ends.
    if (s > p.strips) { return; }
    var length = 0u;
    if (s < p.strips && p.lod < removal_lods[s]) { length = heads[s].y + 1u; }
    lengths[s] = length;
}
