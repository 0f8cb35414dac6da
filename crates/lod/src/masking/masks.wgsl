// Masking Strips (thesis 4.2.2): applies or undoes the position masks between two LODs, one thread
// per strip, and chooses the filter mask. Twin: cursor.rs. Of a jump only the last filter counts;
// going back, that of the entry before does.

struct Parameters {
    strips: u32,
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Where each strip starts, and where the last one ends.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
// Where each strip's entries start, and where the last one's end.
@group(0) @binding(2) var<storage, read> firsts: array<u32>;
// Two words per entry: record; position mask (low half) and filter mask (high half).
@group(0) @binding(3) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> collapse_to: array<u32>;
// The strips at full length.
@group(0) @binding(5) var<storage, read_write> full: array<u32>;
// Two words per strip: the first entry that is not applied, and the filter mask.
@group(0) @binding(6) var<storage, read_write> states: array<vec2<u32>>;
// How many indices each strip draws with the restart index behind it; 0 without triangles.
@group(0) @binding(7) var<storage, read_write> lengths: array<u32>;
@group(0) @binding(8) var<storage, read_write> error_flag: array<atomic<u32>>;

fn put(base: u32, mask: u32, vertex: u32) {
    var left = mask;
    while (left != 0u) {
        full[base + firstTrailingBit(left)] = vertex;
        left &= left - 1u;
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    let base = starts[s];
    let first = firsts[s];
    let end = firsts[s + 1u];
    var next = states[s].x;
    if (next < first || next > end) { atomicMax(&error_flag[0], s + 1u); return; }
    while (next < end && entries[next].x < p.lod) {
        put(base, entries[next].y & 0xffffu, collapse_to[entries[next].x]);
        next++;
    }
    while (next > first && entries[next - 1u].x >= p.lod) {
        next--;
        put(base, entries[next].y & 0xffffu, entries[next].x);
    }
    // Before its first entry a strip is drawn whole.
    var mask = (1u << (starts[s + 1u] - base)) - 1u;
    if (next > first) { mask = entries[next - 1u].y >> 16u; }
    states[s] = vec2<u32>(next, mask);
    let count = countOneBits(mask);
    lengths[s] = count + select(0u, 1u, count > 0u);
}
