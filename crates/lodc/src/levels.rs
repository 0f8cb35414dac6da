//! The triangles of an object at a LOD, and the LODs that tables list.

use crate::LodObject;
use lodc_lod::ModelKind;
use lodc_mesh::{CollapseSequence, Lod, OrientedTriangle};

/// The triangles of an object at a LOD, by a model or, without one, by the reference.
pub fn triangles(object: &LodObject, model: Option<ModelKind>, lod: Lod) -> Vec<OrientedTriangle> {
    match object.models.iter().find(|m| Some(m.kind()) == model) {
        Some(model) => model.triangles_at(lod),
        None => object.simplified.triangles_at(lod),
    }
}

/// Shares of the triangles for which tables list a LOD.
pub const TABLE_SHARES: [f64; 5] = [0.5, 0.25, 0.1, 0.05, 0.01];

/// The LODs that a table lists, fine to coarse: the input, the shares of [`TABLE_SHARES`], the last
/// LOD that has a triangle; each once.
pub fn table_lods(collapses: &CollapseSequence) -> Vec<Lod> {
    let triangles = f64::from(collapses.parts().triangles);
    let wanted =
        TABLE_SHARES.iter().map(|share| collapses.lod_for_triangles((share * triangles) as u32));
    let visible = collapses.last_visible();
    let mut lods: Vec<Lod> =
        std::iter::once(Lod(0)).chain(wanted.map(|l| l.min(visible))).chain([visible]).collect();
    lods.sort_unstable();
    lods.dedup();
    lods
}
