//! Elements taken out of a strip and put back (thesis 3.4).

use crate::trace::{Kind, Removal};

/// The place of a strip in the buffer of all strips.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Start of its room; places of removals count from here.
    pub(super) room: u32,
    pub(super) start: u32,
    pub(super) end: u32,
}

/// Takes elements out. Returns how many others move.
pub(super) fn remove(indices: &mut [u32], span: &mut Span, removal: Removal) -> u64 {
    let at = span.room + removal.at;
    if removal.kind == Kind::Front {
        span.start += removal.count;
        return 0;
    }
    indices.copy_within((at + removal.count) as usize..span.end as usize, at as usize);
    span.end -= removal.count;
    (span.end - at).into()
}

/// Puts elements back: copies of what precedes them, or what was left at the ends. Returns how
/// many elements are written.
pub(super) fn restore(indices: &mut [u32], span: &mut Span, removal: Removal) -> u64 {
    if removal.kind == Kind::Front {
        span.start -= removal.count;
        return 0;
    }
    let at = (span.room + removal.at) as usize;
    let (period, behind) = (removal.kind.period() as usize, at + removal.count as usize);
    indices.copy_within(at..span.end as usize, behind);
    if removal.kind != Kind::Back {
        for i in at..behind {
            indices[i] = indices[i - period];
        }
    }
    span.end += removal.count;
    u64::from(span.end) - at as u64
}
