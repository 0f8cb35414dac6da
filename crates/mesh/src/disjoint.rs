//! Disjoint sets of elements that are connected (union-find with path halving).

/// Elements from 0 on, each in one set.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    /// For each element another one of its set, never a larger one; itself for the smallest.
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Makes a set of each element below `count`.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// Returns the smallest element of the set that `element` is in.
    pub fn find(&mut self, element: u32) -> u32 {
        let mut current = element;
        while self.parent[current as usize] != current {
            let parent = self.parent[current as usize];
            self.parent[current as usize] = self.parent[parent as usize];
            current = self.parent[current as usize];
        }
        current
    }

    /// Unites the sets of two elements.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        // The smaller root becomes the root of both, so that it is the smallest element of its set.
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_elements_find_the_smallest_of_them() {
        let mut sets = DisjointSets::new(6);
        for (a, b) in [(5, 4), (2, 5), (0, 3)] {
            sets.join(a, b);
        }
        let found: Vec<u32> = (0..6).map(|element| sets.find(element)).collect();
        assert_eq!(found, [0, 1, 2, 0, 2, 2]);
    }
}
