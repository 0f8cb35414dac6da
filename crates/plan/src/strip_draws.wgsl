// Arguments of one indirect draw per submesh, for strips that follow one another in one index
// buffer, each closed by a restart index. One thread per submesh.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

// submeshes: their number.
struct Parameters { submeshes: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
// For each submesh x: its first strip, y: its number of strips.
@group(0) @binding(1) var<storage, read> submeshes: array<vec2<u32>>;
// Where each strip starts in the index buffer, and where the last one ends.
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
// Five words per submesh, the arguments of an indexed indirect draw: index count, instance count,
// first index, base vertex, first instance.
@group(0) @binding(3) var<storage, read_write> draws: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let s = number_of(thread);
    if (s >= p.submeshes) { return; }
    let first = offsets[submeshes[s].x];
    draws[5u * s] = offsets[submeshes[s].x + submeshes[s].y] - first;
    draws[5u * s + 1u] = 1u;
    draws[5u * s + 2u] = first;
    draws[5u * s + 3u] = 0u;
    draws[5u * s + 4u] = 0u;
}
