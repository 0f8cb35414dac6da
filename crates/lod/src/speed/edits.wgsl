// Speed Strips, the variant *direct* (thesis of Ripollés, 3.5.2): takes every strip to a
// LOD in place, one thread per strip. A strip has an entry for each record that changes it: record
// k makes vertex k its target. Applying an entry replaces indices (its changes) and then closes the
// gaps of indices that are no longer needed (its removals); undoing it is the reverse. Removed
// indices repeat the ones before them and are made anew from those, except at the ends of a strip,
// where their values are stored. CPU code that does the same: apply.rs, which leaves what is
// removed at an end where it is. For moves past more entries than a kernel may loop over, the host
// runs the kernels `values` and `rewrite` instead.
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
// An entry is x: its record, y: where its changes start, z: where its removals start, w: where the
// values that it removes at the ends of the strip start in `changes`. One entry more ends the last.
@group(0) @binding(2) var<storage, read> entries: array<vec4<u32>>;
// Positions in the strip that get the target of the record, or the record's vertex when it is
// undone. Behind those of all entries, the values that are removed at ends of strips.
@group(0) @binding(3) var<storage, read> changes: array<u32>;
// A removal is x: its position in the strip, y: its number of indices as a signed number: positive
// where one index repeats, negative where two alternate; further from 0 by AT_END at an end of the
// strip.
@group(0) @binding(4) var<storage, read> removals: array<vec2<u32>>;
// Record k makes vertex k its target, collapse_to[k].
@group(0) @binding(5) var<storage, read> collapse_to: array<u32>;
// The indices of all strips; each has the room that it needs at LOD 0.
@group(0) @binding(6) var<storage, read_write> strips: array<u32>;
// For each strip x: its first entry that is not applied, y: its present number of indices.
@group(0) @binding(7) var<storage, read_write> strip_states: array<vec2<u32>>;

const AT_END = 0x40000000u;

// The signed number of a removal without its sign; whether it is at an end; its number of indices.
fn magnitude(removal: vec2<u32>) -> u32 { return u32(abs(bitcast<i32>(removal.y))); }
fn is_end(removal: vec2<u32>) -> bool { return magnitude(removal) > AT_END; }
fn size_of(removal: vec2<u32>) -> u32 { return magnitude(removal) & (AT_END - 1u); }

// Applies an entry to the strip of `length` indices that starts at `base`; returns its new length.
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

// Undoes an entry of the strip of `length` indices that starts at `base`; returns its new length.
fn refine(base: u32, length: u32, entry: u32) -> u32 {
    let e = entries[entry];
    let after = entries[entry + 1u];
    var read = length;
    var write = length;
    // Behind the values in `changes` that go back to the ends.
    var ends_end = e.w;
    for (var i = e.z; i < after.z; i++) {
        write += size_of(removals[i]);
        if (is_end(removals[i])) { ends_end += size_of(removals[i]); }
    }
    let new_length = write;
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
            ends_end -= size_of(r);
            for (var k = 0u; k < size_of(r); k++) {
                strips[base + write + k] = changes[ends_end + k];
            }
            continue;
        }
        // The indices before repeat.
        var period = 2u;
        if (bitcast<i32>(r.y) > 0) { period = 1u; }
        for (var k = 0u; k < size_of(r); k++) {
            strips[base + write + k] = strips[base + read - period + k % period];
        }
    }
    for (var i = e.y; i < after.y; i++) { strips[base + changes[i]] = e.x; }
    return new_length;
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    let base = starts[s].x;
    var next = strip_states[s].x;
    var length = strip_states[s].y;
    while (next < starts[s + 1u].y && entries[next].x < p.lod) {
        length = coarsen(base, length, next);
        next++;
    }
    while (next > starts[s].y && entries[next - 1u].x >= p.lod) {
        next--;
        length = refine(base, length, next);
    }
    strip_states[s] = vec2<u32>(next, length);
}
