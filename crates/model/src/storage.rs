//! Storage as Ripollés's thesis (2009) counts it: words of four bytes per vertex (tables 3.1, 4.2,
//! 4.3, 5.1).

use lodc_mesh::Simplified;

/// The storage of a model, in bytes: geometry, triangles or strips, and the model's own
/// structures. Attributes other than normals are left out, as in the thesis; what a file really
/// holds is counted by `lodc-formats`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StorageCost {
    /// Vertices that triangles of LOD 0 use: the `v` of the thesis's tables.
    pub vertices: u64,
    /// Vertices that the simplifier added.
    pub fakes: u64,
    /// Three words for each vertex, fakes included where the model needs them.
    pub positions: u64,
    /// Three more words for each of these vertices; counted in chapter 4 only.
    pub normals: u64,
    /// Triangle or strip indices.
    pub primitives: u64,
    /// Everything else: what makes it a multiresolution model.
    pub structures: u64,
}

impl StorageCost {
    /// The mesh of LOD 0 as a plain triangle list: `3v + 3f` words, no levels of detail.
    #[must_use]
    pub fn of_triangles(simplified: &Simplified) -> Self {
        let fakes = simplified.fakes() as u64;
        let vertices = simplified.mesh().vertex_count() as u64 - fakes;
        let primitives = 12 * simplified.mesh().triangles().len() as u64;
        Self {
            vertices,
            fakes,
            positions: 12 * vertices,
            normals: 12 * vertices,
            primitives,
            structures: 0,
        }
    }

    /// The mesh of LOD 0 as plain strips, each drawn by itself: `3v + I` words for `I` indices.
    #[must_use]
    pub fn of_strips(simplified: &Simplified, indices: u64) -> Self {
        Self { primitives: 4 * indices, ..Self::of_triangles(simplified) }
    }

    /// Bytes as the thesis counts them with positions only (chapters 3 and 5).
    #[must_use]
    pub fn thesis_bytes(&self) -> u64 {
        self.positions + self.primitives + self.structures
    }

    /// Bytes as the thesis counts them with normals (chapter 4).
    #[must_use]
    pub fn thesis_bytes_with_normals(&self) -> u64 {
        self.thesis_bytes() + self.normals
    }

    /// Bits per vertex of LOD 0, positions only; 0 without vertices.
    #[must_use]
    pub fn thesis(&self) -> f64 {
        self.bits_per_vertex(self.thesis_bytes())
    }

    /// Bits per vertex of LOD 0, with normals; 0 without vertices.
    #[must_use]
    pub fn thesis_normals(&self) -> f64 {
        self.bits_per_vertex(self.thesis_bytes_with_normals())
    }

    /// Any number of bytes as bits per vertex of LOD 0; 0 without vertices.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        reason = "a ratio for people; counts stay far below 2^53"
    )]
    pub fn bits_per_vertex(&self, bytes: u64) -> f64 {
        if self.vertices == 0 { 0.0 } else { 8.0 * bytes as f64 / self.vertices as f64 }
    }
}
