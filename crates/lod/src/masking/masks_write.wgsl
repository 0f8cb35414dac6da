// Masking Strips: writes into the index buffer what each strip draws, closed by a restart index.
// One thread per strip. CPU code that does the same: cursor.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters { strips: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
// Where each strip starts in `full`, and where the last one ends.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
// The vertices of all strips, what is filtered out included.
@group(0) @binding(2) var<storage, read> full: array<u32>;
// For each strip x: its first entry that is not applied, y: its filter mask, a bit for each
// position that is drawn.
@group(0) @binding(3) var<storage, read> states: array<vec2<u32>>;
// Where each strip starts in `drawn`, and where the last one ends. One that draws nothing ends
// where it starts.
@group(0) @binding(4) var<storage, read> offsets: array<u32>;
// The index buffer that is drawn.
@group(0) @binding(5) var<storage, read_write> drawn: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    var to = offsets[s];
    if (offsets[s + 1u] == to) { return; }
    var bits = states[s].y;
    while (bits != 0u) {
        drawn[to] = full[starts[s] + firstTrailingBit(bits)];
        bits &= bits - 1u;
        to++;
    }
    // The restart index.
    drawn[to] = 0xffffffffu;
}
