//! Removes elements of a strip in the buffer of all strips, and puts them back (thesis 3.4).

use crate::trace::{Removal, RemovalKind};

/// The part of the buffer of all strips that a strip fills.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Where the strip starts at LOD 0; offsets of removals count from here.
    pub(super) room: u32,
    pub(super) start: u32,
    pub(super) end: u32,
}

/// Removes elements. Returns how many others move.
pub(super) fn remove(indices: &mut [u32], span: &mut Span, removal: Removal) -> u64 {
    let offset = span.room + removal.offset;
    if removal.kind == RemovalKind::Front {
        span.start += removal.count;
        return 0;
    }
    indices.copy_within((offset + removal.count) as usize..span.end as usize, offset as usize);
    span.end -= removal.count;
    (span.end - offset).into()
}

/// Puts elements back: copies of what precedes them, or what was left at the ends. Returns how
/// many elements are written.
pub(super) fn restore(indices: &mut [u32], span: &mut Span, removal: Removal) -> u64 {
    if removal.kind == RemovalKind::Front {
        span.start -= removal.count;
        return 0;
    }
    let offset = (span.room + removal.offset) as usize;
    let (period, behind) = (removal.kind.period() as usize, offset + removal.count as usize);
    indices.copy_within(offset..span.end as usize, behind);
    if removal.kind != RemovalKind::Back {
        for i in offset..behind {
            indices[i] = indices[i - period];
        }
    }
    span.end += removal.count;
    u64::from(span.end) - offset as u64
}
