//! Writes a chain as separate files, one for each level.

use super::geomorph::{self, GeomorphShapes, MovingMesh};
use super::levels::ChosenLevel;
use super::written::Stated;
use super::{ChainArgs, Chained, Files, provenance};
use crate::compression::EncodeOptions;
use crate::exit::Outcome;
use crate::mesh_output::FormatName;
use lodc::Asset;
use lodc::Rounding;
use lodc::geomorph::{MorphingLevel, morphing_levels, with_staying};
use lodc::level_mesh::{self, LevelMesh, MeshOptions, Order};
use lodc::pipeline::Way;
use lodc_formats::export::ExportOptions;
use lodc_formats::gltf::{ChainObject, ChainShape, Geomorph, export_chain};
use lodc_mesh::{LevelTriangles, Lod, Mesh, Submesh};
use lodc_strip::{codec_order_list, order_list};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

pub(super) fn files(
    out: &Path,
    format: FormatName,
    chained: Chained<'_>,
    levels: &mut [ChosenLevel],
    mut options: ExportOptions,
) -> Outcome<Files> {
    let Chained { asset, .. } = chained;
    let (mut files, mut of_level) = (Vec::new(), Vec::new());
    let (mut left_out, mut warnings) = (None, Vec::new());
    let order = EncodeOptions::of(&options).order();
    for (number, level) in levels.iter_mut().enumerate() {
        let meshes = meshes(asset, level, order)?;
        level.vertices = meshes.iter().map(|m| m.mesh.vertex_count() as u64).sum();
        let path = numbered(out, number);
        let made = asset.level_of(level.lod().map(Lod)).files(
            &meshes,
            &path,
            format.export_format(),
            &mut options,
        )?;
        warnings.extend(made.warnings.iter().map(|line| format!("level {number}: {line}")));
        warnings.extend(chained.state(number, level, &made.of_objects));
        left_out = left_out.or(made.left_out);
        files.extend(made.files);
        // All levels share the copies.
        options.textures.copies.clear();
        of_level.push(path);
    }
    warnings.splice(0..0, left_out);
    Ok(Files { files, of_level, warnings })
}

/// The meshes of the objects at a level, with its distances.
fn meshes(asset: &Asset, level: &mut ChosenLevel, order: Order) -> Outcome<Vec<LevelMesh>> {
    if let Some(refitted) = level.refitted.take() {
        return Ok(refitted);
    }
    let shape = MeshOptions { model: None, order };
    let mut meshes = level_mesh::meshes(&asset.objects, &level.lods, shape)?;
    for (mesh, distance) in meshes.iter_mut().zip(&level.distances) {
        (mesh.error, mesh.rms) = (distance.error, distance.rms);
    }
    Ok(meshes)
}

/// The levels, each on its way to the next one's vertices: in its file the vertices that disappear
/// last come first.
pub(super) fn morphing_files(
    args: &ChainArgs,
    out: &Path,
    format: FormatName,
    chained: Chained<'_>,
    levels: &mut [ChosenLevel],
    mut options: ExportOptions,
) -> Outcome<Files> {
    let Chained { asset, .. } = chained;
    let limits = args.export.import.limits().limits();
    let (objects, document) = (&asset.objects, &asset.document);
    let order = Order::File;
    let mut all: Vec<Vec<LevelMesh>> = Vec::new();
    let mut stated = Stated::default();
    for (number, level) in levels.iter_mut().enumerate() {
        let meshes = meshes(asset, level, order)?;
        let meshes_only = meshes.iter().map(|m| &m.mesh);
        let (stored, precision) = (format.export_format(), options.precision);
        let rounding = Rounding::new(objects, document, meshes_only, stored, precision)?;
        let triangles: Vec<&[[u32; 3]]> = meshes.iter().map(|m| m.mesh.triangles()).collect();
        stated.add(chained, &rounding, (number, level), &triangles);
        level.vertices = meshes.iter().map(|m| m.mesh.vertex_count() as u64).sum();
        all.push(meshes);
    }
    let moved_streams = args.geomorph.moved_streams().unwrap_or_default();
    let shapes = GeomorphShapes::new(asset, &limits)?;
    let of_object = |o: usize| {
        let of_levels: Vec<_> = (0..all.len()).map(|k| (levels[k].lods[o], &all[k][o])).collect();
        let mut morphing = morphing_levels(&objects[o], &of_levels, args.refit)?;
        let judge = shapes.judge(asset, o);
        let mut staying = vec![0; morphing.len()];
        for (k, own) in morphing.iter_mut().enumerate().take(of_levels.len() - 1) {
            let Some(judge) = &judge else { break };
            let way = Way {
                now: &own.mesh,
                next: &own.next,
                triangles: own.mesh.triangles(),
                moving: own.moving.clone(),
                takes_joints: moved_streams.joints,
                error: geomorph::larger_error(levels, k, o),
            };
            let vertices = judge.staying(&way);
            staying[k] = vertices.len() as u64;
            own.next = with_staying(&own.mesh, own.next.clone(), &vertices);
        }
        Ok((morphing, staying))
    };
    let made: Vec<(Vec<MorphingLevel>, Vec<u64>)> =
        (0..objects.len()).into_par_iter().map(of_object).collect::<Result<_, lodc::Error>>()?;
    let (morphing, staying_by_object): (Vec<_>, Vec<Vec<u64>>) = made.into_iter().unzip();
    let staying: Vec<u64> = (0..levels.len())
        .map(|k| staying_by_object.iter().map(|of_object| of_object[k]).sum())
        .collect();
    let moving_meshes = |level: usize| -> Vec<MovingMesh<'_>> {
        morphing.iter().map(|g| (&g[level].mesh, &g[level].next, g[level].moving.clone())).collect()
    };
    let ways: Vec<Vec<MovingMesh<'_>>> = (0..levels.len()).map(moving_meshes).collect();
    let errors = geomorph::pose_errors(asset, &ways, moved_streams.joints, &limits)?;
    geomorph::set_distances(&args.levels, levels, &errors, &staying);

    let (mut files, mut of_level) = (Vec::new(), Vec::new());
    let last = levels.len().saturating_sub(1);
    for (number, level) in levels.iter().enumerate() {
        let chain_object = |o: usize| {
            let own = &morphing[o][number];
            let geomorph = Geomorph {
                next: &own.next,
                moving: vec![Some(own.moving.clone())],
                streams: moved_streams,
            };
            ChainObject {
                info: &objects[o].info,
                mesh: &own.mesh,
                levels: vec![in_order(&own.mesh, options.compress)],
                coverage: vec![0.0],
                geomorph: (number < last).then_some(geomorph),
            }
        };
        let chain_objects: Vec<ChainObject<'_>> = (0..objects.len()).map(chain_object).collect();
        let path = numbered(out, number);
        let mut provenance = provenance(args, asset, std::slice::from_ref(level));
        if number < last {
            let next = numbered(out, number + 1);
            let name = next.file_name().unwrap_or_default().to_string_lossy();
            provenance.next = Some(name.into_owned());
        }
        options.provenance = Some(provenance);
        let binary = format != FormatName::Gltf;
        let shape = ChainShape::Nodes;
        files.extend(export_chain(&path, binary, document, &chain_objects, shape, &options)?);
        options.textures.copies.clear();
        of_level.push(path);
    }
    Ok(Files { files, of_level, warnings: stated.warnings })
}

/// The triangles of a level by submesh, in an order for vertex caches or for compression.
fn in_order(mesh: &Mesh, compress: bool) -> LevelTriangles {
    let of_submesh = |submesh: &Submesh| {
        let triangles = &mesh.triangles()[submesh.triangles()];
        match compress {
            true => codec_order_list(triangles, mesh.vertex_count()),
            false => order_list(triangles, mesh.vertex_count(), level_mesh::CACHE_VERTICES),
        }
    };
    mesh.submeshes().iter().map(of_submesh).collect()
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
