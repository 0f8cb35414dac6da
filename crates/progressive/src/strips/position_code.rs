//! Coding of strip positions, by the triangles beside a new one.
//!
//! The candidates are tried in a fixed order, one bit each, most likely first. Only if none is
//! right the position is named outright.

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::coder::Coder;
use crate::invalid::InvalidStream;
use crate::source::split_source::{SplitSource, StripPosition};
use crate::strips::strip_order::StripOrder;
use lodc_mesh::NONE;

/// Contexts of strip positions.
#[derive(Clone, Debug)]
pub(crate) struct StripContexts {
    /// The new triangle is drawn between the first two neighbours.
    pub(crate) between: AdaptiveBit,
    /// By neighbour, side, whether its strip continues there, and whether another neighbour is in
    /// that strip.
    pub(crate) beside: [[[[AdaptiveBit; 2]; 2]; 2]; 3],
    /// By number of neighbours: a new strip starts.
    pub(crate) new_strip: [AdaptiveBit; 4],
    /// By neighbour and side: the new strip stands there, beside the neighbour's strip.
    pub(crate) beside_strip: [[AdaptiveBit; 2]; 3],
    /// At a boundary of two strips: the second one.
    pub(crate) second: AdaptiveBit,
}

impl StripContexts {
    pub(crate) const NEW: Self = Self {
        between: AdaptiveBit::NEW,
        beside: [[[[AdaptiveBit::NEW; 2]; 2]; 2]; 3],
        new_strip: [AdaptiveBit::NEW; 4],
        beside_strip: [[AdaptiveBit::NEW; 2]; 3],
        second: AdaptiveBit::NEW,
    };
}

/// Up to three triangles beside a new one, [`NONE`] where there is none: the one expected to stay
/// with the parent, the one expected to be transferred, and the new triangle before it.
pub(crate) type StripCandidates = [u32; 3];

/// A coded position, and whether the candidates were not enough to code it.
#[derive(Clone, Copy, Debug)]
struct Coded {
    position: StripPosition,
    explicit: bool,
}

/// Codes the position of the next triangle and inserts it. Returns whether the candidates were not
/// enough.
pub(crate) fn code_position<C: Coder, S: SplitSource>(
    order: &mut StripOrder,
    coder: &mut C,
    source: &S,
    contexts: &mut StripContexts,
    candidates: StripCandidates,
) -> Result<bool, InvalidStream> {
    let wanted = if C::ENCODES {
        source.strip_position(order.face_count(), order.strip_count(), &|f| order.strip(f))
    } else {
        StripPosition { after: NONE, strip: 0 }
    };
    let mut code = PositionCode { order, coder, contexts, candidates, wanted };
    let coded = match code.candidate() {
        Some(position) => Coded { position, explicit: false },
        None => code.other()?,
    };
    order.insert(coded.position);
    Ok(coded.explicit)
}

/// The coding of one position.
struct PositionCode<'a, C> {
    order: &'a StripOrder,
    coder: &'a mut C,
    contexts: &'a mut StripContexts,
    candidates: StripCandidates,
    wanted: StripPosition,
}

impl<C: Coder> PositionCode<'_, C> {
    /// Returns the first of two neighbouring candidates if they are drawn one after the other in
    /// one strip.
    fn linked(&self) -> Option<u32> {
        let [a, b, _] = self.candidates;
        if !self.order.share_strip(a, b) {
            None
        } else if self.order.next(a) == b {
            Some(a)
        } else if self.order.next(b) == a {
            Some(b)
        } else {
            None
        }
    }

    /// Codes which of the positions beside the candidates it is, if one of them.
    fn candidate(&mut self) -> Option<StripPosition> {
        let mut excluded = NONE;
        if let Some(after) = self.linked() {
            let position = StripPosition { after, strip: self.order.strip(after) };
            if self.coder.bit(&mut self.contexts.between, self.wanted == position) {
                return Some(position);
            }
            excluded = after;
        }
        for (i, face) in self.candidates.into_iter().enumerate() {
            if face == NONE {
                continue;
            }
            let strip = self.order.strip(face);
            let shared =
                self.candidates.iter().any(|&f| f != face && self.order.share_strip(face, f));
            for (side, after) in [face, self.order.previous(face)].into_iter().enumerate() {
                let inside = self.order.share_strip(after, self.order.next(after));
                if inside && excluded == after {
                    continue;
                }
                let position = StripPosition { after, strip };
                let context =
                    &mut self.contexts.beside[i][side][usize::from(inside)][usize::from(shared)];
                if self.coder.bit(context, self.wanted == position) {
                    return Some(position);
                }
            }
        }
        None
    }

    /// Codes a position that is beside no candidate.
    fn other(&mut self) -> Result<Coded, InvalidStream> {
        let count = self.candidates.iter().filter(|&&f| f != NONE).count();
        let strips = self.order.strip_count();
        let context = &mut self.contexts.new_strip[count];
        if self.coder.bit(context, self.wanted.strip == strips) {
            return Ok(self.new_strip());
        }
        let faces = self.order.face_count();
        if faces == 0 {
            return Err(InvalidStream("adds a triangle to a strip before there is one"));
        }
        let wanted = self.wanted.after.wrapping_add(1);
        let after = self.coder.uniform(faces + 1, wanted).wrapping_sub(1);
        let before = self.order.next(after);
        if self.order.share_strip(after, before) {
            let position = StripPosition { after, strip: self.order.strip(after) };
            return Ok(Coded { position, explicit: true });
        }
        // At the end of one strip or the beginning of the next.
        let [first, second] =
            [after, before].map(|f| if f == NONE { NONE } else { self.order.strip(f) });
        let is_second = self.coder.bit(&mut self.contexts.second, self.wanted.strip == second);
        match if is_second { second } else { first } {
            NONE => Err(InvalidStream("adds a triangle to a strip that does not exist")),
            strip => Ok(Coded { position: StripPosition { after, strip }, explicit: true }),
        }
    }

    /// Codes where a new strip starts: after the last triangle of another one, or first.
    fn new_strip(&mut self) -> Coded {
        let strips = self.order.strip_count();
        let coded =
            |after, explicit| Coded { position: StripPosition { after, strip: strips }, explicit };
        for (i, face) in self.candidates.into_iter().enumerate() {
            if face == NONE {
                continue;
            }
            let ends = self.order.ends(self.order.strip(face));
            let sides = [ends.last, self.order.previous(ends.first)];
            for (context, after) in self.contexts.beside_strip[i].iter_mut().zip(sides) {
                if self.coder.bit(context, self.wanted.after == after) {
                    return coded(after, false);
                }
            }
        }
        let wanted = match self.wanted.after {
            NONE => 0,
            after if C::ENCODES => self.order.strip(after) + 1,
            _ => 0,
        };
        match self.coder.uniform(strips + 1, wanted) {
            0 => coded(NONE, true),
            strip => coded(self.order.ends(strip - 1).last, true),
        }
    }
}
