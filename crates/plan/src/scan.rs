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
    /// Buffers and their numbers of words: the data, the sums of its blocks, the sums of blocks of
    /// those, and so on.
    levels: Vec<(BufferId, usize)>,
}

impl Scan {
    /// Prepares prefix sums of the first `count` words of `data`.
    pub fn new(program: &mut Program, data: BufferId, count: usize) -> Self {
        let block = program.kernel(SCAN);
        let add = program.kernel(SCAN_ADD);
        let mut levels = vec![(data, count)];
        let mut sums = count;
        loop {
            sums = sums.div_ceil(BLOCK).max(1);
            levels.push((program.zeros("sums of blocks", sums), sums));
            if sums == 1 {
                return Self { block, add, levels };
            }
        }
    }

    /// Returns the buffer that holds the sum of all words afterwards.
    #[must_use]
    pub fn total(&self) -> BufferId {
        self.levels[self.levels.len() - 1].0
    }

    /// Returns the passes: sums within blocks, level by level; then, from the last level back,
    /// additions of the sums before each block.
    #[must_use]
    pub fn passes(&self) -> Vec<Pass> {
        let pass = |kernel, pair: &[(BufferId, usize)], threads: usize| {
            let count = pair[0].1 as u32;
            Pass {
                kernel,
                buffers: vec![pair[0].0, pair[1].0],
                threads: threads as u32,
                parameters: vec![count],
            }
        };
        // Each thread sums four words.
        let sums = self.levels.windows(2).map(|pair| pass(self.block, pair, pair[0].1.div_ceil(4)));
        // One block has nothing before it.
        let additions = self.levels.windows(2).rev().filter(|pair| pair[1].1 > 1);
        sums.chain(additions.map(|pair| pass(self.add, pair, pair[0].1))).collect()
    }
}
