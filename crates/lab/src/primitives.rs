//! Triangles, triangles in cache order, long strips, cache-aware strips (thesis 3.5.3, 5.5.3).

use lodc_mesh::Mesh;
use lodc_strip::{CacheModel, StripSet, measure, order};
use serde::Serialize;

/// The triangles of LOD 0 as a graphics card gets them.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PrimitiveReport {
    /// Null for lists.
    pub strips: Option<u64>,
    /// All of them.
    pub indices: u64,
    /// As a share of the mesh's triangles.
    pub indices_per_triangle: f64,
    /// Misses per triangle of a first-in-first-out cache of 16 vertices.
    pub acmr_fifo16: f64,
}

/// Vertices that the simulated cache holds.
const CACHE: u32 = 16;

/// Any stream of indices that draws a mesh.
fn report(mesh: &Mesh, indices: &[u32], strips: Option<usize>) -> PrimitiveReport {
    let triangles = mesh.triangles().len();
    let model = CacheModel { size: CACHE, ..CacheModel::default() };
    PrimitiveReport {
        strips: strips.map(|n| n as u64),
        indices: indices.len() as u64,
        indices_per_triangle: indices.len() as f64 / triangles.max(1) as f64,
        acmr_fifo16: measure(indices.iter().copied(), mesh.vertex_count(), model).acmr(triangles),
    }
}

/// The triangles as they stand: in reverse order of their disappearance.
pub(crate) fn triangles(mesh: &Mesh) -> PrimitiveReport {
    report(mesh, mesh.triangles().as_flattened(), None)
}

/// The triangles in an order for a vertex cache.
pub(crate) fn cache_ordered(mesh: &Mesh) -> PrimitiveReport {
    report(mesh, order(mesh, CACHE).as_flattened(), None)
}

/// Strips, each drawn by itself.
#[must_use]
pub fn strips(mesh: &Mesh, strips: &StripSet) -> PrimitiveReport {
    report(mesh, strips.indices(), Some(strips.len()))
}
