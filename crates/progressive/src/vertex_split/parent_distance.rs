//! Coding of a vertex's parent as its distance from another vertex: forwards in stream order, and
//! from the last vertex on to the first.

use crate::entropy::coder::Coder;
use crate::vertex_split::contexts::Contexts;

/// The distance from one vertex to a parent, modulo the number of vertices.
pub(super) struct ParentDistance {
    pub(super) from: u32,
    /// Number of vertices so far.
    pub(super) vertices: u32,
}

impl ParentDistance {
    /// Codes the distance and returns the parent.
    pub(super) fn code<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut Contexts,
        wanted: u32,
    ) -> u32 {
        let Self { from, vertices } = *self;
        let distance = if wanted >= from { wanted - from } else { wanted + vertices - from };
        let distance = contexts.parent.code(coder, vertices, distance);
        let to_end = vertices - from;
        if distance >= to_end { distance - to_end } else { from + distance }
    }
}
