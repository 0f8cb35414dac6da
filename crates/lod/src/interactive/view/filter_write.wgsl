// Degenerate filter, second of three: writes the corners of the triangles that are drawn, in their order, to where the
// prefix sums of the blocks say. Twin: filter.rs.

struct Parameters { triangles: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> triangles: array<u32>;
@group(0) @binding(2) var<storage, read> live: array<u32>;
@group(0) @binding(3) var<storage, read> blocks: array<u32>;
@group(0) @binding(4) var<storage, read_write> indices: array<u32>;

var<workgroup> upto: array<u32, 256>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) w: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>,
        @builtin(local_invocation_index) l: u32) {
    let block = w.x + w.y * size.x;
    let i = block * 256u + l;
    var bits = 0u;
    if (4u * i < p.triangles) { bits = live[i]; }
    let count = countOneBits(bits);
    upto[l] = count;
    for (var distance = 1u; distance < 256u; distance <<= 1u) {
        workgroupBarrier();
        var x = upto[l];
        if (l >= distance) { x += upto[l - distance]; }
        workgroupBarrier();
        upto[l] = x;
    }
    if (bits == 0u) { return; }
    var to = 3u * (blocks[block] + upto[l] - count);
    for (var k = 0u; k < 4u; k++) {
        if ((bits & (1u << k)) != 0u) {
            let from_corner = 3u * (4u * i + k);
            indices[to] = triangles[from_corner];
            indices[to + 1u] = triangles[from_corner + 1u];
            indices[to + 2u] = triangles[from_corner + 2u];
            to += 3u;
        }
    }
}
