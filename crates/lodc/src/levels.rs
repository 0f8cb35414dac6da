//! The triangles that an object shows at a LOD, and the LODs that tables show.

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

/// Shares of the triangles at which tables show a LOD.
pub const TABLE: [f64; 5] = [0.5, 0.25, 0.1, 0.05, 0.01];

/// Fine to coarse: the input, the shares of [`TABLE`], the last LOD that has a triangle. Each once.
pub fn table(collapses: &CollapseSequence) -> Vec<Lod> {
    let triangles = f64::from(collapses.parts().triangles);
    let wanted = TABLE.iter().map(|share| collapses.lod_for_triangles((share * triangles) as u32));
    let visible = collapses.last_visible();
    let mut lods: Vec<Lod> =
        std::iter::once(Lod(0)).chain(wanted.map(|l| l.min(visible))).chain([visible]).collect();
    lods.sort_unstable();
    lods.dedup();
    lods
}
