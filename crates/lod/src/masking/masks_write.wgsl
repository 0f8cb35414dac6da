// Masking Strips: writes the filtered copy of every strip to its place, one thread per strip. Twin:
// cursor.rs.

struct Parameters { strips: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> full: array<u32>;
@group(0) @binding(3) var<storage, read> states: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> places: array<u32>;
@group(0) @binding(5) var<storage, read_write> drawn: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    var to = places[s];
    if (places[s + 1u] == to) { return; }
    var left = states[s].y;
    while (left != 0u) {
        drawn[to] = full[starts[s] + firstTrailingBit(left)];
        left &= left - 1u;
        to++;
    }
    // The restart index.
    drawn[to] = 0xffffffffu;
}
