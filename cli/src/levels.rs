//! The models of an object, and the triangles that one of them shows at a LOD.

use lodc::LodObject;
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{CollapseSequence, Lod, OrientedTriangle, PositionIds, TriangleHash};
use lodc_model::Model;
use lodc_strip::{Report, StripKind, StripPool};
use rayon::prelude::*;

/// The kinds that were asked for, in the order of files; all if none was named.
pub(crate) fn chosen(named: &[ModelKind]) -> Vec<ModelKind> {
    let wanted = |kind: &ModelKind| named.is_empty() || named.contains(kind);
    ModelKind::ALL.into_iter().filter(wanted).collect()
}

/// The models of an object, in the order of `kinds`, built at once. `report` gets the triangles of
/// each that is ready.
///
/// # Errors
/// If a model cannot be made of the sequence: a bug, since every sequence that a simplifier makes
/// can be modelled.
pub(crate) fn models(
    strips: &mut StripPool<'_>,
    kinds: &[ModelKind],
    report: Report<'_>,
) -> Result<Vec<AnyModel>, String> {
    let made: Vec<StripKind> = kinds.iter().filter_map(|kind| kind.strips()).collect();
    strips.make(&made, &|_| {});
    let triangles = strips.simplified().mesh().triangles().len() as u64;
    let build = |&kind: &ModelKind| {
        let model = AnyModel::build(kind, &mut strips.clone());
        report(triangles);
        model.map_err(|e| format!("{}: {e}", kind.name()))
    };
    kinds.par_iter().with_max_len(1).map(build).collect()
}

/// Compares every model of an object with the reference at a few LODs, back and forth, several
/// models at once. `report` gets the triangles of each that is through.
///
/// # Errors
/// If one differs.
pub(crate) fn self_check(object: &LodObject, report: Report<'_>) -> Result<(), String> {
    let simplified = &object.simplified;
    let collapses = simplified.collapses();
    let mut stops = table(collapses);
    stops.extend([Lod(0), collapses.last()]);
    if object.models.is_empty() {
        return Ok(());
    }
    let positions = PositionIds::new(simplified.mesh().positions());
    let reference =
        |&lod: &Lod| simplified.triangles_at_with(lod, &positions).into_iter().collect();
    let references: Vec<TriangleHash> = stops.par_iter().with_max_len(1).map(reference).collect();
    let check = |model: &AnyModel| {
        let mut cursor = model.cursor();
        for (&lod, reference) in stops.iter().zip(&references) {
            model.seek(&mut cursor, lod, &mut ());
            if model.triangles(&cursor).into_iter().collect::<TriangleHash>() != *reference {
                let (name, model) = (&object.info.name, model.name());
                return Err(format!("{name}: {model} differs from the reference at LOD {}", lod.0));
            }
        }
        report(simplified.mesh().triangles().len() as u64);
        Ok(())
    };
    object.models.par_iter().with_max_len(1).try_for_each(check)
}

/// The triangles of an object at a LOD, by a model or, without one, by the reference.
pub(crate) fn triangles(
    object: &LodObject,
    model: Option<ModelKind>,
    lod: Lod,
) -> Vec<OrientedTriangle> {
    match object.models.iter().find(|m| Some(m.kind()) == model) {
        Some(model) => model.triangles_at(lod),
        None => object.simplified.triangles_at(lod),
    }
}

/// Shares of the triangles at which tables show a LOD.
pub(crate) const TABLE: [f64; 5] = [0.5, 0.25, 0.1, 0.05, 0.01];

/// Fine to coarse: the input, the shares of [`TABLE`], the last LOD that has a triangle. Each once.
pub(crate) fn table(collapses: &CollapseSequence) -> Vec<Lod> {
    let triangles = f64::from(collapses.parts().triangles);
    let wanted = TABLE.iter().map(|share| collapses.lod_for_triangles((share * triangles) as u32));
    let visible = collapses.last_visible();
    let mut lods: Vec<Lod> =
        std::iter::once(Lod(0)).chain(wanted.map(|l| l.min(visible))).chain([visible]).collect();
    lods.sort_unstable();
    lods.dedup();
    lods
}
