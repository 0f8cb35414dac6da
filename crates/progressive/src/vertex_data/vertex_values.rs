//! The values of all vertices so far, as indices of number systems, and the neighbours from which
//! those of a new vertex are predicted.

use crate::vertex_data::vertex_layout::{AttributeStream, VertexLayout};
use std::ops::Range;

/// The vertices from which the values of a new one are predicted.
#[derive(Clone, Debug)]
pub(crate) struct Neighbourhood<'a> {
    pub(crate) parent: u32,
    /// The other wedges so far: earlier vertices of the same step at the same position.
    pub(crate) siblings: Range<u32>,
    /// The vertices around the new one.
    pub(crate) link: &'a [u32],
    /// The apexes (third corners) of the first left and the first right new triangle; the parent
    /// for a side without one.
    pub(crate) apexes: [u32; 2],
}

/// The values of all vertices so far.
#[derive(Clone, Debug)]
pub(crate) struct VertexValues {
    pub(crate) layout: VertexLayout,
    /// The channels of each vertex as indices of their number systems.
    pub(crate) indices: Vec<i32>,
}

impl VertexValues {
    pub(crate) fn new(layout: VertexLayout) -> Self {
        Self { layout, indices: Vec::new() }
    }

    pub(crate) fn channels(&self) -> usize {
        self.layout.systems.len()
    }

    /// Returns the indices of a vertex's channels in a stream.
    pub(super) fn stream_indices(&self, vertex: u32, stream: &AttributeStream) -> &[i32] {
        &self.indices[vertex as usize * self.channels() + stream.first_channel..][..stream.channels]
    }
}
