//! Corner lists of vertices with many triangles, as linked blocks of up to 128 corners. The block
//! of each corner is stored, so that inserting beside it and removing it cost no more in a list of
//! a million than in one of a hundred.

use lodc_mesh::NONE;

/// A block of more corners than this is divided. Finding and inserting a corner takes a pass over a
/// block, dividing one an allocation; chosen by hand.
const MAX_BLOCK: usize = 128;

#[derive(Clone, Debug, Default)]
struct Block {
    corners: Vec<u32>,
    previous: u32,
    next: u32,
}

/// A list: its first and its last block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks {
    pub(crate) first: u32,
    pub(crate) last: u32,
}

/// The blocks of all long lists. A corner is in one list at most.
#[derive(Clone, Debug, Default)]
pub(crate) struct LongLists {
    blocks: Vec<Block>,
    /// Blocks that are in no list.
    unused: Vec<u32>,
    /// The block of each corner that is in a list.
    block_of: Vec<u32>,
    /// Corners that were moved within lists or between their blocks.
    #[cfg(test)]
    pub(crate) moves: usize,
}

impl LongLists {
    /// Returns the number of blocks that are in lists.
    #[cfg(test)]
    pub(crate) fn used_blocks(&self) -> usize {
        self.blocks.len() - self.unused.len()
    }

    /// Makes a list.
    pub(crate) fn add(&mut self, corners: &[u32]) -> Blocks {
        let mut list = Blocks { first: NONE, last: NONE };
        for corners in corners.chunks(MAX_BLOCK / 2) {
            let block = self.add_block(corners.to_vec(), list.last, NONE);
            match list.last {
                NONE => list.first = block,
                last => self.blocks[last as usize].next = block,
            }
            list.last = block;
        }
        list
    }

    /// Frees the blocks of a list.
    pub(crate) fn remove(&mut self, list: Blocks) {
        let mut block = list.first;
        while block != NONE {
            let Block { next, .. } = std::mem::take(&mut self.blocks[block as usize]);
            self.unused.push(block);
            block = next;
        }
    }

    /// Iterates over the corners of a list.
    pub(crate) fn corners(&self, list: Blocks) -> impl Iterator<Item = u32> + '_ {
        let block = |b: u32| (b != NONE).then(|| &self.blocks[b as usize]);
        let blocks = std::iter::successors(block(list.first), move |b| block(b.next));
        blocks.flat_map(|b| b.corners.iter().copied())
    }

    /// Inserts a corner after another one of the list. If the other one is in no list, which only
    /// crafted streams cause, the corner goes to the end.
    pub(crate) fn insert_after(&mut self, list: &mut Blocks, corner: u32, other: u32) {
        match self.find(other) {
            Some((block, index)) => self.insert_at(list, block, index + 1, corner),
            None => self.push(list, corner),
        }
    }

    /// Inserts a corner before another one of the list, or like [`Self::insert_after`] at the end.
    pub(crate) fn insert_before(&mut self, list: &mut Blocks, corner: u32, other: u32) {
        match self.find(other) {
            Some((block, index)) => self.insert_at(list, block, index, corner),
            None => self.push(list, corner),
        }
    }

    /// Inserts a corner at the beginning of a list.
    pub(crate) fn push_front(&mut self, list: &mut Blocks, corner: u32) {
        self.insert_at(list, list.first, 0, corner);
    }

    /// Inserts a corner at the end of a list.
    pub(crate) fn push(&mut self, list: &mut Blocks, corner: u32) {
        let index = self.blocks[list.last as usize].corners.len();
        self.insert_at(list, list.last, index, corner);
    }

    fn insert_at(&mut self, list: &mut Blocks, block: u32, index: usize, corner: u32) {
        let corners = &mut self.blocks[block as usize].corners;
        #[cfg(test)]
        {
            self.moves += corners.len() - index;
        }
        corners.insert(index, corner);
        self.set_block(corner, block);
        let Block { corners, next, .. } = &mut self.blocks[block as usize];
        if corners.len() > MAX_BLOCK {
            let (rest, next) = (corners.split_off(MAX_BLOCK / 2), *next);
            let new = self.add_block(rest, block, next);
            self.blocks[block as usize].next = new;
            match next {
                NONE => list.last = new,
                next => self.blocks[next as usize].previous = new,
            }
        }
    }

    /// Returns whether a corner is in a list.
    pub(crate) fn contains(&self, corner: u32) -> bool {
        self.find(corner).is_some()
    }

    /// Returns the block of a corner and its index there, if it is in a list.
    fn find(&self, corner: u32) -> Option<(u32, usize)> {
        let block = self.block_of.get(corner as usize).copied().filter(|&b| b != NONE)?;
        let index = self.blocks[block as usize].corners.iter().position(|&c| c == corner)?;
        Some((block, index))
    }

    /// Takes a corner out of the list that holds it. Blocks that become empty are taken out too, so
    /// that a list never has more blocks than corners.
    pub(crate) fn remove_corner(&mut self, list: &mut Blocks, corner: u32) {
        let Some((number, index)) = self.find(corner) else { return };
        let block = &mut self.blocks[number as usize];
        block.corners.remove(index);
        if !block.corners.is_empty() {
            return;
        }
        let Block { previous, next, .. } = std::mem::take(block);
        self.unused.push(number);
        match previous {
            NONE => list.first = next,
            previous => self.blocks[previous as usize].next = next,
        }
        match next {
            NONE => list.last = previous,
            next => self.blocks[next as usize].previous = previous,
        }
    }

    fn add_block(&mut self, corners: Vec<u32>, previous: u32, next: u32) -> u32 {
        let number = self.unused.pop().unwrap_or_else(|| {
            self.blocks.push(Block::default());
            self.blocks.len() as u32 - 1
        });
        #[cfg(test)]
        {
            self.moves += corners.len();
        }
        corners.iter().for_each(|&corner| self.set_block(corner, number));
        self.blocks[number as usize] = Block { corners, previous, next };
        number
    }

    fn set_block(&mut self, corner: u32, block: u32) {
        if self.block_of.len() <= corner as usize {
            self.block_of.resize((corner as usize + 1).next_power_of_two(), NONE);
        }
        self.block_of[corner as usize] = block;
    }
}
