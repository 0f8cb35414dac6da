// Construction pass, first half (thesis of Ripollés, 5.2.2): the length of each vertex's
// collapse list (the vertex, its target, the target's target, and so on), one thread per vertex.
// Prefix sums of the lengths are where the lists start. CPU code that does the same: lists.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    vertices: u32,
    // A list ends with its first entry of at least this number: that vertex is in every level.
    coarsest: u32,
    // The length of the longest list. Also keeps a cycle in damaged data from hanging the device.
    longest: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Collapse k (record k of the sequence) makes vertex k its target, collapse_to[k].
@group(0) @binding(1) var<storage, read> collapse_to: array<u32>;
// A length for each vertex, then 0.
@group(0) @binding(2) var<storage, read_write> offsets: array<u32>;
// One word: 0, or 1 + the largest vertex whose list would be too long.
@group(0) @binding(3) var<storage, read_write> error_flag: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let v = number_of(thread);
    if (v > p.vertices) { return; }
    // The word behind the last vertex: after the prefix sums it says where the last list ends.
    var length = 0u;
    if (v < p.vertices) {
        length = 1u;
        var entry = v;
        loop {
            if (entry >= p.coarsest) { break; }
            if (length >= p.longest) { atomicMax(&error_flag[0], v + 1u); break; }
            entry = collapse_to[entry];
            length++;
        }
    }
    offsets[v] = length;
}
