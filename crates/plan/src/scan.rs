//! Prefix sums on a device, for any number of words and in one fixed order. They are how kernels
//! compact lists without changing their order.

use crate::program::{BufferId, KernelId, Pass, Program, Shader};

/// Prefix sums of blocks.
pub const SCAN: Shader = Shader { name: "scan", wgsl: include_str!("scan.wgsl") };
/// Adds to each block the sum of all words before it.
pub const SCAN_ADD: Shader = Shader { name: "scan_add", wgsl: include_str!("scan_add.wgsl") };

/// Words that one workgroup sums.
const BLOCK: usize = 1024;

/// Exclusive prefix sums of one buffer, in place.
#[derive(Clone, Debug)]
pub struct Scan {
    /// [`SCAN`].
    block: KernelId,
    /// [`SCAN_ADD`].
    add: KernelId,
    /// The data, the sums of its blocks, the sums of blocks of those, and so on, down to one word:
    /// at least two.
    sums: Vec<Words>,
}

/// The first words of a buffer.
#[derive(Clone, Copy, Debug)]
struct Words {
    buffer: BufferId,
    count: usize,
}

impl Scan {
    /// Prepares prefix sums of the first `count` words of `data`.
    pub fn new(program: &mut Program, data: BufferId, count: usize) -> Self {
        let block = program.kernel(SCAN);
        let add = program.kernel(SCAN_ADD);
        let mut sums = vec![Words { buffer: data, count }];
        let mut blocks = count;
        loop {
            blocks = blocks.div_ceil(BLOCK).max(1);
            let buffer = program.zeros("sums of blocks", blocks);
            sums.push(Words { buffer, count: blocks });
            if blocks == 1 {
                return Self { block, add, sums };
            }
        }
    }

    /// Returns the buffer whose one word is the sum of all words after the passes.
    #[must_use]
    pub fn total(&self) -> BufferId {
        self.sums[self.sums.len() - 1].buffer
    }

    /// Returns the passes: sums within blocks, level by level; then, from the last level back,
    /// additions of the sums before each block.
    #[must_use]
    pub fn passes(&self) -> Vec<Pass> {
        let mut passes = Vec::new();
        for pair in self.sums.windows(2) {
            let [words, sums] = [pair[0], pair[1]];
            // Each thread sums four words.
            passes.push(pass(self.block, words, sums, words.count.div_ceil(4)));
        }
        for pair in self.sums.windows(2).rev() {
            let [words, sums] = [pair[0], pair[1]];
            // One block has nothing before it.
            if sums.count > 1 {
                passes.push(pass(self.add, words, sums, words.count));
            }
        }
        passes
    }
}

/// A pass over `words` and the `sums` of their blocks.
fn pass(kernel: KernelId, words: Words, sums: Words, threads: usize) -> Pass {
    Pass {
        kernel,
        buffers: vec![words.buffer, sums.buffer],
        threads: threads as u32,
        parameters: vec![words.count as u32],
    }
}
