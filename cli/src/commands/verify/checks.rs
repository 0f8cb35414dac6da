//! The checks of one file, as the report shows them.

use super::errors;
use super::source::first_difference;
use crate::exit::{Failure, Outcome, Status};
use crate::report::CheckReport;
use lodc_formats::import::{ImportOptions, import};
use lodc_formats::lodc::{LodFile, LodObject};
use lodc_verify::{Check, Reference, VerifyOptions, verify};
use rayon::prelude::*;
use std::path::Path;

/// Stored facts and models of every object, several objects at once.
pub(super) fn models(file: &LodFile, stride: u32) -> Outcome<Vec<CheckReport>> {
    let options = VerifyOptions { stride, ..VerifyOptions::default() };
    let checked: Outcome<Vec<_>> = file.objects.par_iter().map(|o| object(o, &options)).collect();
    Ok(checked?.concat())
}

pub(super) fn object(object: &LodObject, options: &VerifyOptions) -> Outcome<Vec<CheckReport>> {
    let name = &object.info.name;
    let reference = Reference::new(&object.simplified).map_err(|e| {
        Failure::new(Status::Limit, format!("{name}: {e}; nothing more was verified"))
    })?;
    let mut checks: Vec<_> = reference.checks().iter().map(|c| report(name, c)).collect();
    checks.push(errors::check(object));
    for model in &object.models {
        checks.extend(verify(model, &reference, options).iter().map(|c| report(name, c)));
    }
    Ok(checks)
}

fn report(object: &str, check: &Check) -> CheckReport {
    CheckReport {
        object: Some(object.to_owned()),
        model: check.model,
        check: check.name,
        device: "cpu",
        adapter: None,
        lods: check.lods,
        full: check.full,
        ok: Some(check.ok()),
        skipped: None,
        first_difference: check
            .failure
            .as_ref()
            .map(|failure| format!("{}: {failure}", check.model)),
    }
}

/// LOD 0 against the mesh it was made from.
pub(super) fn source(
    file: &LodFile,
    source: &Path,
    options: &ImportOptions,
) -> Outcome<CheckReport> {
    let scene = import(source, options)?;
    let difference = if scene.objects.len() == file.objects.len() {
        scene.objects.iter().zip(&file.objects).find_map(|(source, stored)| {
            let what = first_difference(&source.mesh, stored.simplified.mesh());
            what.map(|what| format!("{}: {what}", stored.info.name))
        })
    } else {
        Some(format!(
            "the source has {} objects, the file {}",
            scene.objects.len(),
            file.objects.len()
        ))
    };
    Ok(CheckReport {
        object: None,
        model: "source",
        check: "LOD 0 is the input",
        device: "cpu",
        adapter: None,
        lods: 1,
        full: 1,
        ok: Some(difference.is_none()),
        skipped: None,
        first_difference: difference,
    })
}
