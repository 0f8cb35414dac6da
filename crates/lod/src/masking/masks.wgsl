// Masking Strips (thesis 4.2.2): applies or undoes the position masks between two LODs, one thread per strip, and chooses the
// filter mask. Twin: cursor.rs. Of a jump only the last filter counts; going back, that of the entry before does.

struct Parameters {
    strips: u32,
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Where each strip starts, and where the last one ends.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
// Where each strip's entries start, and where the last one's end.
@group(0) @binding(2) var<storage, read> firsts: array<u32>;
// Five words per entry: record, position mask (low, high), filter mask (low, high).
@group(0) @binding(3) var<storage, read> entries: array<u32>;
@group(0) @binding(4) var<storage, read> collapse_to: array<u32>;
// The strips at full length.
@group(0) @binding(5) var<storage, read_write> full: array<u32>;
// Three words per strip: the first entry that is not applied, and the filter mask.
@group(0) @binding(6) var<storage, read_write> states: array<u32>;
// How many indices each strip draws with the restart index behind it; 0 without triangles.
@group(0) @binding(7) var<storage, read_write> lengths: array<u32>;
@group(0) @binding(8) var<storage, read_write> trouble: array<atomic<u32>>;

fn put(base: u32, mask: u32, vertex: u32) {
    var left = mask;
    while (left != 0u) {
        full[base + firstTrailingBit(left)] = vertex;
        left &= left - 1u;
    }
}

// A mask's low bits for a strip of this length.
fn whole(length: u32) -> u32 {
    if (length >= 32u) { return 0xffffffffu; }
    return (1u << length) - 1u;
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) g: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>) {
    let s = g.x + g.y * size.x * 256u;
    if (s >= p.strips) { return; }
    let base = starts[s];
    let first = firsts[s];
    let end = firsts[s + 1u];
    var next = states[3u * s];
    if (next < first || next > end) { atomicMax(&trouble[0], s + 1u); return; }
    while (next < end && entries[5u * next] < p.lod) {
        let vertex = collapse_to[entries[5u * next]];
        put(base, entries[5u * next + 1u], vertex);
        put(base + 32u, entries[5u * next + 2u], vertex);
        next++;
    }
    while (next > first && entries[5u * (next - 1u)] >= p.lod) {
        next--;
        put(base, entries[5u * next + 1u], entries[5u * next]);
        put(base + 32u, entries[5u * next + 2u], entries[5u * next]);
    }
    let length = starts[s + 1u] - base;
    var low = whole(length);
    var high = whole(max(length, 32u) - 32u);
    if (next > first) {
        low = entries[5u * next - 2u];
        high = entries[5u * next - 1u];
    }
    states[3u * s] = next;
    states[3u * s + 1u] = low;
    states[3u * s + 2u] = high;
    let count = countOneBits(low) + countOneBits(high);
    lengths[s] = count + select(0u, 1u, count > 0u);
}
