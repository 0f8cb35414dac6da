// Exclusive prefix sums of blocks of 1024 words, in place; the sum of each block goes to `sums`.
// Run again over `sums`, and then `scan_add`, this makes the prefix sums of any number of words in
// one fixed order. One workgroup sums one block, each thread four words of it.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

struct Parameters {
    // Words of `data`.
    count: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
@group(0) @binding(1) var<storage, read_write> data: array<u32>;
// The sum of each block.
@group(0) @binding(2) var<storage, read_write> sums: array<u32>;

// For each thread of a workgroup the sum of its words and of those of all threads before it.
var<workgroup> inclusive_sums: array<u32, 256>;

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread, @builtin(local_invocation_index) local: u32) {
    let block = number_of(thread) / WORKGROUP;
    let first = number_of(thread) * 4u;
    // What this thread's words before each of them add up to.
    var before: array<u32, 4>;
    var sum = 0u;
    for (var k = 0u; k < 4u; k++) {
        before[k] = sum;
        if (first + k < p.count) { sum += data[first + k]; }
    }
    inclusive_sums[local] = sum;
    for (var distance = 1u; distance < 256u; distance <<= 1u) {
        workgroupBarrier();
        var x = inclusive_sums[local];
        if (local >= distance) { x += inclusive_sums[local - distance]; }
        workgroupBarrier();
        inclusive_sums[local] = x;
    }
    workgroupBarrier();
    for (var k = 0u; k < 4u; k++) {
        if (first + k < p.count) {
            data[first + k] = inclusive_sums[local] - sum + before[k];
        }
    }
    if (local == 255u && block * 1024u < p.count) { sums[block] = inclusive_sums[local]; }
}
