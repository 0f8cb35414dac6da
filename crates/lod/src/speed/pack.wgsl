// Speed Strips: one strip behind the other, each closed by a restart index, one thread per strip.

struct Parameters { strips: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> starts: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> strips: array<u32>;
@group(0) @binding(3) var<storage, read> places: array<u32>;
@group(0) @binding(4) var<storage, read_write> drawn: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.strips) { return; }
    let first = places[s];
    let end = places[s + 1u];
    if (first == end) { return; }
    for (var i = first; i + 1u < end; i++) { drawn[i] = strips[starts[s].x + i - first]; }
    drawn[end - 1u] = 0xffffffffu;
}
