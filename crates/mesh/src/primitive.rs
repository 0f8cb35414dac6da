//! Conventions for indices that every stage shares.

/// The index that means "none": no vertex, triangle, edge or neighbour.
pub const NONE: u32 = u32::MAX;

/// Returns whether a triangle names one index twice: such a triangle draws nothing.
///
/// With position numbers ([`crate::PositionIds`]) or keys ([`crate::position_key`]) instead of
/// vertices: whether two corners are at one position.
#[must_use]
#[inline]
pub fn is_degenerate<T: PartialEq>([a, b, c]: [T; 3]) -> bool {
    a == b || b == c || c == a
}
