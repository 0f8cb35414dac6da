//! A file per level.

use super::levels::Level;
use super::{Asset, ChainArgs, Files, FormatName};
use crate::exit::{Failure, Outcome, Status};
use crate::mesh_output;
use crate::output::Target;
use lodc_formats::export::ExportObject;
use lodc_formats::lodc::LodObject;
use lodc_mesh::{Lod, Mesh};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

pub(super) fn files(
    args: &ChainArgs,
    format: FormatName,
    asset: &Asset,
    levels: &mut [Level],
) -> Outcome<Files> {
    let (mut files, mut of_level) = (Vec::new(), Vec::new());
    for (number, level) in levels.iter_mut().enumerate() {
        let one = |(o, &lod): (&LodObject, &Lod)| mesh(args, o, lod);
        let meshes: Vec<Mesh> =
            asset.objects.par_iter().zip(&level.lods).map(one).collect::<Outcome<_>>()?;
        level.vertices = meshes.iter().map(|m| m.vertex_count() as u64).sum();
        let objects: Vec<ExportObject<'_>> = asset
            .objects
            .iter()
            .zip(&meshes)
            .map(|(o, mesh)| ExportObject { info: &o.info, mesh })
            .collect();
        let path = numbered(&args.output, number);
        let target = Target::File(path.clone());
        files.extend(mesh_output::files(&target, format, &asset.document, &objects)?);
        of_level.push(path);
    }
    Ok(Files { files, of_level })
}

/// `part.glb` becomes `part_LOD2.glb`.
fn numbered(output: &Path, level: usize) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_LOD{level}"));
    if let Some(extension) = output.extension() {
        name.push(".");
        name.push(extension);
    }
    output.with_file_name(name)
}

fn mesh(args: &ChainArgs, object: &LodObject, lod: Lod) -> Outcome<Mesh> {
    if args.refit {
        return Ok(lodc_refit::refit(&object.simplified, lod, &lodc_refit::Options::DEFAULT));
    }
    object.simplified.mesh().extract(&object.simplified.triangles_at(lod)).map_err(|e| {
        Failure::new(Status::Bug, format!("{}: LOD {} is no mesh: {e}", object.info.name, lod.0))
    })
}
