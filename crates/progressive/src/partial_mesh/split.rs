//! Vertex splits on the partial mesh: transfer of corners, new triangles, order of corner lists.
//!
//! ```text
//!          before: star of the parent                 after
//!
//!               p ------- q                        p ------- q
//!              / \   1   / \                      / \   1   / \
//!             / 2 \     / 0 \                    / 2 \     / 0 \
//!            /     \   /     \                  /     \   /     \
//!         v_l --- parent --- v_r             v_l ----- new ----- v_r
//!            \     /   \     /                  \   L   |   R   /
//!             \ 3 /     \ 5 /                    \      |      /
//!              \ /   4   \ /                      `-- parent -´
//!               r ------- s                     (triangles 3, 4 and 5)
//!
//!   corner list of the parent:  0 1 2 3 4 5   ->   L 3 4 5 R
//!   corner list of the new vertex:            ->   0 1 2 L R
//!   corner list of v_l: L follows the corner of 3, the triangle whose link edge starts there
//!   corner list of v_r: R follows the corner of 0, likewise
//! ```

use crate::partial_mesh::corner_lists::{INLINE_CORNERS, Insertion};
use crate::partial_mesh::mesh::PartialMesh;
use crate::partial_mesh::new_triangle::{NewTriangle, Side};
use crate::partial_mesh::star::StarFace;
use lodc_mesh::NONE;

/// A vertex split of a closed star by one left and one right triangle: the star falls into two
/// arcs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Arcs {
    /// Index in the star of the first triangle that the parent keeps.
    pub(crate) first_kept: usize,
    /// Index in the star of the first triangle that is transferred.
    pub(crate) first_transferred: usize,
}

/// The two vertices of a split.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SplitEdge {
    pub(crate) parent: u32,
    pub(crate) new: u32,
}

/// Buffers of [`PartialMesh::split`].
#[derive(Clone, Debug, Default)]
pub(crate) struct SplitBuffers {
    kept: Vec<u32>,
    transferred: Vec<u32>,
}

impl PartialMesh {
    /// Does the split in the common case, see [`Arcs`], and collects the link of the new vertex.
    /// Changes nothing and returns false if a list could become longer than [`INLINE_CORNERS`].
    #[inline]
    pub(crate) fn split_arcs(
        &mut self,
        edge: SplitEdge,
        star: &[StarFace],
        arcs: Arcs,
        new_link: &mut Vec<u32>,
    ) -> bool {
        let SplitEdge { parent, new } = edge;
        let (first_kept, first_transferred) = (arcs.first_kept, arcs.first_transferred);
        let n = star.len();
        let following = |i: usize| if i + 1 == n { 0 } else { i + 1 };
        let (transferred, kept) = if first_transferred < first_kept {
            (first_kept - first_transferred, n + first_transferred - first_kept)
        } else {
            (n + first_kept - first_transferred, first_transferred - first_kept)
        };
        // Corner c of face f has the number 4 f + c. Corner 0 of new faces is the new vertex.
        let first_left = 4 * self.face_count();
        let first_right = first_left + 4;
        if transferred + 2 > INLINE_CORNERS
            || kept + 2 > INLINE_CORNERS
            || self.corners.count(parent) as usize > INLINE_CORNERS
        {
            return false;
        }
        let (Some(left), Some(right)) = (star.get(first_kept), star.get(first_transferred)) else {
            return false;
        };
        let list = self.corners.reset_inline(parent, kept + 2);
        let mut i = first_kept;
        list[0] = first_left + 2;
        for slot in &mut list[1..=kept] {
            *slot = star[i].corner;
            i = following(i);
        }
        list[kept + 1] = first_right + 1;
        let list = self.corners.reset_inline(new, transferred + 2);
        new_link.clear();
        for slot in &mut list[..transferred] {
            let face = star[i];
            *slot = face.corner;
            new_link.push(face.a);
            self.faces[face.face() as usize][face.corner as usize & 3] = new;
            i = following(i);
        }
        [list[transferred], list[transferred + 1]] = [first_left, first_right];
        new_link.extend([left.a, parent]);
        self.faces.extend([[new, left.a, parent, NONE], [new, parent, right.a, NONE]]);
        self.corners.insert(left.a, first_left + 1, Insertion::After(left.corner_a()));
        self.corners.insert(right.a, first_right + 2, Insertion::After(right.corner_a()));
        true
    }

    /// Does any split: transfers the triangles of the parent's star that `transfer` marks, adds the
    /// new ones, updates all corner lists (docs/STREAM.md, "Corner lists") and collects the star of
    /// the new vertex.
    pub(crate) fn split(
        &mut self,
        edge: SplitEdge,
        parent_star: ParentStar<'_>,
        triangles: &[NewTriangle],
        buffers: &mut SplitBuffers,
        new_star: &mut Vec<StarFace>,
    ) {
        let SplitEdge { parent, new } = edge;
        let first_face = self.face_count();
        let corner = |i: usize, number: u32| 4 * (first_face + i as u32) + number;
        let SplitBuffers { kept, transferred } = buffers;
        kept.clear();
        transferred.clear();
        new_star.clear();
        let left = triangles.iter().enumerate().filter(|(_, t)| t.side == Side::Left);
        kept.extend(left.map(|(i, _)| corner(i, 2)));
        let left_count = kept.len();
        for (face, is_transferred) in parent_star.rotated() {
            if is_transferred {
                transferred.push(face.corner);
                new_star.push(face);
                self.faces[face.face() as usize][face.corner as usize & 3] = new;
            } else {
                kept.push(face.corner);
            }
        }
        for (i, t) in triangles.iter().enumerate() {
            self.faces.push([new, t.next, t.previous, NONE]);
            transferred.push(corner(i, 0));
            new_star.push(StarFace { corner: corner(i, 0), a: t.next, b: t.previous });
            let [next, previous] = [corner(i, 1), corner(i, 2)];
            match t.side {
                Side::Left => self.corners.insert(t.next, next, parent_star.insertion(t)),
                Side::Right => {
                    kept.push(next);
                    self.corners.insert(t.previous, previous, parent_star.insertion(t));
                }
                Side::Detached => {
                    self.corners.insert(t.next, next, Insertion::Last);
                    self.corners.insert(t.previous, previous, Insertion::Last);
                }
            }
        }
        if parent_star.is_part {
            let removed = &transferred[..parent_star.faces.len()];
            let (prepended, appended) = kept.split_at(left_count);
            self.corners.exchange(parent, removed, prepended, appended);
        } else {
            self.corners.set(parent, kept);
        }
        self.corners.set(new, transferred);
    }
}

/// The star of the parent before a split, and which of its triangles are transferred.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParentStar<'a> {
    pub(crate) faces: &'a [StarFace],
    /// For each of `faces` whether it is transferred.
    pub(crate) transfer: &'a [bool],
    /// True for an explicit face list: `faces` has only the triangles that are transferred.
    pub(crate) is_part: bool,
}

impl ParentStar<'_> {
    /// Returns where an apex corner belongs in its vertex's list: beside the corner of the triangle
    /// of the star that shares its link edge.
    fn insertion(&self, triangle: &NewTriangle) -> Insertion {
        let face = |i: u32| self.faces.get(i as usize);
        let after = face(triangle.outgoing).map(|f| Insertion::After(f.corner_a()));
        let before = || face(triangle.incoming).map(|f| Insertion::Before(f.corner_b()));
        after.or_else(before).unwrap_or(Insertion::Last)
    }

    /// Iterates over the star. If its ends meet, it starts where the transfer changes, so that what
    /// is kept and what is transferred are one run each.
    fn rotated(&self) -> impl Iterator<Item = (StarFace, bool)> {
        let start = match (self.faces, self.transfer) {
            ([first, .., last], [begins, ..]) if last.b == first.a => {
                let same = self.transfer.iter().rev().take_while(|&t| t == begins).count();
                if same == self.transfer.len() { 0 } else { self.transfer.len() - same }
            }
            _ => 0,
        };
        let order = (start..self.faces.len()).chain(0..start);
        order.map(|i| (self.faces[i], self.transfer[i]))
    }
}
