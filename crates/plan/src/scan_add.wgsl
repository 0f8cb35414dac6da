// Second half of prefix sums of more than 1024 words: every block is raised by what all blocks
// before it hold.

struct Parameters { count: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read_write> data: array<u32>;
@group(0) @binding(2) var<storage, read> sums: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) g: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>) {
    let i = g.x + g.y * size.x * 256u;
    if (i >= p.count) { return; }
    data[i] += sums[i / 1024u];
}
