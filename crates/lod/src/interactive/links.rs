//! For every vertex that is still there, the list of input vertices it stands for: joined and cut
//! in constant time.

use std::ops::Range;

/// Circular doubly linked lists, one per vertex. Element `v` is the input vertex `v`; element `n +
/// v` is the head of the list of vertex `v`. What is taken out keeps its own links, so that putting
/// things back in the opposite order restores everything.
#[derive(Clone, Debug)]
pub(super) struct Links {
    vertices: u32,
    next: Vec<u32>,
    previous: Vec<u32>,
}

impl Links {
    /// Each of `members` alone in its own list; other vertices' lists are empty.
    pub(super) fn new(vertices: u32, members: &[u32]) -> Self {
        // Every element its own neighbour: empty lists.
        let alone: Vec<u32> = (0..2 * vertices).collect();
        let mut links = Self { vertices, next: alone.clone(), previous: alone };
        for &v in members {
            links.connect(v + vertices, v);
            links.connect(v, v + vertices);
        }
        links
    }

    fn connect(&mut self, a: u32, b: u32) {
        self.next[a as usize] = b;
        self.previous[b as usize] = a;
    }

    /// Takes an input vertex out of the list it is in.
    pub(super) fn unlink(&mut self, v: u32) {
        self.connect(self.previous[v as usize], self.next[v as usize]);
    }

    /// Undoes the latest [`Self::unlink`].
    pub(super) fn relink(&mut self, v: u32) {
        self.next[self.previous[v as usize] as usize] = v;
        self.previous[self.next[v as usize] as usize] = v;
    }

    /// Moves a vertex's list to the end of another's. Its head goes on pointing at what it had.
    pub(super) fn splice(&mut self, from: u32, to: u32) {
        let (from, to) = (from + self.vertices, to + self.vertices);
        let (first, last) = (self.next[from as usize], self.previous[from as usize]);
        if first != from {
            self.connect(self.previous[to as usize], first);
            self.connect(last, to);
        }
    }

    /// Undoes the latest [`Self::splice`].
    pub(super) fn unsplice(&mut self, from: u32) {
        let from = from + self.vertices;
        let (first, last) = (self.next[from as usize], self.previous[from as usize]);
        if first != from {
            self.connect(self.previous[first as usize], self.next[last as usize]);
            self.connect(from, first);
            self.connect(last, from);
        }
    }

    /// Calls `visit` with every input vertex in a vertex's list.
    pub(super) fn for_each(&self, list: u32, mut visit: impl FnMut(u32)) {
        let head = list + self.vertices;
        let mut v = self.next[head as usize];
        while v != head {
            visit(v);
            v = self.next[v as usize];
        }
    }

    /// The input vertices in some vertices' lists.
    pub(super) fn members(&self, lists: Range<u32>) -> Vec<u32> {
        let mut members = Vec::new();
        for list in lists {
            self.for_each(list, |v| members.push(v));
        }
        members
    }
}
