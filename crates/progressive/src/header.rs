//! The header of an object in a stream: what a decoder needs before the first vertex. It is
//! everything but vertices and triangles.

use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::vertex_layout::VertexLayout;
use lodc_mesh::{Attribute, Simplified, Submesh};

/// The header of an object: everything but its vertices and triangles.
#[derive(Clone, Debug)]
pub struct MeshHeader {
    /// The submeshes, without triangles.
    pub submeshes: Vec<Submesh>,
    /// The attributes, without bytes.
    pub attributes: Vec<Attribute>,
    /// The values of a vertex (position and attributes) and their number systems.
    pub layout: VertexLayout,
    /// Vertices of the whole object, at the end of the stream.
    pub vertices: u32,
    /// Triangles of the whole object, at the end of the stream.
    pub triangles: u32,
    /// Steps: one for each collapse after the points (the vertices before the first triangle), and
    /// one for each wedge group with points that no split has needed.
    pub steps: u32,
    /// True if steps come in the order of the collapse sequence, each with its parent and errors;
    /// else they come in batches, each with the errors at its end.
    pub exact: bool,
}

impl MeshHeader {
    /// The header of a simplified mesh that is coded in `steps` steps.
    pub(crate) fn new(
        simplified: &Simplified,
        layout: VertexLayout,
        steps: u32,
        exact: bool,
    ) -> Self {
        let mesh = simplified.mesh();
        let submesh = |s: &Submesh| Submesh { first_triangle: 0, triangle_count: 0, ..s.clone() };
        let vertices = mesh.vertex_count() as u32;
        Self {
            submeshes: mesh.submeshes().iter().map(submesh).collect(),
            attributes: mesh.attributes().iter().map(Attribute::described).collect(),
            layout,
            vertices,
            triangles: mesh.triangles().len() as u32,
            steps,
            exact,
        }
    }

    /// A header without vertices, for an object whose header has not been read: only the number of
    /// its submeshes is known.
    #[must_use]
    pub fn unknown(submeshes: usize) -> Self {
        Self {
            submeshes: vec![Submesh::default(); submeshes],
            attributes: Vec::new(),
            layout: VertexLayout {
                systems: vec![NumberSystem::Float; 3],
                streams: VertexLayout::streams(&[], &[]),
            },
            vertices: 0,
            triangles: 0,
            steps: 0,
            exact: true,
        }
    }
}
