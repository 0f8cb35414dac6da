// Speed Strips: copies the strips into the index buffer that is drawn, one behind the other, each
// closed by a restart index. One thread per strip.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters { strips: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
// For each strip x: where its indices start in `strips`.
@group(0) @binding(1) var<storage, read> starts: array<vec2<u32>>;
// The indices of all strips; each has the room that it needs at LOD 0.
@group(0) @binding(2) var<storage, read> strips: array<u32>;
// Where each strip starts in `drawn`, and where the last one ends. One that draws nothing ends
// where it starts.
@group(0) @binding(3) var<storage, read> offsets: array<u32>;
// The index buffer that is drawn.
@group(0) @binding(4) var<storage, read_write> drawn: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    let first = offsets[s];
    let end = offsets[s + 1u];
    if (first == end) { return; }
    for (var i = first; i + 1u < end; i++) { drawn[i] = strips[starts[s].x + i - first]; }
    drawn[end - 1u] = 0xffffffffu;
}
