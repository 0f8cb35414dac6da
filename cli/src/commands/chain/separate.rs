//! A file per level.

use super::levels::Level;
use super::{Asset, ChainArgs, Files, FormatName};
use crate::exit::{Failure, Outcome, Status};
use crate::mesh_output;
use crate::output::Target;
use lodc_formats::export::ExportObject;
use lodc_formats::lodc::LodObject;
use lodc_measure::{Sampling, Surface, distances};
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
        if args.refit {
            measure(asset, &meshes, level);
        }
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

/// Replaces the errors of a level by those of its refitted meshes: the stored ones are of the
/// vertices where they were.
fn measure(asset: &Asset, meshes: &[Mesh], level: &mut Level) {
    let several = asset.objects.len() > 1;
    let one = |(o, mesh): (&LodObject, &Mesh)| {
        let unit = if several { o.info.world_scale } else { 1.0 };
        let [from, to] = [o.simplified.mesh(), mesh].map(surface);
        let found = distances(&from, &to, &Sampling::DEFAULT);
        let larger = |pair: [f64; 2]| unit * pair[0].max(pair[1]);
        (larger(found.hausdorff), larger(found.rms))
    };
    let found = asset.objects.iter().zip(meshes).map(one);
    let (error, rms) = found.fold((0.0, 0.0), |a: (f64, f64), b| (a.0.max(b.0), a.1.max(b.1)));
    (level.error, level.rms) = (error, Some(rms));
}

fn surface(mesh: &Mesh) -> Surface {
    Surface {
        positions: mesh.positions().iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
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
