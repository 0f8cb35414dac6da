//! A file per level.

use super::levels::Level;
use super::{ChainArgs, Files, provenance};
use crate::commands::asset::Asset;
use crate::compression::Packing;
use crate::exit::Outcome;
use crate::mesh_output::{self, FormatName};
use crate::output::Target;
use lodc::{
    build::{Paints, refitted_meshes},
    level_mesh::{self, Shape},
};
use lodc_formats::export::Additions;
use std::path::{Path, PathBuf};

pub(super) fn files(
    args: &ChainArgs,
    paints: Option<&Paints>,
    out: &Path,
    format: FormatName,
    asset: &Asset,
    levels: &mut [Level],
    mut additions: Additions,
) -> Outcome<Files> {
    let (mut files, mut of_level) = (Vec::new(), Vec::new());
    let order = Packing::of(&additions).order();
    let shape = Shape { model: None, order };
    for (number, level) in levels.iter_mut().enumerate() {
        let mut meshes = match paints {
            Some(paints) => refitted_meshes(&asset.objects, &level.lods, order, paints),
            None => level_mesh::meshes(&asset.objects, &level.lods, shape)?,
        };
        let precision = additions.precision;
        level_mesh::round(&asset.objects, &asset.document, &mut meshes, precision)?;
        // Of refitted meshes they are measured.
        (level.error, level.rms) = level_mesh::distance(&asset.objects, &meshes);
        level.vertices = meshes.iter().map(|m| m.mesh.vertex_count() as u64).sum();
        let objects = level_mesh::exported(&asset.objects, &meshes);
        let path = numbered(out, number);
        let target = Target::File(path.clone());
        additions.provenance = Some(provenance(args, asset, std::slice::from_ref(level)));
        files.extend(mesh_output::files(&target, format, &asset.document, &objects, &additions)?);
        // All levels share the copies.
        additions.textures.copies.clear();
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
