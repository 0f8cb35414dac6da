//! The checks of one `.lodc` file: models against the reference, stored errors against measured
//! ones, LOD 0 against the source.

use super::report::CheckReport;
use lodc::pipeline::check_errors;
use lodc::pipeline::step_errors;
use lodc::{LodFile, LodObject, stated_shapes};
use lodc_formats::import::{ImportOptions, document_difference, import};
use lodc_formats::lodc::MadeFrom;
use lodc_formats::{Document, Fault, FormatError, Limits, ObjectInfo, Scene, animation_names};
use lodc_lod::AnyModel;
use lodc_mesh::PoseKey;
use lodc_scene::ObjectShapes;
use lodc_verify::{Check, Reference, VerifyOptions, source_difference, verify};
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::Path;

/// Checks the sequence and the models of every object, several objects at once.
///
/// # Errors
/// If the stored document is damaged, or an object is more than can be verified.
pub fn check_models(
    objects: &[LodObject],
    document: &Document,
    stride: u32,
    limits: &Limits,
) -> Result<Vec<CheckReport>, FormatError> {
    check_models_by_reference(objects, document, stride, limits).map(|(checks, _)| checks)
}

/// Does the same, and returns the reference of each object as well: a device is compared with it,
/// too.
///
/// # Errors
/// As [`check_models`].
pub fn check_models_by_reference<'a>(
    objects: &'a [LodObject],
    document: &Document,
    stride: u32,
    limits: &Limits,
) -> Result<(Vec<CheckReport>, Vec<Reference<'a>>), FormatError> {
    let options = VerifyOptions { stride, ..VerifyOptions::default() };
    let shapes = stated_shapes(objects, document, limits)?;
    let check = |(o, shapes): (&'a LodObject, &ObjectShapes)| {
        let shapes = shapes.all().iter();
        let shapes: Vec<_> = shapes.map(|shape| shape.of(o.simplified.mesh())).collect();
        check_object(o, &shapes, &options)
    };
    let animations = animation_names(document, limits)?.len();
    let checked: Result<Vec<_>, FormatError> = objects.par_iter().zip(&shapes).map(check).collect();
    let (checks, references): (Vec<_>, Vec<_>) = checked?.into_iter().unzip();
    let mut checks = checks.concat();
    checks.extend(objects.iter().filter_map(|object| check_poses(object, animations)));
    Ok((checks, references))
}

/// Checks that the poses that errors are the largest over are of this file; none without any.
fn check_poses(object: &LodObject, animations: usize) -> Option<CheckReport> {
    let (poses, mesh) = (&object.info.poses, object.simplified.mesh());
    let targets = mesh.attributes().iter().filter_map(|a| a.morph_target).max();
    let unknown = poses.iter().enumerate().find_map(|(number, pose)| {
        let what = match *pose {
            PoseKey::Moment { animation, .. } if animation as usize >= animations => "an animation",
            PoseKey::Target(target) if targets.is_none_or(|last| target > last) => "a morph target",
            PoseKey::Moment { .. } | PoseKey::Target(_) => return None,
        };
        Some(format!("pose {} is of {what} that is not there", number + 1))
    });
    let report = CheckReport::new(Some(&object.info.name), "sequence", "poses are of this file");
    (!poses.is_empty()).then(|| report.of(poses.len() as u64, unknown))
}

fn check_object<'a>(
    object: &'a LodObject,
    shapes: &[Cow<'_, [[f32; 3]]>],
    options: &VerifyOptions,
) -> Result<(Vec<CheckReport>, Reference<'a>), FormatError> {
    let name = &object.info.name;
    let (reference, errors) =
        rayon::join(|| Reference::new(&object.simplified), || check_stored_errors(object, shapes));
    let reference = reference.map_err(|e| {
        let what = format!("{name}: {e}; nothing more was verified");
        FormatError::new(Fault::Limit, "", what)
    })?;
    let mut checks: Vec<_> = reference.checks().iter().map(|c| report(name, c)).collect();
    checks.push(errors);
    let replays = object.models.par_iter().with_max_len(1);
    let replayed = |model: &AnyModel| {
        let (mut checks, views) =
            rayon::join(|| verify(model, &reference, options), || model.verify_views());
        checks.extend(views);
        checks
    };
    let replays: Vec<_> = replays.map(replayed).collect();
    checks.extend(replays.iter().flatten().map(|c| report(name, c)));
    if object.models.is_empty() {
        let none = "the file has none, only the collapse sequence".to_owned();
        let models = CheckReport::new(Some(name), "models", "replay");
        checks.push(CheckReport { skipped: Some(none), ..models });
    }
    Ok((checks, reference))
}

/// Compares stored errors with measured ones; skipped if they are estimates.
fn check_stored_errors(object: &LodObject, shapes: &[Cow<'_, [[f32; 3]]>]) -> CheckReport {
    let report = CheckReport::new(Some(&object.info.name), "sequence", "errors hold");
    if !is_measured(object) {
        let what = "the errors are estimates";
        return CheckReport { skipped: Some(what.to_owned()), ..report };
    }
    let (lods, difference) = check_errors(&object.simplified, shapes);
    report.of(lods as u64, difference)
}

/// Measures stored errors again as the build does, which gives the same numbers for a file that
/// this version made. Files of other versions are not checked.
///
/// # Errors
/// If the stored document is damaged.
pub fn check_errors_again(
    file: &LodFile,
    limits: &Limits,
) -> Result<Vec<CheckReport>, FormatError> {
    if !file.made_from.as_ref().is_some_and(MadeFrom::is_of_this_version) {
        return Ok(Vec::new());
    }
    let shapes = stated_shapes(&file.objects, &file.document, limits)?;
    let triangles = |o: &LodObject| o.simplified.mesh().triangles().len();
    let all = file.objects.iter().map(triangles).sum();
    let measured = file.objects.par_iter().zip(&shapes).filter(|(o, _)| is_measured(o));
    Ok(measured.map(|(o, shapes)| errors_again(o, shapes, all)).collect())
}

fn errors_again(object: &LodObject, shapes: &ObjectShapes, scene_triangles: usize) -> CheckReport {
    let simplified = &object.simplified;
    let collapses = simplified.collapses();
    let stored = collapses.parts();
    let (remeasured, _) = step_errors(simplified, shapes, scene_triangles, &|| ());
    let differs = |stored: &[f32], remeasured: &[f32], what: &str| {
        let (step, (stored, remeasured)) = stored
            .iter()
            .zip(remeasured)
            .enumerate()
            .find(|(_, (stored, remeasured))| stored != remeasured)?;
        let lod = collapses.step(step).lod.0;
        Some(format!("LOD {lod}: the {what} is {stored}, measured again {remeasured}"))
    };
    let difference = differs(&stored.step_errors, &remeasured.error, "error")
        .or_else(|| differs(&stored.step_rms, &remeasured.rms, "root mean square distance"));
    let report = CheckReport::new(Some(&object.info.name), "sequence", "errors measured again");
    report.of(remeasured.error.len() as u64, difference)
}

fn is_measured(object: &LodObject) -> bool {
    object.simplified.collapses().is_measured()
}

fn report(object: &str, check: &Check) -> CheckReport {
    let failure = check.failure.as_ref();
    let difference = failure.map(|failure| format!("{}: {failure}", check.model));
    let report = CheckReport::new(Some(object), check.model, check.name);
    CheckReport { full: check.full, ..report.of(check.lods, difference) }
}

/// Compares LOD 0 and everything around the meshes with the source.
///
/// # Errors
/// If the mesh cannot be read, or the stored document is damaged.
pub fn check_source(
    file: &LodFile,
    source: &Path,
    options: &ImportOptions,
) -> Result<Vec<CheckReport>, FormatError> {
    let scene = import(source, options)?;
    let difference = if scene.objects.len() == file.objects.len() {
        scene.objects.iter().zip(&file.objects).find_map(|(source, stored)| {
            let what = source_difference(&source.mesh, stored.simplified.mesh());
            what.map(|what| format!("{}: {what}", stored.info.name))
        })
    } else {
        Some(format!(
            "the source has {} objects, the file {}",
            scene.objects.len(),
            file.objects.len()
        ))
    };
    let surroundings = CheckReport::new(None, "source", "nothing else changed");
    let same_kind = matches!(
        (&scene.document, &file.document),
        (Document::Gltf(_), Document::Gltf(_)) | (Document::Obj(_), Document::Obj(_))
    );
    let surroundings = if same_kind {
        surroundings.of(1, surroundings_difference(&scene, file, &options.limits)?)
    } else {
        let why = "the file was made from another format".to_owned();
        CheckReport { skipped: Some(why), ..surroundings }
    };
    Ok(vec![CheckReport::new(None, "source", "LOD 0 is the input").of(1, difference), surroundings])
}

/// The first difference between a file and its source in the document and in the descriptions of
/// objects.
fn surroundings_difference(
    scene: &Scene,
    file: &LodFile,
    limits: &Limits,
) -> Result<Option<String>, FormatError> {
    let difference = match (&scene.document, &file.document) {
        (Document::Obj(source), Document::Obj(stored)) => {
            (source != stored).then(|| "other materials or groups than the source".to_owned())
        }
        (source, stored) => document_difference(source, stored, limits)?,
    };
    let objects =
        || scene.objects.iter().map(|o| &o.info).zip(file.objects.iter().map(|o| &o.info));
    Ok(difference
        .or_else(|| objects().find_map(|(source, stored)| info_difference(source, stored))))
}

fn info_difference(source: &ObjectInfo, stored: &ObjectInfo) -> Option<String> {
    let name = &stored.name;
    if source.name != stored.name {
        return Some(format!("an object is named {name}, in the source {}", source.name));
    }
    if (source.document_mesh, &source.submeshes) != (stored.document_mesh, &stored.submeshes) {
        return Some(format!("{name}: other names, materials or places in the document"));
    }
    // Another version may have added in another order.
    let difference_of_scales = (source.world_scale - stored.world_scale).abs();
    (difference_of_scales > 1e-6 * source.world_scale.abs()).then(|| {
        format!(
            "{name}: the world scale is {}, of the source {}",
            stored.world_scale, source.world_scale
        )
    })
}
