//! Triangles, triangles in cache order, long strips, cache-aware strips (thesis 3.5.3, 5.5.3, table
//! 5.3): at LOD 0, and what they have become where a fifth of the triangles is left.

use crate::error::LabError;
use crate::prepared::Prepared;
use indexmap::IndexMap;
use lodc_lod::Speed;
use lodc_mesh::{Lod, Mesh, NONE, Simplified, is_degenerate};
use lodc_model::Model;
use lodc_strip::{CacheModel, StripSet, measure, order, restart_list};
use serde::Serialize;

/// The triangles of a level as a graphics card gets them.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PrimitiveReport {
    /// Null for lists.
    pub strips: Option<u64>,
    /// All of them, strips drawn one by one.
    pub indices: u64,
    /// As a share of the level's triangles.
    pub indices_per_triangle: f64,
    /// Misses per triangle of a first-in-first-out cache of 16 vertices.
    pub acmr_fifo16: f64,
}

/// Vertices that the simulated cache holds.
const CACHE: u32 = 16;

/// Besides LOD 0, primitives are measured where one triangle in this many is left.
const ONE_TRIANGLE_IN: u32 = 5;

/// One way to draw a level.
pub(crate) struct Primitive {
    pub(crate) name: &'static str,
    /// Three for a triangle, or strips that are each followed by [`NONE`].
    pub(crate) indices: Vec<u32>,
    /// True if the indices are those of strips.
    pub(crate) strips: bool,
}

impl Primitive {
    /// Figures of a level with a number of triangles.
    pub(crate) fn report(&self, mesh: &Mesh, triangles: usize) -> PrimitiveReport {
        let drawn = || self.indices.iter().copied().filter(|&v| v != NONE);
        let indices = drawn().count();
        let model = CacheModel { size: CACHE, ..CacheModel::default() };
        PrimitiveReport {
            strips: self.strips.then(|| (self.indices.len() - indices) as u64),
            indices: indices as u64,
            indices_per_triangle: indices as f64 / triangles.max(1) as f64,
            acmr_fifo16: measure(drawn(), mesh.vertex_count(), model).acmr(triangles),
        }
    }
}

/// Strips of LOD 0, each drawn by itself.
#[must_use]
pub fn strips(mesh: &Mesh, strips: &StripSet) -> PrimitiveReport {
    let indices = restart_list(strips.iter());
    Primitive { name: "strips", indices, strips: true }.report(mesh, mesh.triangles().len())
}

/// The LODs at which primitives are measured: 0, and where a fifth of the triangles is left.
pub(crate) fn lods(simplified: &Simplified) -> [Lod; 2] {
    let collapses = simplified.collapses();
    let fifth = collapses.lod_for_triangles(collapses.parts().triangles / ONE_TRIANGLE_IN);
    [Lod(0), fifth.min(collapses.last_visible())]
}

/// Every way to draw a level. At other LODs than 0 each is what that of LOD 0 has become: lists
/// keep their order, strips are Speed Strips.
///
/// # Errors
/// If strips cannot follow the sequence: a bug.
pub(crate) fn all(prepared: &Prepared, lod: Lod) -> Result<Vec<Primitive>, LabError> {
    let simplified = &prepared.object.simplified;
    let mesh = simplified.mesh();
    let positions = mesh.position_ids();
    let resolved = simplified.collapses().resolve_all(lod);
    let list = |name, triangles: &[[u32; 3]]| {
        let level = triangles.iter().map(|t| t.map(|v| resolved[v as usize]));
        let live = level.filter(|t| !is_degenerate(t.map(|v| positions.of_vertex[v as usize])));
        Primitive { name, indices: live.flatten().collect(), strips: false }
    };
    let mut all =
        vec![list("triangles", mesh.triangles()), list("triangles_cache", &order(mesh, CACHE))];
    for strips in &prepared.strips {
        let indices = if lod == Lod(0) {
            restart_list(strips.iter())
        } else {
            let failed = |e| LabError::Bug(format!("{}: {e}", prepared.object.info.name));
            let model = Speed::build(simplified, strips.clone()).map_err(failed)?;
            let mut cursor = model.cursor();
            model.seek(&mut cursor, lod, &mut ());
            model.strip_list(&cursor).expect("Speed Strips are strips")
        };
        all.push(Primitive { name: strips.kind.name(), indices, strips: true });
    }
    Ok(all)
}

/// The figures of all primitives of a level.
pub(crate) fn reports(
    simplified: &Simplified,
    lod: Lod,
    all: &[Primitive],
) -> IndexMap<&'static str, PrimitiveReport> {
    let triangles = simplified.collapses().triangles_at(lod) as usize;
    all.iter().map(|p| (p.name, p.report(simplified.mesh(), triangles))).collect()
}
