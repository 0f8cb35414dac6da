// Masking Strips (thesis of Ripollés, 4.2.2): takes every strip to a LOD, one thread per
// strip. A strip has an entry for each record that changes it: record k makes vertex k its target.
// A position mask says at which positions of the strip that vertex is; a filter mask, which
// positions are drawn afterwards. Position masks are applied or undone one by one; of the filter
// masks only that of the last entry before the new LOD counts. CPU version: `CpuVersion`
// in replay.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    strips: u32,
    // The new LOD: records below it are applied, all others are not.
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Where each strip starts in `full`, and where the last one ends.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
// Where each strip's entries start in `entries`, and where the last one's end.
@group(0) @binding(2) var<storage, read> entry_starts: array<u32>;
// An entry is x: its record, y: its position mask (low half) and filter mask (high half).
@group(0) @binding(3) var<storage, read> entries: array<vec2<u32>>;
// Record k makes vertex k its target, collapse_to[k].
@group(0) @binding(4) var<storage, read> collapse_to: array<u32>;
// The vertices of all strips, what is filtered out included.
@group(0) @binding(5) var<storage, read_write> full: array<u32>;
// For each strip x: its first entry that is not applied, y: its filter mask.
@group(0) @binding(6) var<storage, read_write> states: array<vec2<u32>>;
// The number of indices that each strip draws, with the restart index that closes it; 0 if it draws
// no triangle. Prefix sums make this the offset of each in the index buffer.
@group(0) @binding(7) var<storage, read_write> lengths: array<u32>;
// One word: 0, or 1 + the largest strip whose state is outside of its entries.
@group(0) @binding(8) var<storage, read_write> error_flag: array<atomic<u32>>;

// Writes a vertex to all positions in a mask, of the strip that starts at `base`.
fn put(base: u32, mask: u32, vertex: u32) {
    var bits = mask;
    while (bits != 0u) {
        full[base + firstTrailingBit(bits)] = vertex;
        bits &= bits - 1u;
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    let base = starts[s];
    let first = entry_starts[s];
    let end = entry_starts[s + 1u];
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
    // Before its first entry all positions of a strip are drawn.
    var mask = (1u << (starts[s + 1u] - base)) - 1u;
    if (next > first) { mask = entries[next - 1u].y >> 16u; }
    states[s] = vec2<u32>(next, mask);
    let count = countOneBits(mask);
    lengths[s] = count + select(0u, 1u, count > 0u);
}
