//! A part of a mesh with one material.

/// A part of a mesh with one material: a run of its triangles.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Submesh {
    /// The index of its first triangle in [`Mesh::triangles`](crate::Mesh::triangles).
    pub first_triangle: u32,
    /// Number of its triangles.
    pub triangle_count: u32,
    /// Attribute streams that its vertices have, as indices into
    /// [`Mesh::attributes`](crate::Mesh::attributes).
    pub attributes: Vec<u32>,
}

impl Submesh {
    /// Its triangles, as a range of indices.
    #[must_use]
    pub fn triangles(&self) -> std::ops::Range<usize> {
        let first = self.first_triangle as usize;
        first..first + self.triangle_count as usize
    }
}
