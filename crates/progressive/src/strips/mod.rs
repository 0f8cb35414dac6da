//! Triangle strips of a partial mesh: all triangles in one drawing order, cut into strips.
//!
//! A strip is a sequence of triangles. Its live triangles, in its order, are what is drawn of it at
//! any level of detail; at the end of the stream they are the strip itself. So all that a new
//! triangle needs is a position in this order. (The thesis's StripPackage sends masks over full
//! strips instead, most of whose positions show nothing yet.)
//!
//! ```text
//! drawing order   | 4  9  2 | 7  0 |      strips 0 and 1
//!                        ^
//! position of a new triangle: after 9, in strip 0
//! drawing order   | 4  9  10  2 | 7  0 |
//! ```

pub(crate) mod indices;
pub(crate) mod position_code;
pub(crate) mod strip_order;
