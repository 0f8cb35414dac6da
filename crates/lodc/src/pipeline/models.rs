//! The stages that make and check models: strips, models, check.

use super::Watch;
use super::watch::run_stage;
use crate::levels::table_lods;
use crate::{Error, LodObject};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Lod, Simplified, TriangleHash};
use lodc_model::Model;
use lodc_strip::{Report, StripKind, StripOptions, StripPool};
use rayon::prelude::*;

/// Makes the models of some kinds for every object, and before them the strips that they need.
///
/// # Errors
/// If a model cannot be made of its sequence: a bug.
pub fn build_models(
    mut objects: Vec<LodObject>,
    kinds: &[ModelKind],
    options: StripOptions,
    watch: &dyn Watch,
) -> Result<Vec<LodObject>, Error> {
    let triangles = triangles(objects.iter().map(|o| &*o.simplified));
    let report = &|triangles| watch.add(triangles);
    let mut pools: Vec<StripPool<'_>> =
        objects.iter().map(|o| StripPool::new(&o.simplified, options)).collect();
    let generators: Vec<StripKind> = kinds.iter().filter_map(|kind| kind.strips()).collect();
    if !generators.is_empty() {
        let passes = pools.iter().map(|pool| pool.missing(&generators).len()).max().unwrap_or(0);
        let make = |pool: &mut StripPool<'_>| pool.make(&generators, report);
        run_stage(watch, "strips", Some(triangles * passes as u64), || {
            pools.par_iter_mut().for_each(make);
        });
    }
    let mut made = vec![vec![]; objects.len()];
    if !kinds.is_empty() {
        let build = |pool: &mut StripPool<'_>| models(pool, kinds, report);
        made = run_stage(watch, "models", Some(triangles * kinds.len() as u64), || {
            pools.par_iter_mut().map(build).collect::<Result<_, _>>()
        })?;
    }
    drop(pools);
    for (object, models) in objects.iter_mut().zip(made) {
        object.models = models;
    }
    Ok(objects)
}

/// Compares all models with the reference at a few LODs, back and forth.
///
/// # Errors
/// If one differs: a bug.
pub(crate) fn check_models(objects: &[LodObject], watch: &dyn Watch) -> Result<(), Error> {
    let models = objects.iter().map(|o| o.models.len()).max().unwrap_or(0) as u64;
    if models == 0 {
        return Ok(());
    }
    let triangles = triangles(objects.iter().map(|o| &*o.simplified));
    let check = |object: &LodObject| self_check(object, &|done| watch.add(done));
    run_stage(watch, "check", Some(triangles * models), || objects.par_iter().try_for_each(check))
}

/// Triangles of all objects.
fn triangles<'a>(objects: impl Iterator<Item = &'a Simplified>) -> u64 {
    objects.map(|s| s.mesh().triangles().len() as u64).sum()
}

/// The models of an object, in the order of `kinds`, built at once. `report` is called with the
/// number of triangles for each model that is ready.
///
/// # Errors
/// If a model cannot be made of the sequence: a bug, since every sequence that a simplifier makes
/// can be modelled.
pub fn models(
    strips: &mut StripPool<'_>,
    kinds: &[ModelKind],
    report: Report<'_>,
) -> Result<Vec<AnyModel>, Error> {
    let generators: Vec<StripKind> = kinds.iter().filter_map(|kind| kind.strips()).collect();
    strips.make(&generators, &|_| {});
    let triangles = strips.simplified().mesh().triangles().len() as u64;
    let build = |&kind: &ModelKind| {
        let model = AnyModel::build(kind, &mut strips.clone());
        report(triangles);
        model.map_err(|e| Error::Bug(format!("{}: {e}", kind.name())))
    };
    kinds.par_iter().with_max_len(1).map(build).collect()
}

/// Compares every model of an object with the reference at a few LODs, back and forth, several
/// models at once. `report` is called with the number of triangles for each model that is
/// checked.
///
/// # Errors
/// If one differs.
fn self_check(object: &LodObject, report: Report<'_>) -> Result<(), Error> {
    let simplified = &object.simplified;
    let collapses = simplified.collapses();
    let mut lods = table_lods(collapses);
    lods.extend([Lod(0), collapses.last()]);
    if object.models.is_empty() {
        return Ok(());
    }
    let positions = simplified.mesh().position_ids();
    let reference =
        |&lod: &Lod| simplified.triangles_at_with(lod, &positions).into_iter().collect();
    let references: Vec<TriangleHash> = lods.par_iter().with_max_len(1).map(reference).collect();
    let check = |model: &AnyModel| {
        let mut cursor = model.cursor();
        for (&lod, reference) in lods.iter().zip(&references) {
            model.seek(&mut cursor, lod, &mut ());
            if model.triangles(&cursor).into_iter().collect::<TriangleHash>() != *reference {
                let (name, model) = (&object.info.name, model.name());
                return Err(Error::Bug(format!(
                    "{name}: {model} differs from the reference at LOD {}",
                    lod.0
                )));
            }
        }
        report(simplified.mesh().triangles().len() as u64);
        Ok(())
    };
    object.models.par_iter().with_max_len(1).try_for_each(check)
}
