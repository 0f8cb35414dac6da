// Second half of prefix sums of more than 1024 words: adds to each word of a block the sum of all
// blocks before it. One thread per word.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    // Words of `data`.
    count: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Prefix sums within each block of 1024 words; afterwards those of all words.
@group(0) @binding(1) var<storage, read_write> data: array<u32>;
// Exclusive prefix sums of the sums of blocks.
@group(0) @binding(2) var<storage, read> sums: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let i = number_of(thread);
    if (i >= p.count) { return; }
    data[i] += sums[i / 1024u];
}
