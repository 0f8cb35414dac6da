//! The list of corners of each vertex. Up to eleven are stored inline, in one array, so that
//! reading the star of a vertex takes one memory access; longer lists are in `long_lists`.

use crate::partial_mesh::long_lists::{Blocks, LongLists};

/// Corners that a vertex holds inline; longer lists are in `long_lists`. With the count a list
/// takes 48 bytes, less than a cache line, and nearly every vertex of a scanned mesh fits. Chosen
/// by hand.
pub(crate) const INLINE_CORNERS: usize = 11;

#[derive(Clone, Copy, Debug)]
struct List {
    count: u32,
    /// The corners. If there are more than fit, the first two are the ends of a long list.
    inline: [u32; INLINE_CORNERS],
}

impl List {
    fn is_long(&self) -> bool {
        self.count as usize > INLINE_CORNERS
    }

    fn blocks(&self) -> Blocks {
        Blocks { first: self.inline[0], last: self.inline[1] }
    }

    fn set_blocks(&mut self, blocks: Blocks) {
        [self.inline[0], self.inline[1]] = [blocks.first, blocks.last];
    }
}

/// Where in a list a corner is inserted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Insertion {
    /// After another corner, which is in the list.
    After(u32),
    /// Before another corner, which is in the list.
    Before(u32),
    /// At the end.
    Last,
}

impl Insertion {
    /// Returns the index in `corners`: the end if the other corner is not there.
    fn index(self, corners: &[u32]) -> usize {
        let (other, after) = match self {
            Self::After(other) => (other, 1),
            Self::Before(other) => (other, 0),
            Self::Last => return corners.len(),
        };
        corners.iter().position(|&c| c == other).map_or(corners.len(), |i| i + after)
    }
}

/// The corners of all vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct CornerLists {
    lists: Vec<List>,
    /// Lists that do not fit inline.
    long: LongLists,
}

impl CornerLists {
    /// Reserves memory for this many more vertices.
    pub(crate) fn reserve(&mut self, vertices: usize) {
        self.lists.reserve_exact(vertices);
    }

    /// Adds a vertex without corners.
    pub(crate) fn add_vertex(&mut self) {
        self.lists.push(List { count: 0, inline: [0; INLINE_CORNERS] });
    }

    /// Returns the corners of a vertex if they are inline.
    #[inline]
    pub(crate) fn inline(&self, vertex: u32) -> Option<&[u32]> {
        let list = &self.lists[vertex as usize];
        list.inline.get(..list.count as usize)
    }

    /// Iterates over the corners of a vertex that has more than [`INLINE_CORNERS`].
    pub(crate) fn long_corners(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        self.long.corners(self.lists[vertex as usize].blocks())
    }

    /// Returns the number of corners of a vertex.
    pub(crate) fn count(&self, vertex: u32) -> u32 {
        self.lists[vertex as usize].count
    }

    /// Replaces the corners of a vertex.
    #[inline]
    pub(crate) fn set(&mut self, vertex: u32, corners: &[u32]) {
        let list = &mut self.lists[vertex as usize];
        if list.is_long() {
            self.long.remove(list.blocks());
        }
        list.count = corners.len() as u32;
        if corners.len() <= INLINE_CORNERS {
            list.inline[..corners.len()].copy_from_slice(corners);
        } else {
            list.set_blocks(self.long.add(corners));
        }
    }

    /// Returns the inline list of a vertex, now of `count` corners that the caller sets. Neither
    /// the old nor the new list may be longer than [`INLINE_CORNERS`].
    #[inline]
    pub(crate) fn reset_inline(&mut self, vertex: u32, count: usize) -> &mut [u32; INLINE_CORNERS] {
        let list = &mut self.lists[vertex as usize];
        list.count = count as u32;
        &mut list.inline
    }

    /// Returns whether a corner is in the list of a vertex, given that it is in no other one.
    pub(crate) fn contains(&self, vertex: u32, corner: u32) -> bool {
        match self.inline(vertex) {
            Some(corners) => corners.contains(&corner),
            None => self.long.contains(corner),
        }
    }

    /// Removes corners from the list of a vertex, which has all of them, and adds others at its
    /// beginning and its end. In a long list the time depends only on how many are removed and
    /// added.
    pub(crate) fn exchange(
        &mut self,
        vertex: u32,
        removed: &[u32],
        prepended: &[u32],
        appended: &[u32],
    ) {
        let corners: Vec<u32> = match self.inline(vertex) {
            Some(corners) => {
                let remaining = corners.iter().filter(|corner| !removed.contains(corner));
                prepended.iter().chain(remaining).chain(appended).copied().collect()
            }
            None => {
                let list = &mut self.lists[vertex as usize];
                let mut blocks = list.blocks();
                prepended.iter().rev().for_each(|&c| self.long.push_front(&mut blocks, c));
                appended.iter().for_each(|&c| self.long.push(&mut blocks, c));
                removed.iter().for_each(|&c| self.long.remove_corner(&mut blocks, c));
                list.set_blocks(blocks);
                let count = list.count as usize + prepended.len() + appended.len() - removed.len();
                if count > INLINE_CORNERS {
                    list.count = count as u32;
                    return;
                }
                self.long.corners(blocks).collect()
            }
        };
        self.set(vertex, &corners);
    }

    /// Inserts a corner into the list of a vertex.
    #[inline]
    pub(crate) fn insert(&mut self, vertex: u32, corner: u32, insertion: Insertion) {
        let list = &mut self.lists[vertex as usize];
        let count = list.count as usize;
        match (count < INLINE_CORNERS, insertion) {
            (true, Insertion::After(other)) => {
                // The common case: the search from the end moves the later corners on its way.
                let mut index = count;
                while index > 0 && list.inline[index - 1] != other {
                    list.inline[index] = list.inline[index - 1];
                    index -= 1;
                }
                list.inline[index] = corner;
                list.count += 1;
            }
            (true, _) => {
                let index = insertion.index(&list.inline[..count]);
                list.inline.copy_within(index..count, index + 1);
                list.inline[index] = corner;
                list.count += 1;
            }
            (false, _) if list.is_long() => {
                let mut blocks = list.blocks();
                match insertion {
                    Insertion::After(other) => self.long.insert_after(&mut blocks, corner, other),
                    Insertion::Before(other) => self.long.insert_before(&mut blocks, corner, other),
                    Insertion::Last => self.long.push(&mut blocks, corner),
                }
                list.set_blocks(blocks);
                list.count += 1;
            }
            _ => {
                let mut long = list.inline.to_vec();
                long.insert(insertion.index(&long), corner);
                self.set(vertex, &long);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SplitMix64;

    #[test]
    fn lists_behave_like_vectors() {
        let mut random = SplitMix64::new(4);
        let mut lists = CornerLists::default();
        let mut reference: Vec<Vec<u32>> = vec![Vec::new(); 20];
        (0..20).for_each(|_| lists.add_vertex());
        for corner in 0..20_000 {
            let vertex = random.below(20);
            let list = &mut reference[vertex];
            if random.below(40) == 0 {
                list.truncate(random.below(300));
                lists.set(vertex as u32, list);
            }
            if random.below(30) == 0 {
                // Corners from 20,000 on: no other insertion uses these numbers.
                let new: Vec<u32> =
                    (1..1 + random.below(4) as u32).map(|i| corner + i * 20_000).collect();
                let (prepended, appended) = new.split_at(random.below(new.len() + 1));
                let all_but = random.below(list.len() / 2 + 1);
                let mut removed = list.clone();
                removed.rotate_left(random.below(list.len() + 1) % list.len().max(1));
                removed.truncate(if random.below(2) == 0 { list.len() - all_but } else { all_but });
                assert!(removed.iter().all(|&c| lists.contains(vertex as u32, c)));
                lists.exchange(vertex as u32, &removed, prepended, appended);
                list.retain(|c| !removed.contains(c));
                *list = [prepended, list, appended].concat();
                assert!(removed.iter().all(|&c| !lists.contains(vertex as u32, c)));
            }
            let insertion = if list.is_empty() || random.below(3) == 0 {
                Insertion::Last
            } else {
                let other = list[random.below(list.len())];
                if random.below(2) == 0 {
                    Insertion::After(other)
                } else {
                    Insertion::Before(other)
                }
            };
            list.insert(insertion.index(list), corner);
            lists.insert(vertex as u32, corner, insertion);
            let vertex = vertex as u32;
            match lists.inline(vertex) {
                Some(inline) => assert_eq!(inline, list),
                None => assert_eq!(&lists.long_corners(vertex).collect::<Vec<_>>(), list),
            }
        }
    }

    #[test]
    fn inserting_beside_a_corner_moves_a_few_however_long_the_list_is() {
        let (mut random, mut lists, n) = (SplitMix64::new(5), CornerLists::default(), 100_000);
        lists.add_vertex();
        lists.insert(0, 0, Insertion::Last);
        for corner in 1..n {
            let other = random.below(corner as usize) as u32;
            lists.insert(0, corner, Insertion::After(other));
        }
        assert_eq!(lists.long_corners(0).count(), n as usize);
        assert!(lists.long.moves < 70 * n as usize, "{}", lists.long.moves);
        for corner in 0..n - 300 {
            lists.exchange(0, &[corner], &[], &[]);
        }
        assert!(lists.long_corners(0).count() == 300 && lists.long.used_blocks() <= 300);
    }
}
