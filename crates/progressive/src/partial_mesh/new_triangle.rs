//! A triangle that a vertex split adds, and on which side of the split edge it lies.

use lodc_mesh::NONE;

/// Where a new triangle lies relative to the split edge, which joins new vertex and parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Left of it: (new, apex, parent). The apex is Hoppe's v_l.
    Left = 0,
    /// Right of it: (new, parent, apex). The apex is Hoppe's v_r.
    Right = 1,
    /// The parent is no corner of it.
    Detached = 2,
}

impl Side {
    /// Returns the side of the triangle (new, next, previous).
    pub(crate) fn of(next: u32, previous: u32, parent: u32) -> Self {
        if previous == parent {
            Self::Left
        } else if next == parent {
            Self::Right
        } else {
            Self::Detached
        }
    }
}

/// A triangle that a vertex split adds: (new, next, previous), counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewTriangle {
    pub(crate) next: u32,
    pub(crate) previous: u32,
    pub(crate) side: Side,
    /// Index in the parent's star of the triangle whose link edge starts at the apex, the corner
    /// off the split edge. [`NONE`] if there is none, or if the apex was not coded as a vertex of
    /// the link.
    pub(crate) outgoing: u32,
    /// Likewise, of the triangle whose link edge ends at the apex.
    pub(crate) incoming: u32,
}

impl NewTriangle {
    /// A triangle without known neighbours in the parent's star.
    pub(crate) fn unconnected(next: u32, previous: u32, side: Side) -> Self {
        Self { next, previous, side, outgoing: NONE, incoming: NONE }
    }
}
