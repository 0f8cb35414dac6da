//! The stages that make and check models: strips, models, check. Without models there is none.

use super::errors::SimplifiedObjects;
use crate::levels;
use crate::progress::Progress;
use crate::stages::Stages;
use lodc::LodObject;
use lodc_lod::ModelKind;
use lodc_strip::{StripKind, StripOptions, StripPool, Strips};
use rayon::prelude::*;

/// The models that one input gets.
pub(crate) struct ModelWork<'a> {
    pub(crate) kinds: &'a [ModelKind],
    /// Triangles of all objects.
    pub(crate) triangles: u64,
    pub(crate) stages: &'a mut Stages,
    pub(crate) progress: &'a Progress,
}

impl ModelWork<'_> {
    /// Makes the models of every object, and before them the strips that they need and that are
    /// not there: `strips` has some by object, or is empty.
    ///
    /// # Errors
    /// If a model cannot be made of its sequence: a bug.
    pub(crate) fn build_all(
        &mut self,
        simplified: SimplifiedObjects,
        options: StripOptions,
        strips: Vec<Option<Strips>>,
    ) -> Result<Vec<LodObject>, String> {
        let Self { kinds, triangles, progress, .. } = *self;
        let report = &|triangles| progress.add(triangles);
        let mut pools: Vec<StripPool<'_>> =
            simplified.iter().map(|(_, s)| StripPool::new(s, options)).collect();
        for (pool, strips) in pools.iter_mut().zip(strips) {
            if let Some(strips) = strips {
                pool.add(strips);
            }
        }
        let generators: Vec<StripKind> = kinds.iter().filter_map(|kind| kind.strips()).collect();
        if !generators.is_empty() {
            let passes =
                pools.iter().map(|pool| pool.missing(&generators).len()).max().unwrap_or(0);
            progress.stage_of("strips", triangles * passes as u64);
            let make = |pool: &mut StripPool<'_>| pool.make(&generators, report);
            self.stages.run("strips", || pools.par_iter_mut().for_each(make));
        }
        let mut models = vec![vec![]; simplified.len()];
        if !kinds.is_empty() {
            progress.stage_of("models", triangles * kinds.len() as u64);
            let build = |pool: &mut StripPool<'_>| levels::models(pool, kinds, report);
            let built = || pools.par_iter_mut().map(build).collect::<Result<_, String>>();
            models = self.stages.run("models", built)?;
        }
        drop(pools);
        let object = |((info, simplified), models)| LodObject { info, simplified, models };
        Ok(simplified.into_iter().zip(models).map(object).collect())
    }

    /// Compares all models with the reference.
    ///
    /// # Errors
    /// If one differs: a bug.
    pub(crate) fn check_all(&mut self, objects: &[LodObject]) -> Result<(), String> {
        if self.kinds.is_empty() {
            return Ok(());
        }
        let progress = self.progress;
        progress.stage_of("check", self.triangles * self.kinds.len() as u64);
        let check = |object: &LodObject| levels::self_check(object, &|done| progress.add(done));
        self.stages.run("check", || objects.par_iter().try_for_each(check))
    }
}
