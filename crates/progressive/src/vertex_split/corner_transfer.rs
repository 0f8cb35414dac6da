//! Coding of which triangles of the parent's star are transferred to the new vertex.
//!
//! The new triangles predict the transfer: each lies between a triangle that the parent keeps and
//! one that is transferred, and neighbouring triangles of a fan go the same way until the next new
//! triangle.
//!
//! ```text
//!       fan around the parent, unrolled           L at v_l          R at v_r
//!
//!   link   s      p      q     v_l     r      t     v_r     u
//!          |  ->  |  ->  |  ->  |  ->  |  ->  |  ->  |  ->  |
//!   known                 trans.  kept          kept  trans.
//!   spread  trans. trans. trans.  kept   kept   kept  trans.  (backwards only if forwards fails)
//! ```
//!
//! The arrows are triangles, each from its first link vertex to its second; L is the new triangle
//! to the left of the split edge, R the one to the right.

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::coder::Coder;
use crate::invalid::InvalidStream;
use crate::partial_mesh::new_triangle::{NewTriangle, Side};
use crate::partial_mesh::split::Arcs;
use crate::partial_mesh::star::StarFace;
use crate::source::split_source::SplitSource;
use crate::vertex_split::neighbourhood::SplitNeighbourhood;

/// Contexts of the transfer of triangles.
#[derive(Clone, Debug)]
pub(crate) struct TransferContexts {
    /// By the bits of the expected transfer ([`KEPT`], [`TRANSFERRED`]), and by the triangle
    /// before: none, kept or transferred.
    pub(crate) transferred: [[AdaptiveBit; 3]; 4],
}

impl TransferContexts {
    pub(crate) const NEW: Self = Self { transferred: [[AdaptiveBit::NEW; 3]; 4] };
}

/// The bits of an expected transfer. None set: unknown; both: contradictory.
const KEPT: u8 = 1;
const TRANSFERRED: u8 = 2;

/// The coding of the transfer of a split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TransferRule {
    /// The whole star is transferred.
    All,
    /// It follows from the new triangles.
    Implied,
    /// A bit for each triangle of the star.
    Coded,
}

impl SplitNeighbourhood {
    /// Codes the transfer into `self.transfer`.
    pub(crate) fn code_transfer<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut TransferContexts,
        rule: TransferRule,
    ) -> Result<(), InvalidStream> {
        self.transfer.clear();
        match rule {
            TransferRule::All => self.transfer.resize(self.star.len(), true),
            TransferRule::Coded => {
                predict_transfer(&self.star, &self.triangles, &mut self.expected);
                let mut previous = 0;
                for (face, &expected) in self.star.iter().zip(&self.expected) {
                    let context = &mut contexts.transferred[usize::from(expected)][previous];
                    let wanted = source.is_transferred(face.corner, self.new);
                    let transferred = coder.bit(context, wanted);
                    previous = 1 + usize::from(transferred);
                    self.transfer.push(transferred);
                }
            }
            TransferRule::Implied => {
                // An encoder has filled `expected` in `follows_rule`, when it chose the rule.
                if !C::ENCODES {
                    predict_transfer(&self.star, &self.triangles, &mut self.expected);
                }
                if self.expected.iter().any(|e| !matches!(*e, KEPT | TRANSFERRED)) {
                    return Err(InvalidStream("leaves the transfer of a triangle undetermined"));
                }
                self.transfer.extend(self.expected.iter().map(|&e| e == TRANSFERRED));
            }
        }
        Ok(())
    }

    /// Returns what [`predict_transfer`] finds in the common case: a closed star and a triangle on
    /// each side of the split edge.
    pub(crate) fn arcs(&self) -> Option<Arcs> {
        match &self.triangles[..] {
            [left, right]
                if self.closed && (left.side, right.side) == (Side::Left, Side::Right) =>
            {
                let (first_kept, first_transferred) =
                    (left.outgoing as usize, right.outgoing as usize);
                (first_kept != first_transferred).then_some(Arcs { first_kept, first_transferred })
            }
            _ => None,
        }
    }

    /// Returns whether a rule other than [`TransferRule::Coded`] gives the transfer of an encoder's
    /// split.
    pub(crate) fn follows_rule<S: SplitSource>(&mut self, source: &S, rule: TransferRule) -> bool {
        let new = self.new;
        let transferred = |f: &StarFace| source.is_transferred(f.corner, new);
        if rule == TransferRule::All {
            return self.star.iter().all(transferred);
        }
        predict_transfer(&self.star, &self.triangles, &mut self.expected);
        let as_expected = |(face, &expected): (&StarFace, &u8)| {
            matches!(expected, KEPT | TRANSFERRED) && transferred(face) == (expected == TRANSFERRED)
        };
        self.star.iter().zip(&self.expected).all(as_expected)
    }
}

/// Predicts the transfer of each triangle of the parent's star from the new triangles.
fn predict_transfer(star: &[StarFace], triangles: &[NewTriangle], expected: &mut Vec<u8>) {
    expected.clear();
    expected.resize(star.len(), 0);
    for t in triangles {
        let (outgoing, incoming) = match t.side {
            Side::Left => (KEPT, TRANSFERRED),
            Side::Right => (TRANSFERRED, KEPT),
            Side::Detached => continue,
        };
        for (face, bit) in [(t.outgoing, outgoing), (t.incoming, incoming)] {
            if let Some(expected) = expected.get_mut(face as usize) {
                *expected |= bit;
            }
        }
    }
    let mut start = 0;
    while start < star.len() {
        let more = star[start..].windows(2).take_while(|w| w[0].b == w[1].a).count();
        let closed = star[start + more].b == star[start].a;
        spread(&mut expected[start..=start + more], closed);
        start += more + 1;
    }
}

/// Spreads what is known about some triangles of a fan to their unknown neighbours: forwards, then
/// backwards. A closed fan is passed twice, so that what its end knows continues at its beginning.
/// The order is a contract of the format: an unknown triangle between two known ones goes with the
/// one before it.
fn spread(fan: &mut [u8], closed: bool) {
    let fill = |expected: &mut u8, last: &mut u8| {
        *expected = if *expected == 0 { *last } else { *expected };
        *last = *expected;
    };
    for _ in 0..=usize::from(closed) {
        let mut last = if closed { fan.last().copied().unwrap_or_default() } else { 0 };
        fan.iter_mut().for_each(|e| fill(e, &mut last));
    }
    let mut last = 0;
    fan.iter_mut().rev().for_each(|e| fill(e, &mut last));
}
