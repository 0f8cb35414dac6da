//! A cover of the triangles by paths in their dual graph: strips before they are written as
//! indices. A slot is one of a triangle's three edges, a code is a triangle with a slot
//! (`adjacency`).
//!
//! Following a path, each inner triangle turns left or right. Two inner triangles in a row that
//! turn the same way need a *swap*: one repeated index. A path of n triangles becomes n + 2 indices
//! and one more per swap.

use crate::adjacency::{code, decode};
use lodc_mesh::{Mesh, NONE};

/// A triangle with its three neighbours (as codes) and, as bits, which of them follow or precede it
/// in its path.
pub(crate) type Node = [u32; 4];

/// Where a [`Node`] holds the bits of its links.
pub(crate) const LINKS: usize = 3;

/// `TURN[links][slot]`: the number of corners, 1 or 2, from a linked slot of an inner triangle to
/// its other linked one, which says whether the path turns left or right there; 0 at an end. Two
/// triangles that turn the same way have numbers that add up to 3, since each is seen from the edge
/// between them.
const TURN: [[u32; 4]; 8] =
    [[0; 4], [0; 4], [0; 4], [1, 2, 0, 0], [0; 4], [2, 0, 1, 0], [0, 1, 2, 0], [0; 4]];

/// Returns whether the link between two triangles needs a swap, by the links of each and its slot.
#[inline]
pub(crate) fn needs_swap(links: u32, slot: u32, others: u32, entered: u32) -> bool {
    TURN[links as usize][slot as usize] + TURN[others as usize][entered as usize] == 3
}

/// Paths that cover all triangles, each once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cover {
    pub(crate) nodes: Vec<Node>,
}

impl Cover {
    /// Every triangle by itself.
    pub(crate) fn new(neighbours: impl Iterator<Item = [u32; 3]>) -> Self {
        Self { nodes: neighbours.map(|n| [n[0], n[1], n[2], 0]).collect() }
    }
    #[inline]
    pub(crate) fn links(&self, t: u32) -> u32 {
        self.nodes[t as usize][LINKS]
    }
    #[inline]
    pub(crate) fn is_end(&self, t: u32) -> bool {
        self.links(t).count_ones() < 2
    }
    #[inline]
    pub(crate) fn neighbour(&self, t: u32, slot: u32) -> u32 {
        self.nodes[t as usize][slot as usize]
    }
    /// Links or unlinks a triangle and the neighbour at one of its slots.
    #[inline]
    pub(crate) fn toggle(&mut self, t: u32, slot: u32) {
        let (u, f) = decode(self.neighbour(t, slot));
        self.nodes[t as usize][LINKS] ^= 1 << slot;
        self.nodes[u as usize][LINKS] ^= 1 << f;
    }
    /// The linked slot of a triangle that is not the given one.
    #[inline]
    pub(crate) fn other(&self, t: u32, slot: u32) -> Option<u32> {
        let rest = self.links(t) & !(1 << slot);
        (rest != 0).then(|| rest.trailing_zeros())
    }
    /// Returns whether a link at slot `f` of `u` needs a swap, if the path turns by `turn` (see
    /// [`TURN`]) before it.
    pub(crate) fn would_swap(&self, turn: u32, u: u32, f: u32) -> bool {
        turn + TURN[(self.links(u) | 1 << f) as usize][f as usize] == 3
    }
    /// Writes the path that starts at an end: its triangles and the slot through which each is
    /// left, as codes. The last code has slot 3.
    pub(crate) fn path(&self, start: u32, path: &mut Vec<u32>) {
        path.clear();
        let links = self.links(start);
        let mut current = start;
        let mut exit = (links != 0).then(|| links.trailing_zeros());
        while let Some(slot) = exit {
            path.push(code(current, slot));
            let (next, entered) = decode(self.neighbour(current, slot));
            exit = self.other(next, entered);
            current = next;
        }
        path.push(code(current, 3));
    }
    /// Calls `visit` with every path, in order of their lower ends.
    pub(crate) fn paths(&self, mut visit: impl FnMut(&[u32])) {
        let mut path = Vec::new();
        let mut done = vec![false; self.nodes.len()];
        for t in 0..self.nodes.len() as u32 {
            if !done[t as usize] && self.is_end(t) {
                self.path(t, &mut path);
                let last = path.last().map_or(t, |&c| decode(c).0);
                done[last as usize] = true;
                visit(&path);
            }
        }
    }
    /// Appends the indices of a path, from its last triangle if that takes fewer. The third index
    /// of a strip fixes the direction of its first turn; where that is wrong, a swap is needed.
    pub(crate) fn write(&self, path: &[u32], triangles: &[[u32; 3]], indices: &mut Vec<u32>) {
        let turns_wrong = |from: u32, slot: u32| {
            let (second, entered) = decode(self.neighbour(from, slot));
            TURN[self.links(second) as usize][entered as usize] == 1
        };
        let (first, leave) = decode(path[0]);
        let (last, _) = decode(path[path.len() - 1]);
        if leave == 3 {
            indices.extend(triangles[first as usize]);
            return;
        }
        if turns_wrong(first, leave) && !turns_wrong(last, self.links(last).trailing_zeros()) {
            let mut backward = Vec::with_capacity(path.len());
            self.path(last, &mut backward);
            self.write_forward(&backward, triangles, indices);
        } else {
            self.write_forward(path, triangles, indices);
        }
    }
    /// Appends the indices of a path from its first triangle.
    pub(crate) fn write_forward(
        &self,
        path: &[u32],
        triangles: &[[u32; 3]],
        indices: &mut Vec<u32>,
    ) {
        write_path(path, triangles, |t, slot| self.neighbour(t, slot), indices);
    }
}

/// Appends the indices of a path from its first triangle.
pub(crate) fn write_path(
    path: &[u32],
    triangles: &[[u32; 3]],
    neighbour: impl Fn(u32, u32) -> u32,
    indices: &mut Vec<u32>,
) {
    let (first, slot) = decode(path[0]);
    let t = triangles[first as usize];
    if slot == 3 {
        indices.extend(t);
        return;
    }
    let corner = |slot: u32| t[slot as usize % 3];
    indices.extend([corner(slot + 2), corner(slot), corner(slot + 1)]);
    let (mut second_last, mut last) = (corner(slot), corner(slot + 1));
    for (&from, &step) in path.iter().zip(&path[1..]) {
        let (t, exit) = decode(step);
        let (previous, slot) = decode(from);
        let (_, entered) = decode(neighbour(previous, slot));
        let t = triangles[t as usize];
        let new = t[(entered as usize + 2) % 3];
        if exit != 3 {
            // The edge to leave by has the new corner and one of the last two. If that is the
            // older, it must come again.
            let (a, b) = (t[exit as usize], t[(exit as usize + 1) % 3]);
            let old_corner = if a == new { b } else { a };
            if old_corner == second_last {
                indices.push(second_last);
                last = second_last;
            }
        }
        indices.push(new);
        (second_last, last) = (last, new);
    }
}

/// The submesh of every triangle in a mesh's order of triangles.
pub(crate) fn submesh_of(mesh: &Mesh) -> Vec<u32> {
    let mut of = Vec::with_capacity(mesh.triangles().len());
    for (i, submesh) in mesh.submeshes().iter().enumerate() {
        of.resize(submesh.triangles().end, i as u32);
    }
    of
}

/// Returns whether a code is [`NONE`]: there is no neighbour.
pub(crate) fn is_none(code: u32) -> bool {
    code == NONE
}
