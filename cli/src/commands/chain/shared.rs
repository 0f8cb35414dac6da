//! All levels in one file, over one vertex buffer.

use super::levels::Level;
use super::{ChainArgs, Files, provenance};
use crate::commands::asset::Asset;
use crate::exit::{Failure, Outcome, Status};
use crate::mesh_output::FormatName;
use lodc::{
    LodObject,
    level_mesh::{self, CACHE},
};
use lodc_formats::export::Additions;
use lodc_formats::gltf::{ChainObject, ChainShape, export_chain};
use lodc_mesh::{Chain, Lod};
use lodc_strip::{codec_order_list, order_list};
use rayon::prelude::*;
use std::path::Path;

pub(super) fn files(
    args: &ChainArgs,
    out: &Path,
    format: FormatName,
    asset: &Asset,
    levels: &mut [Level],
    mut additions: Additions,
) -> Outcome<Files> {
    let lods = |object: usize| -> Vec<Lod> { levels.iter().map(|l| l.lods[object]).collect() };
    let chains: Vec<Chain> = (0..asset.objects.len())
        .into_par_iter()
        .map(|o| chain(&asset.objects[o], &lods(o), additions.compress))
        .collect::<Outcome<_>>()?;
    let coverages: Vec<Vec<f64>> =
        asset.objects.iter().enumerate().map(|(o, object)| coverage(object, o, levels)).collect();
    let (meshes, precision) = (chains.iter().map(|c| &c.mesh), additions.precision);
    let moved = level_mesh::rounding(&asset.objects, &asset.document, meshes, precision)?.largest;
    for (k, level) in levels.iter_mut().enumerate() {
        level_mesh::add_rounding(&mut level.error, &mut level.rms, moved);
        level.vertices = chains.iter().map(|c| u64::from(c.prefixes[k])).sum();
    }
    let objects: Vec<ChainObject<'_>> = (asset.objects.iter().zip(&chains).zip(coverages))
        .map(|((o, chain), coverage)| ChainObject {
            info: &o.info,
            mesh: &chain.mesh,
            levels: chain.levels.clone(),
            coverage,
        })
        .collect();
    let shape = if args.index_ranges { ChainShape::IndexRanges } else { ChainShape::Nodes };
    let binary = format == FormatName::Glb;
    additions.provenance = Some(provenance(args, asset, levels));
    let files = export_chain(out, binary, &asset.document, &objects, shape, &additions)?;
    Ok(Files { files, of_level: vec![out.to_owned(); levels.len()] })
}

/// The levels of an object, each in an order for vertex caches or for compression.
fn chain(object: &LodObject, lods: &[Lod], compress: bool) -> Outcome<Chain> {
    let mut chain = object.simplified.chain(lods).map_err(|e| {
        Failure::new(Status::Bug, format!("{}: its levels are no mesh: {e}", object.info.name))
    })?;
    for (level, &prefix) in chain.levels.iter_mut().zip(&chain.prefixes) {
        for triangles in level {
            *triangles = match compress {
                true => codec_order_list(triangles, prefix as usize),
                false => order_list(triangles, prefix as usize, CACHE),
            };
        }
    }
    Ok(chain)
}

/// Share of the screen below which the next level suits: where its error falls below a pixel of
/// 1,080. The share is that of the bounding box's diagonal, squared.
fn coverage(object: &LodObject, number: usize, levels: &[Level]) -> Vec<f64> {
    let diagonal = object.simplified.mesh().diagonal();
    let next = levels.iter().skip(1).map(|level| {
        let error = level.distances[number].error;
        if error > 0.0 { (diagonal / (1080.0 * error)).powi(2).min(1.0) } else { 1.0 }
    });
    next.chain([0.0]).collect()
}
