// Degenerate filter, first of three: which triangles are drawn. One thread looks at four, one workgroup at 1024. Twin:
// filter.rs. A triangle is not drawn if two of its corners are drawn at one position, which is so exactly if they share
// the entry they show, the one they move towards, and how far they are.

struct Parameters {
    triangles: u32,
    // Words of a vertex record; the first three are the position.
    stride: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> triangles: array<u32>;
@group(0) @binding(2) var<storage, read> vertices: array<u32>;
// Four bits per thread.
@group(0) @binding(3) var<storage, read_write> live: array<u32>;
// Live triangles per workgroup.
@group(0) @binding(4) var<storage, read_write> blocks: array<u32>;

var<workgroup> counts: array<u32, 256>;

// Coordinates are the same if their bits are, or if both are zero of either sign.
fn same(x: u32, y: u32) -> bool { return x == y || ((x | y) << 1u) == 0u; }

// Whether two corners are at one position. Most triangles are told by the first coordinate.
fn degenerate(t: u32) -> bool {
    let a = triangles[3u * t] * p.stride;
    let b = triangles[3u * t + 1u] * p.stride;
    let c = triangles[3u * t + 2u] * p.stride;
    var ab = true;
    var bc = true;
    var ca = true;
    for (var i = 0u; i < 3u; i++) {
        let x = vertices[a + i];
        let y = vertices[b + i];
        let z = vertices[c + i];
        ab = ab && same(x, y);
        bc = bc && same(y, z);
        ca = ca && same(z, x);
        if (!(ab || bc || ca)) { return false; }
    }
    return true;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) w: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>,
        @builtin(local_invocation_index) l: u32) {
    let block = w.x + w.y * size.x;
    let i = block * 256u + l;
    var bits = 0u;
    for (var k = 0u; k < 4u; k++) {
        let t = 4u * i + k;
        if (t < p.triangles && !degenerate(t)) { bits |= 1u << k; }
    }
    if (4u * i < p.triangles) { live[i] = bits; }
    counts[l] = countOneBits(bits);
    for (var half = 128u; half > 0u; half >>= 1u) {
        workgroupBarrier();
        if (l < half) { counts[l] += counts[l + half]; }
    }
    workgroupBarrier();
    if (l == 0u && block * 1024u < p.triangles) { blocks[block] = counts[0]; }
}
