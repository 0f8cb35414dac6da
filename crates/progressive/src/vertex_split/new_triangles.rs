//! Coding of the triangles that a vertex split adds: their pattern, and their corners by index in
//! the parent's link.

use crate::entropy::adaptive_probability::{AdaptiveBit, AdaptiveSymbol};
use crate::entropy::coder::Coder;
use crate::entropy::integer_codes::GammaCode;
use crate::invalid::InvalidStream;
use crate::partial_mesh::new_triangle::{NewTriangle, Side};
use crate::source::split_source::{SourceTriangle, SplitSource};
use crate::vertex_split::corner_transfer::TransferRule;
use crate::vertex_split::neighbourhood::{Apex, SplitNeighbourhood};

/// Links of up to this many vertices, which a symbol can name, have contexts of their own; in
/// longer ones, of high-valence vertices, indices are coded as equally likely.
const MAX_LINK_CONTEXTS: usize = 16;
/// The symbol of a number of triangles that does not fit a symbol.
const COUNT_ESCAPE: u32 = 15;
/// The most triangles that a split may add: a limit of the format (docs/STREAM.md), against streams
/// that ask for memory by one number.
const MAX_TRIANGLES: usize = 1 << 20;

/// The common forms of a split, in one symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SplitPattern {
    /// A left and a right triangle; the transfer is implied.
    Both = 0,
    /// A left triangle; the transfer is implied.
    Left = 1,
    /// A right triangle; the transfer is implied.
    Right = 2,
    /// No triangle; the whole star is transferred.
    Empty = 3,
    /// Any triangles and any transfer, each coded by itself.
    General = 4,
}

impl SplitPattern {
    /// Returns the pattern of a symbol; all others are general too.
    fn of_symbol(symbol: u32) -> Self {
        match symbol {
            0 => Self::Both,
            1 => Self::Left,
            2 => Self::Right,
            3 => Self::Empty,
            _ => Self::General,
        }
    }

    /// Returns how the transfer of triangles is coded.
    pub(crate) fn transfer_rule(self) -> TransferRule {
        match self {
            Self::Empty => TransferRule::All,
            Self::General => TransferRule::Coded,
            Self::Both | Self::Left | Self::Right => TransferRule::Implied,
        }
    }
}

/// Contexts of new triangles.
#[derive(Clone, Debug)]
pub(crate) struct TriangleContexts {
    /// The pattern: by the size of the star (up to 3); whether it is closed; 0 for the first vertex
    /// of a step, else 1 + the sides on which earlier vertices of the step brought triangles.
    pub(crate) pattern: [[[AdaptiveSymbol; 5]; 2]; 4],
    /// The number of triangles: by whether the step continued.
    pub(crate) count: [AdaptiveSymbol; 2],
    /// The number of triangles beyond [`COUNT_ESCAPE`].
    pub(crate) more: GammaCode,
    /// Two bits, "is detached" and else "is left": by the number of triangles before (up to 2) and
    /// the side of the last one (3: none).
    pub(crate) side: [[[AdaptiveBit; 2]; 4]; 3],
    /// The corner is in the parent's link: by the size of the link, up to 3.
    pub(crate) in_link: [AdaptiveBit; 4],
    /// The index in the link (docs/STREAM.md calls it place): by what it is counted from (0: the
    /// first vertex; the left apex: 1, or 2 in a closed fan), and the size of the link.
    pub(crate) place: [[AdaptiveSymbol; MAX_LINK_CONTEXTS + 1]; 3],
}

impl TriangleContexts {
    pub(crate) const NEW: Self = Self {
        pattern: [[[AdaptiveSymbol::NEW; 5]; 2]; 4],
        count: [AdaptiveSymbol::NEW; 2],
        more: GammaCode::NEW,
        side: [[[AdaptiveBit::NEW; 2]; 4]; 3],
        in_link: [AdaptiveBit::NEW; 4],
        place: [[AdaptiveSymbol::NEW; MAX_LINK_CONTEXTS + 1]; 3],
    };
}

/// The coding of the triangles of one split.
pub(crate) struct TriangleCode<'a, C> {
    pub(crate) coder: &'a mut C,
    pub(crate) contexts: &'a mut TriangleContexts,
    pub(crate) split: &'a mut SplitNeighbourhood,
    /// Bytes that the coded corners take in the thesis's packages.
    pub(crate) package_bytes: u64,
}

impl<C: Coder> TriangleCode<'_, C> {
    /// Codes the triangles into `split.triangles`.
    pub(crate) fn code<S: SplitSource>(
        &mut self,
        source: &S,
    ) -> Result<SplitPattern, InvalidStream> {
        let triangles = source.new_triangles(self.split.new);
        let pattern = if C::ENCODES { self.choose_pattern(source) } else { SplitPattern::General };
        let size = self.split.star.len().min(3);
        let closed = usize::from(self.split.closed);
        let sides_before = if self.split.continued { 1 + self.split.sides } else { 0 };
        let context = &mut self.contexts.pattern[size][closed][sides_before];
        let pattern = SplitPattern::of_symbol(self.coder.symbol(context, pattern as u32));
        self.split.triangles.clear();
        match pattern {
            SplitPattern::Empty => {}
            SplitPattern::General => self.code_general(triangles)?,
            SplitPattern::Both | SplitPattern::Left | SplitPattern::Right => {
                self.code_sides(triangles, pattern)?;
            }
        }
        Ok(pattern)
    }

    /// Returns the pattern of an encoder's split.
    fn choose_pattern<S: SplitSource>(&mut self, source: &S) -> SplitPattern {
        let split = &mut *self.split;
        let triangles = source.new_triangles(split.new);
        let parent = split.parent;
        let side = |t: &SourceTriangle| Side::of(t.next, t.previous, parent);
        let pattern = match triangles {
            [] => SplitPattern::Empty,
            [t] if side(t) == Side::Left => SplitPattern::Left,
            [t] if side(t) == Side::Right => SplitPattern::Right,
            [t, u] if (side(t), side(u)) == (Side::Left, Side::Right) => SplitPattern::Both,
            _ => return SplitPattern::General,
        };
        split.triangles.clear();
        for t in triangles {
            let vertex = if side(t) == Side::Left { t.next } else { t.previous };
            let link_index = split.link_index_of(vertex);
            if link_index.is_none() {
                return SplitPattern::General;
            }
            split.add_triangle(side(t), Apex { vertex, link_index });
        }
        if split.is_named || split.follows_rule(source, pattern.transfer_rule()) {
            pattern
        } else {
            SplitPattern::General
        }
    }

    /// Codes one triangle on each side of the split edge, or on one.
    fn code_sides(
        &mut self,
        wanted: &[SourceTriangle],
        pattern: SplitPattern,
    ) -> Result<(), InvalidStream> {
        if self.split.link_len() == 0 {
            return Err(InvalidStream("has a triangle at a split edge whose parent has none"));
        }
        let wanted = |i: usize| wanted.get(i).copied().unwrap_or_default();
        let mut left = None;
        if pattern != SplitPattern::Right {
            let apex = self.code_link_apex(wanted(0).next, None);
            left = apex.link_index;
            self.split.add_triangle(Side::Left, apex);
        }
        if pattern != SplitPattern::Left {
            let i = usize::from(pattern == SplitPattern::Both);
            let apex = self.code_link_apex(wanted(i).previous, left);
            self.split.add_triangle(Side::Right, apex);
        }
        self.split.check_corners(0)
    }

    /// Codes any number of triangles, each with its side and corners.
    fn code_general(&mut self, wanted: &[SourceTriangle]) -> Result<(), InvalidStream> {
        let count = self.code_count(wanted.len() as u32);
        let mut previous_side = 3;
        let mut left = None;
        for i in 0..count as usize {
            let wanted = wanted.get(i).copied().unwrap_or_default();
            let contexts = &mut self.contexts.side[i.min(2)][previous_side];
            let side = Side::of(wanted.next, wanted.previous, self.split.parent);
            let side = if self.coder.bit(&mut contexts[0], side == Side::Detached) {
                Side::Detached
            } else if self.coder.bit(&mut contexts[1], side == Side::Left) {
                Side::Left
            } else {
                Side::Right
            };
            previous_side = side as usize;
            match side {
                Side::Left => {
                    let apex = self.code_apex(wanted.next, None);
                    left = left.or(apex.link_index);
                    self.split.add_triangle(side, apex);
                }
                Side::Right => {
                    let apex = self.code_apex(wanted.previous, left);
                    self.split.add_triangle(side, apex);
                }
                Side::Detached => {
                    let next = self.code_apex(wanted.next, None).vertex;
                    let previous = self.code_apex(wanted.previous, None).vertex;
                    let triangle = NewTriangle::unconnected(next, previous, side);
                    self.split.triangles.push(triangle);
                }
            }
            self.split.check_corners(i)?;
            if self.split.triangles.len() > MAX_TRIANGLES {
                return Err(InvalidStream("adds more than 2^20 triangles in one split"));
            }
        }
        Ok(())
    }

    fn code_count(&mut self, wanted: u32) -> u32 {
        let context = &mut self.contexts.count[usize::from(self.split.continued)];
        let count = self.coder.symbol(context, wanted.min(COUNT_ESCAPE));
        if count < COUNT_ESCAPE {
            return count;
        }
        let more = self.contexts.more.code(self.coder, wanted.wrapping_sub(count));
        count.saturating_add(more)
    }

    /// Codes a corner of a new triangle: a vertex of the parent's link, or any vertex.
    fn code_apex(&mut self, wanted: u32, left: Option<usize>) -> Apex {
        let size = self.split.link_len();
        let in_link = C::ENCODES && self.split.link_index_of(wanted).is_some();
        if size == 0 || !self.coder.bit(&mut self.contexts.in_link[size.min(3)], in_link) {
            self.package_bytes += 5;
            let vertex = self.coder.uniform(self.split.new + 1, wanted);
            return Apex { vertex, link_index: None };
        }
        self.code_link_apex(wanted, left)
    }

    /// Codes a vertex of the parent's link, which is not empty. `left` is the index of the first
    /// left apex, from which that of a right one is counted: the distance is the number of
    /// triangles that the parent keeps.
    fn code_link_apex(&mut self, wanted: u32, left: Option<usize>) -> Apex {
        let size = self.split.link_len();
        self.package_bytes += 1;
        let origin = left.unwrap_or(0);
        let wrap =
            |link_index: usize| if link_index >= size { link_index - size } else { link_index };
        let distance = if C::ENCODES {
            wrap(self.split.link_index_of(wanted).unwrap_or(0) + size - origin) as u32
        } else {
            0
        };
        let distance = if size <= MAX_LINK_CONTEXTS {
            let origin_kind = if left.is_none() { 0 } else { 1 + usize::from(self.split.closed) };
            let context = &mut self.contexts.place[origin_kind][size];
            // Only a crafted stream names an index beyond the link.
            self.coder.symbol(context, distance).min(size as u32 - 1) as usize
        } else {
            self.coder.uniform(size as u32, distance) as usize
        };
        let link_index = wrap(distance + origin);
        Apex { vertex: self.split.link_vertex(link_index).vertex, link_index: Some(link_index) }
    }
}
