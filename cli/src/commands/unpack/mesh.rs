//! Writes the mesh of a stream, complete or cut off anywhere, as a mesh file.

use super::{Stream, UnpackArgs, read, summary};
use crate::exit::{Failure, Outcome, Status};
use crate::mesh_output;
use crate::output;
use crate::stages::Stages;
use lodc_formats::FormatError;
use lodc_formats::export::{ExportObject, export};
use lodc_formats::lods::{Arrived, Unpacker};
use lodc_mesh::Mesh;

/// Writes what has come of a stream as a mesh.
///
/// # Errors
/// If nothing has come, the stream is damaged (the part before the damage is written) or not
/// complete though it should be, or the mesh cannot be written.
pub(super) fn run(args: &UnpackArgs) -> Outcome<Status> {
    if args.json && output::is_standard_stream(&args.output) {
        return Err(Failure::usage("the mesh and the JSON cannot both go to standard output"));
    }
    let format = mesh_output::format(&args.output, args.format, output::is_folder(&args.output))?;
    let target = output::single_target(&args.input, Some(&args.output), format.extension())?;
    output::prepare_targets([&target], output::is_folder(&args.output))?;
    let mut stages = Stages::new(args.limits.clock(&args.input));
    let unpacker = Unpacker::new(args.limits.limits());
    let stream = read(args, unpacker, &mut stages)?;
    let arrived = arrived(args, &stream)?;
    let (meshes, warnings) = meshes(&stream.unpacker).map_err(|e| e.in_file(&stream.name))?;
    let objects: Vec<_> = (meshes.iter().enumerate())
        .map(|(i, mesh)| ExportObject { info: &arrived.infos[i], mesh })
        .collect();
    let document = &arrived.document;
    let files = stages.run("export", || {
        export(&mesh_output::path(&target, format), format.export_format(), document, &objects)
    })?;
    stages.run("write", || mesh_output::write(&target, files))?;
    summary::print(args, &stream, &arrived, warnings, &target)?;
    match stream.damaged {
        None => Ok(Status::Done),
        Some(error) => {
            let mut failure = Failure::from(error);
            failure.message += "; what came before it was written";
            Err(failure)
        }
    }
}

/// Returns the mesh of each object so far, and a warning for each that lost triangles.
fn meshes(unpacker: &Unpacker) -> Result<(Vec<Mesh>, Vec<String>), FormatError> {
    let (mut meshes, mut warnings) = (Vec::new(), Vec::new());
    for object in 0..unpacker.objects() {
        let (mesh, cleaning) = unpacker.mesh(object)?;
        let name = &unpacker.info(object).name;
        warnings.extend(super::flattened(name, cleaning.degenerate_triangles));
        meshes.push(mesh);
    }
    Ok((meshes, warnings))
}

/// Returns the document and the names so far; an error if nothing can be written.
fn arrived<'a>(args: &UnpackArgs, stream: &'a Stream) -> Outcome<Arrived<'a>> {
    let Stream { name, unpacker, damaged } = stream;
    if let (Some(error), true) = (damaged, args.whole || unpacker.objects() == 0) {
        return Err(Failure::from(error.clone()));
    }
    if args.whole && !unpacker.is_complete() {
        return Err(Failure::new(Status::Input, format!("{name}: the stream is not complete")));
    }
    let arrived = unpacker.arrived().map_err(|e| Failure::from(e.in_file(name)))?;
    let is_empty = unpacker.objects() == 0 && !unpacker.is_complete();
    arrived.filter(|_| !is_empty).ok_or_else(|| {
        Failure::new(
            Status::Input,
            format!("{name}: the stream ends before there is anything to show"),
        )
    })
}
