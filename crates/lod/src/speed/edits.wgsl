// Speed Strips, direct (thesis 3.5.2): every strip is taken to a LOD in place, one thread per
// strip, by applying or undoing the changes between. Twin: apply.rs, where what goes at the ends
// stays in the strip's room; here its values are kept. For moves past so many changes that a kernel
// may not loop that often, the host takes `values` and `rewrite` instead.

struct Parameters {
    strips: u32,
    lod: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Two words per strip and one pair more: where its indices and its entries start.
@group(0) @binding(1) var<storage, read> starts: array<vec2<u32>>;
// Four words per entry and one entry more: record, where its changes start, where its removals
// start, where what goes at the ends of the strip is kept among the changes.
@group(0) @binding(2) var<storage, read> entries: array<vec4<u32>>;
// Changes: places that get the target of the record, or the record's vertex back.
@group(0) @binding(3) var<storage, read> changes: array<u32>;
// Removals: where, and how many: positive for repetitions of one index, negative for those of two;
// further from 0 by AT_END for what goes at an end of the strip.
@group(0) @binding(4) var<storage, read> removals: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> collapse_to: array<u32>;
@group(0) @binding(6) var<storage, read_write> strips: array<u32>;
// Two words per strip: the first entry that is not applied, and the length.
@group(0) @binding(7) var<storage, read_write> heads: array<vec2<u32>>;

const AT_END = 0x40000000u;

fn magnitude(removal: vec2<u32>) -> u32 { return u32(abs(bitcast<i32>(removal.y))); }
fn is_end(removal: vec2<u32>) -> bool { return magnitude(removal) > AT_END; }
fn size_of(removal: vec2<u32>) -> u32 { return magnitude(removal) & (AT_END - 1u); }

fn coarsen(base: u32, length: u32, entry: u32) -> u32 {
    let e = entries[entry];
    let after = entries[entry + 1u];
    let vertex = collapse_to[e.x];
    for (var i = e.y; i < after.y; i++) { strips[base + changes[i]] = vertex; }
    if (e.z == after.z) { return length; }
    var write = removals[e.z].x;
    for (var i = e.z; i < after.z; i++) {
        let r = removals[i];
        var end = length;
        if (i + 1u < after.z) { end = removals[i + 1u].x; }
        for (var read = r.x + size_of(r); read < end; read++) {
            strips[base + write] = strips[base + read];
            write++;
        }
    }
    return write;
}

fn refine(base: u32, length: u32, entry: u32) -> u32 {
    let e = entries[entry];
    let after = entries[entry + 1u];
    var read = length;
    var write = length;
    var kept = e.w;
    for (var i = e.z; i < after.z; i++) {
        write += size_of(removals[i]);
        if (is_end(removals[i])) { kept += size_of(removals[i]); }
    }
    let longer = write;
    // From the back, so that nothing is overwritten before it has moved.
    for (var i = after.z; i > e.z; i--) {
        let r = removals[i - 1u];
        let end = r.x + size_of(r);
        while (write > end) {
            write--;
            read--;
            strips[base + write] = strips[base + read];
        }
        write = r.x;
        if (is_end(r)) {
            kept -= size_of(r);
            for (var k = 0u; k < size_of(r); k++) { strips[base + write + k] = changes[kept + k]; }
            continue;
        }
        var period = 2u;
        if (bitcast<i32>(r.y) > 0) { period = 1u; }
        for (var k = 0u; k < size_of(r); k++) {
            strips[base + write + k] = strips[base + read - period + k % period];
        }
    }
    for (var i = e.y; i < after.y; i++) { strips[base + changes[i]] = e.x; }
    return longer;
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    let base = starts[s].x;
    var next = heads[s].x;
    var length = heads[s].y;
    while (next < starts[s + 1u].y && entries[next].x < p.lod) {
        length = coarsen(base, length, next);
        next++;
    }
    while (next > starts[s].y && entries[next - 1u].x >= p.lod) {
        next--;
        length = refine(base, length, next);
    }
    heads[s] = vec2<u32>(next, length);
}
