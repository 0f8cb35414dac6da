//! Makes a `.lodc` file out of a complete stream: meshes and sequences are those of the stream,
//! distances are measured and models made anew (thesis 4.3.3).

use super::{Stream, UnpackArgs, read, summary};
use crate::exit::{Failure, Outcome, Status};
use crate::output;
use crate::progress::Progress;
use crate::stages::Stages;
use lodc::{Asset, LodFile, pipeline::Size};
use lodc_formats::ObjectInfo;
use lodc_formats::lods::Unpacker;
use lodc_mesh::Simplified;
use lodc_strip::StripOptions;
use lodc_verify::Reference;
use rayon::prelude::*;
use std::sync::Arc;

/// The objects of a stream, with the sequences that they had in their file.
type Rebuilt = Vec<(ObjectInfo, Arc<Simplified>)>;

/// Returns whether OUT asks for a file with levels, not for a mesh.
pub(super) fn is_wanted(args: &UnpackArgs) -> bool {
    let extension = args.output.extension().unwrap_or_default();
    extension.eq_ignore_ascii_case("lodc") && args.format.is_none() && !args.output.is_dir()
}

/// Writes the file of a stream.
///
/// # Errors
/// If the stream is not complete or a crafted one, if quantising has broken what a sequence
/// promises, if memory does not suffice, or the file cannot be written.
pub(super) fn run(args: &UnpackArgs) -> Outcome<Status> {
    args.models.kinds()?;
    let target = output::single_target(&args.input, Some(&args.output), "lodc")?;
    output::prepare_targets(std::slice::from_ref(&target), false)?;
    let mut stages = Stages::new(args.limits.clock(&args.input));
    let mut stream = read(args, Unpacker::new(args.limits.limits()), &mut stages)?;
    if let Some(damaged) = stream.damaged.take() {
        return Err(damaged.into());
    }
    let Stream { name, unpacker, .. } = &stream;
    if !unpacker.is_complete() {
        let what = "the stream is not complete, and a .lodc file needs all of it: a mesh does not";
        return Err(Failure::new(Status::Input, format!("{name}: {what}")));
    }
    let (simplified, mut warnings) = stages.run("rebuild", || rebuild_objects(unpacker, name))?;
    let file = measure_and_build(args, unpacker, simplified, name, &mut stages)?;
    warnings.extend(stages.take_notes());
    stages.run("write", || output::write(&target, lodc::write(&file)))?;
    let arrived = unpacker.arrived().map_err(|e| e.in_file(name))?;
    let arrived = arrived.expect("a complete stream has a head");
    summary::print(args, &stream, &arrived, warnings, &target)?;
    Ok(Status::Done)
}

/// The objects with their sequences, and a warning for each that lost triangles.
fn rebuild_objects(unpacker: &Unpacker, name: &str) -> Outcome<(Rebuilt, Vec<String>)> {
    let all: Vec<_> = (0..unpacker.objects())
        .into_par_iter()
        .map(|i| unpacker.rebuilt(i).map_err(|e| Failure::from(e.in_file(name))))
        .collect::<Outcome<_>>()?;
    let (mut objects, mut warnings) = (Vec::new(), Vec::new());
    for (number, rebuilt) in all.into_iter().enumerate() {
        let info = unpacker.info(number).clone();
        warnings.extend(super::flattened(&info.name, rebuilt.degenerate_triangles));
        objects.push((info, Arc::new(rebuilt.simplified)));
    }
    Ok((objects, warnings))
}

/// Measures distances and makes models, as `build` does.
fn measure_and_build(
    args: &UnpackArgs,
    unpacker: &Unpacker,
    simplified: Rebuilt,
    name: &str,
    stages: &mut Stages,
) -> Outcome<LodFile> {
    let meshes = simplified.iter().map(|(_, s)| s.mesh());
    let size = Size::of(meshes.map(|m| (m.triangles().len(), m.vertex_count())));
    let kinds = args.models.kinds()?;
    args.limits.check_memory(name, size, &[size.errors(), size.models(&kinds)])?;
    stages.run("verify", || check(&simplified, name))?;
    let progress = Progress::new(name);
    let document = unpacker.document().expect("a complete stream has a document").clone();
    let source = unpacker.source().expect("a complete stream has a source").clone();
    let watch = stages.watched(&progress);
    let asset = Asset::of_sequences(source, document, simplified, args.limits.limits());
    let asset = asset.measured(args.poses.max_poses(), &watch)?;
    let bug = |error: lodc::Error| {
        Failure::new(Status::Bug, format!("{name}: {error}; nothing was written"))
    };
    let asset = asset.with_models(&kinds, StripOptions::default(), &watch).map_err(bug)?;
    Ok(asset.into_file(args.models.layout(), None))
}

/// Checks every promise of the sequences: a stream may be crafted, and quantising can put vertices
/// of different wedge groups at one position.
fn check(objects: &Rebuilt, name: &str) -> Outcome<()> {
    objects.par_iter().try_for_each(|(info, simplified)| {
        let reference = Reference::new(simplified)
            .map_err(|e| Failure::new(Status::Limit, format!("{name}: {}: {e}", info.name)))?;
        let failed = reference.checks().iter().find_map(|check| check.failure.as_ref());
        let Some(what) = failed else { return Ok(()) };
        let what = format!(
            "{name}: {}: its levels do not hold ({what}), as can happen after quantising: it can \
             be unpacked as a mesh only",
            info.name
        );
        Err(Failure::new(Status::Input, what))
    })
}
