// Second half of prefix sums of more than 1024 words: every block is raised by what all blocks
// before it hold.

struct Parameters { count: u32 }

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read_write> data: array<u32>;
@group(0) @binding(2) var<storage, read> sums: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let i = number_of(thread);
    if (i >= p.count) { return; }
    data[i] += sums[i / 1024u];
}
