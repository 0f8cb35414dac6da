//! Inputs of a benchmark prepared for it: simplified meshes with all models and baselines built.

use crate::error::LabError;
use lodc::LodObject;
use lodc_formats::Document;
use lodc_lod::{AnyModel, ModelKind};
use lodc_strip::{StripKind, StripOptions, StripPool, Strips};
use rayon::prelude::*;
use std::sync::Arc;

/// An input that is measured.
#[derive(Debug)]
pub struct Input {
    /// The name of its file, for messages.
    pub name: String,
    /// Its objects.
    pub objects: Vec<Prepared>,
    /// Everything in it that is not a triangle mesh.
    pub document: Document,
}

/// An object with the models to be measured, and strips of every kind.
#[derive(Debug)]
pub struct Prepared {
    pub(crate) object: LodObject,
    pub(crate) strips: [Arc<Strips>; StripKind::ALL.len()],
}

impl Prepared {
    /// Makes what an object lacks of the models of these kinds, all if none is named, and strips.
    ///
    /// # Errors
    /// If a model cannot be made of its sequence: a bug.
    pub fn new(
        mut object: LodObject,
        named: &[ModelKind],
        options: StripOptions,
    ) -> Result<Self, LabError> {
        let simplified = Arc::clone(&object.simplified);
        let mut pool = StripPool::new(&simplified, StripOptions { kind: None, ..options });
        // Not those of a file: its models may have cut them, or been made with another effort.
        pool.make(&StripKind::ALL, &|_| {});
        let strips = StripKind::ALL.map(|kind| pool.get(kind));
        let models = &mut object.models;
        models.retain(|m| named.is_empty() || named.contains(&m.kind()));
        let mut kinds: Vec<ModelKind> = ModelKind::ALL.to_vec();
        kinds.retain(|kind| named.is_empty() || named.contains(kind));
        kinds.retain(|&kind| models.iter().all(|m| m.kind() != kind));
        if options.kind.is_some() {
            pool = StripPool::new(&simplified, options);
            let made: Vec<StripKind> = kinds.iter().filter_map(|kind| kind.strips()).collect();
            pool.make(&made, &|_| {});
        }
        let name = &object.info.name;
        let build = |&kind: &ModelKind| {
            AnyModel::build(kind, &mut pool.clone())
                .map_err(|e| LabError::Bug(format!("{name}: {}: {e}", kind.name())))
        };
        let made: Vec<AnyModel> =
            kinds.par_iter().with_max_len(1).map(build).collect::<Result<_, _>>()?;
        models.extend(made);
        models.sort_by_key(AnyModel::kind);
        Ok(Self { object, strips })
    }

    /// The object.
    #[must_use]
    pub fn object(&self) -> &LodObject {
        &self.object
    }

    /// The strips of one kind.
    pub(crate) fn strips(&self, kind: StripKind) -> &Arc<Strips> {
        self.strips.iter().find(|strips| strips.kind == kind).expect("there are some of every kind")
    }
}
