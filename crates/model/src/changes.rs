//! Triangles that a move of a cursor removes and adds.

use lodc_mesh::OrientedTriangle;
use std::cmp::Ordering;

/// A listener to the triangles that a cursor removes and adds while it moves.
pub trait Changes {
    /// True if anybody listens. A model need not work out changes that nobody hears of.
    const HEARD: bool = true;
    /// Takes note of a triangle that is not drawn any more.
    fn removed(&mut self, triangle: OrientedTriangle);
    /// Takes note of a triangle that is drawn from now on.
    fn added(&mut self, triangle: OrientedTriangle);
}

/// Listens to nothing.
impl Changes for () {
    const HEARD: bool = false;
    fn removed(&mut self, _: OrientedTriangle) {}
    fn added(&mut self, _: OrientedTriangle) {}
}

/// The difference between what one strip draws before a move and after it.
#[derive(Clone, Debug, Default)]
pub struct Difference {
    before: Vec<OrientedTriangle>,
    after: Vec<OrientedTriangle>,
}

impl Difference {
    /// Keeps the triangles of a strip before a move.
    pub fn before(&mut self, triangles: impl Iterator<Item = OrientedTriangle>) {
        self.before.clear();
        self.before.extend(triangles);
    }

    /// Reports what the move did. A triangle changes with it exactly if one of its corners at the
    /// finer LOD is a vertex that is gone at the coarser one; the others keep their order, so they
    /// are found again one after the other.
    pub fn after(
        &mut self,
        triangles: impl Iterator<Item = OrientedTriangle>,
        coarsens: bool,
        coarse: u32,
        changes: &mut impl Changes,
    ) {
        self.after.clear();
        self.after.extend(triangles);
        let (fine, other) =
            if coarsens { (&self.before, &self.after) } else { (&self.after, &self.before) };
        let moves = |t: &&OrientedTriangle| t.corners.iter().any(|&v| v < coarse);
        let mut stays = fine.iter().filter(|t| !moves(t)).peekable();
        for &t in fine.iter().filter(moves) {
            if coarsens {
                changes.removed(t);
            } else {
                changes.added(t);
            }
        }
        for &t in other {
            if stays.next_if(|&&s| s == t).is_none() {
                if coarsens {
                    changes.added(t);
                } else {
                    changes.removed(t);
                }
            }
        }
    }
}

/// Reports the multiset difference of two lists of triangles, and sorts both.
pub fn report_difference(
    before: &mut [OrientedTriangle],
    after: &mut [OrientedTriangle],
    changes: &mut impl Changes,
) {
    before.sort_unstable();
    after.sort_unstable();
    let (mut before, mut after) = (before.iter().peekable(), after.iter().peekable());
    while let (Some(&&b), Some(&&a)) = (before.peek(), after.peek()) {
        if b <= a {
            before.next();
        }
        if a <= b {
            after.next();
        }
        match b.cmp(&a) {
            Ordering::Less => changes.removed(b),
            Ordering::Greater => changes.added(a),
            Ordering::Equal => {}
        }
    }
    before.for_each(|&t| changes.removed(t));
    after.for_each(|&t| changes.added(t));
}
