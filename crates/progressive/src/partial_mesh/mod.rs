//! The mesh so far: connectivity that vertex splits refine, alike on both sides of a stream.
//!
//! # Corners, stars and links
//!
//! A corner is a vertex of a triangle. Each vertex has a list of its corners; seen from it, the
//! triangles of that list are its *star*. Each triangle (v, a, b) of the star, counter-clockwise,
//! has one edge a → b opposite v; these edges form the *link* of v.
//!
//! ```text
//!           q <----- p             star of v, by its corner list:
//!          / \     / ^               0: (v, s, p)   1: (v, p, q)
//!         /   \ 1 /   \              2: (v, q, r)
//!        v  2  \ /  0  \
//!       r ----- v ----- s          link of v: s -> p -> q -> r
//!
//!   link vertex   outgoing edge in    incoming edge in
//!       s            triangle 0             -
//!       p            triangle 1         triangle 0
//!       q            triangle 2         triangle 1
//!       r                -              triangle 2
//! ```
//!
//! A star is one or several fans. A triangle continues a fan if its `a` is the `b` of the triangle
//! before. A fan is closed if its last `b` is its first `a`; the link then lists that vertex once.
//! The link lists the vertices fan by fan, so it may name a vertex more than once.
//!
//! # Splits
//!
//! A vertex split inserts a vertex beside its *parent*. Some triangles of the parent's star are
//! transferred to the new vertex: their corner at the parent moves there. New triangles fill the
//! gap between the two. The figure is at the top of `lib.rs`.

pub(crate) mod corner_lists;
mod long_lists;
pub(crate) mod mesh;
pub(crate) mod new_triangle;
pub(crate) mod split;
pub(crate) mod star;
#[cfg(test)]
mod tests;
