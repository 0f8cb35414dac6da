//! The nearest triangle to a point.
//!
//! [`TriangleTree`] keeps its triangles; [`MovingTree`] asks for them ([`Triangles`]), so that
//! those of a mesh under simplification may move and die. Both are trees of boxes; a search may
//! begin at a triangle that is probably near. [`FarthestSearch`] bounds the distance between two
//! surfaces with them.
//!
//! ```
//! use glam::DVec3;
//! use lodc_nearest::TriangleTree;
//!
//! let square = [DVec3::ZERO, DVec3::X, DVec3::ONE.with_z(0.0), DVec3::Y];
//! let [a, b, c, d] = square;
//! let tree = TriangleTree::new(&[[a, b, c], [a, c, d]]);
//! assert_eq!(tree.distance_squared(DVec3::new(0.25, 0.5, 2.0)), 4.0);
//! ```

mod bounds;
mod capsule;
mod farthest;
mod morton;
mod moving;
mod polygon;
mod sah;
mod surface;
mod tree;
mod triangle;

pub use farthest::{Farthest, FarthestSearch, TriangleSearcher};
pub use morton::morton_order;
pub use moving::{Hit, MovingTree, Query, Triangles};
pub use surface::{MovingSurface, Surface};
pub use tree::{Nearest, TriangleTree};
pub use triangle::{
    area, centroid, closest, distance_squared, is_within, longest_edge_squared, point_at,
};
