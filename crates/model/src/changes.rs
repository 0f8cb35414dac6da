//! The triangles that a move of a cursor removes and adds, as a listener hears of them, and the
//! difference of two lists.

use lodc_mesh::OrientedTriangle;
use std::cmp::Ordering;

/// A listener to the triangles that a cursor removes and adds while it moves.
pub trait Changes {
    /// False if changes are ignored: then a model need not find them.
    const REPORTED: bool = true;
    /// Takes note of a triangle that is not drawn any more.
    fn removed(&mut self, triangle: OrientedTriangle);
    /// Takes note of a triangle that is drawn from now on.
    fn added(&mut self, triangle: OrientedTriangle);
}

/// Ignores all changes.
impl Changes for () {
    const REPORTED: bool = false;
    fn removed(&mut self, _: OrientedTriangle) {}
    fn added(&mut self, _: OrientedTriangle) {}
}

/// The difference between what some strips draw before a move and after it.
#[derive(Clone, Debug, Default)]
pub struct Difference {
    /// The triangles before the move, strip by strip.
    before: Vec<OrientedTriangle>,
    /// The end of each strip in `before`.
    ends: Vec<usize>,
    /// A buffer for the triangles of one strip after the move.
    after: Vec<OrientedTriangle>,
}

impl Difference {
    /// Forgets the strips of the last move.
    pub fn clear(&mut self) {
        self.before.clear();
        self.ends.clear();
    }

    /// Keeps the triangles of one more strip before a move.
    pub fn add_before(&mut self, triangles: impl Iterator<Item = OrientedTriangle>) {
        self.before.extend(triangles);
        self.ends.push(self.before.len());
    }

    /// Reports what the move did to the strip that was kept as the `number`-th, from 0.
    pub fn report_after(
        &mut self,
        number: usize,
        triangles: impl Iterator<Item = OrientedTriangle>,
        changes: &mut impl Changes,
    ) {
        self.after.clear();
        self.after.extend(triangles);
        let start = if number == 0 { 0 } else { self.ends[number - 1] };
        report_difference(&mut self.before[start..self.ends[number]], &mut self.after, changes);
    }
}

/// Reports the multiset difference of two lists of triangles, and sorts what is between their
/// first and last differences.
pub fn report_difference(
    before: &mut [OrientedTriangle],
    after: &mut [OrientedTriangle],
    changes: &mut impl Changes,
) {
    // Most of what a strip draws stays, in its order.
    let same = before.iter().zip(after.iter()).take_while(|(b, a)| b == a).count();
    let (before, after) = (&mut before[same..], &mut after[same..]);
    let same = before.iter().rev().zip(after.iter().rev()).take_while(|(b, a)| b == a).count();
    let (before_end, after_end) = (before.len() - same, after.len() - same);
    let (before, after) = (&mut before[..before_end], &mut after[..after_end]);
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
