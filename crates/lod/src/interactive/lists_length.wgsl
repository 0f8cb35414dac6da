// Construction pass, first half (thesis 5.2.2): how long each vertex's collapse list is. Twin:
// lists.rs. Prefix sums of the lengths are where the lists start.

struct Parameters {
    vertices: u32,
    // A list ends with its first entry of at least this number.
    coarsest: u32,
    // No list is longer. Also what keeps a cycle in damaged data from hanging the device.
    longest: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read> collapse_to: array<u32>;
@group(0) @binding(2) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(3) var<storage, read_write> error_flag: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let v = number_of(thread);
    if (v > p.vertices) { return; }
    // One more than there are vertices: after the prefix sums it says where the last list ends.
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
