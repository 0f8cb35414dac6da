//! Ranks of the remaining elements of a strip: a binary indexed tree (Fenwick 1994).

/// For each element the number of remaining ones before it.
#[derive(Clone, Debug, Default)]
pub(super) struct Ranks {
    /// Node `i` counts the `i & -i` elements up to the `i`-th, from 1.
    tree: Vec<u32>,
}

impl Ranks {
    /// Starts with `count` elements, all of which remain.
    pub(super) fn fill(&mut self, count: usize) {
        self.tree.clear();
        self.tree.extend((0..=count as u32).map(|i| i & i.wrapping_neg()));
    }

    /// Returns the number of remaining elements before this one.
    pub(super) fn rank(&self, element: u32) -> u32 {
        let (mut i, mut sum) = (element, 0);
        while i > 0 {
            sum += self.tree[i as usize];
            i &= i - 1;
        }
        sum
    }

    /// Returns the remaining element with `rank` remaining ones before it. There must be one.
    pub(super) fn select(&self, rank: u32) -> u32 {
        let last = self.tree.len() - 1;
        // Descends the tree: `index` elements are before the one sought, `uncounted` of those that
        // remain are not counted yet.
        let (mut index, mut uncounted) = (0, rank);
        let mut width = (last + 1).next_power_of_two();
        while width > 0 {
            if index + width <= last && self.tree[index + width] <= uncounted {
                index += width;
                uncounted -= self.tree[index];
            }
            width /= 2;
        }
        index as u32
    }

    /// Removes an element, which must remain until now.
    pub(super) fn remove(&mut self, element: u32) {
        let mut i = element as usize + 1;
        while i < self.tree.len() {
            self.tree[i] -= 1;
            i += i & i.wrapping_neg();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_a_plain_count() {
        for count in [1usize, 2, 3, 8, 9, 100] {
            let (mut ranks, mut left) = (Ranks::default(), vec![true; count]);
            ranks.fill(count);
            let mut rng = lodc_fixtures::Rng::new(count as u64);
            for _ in 0..count {
                let gone = rng.below(count);
                if std::mem::replace(&mut left[gone], false) {
                    ranks.remove(gone as u32);
                }
                for (rank, element) in (0..count).filter(|&e| left[e]).enumerate() {
                    assert_eq!(ranks.rank(element as u32) as usize, rank);
                    assert_eq!(ranks.select(rank as u32) as usize, element);
                }
            }
        }
    }
}
