//! Which triangles of a strip go and come with a move.

use crate::Changes;
use lodc_mesh::{OrientedTriangle, PositionIds};
use lodc_strip::strip_triangles;
use std::cmp::Ordering;

/// The triangles that a strip draws: those with an area.
pub(crate) fn drawn<'a>(
    strip: &'a [u32],
    submesh: u32,
    positions: &'a PositionIds,
) -> impl Iterator<Item = OrientedTriangle> + 'a {
    let has_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions.of_vertex[v as usize]);
        a != b && b != c && c != a
    };
    strip_triangles(strip).filter(has_area).map(move |t| OrientedTriangle::new(submesh, t))
}

/// Compares what a strip draws before a move with what it draws after it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Difference {
    before: Vec<OrientedTriangle>,
    after: Vec<OrientedTriangle>,
}

impl Difference {
    /// Remembers a strip before a move.
    pub(crate) fn before(&mut self, triangles: impl Iterator<Item = OrientedTriangle>) {
        self.before.clear();
        self.before.extend(triangles);
    }

    /// Tells what the move did. A triangle changes with it exactly if one of its corners at the
    /// finer LOD is a vertex that is gone at the coarser one; the others keep their order, so they
    /// are found again one after the other.
    pub(crate) fn after(
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
                changes.gone(t);
            } else {
                changes.came(t);
            }
        }
        for &t in other {
            if stays.next_if(|&&s| s == t).is_none() {
                if coarsens {
                    changes.came(t);
                } else {
                    changes.gone(t);
                }
            }
        }
    }
}

/// Tells what is in one of two lists and not in the other, each as often, in whatever order the two
/// are.
pub(crate) fn tell(
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
            Ordering::Less => changes.gone(b),
            Ordering::Greater => changes.came(a),
            Ordering::Equal => {}
        }
    }
    before.for_each(|&t| changes.gone(t));
    after.for_each(|&t| changes.came(t));
}
