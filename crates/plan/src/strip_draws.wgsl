// Arguments of one indirect draw per submesh for strips that stand one behind the other, each
// closed by a restart index.

struct Parameters { submeshes: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
// First strip and number of strips of each submesh.
@group(0) @binding(1) var<storage, read> submeshes: array<vec2<u32>>;
// Where each strip starts.
@group(0) @binding(2) var<storage, read> places: array<u32>;
// Five words per submesh: index count, instance count, first index, base vertex, first instance.
@group(0) @binding(3) var<storage, read_write> draws: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) g: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>) {
    let s = g.x + g.y * size.x * 256u;
    if (s >= p.submeshes) { return; }
    let first = places[submeshes[s].x];
    draws[5u * s] = places[submeshes[s].x + submeshes[s].y] - first;
    draws[5u * s + 1u] = 1u;
    draws[5u * s + 2u] = first;
    draws[5u * s + 3u] = 0u;
    draws[5u * s + 4u] = 0u;
}
