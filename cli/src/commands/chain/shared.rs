//! Writes a chain as one file, all levels over one vertex buffer.

use super::geomorph::{self, GeomorphShapes, MovingMesh};
use super::levels::ChosenLevel;
use super::written::Stated;
use super::{ChainArgs, Chained, Files, provenance, showing_nodes};
use crate::exit::{Failure, Outcome, Status};
use crate::mesh_output::FormatName;
use lodc::geomorph::with_staying;
use lodc::level_mesh::CACHE_VERTICES;
use lodc::pipeline::{GeomorphJudge, Way};
use lodc::{Asset, LodObject, Rounding};
use lodc_formats::OutputFile;
use lodc_formats::export::ExportOptions;
use lodc_formats::gltf::{ChainObject, ChainShape, Geomorph, MovedStreams, export_chain};
use lodc_mesh::{Chain, Lod, Mesh, MorphingChain};
use lodc_report::text::{count, size};
use lodc_strip::{codec_order_list, order_list};
use rayon::prelude::*;
use std::path::Path;

/// Nodes for each mesh from which on a line says what they cost. Chosen by hand.
const MIN_REPEATED: usize = 10;

/// Makes the file, and says of each level what that does to it: error, vertices, distances.
pub(super) fn files(
    args: &ChainArgs,
    out: &Path,
    format: FormatName,
    chained: Chained<'_>,
    levels: &mut [ChosenLevel],
    mut options: ExportOptions,
) -> Outcome<Files> {
    let Chained { asset, .. } = chained;
    let moved_streams = args.geomorph.moved_streams();
    let made: Vec<MorphingChain> = (0..asset.objects.len())
        .into_par_iter()
        .map(|o| {
            let lods = geomorph::lods(levels, o);
            chain(&asset.objects[o], &lods, moved_streams.is_some(), options.compress)
        })
        .collect::<Outcome<_>>()?;
    // Of each object the mesh that each vertex morphs to.
    let mut next: Vec<Mesh> = match moved_streams {
        Some(_) => made.par_iter().map(MorphingChain::next).collect(),
        None => Vec::new(),
    };
    let chains: Vec<&Chain> = made.iter().map(|made| &made.chain).collect();
    let coverages: Vec<Vec<f64>> =
        asset.objects.iter().enumerate().map(|(o, object)| coverage(object, o, levels)).collect();
    let (meshes, precision) = (chains.iter().map(|c| &c.mesh), options.precision);
    let stored = format.export_format();
    let rounding = Rounding::new(&asset.objects, &asset.document, meshes, stored, precision)?;
    let mut stated = Stated::default();
    for (k, level) in levels.iter_mut().enumerate() {
        let triangles: Vec<_> = chains.iter().map(|chain| chain.levels[k].concat()).collect();
        let triangles: Vec<&[[u32; 3]]> = triangles.iter().map(Vec::as_slice).collect();
        stated.add(chained, &rounding, (k, level), &triangles);
        level.vertices = chains.iter().map(|c| u64::from(c.prefixes[k])).sum();
    }
    if let Some(moved_streams) = moved_streams {
        let limits = args.export.import.limits().limits();
        let shapes = GeomorphShapes::new(asset, &limits)?;
        let held = (next.into_par_iter().enumerate()).map(|(o, next)| {
            let judge = shapes.judge(asset, o);
            hold_back(chains[o], next, judge.as_ref(), moved_streams, |k| {
                geomorph::larger_error(levels, k, o)
            })
        });
        let staying: Vec<Vec<u64>>;
        (next, staying) = held.collect();
        let staying: Vec<u64> =
            (0..levels.len()).map(|k| staying.iter().map(|of_object| of_object[k]).sum()).collect();
        let of_level = |level: usize| -> Vec<MovingMesh<'_>> {
            let of_object = |o: usize| {
                let moving = geomorph::moving(&chains[o].prefixes, level).unwrap_or(0..0);
                (&chains[o].mesh, &next[o], moving)
            };
            (0..chains.len()).map(of_object).collect()
        };
        let moving_meshes: Vec<Vec<MovingMesh<'_>>> = (0..levels.len()).map(of_level).collect();
        let errors = geomorph::pose_errors(asset, &moving_meshes, moved_streams.joints, &limits)?;
        geomorph::set_distances(&args.levels, levels, &errors, &staying);
    }
    let geomorph_of = |object: usize, moved_streams: MovedStreams| Geomorph {
        next: &next[object],
        moving: (0..levels.len()).map(|k| geomorph::moving(&chains[object].prefixes, k)).collect(),
        streams: moved_streams,
    };
    let objects: Vec<ChainObject<'_>> = (asset.objects.iter().zip(&chains).zip(coverages))
        .enumerate()
        .map(|(o, ((object, chain), coverage))| ChainObject {
            info: &object.info,
            mesh: &chain.mesh,
            levels: chain.levels.clone(),
            coverage: moved_streams.map_or(coverage, |_| by_distance(args, asset, o, levels)),
            geomorph: moved_streams.map(|moved_streams| geomorph_of(o, moved_streams)),
        })
        .collect();
    let shape = if args.index_ranges { ChainShape::IndexRanges } else { ChainShape::Nodes };
    let binary = format != FormatName::Gltf;
    options.provenance = Some(provenance(args, asset, levels));
    let files = export_chain(out, binary, &asset.document, &objects, shape, &options)?;
    let note = match shape {
        ChainShape::Nodes => repeated_nodes(args, asset, &files)?,
        ChainShape::IndexRanges => None,
    };
    let mut warnings = stated.warnings;
    warnings.extend(note);
    Ok(Files { files, of_level: vec![out.to_owned(); levels.len()], warnings })
}

/// Returns `next`, where the vertices of an object go, with those back in their places that would
/// spoil a shape; and the number of these by level. `error` is the larger one of a level and the
/// next.
fn hold_back(
    chain: &Chain,
    mut next: Mesh,
    judge: Option<&GeomorphJudge<'_>>,
    moved_streams: MovedStreams,
    error: impl Fn(usize) -> f64,
) -> (Mesh, Vec<u64>) {
    let mut staying = vec![0; chain.levels.len()];
    for (k, triangles) in chain.levels.iter().enumerate() {
        let (Some(judge), Some(moving)) = (judge, geomorph::moving(&chain.prefixes, k)) else {
            break;
        };
        let way = Way {
            now: &chain.mesh,
            next: &next,
            triangles: &triangles.concat(),
            moving,
            takes_joints: moved_streams.joints,
            error: error(k),
        };
        let vertices = judge.staying(&way);
        staying[k] = vertices.len() as u64;
        next = with_staying(&chain.mesh, next, &vertices);
    }
    (next, staying)
}

/// A line where most of a file are nodes that only repeat a mesh: each has a node for every level.
fn repeated_nodes(
    args: &ChainArgs,
    asset: &Asset,
    files: &[OutputFile],
) -> Outcome<Option<String>> {
    let Some(first) = files.first() else { return Ok(None) };
    // The text of a GLB is its first chunk, which states its length.
    let text = match first.bytes.get(12..16).and_then(|length| length.try_into().ok()) {
        Some(length) if first.bytes.starts_with(b"glTF") => u32::from_le_bytes(length).into(),
        _ => first.bytes.len() as u64,
    };
    let all: u64 = files.iter().map(|file| file.bytes.len() as u64).sum();
    if 2 * text < all {
        return Ok(None);
    }
    let nodes: usize = showing_nodes(asset, &args.export.import.limits().limits())?.iter().sum();
    let meshes = asset.objects.len();
    Ok((nodes >= MIN_REPEATED * meshes).then(|| {
        format!(
            "{} of {} are nodes and their like: {nodes} nodes show {} and are repeated for every \
             level; instances (EXT_mesh_gpu_instancing) and --index-ranges need none of that",
            size(text),
            size(all),
            count(meshes as u64, "mesh"),
        )
    }))
}

/// The levels of an object, each in an order for vertex caches or for compression.
fn chain(object: &LodObject, lods: &[Lod], morphs: bool, compress: bool) -> Outcome<MorphingChain> {
    let made = if morphs {
        object.simplified.morphing_chain(lods)
    } else {
        let plain = object.simplified.chain(lods);
        plain.map(|chain| MorphingChain { chain, becomes: Vec::new() })
    };
    let mut made = made.map_err(|e| {
        Failure::new(Status::Bug, format!("{}: its levels are no mesh: {e}", object.info.name))
    })?;
    let chain = &mut made.chain;
    for (level, &prefix) in chain.levels.iter_mut().zip(&chain.prefixes) {
        for triangles in level {
            *triangles = match compress {
                true => codec_order_list(triangles, prefix as usize),
                false => order_list(triangles, prefix as usize, CACHE_VERTICES),
            };
        }
    }
    Ok(made)
}

/// As [`coverage`], where levels state distances: the box's diagonal at that of the next level.
fn by_distance(args: &ChainArgs, asset: &Asset, number: usize, levels: &[ChosenLevel]) -> Vec<f64> {
    let object = &asset.objects[number];
    let diagonal = object.info.world_scale * object.simplified.mesh().diagonal();
    let next = levels.iter().skip(1).map(|level| {
        level.distance.map_or(0.0, |distance| args.levels.coverage(diagonal, distance))
    });
    // Distances rise with levels: shares that do not fall by rounding would be refused.
    let mut least: f64 = 1.0;
    let falling = next.map(|share| {
        least = least.min(share);
        least
    });
    falling.chain([0.0]).collect()
}

/// Share of the screen below which the next level suits: where its error falls below a pixel of
/// 1,080. The share is that of the bounding box's diagonal, squared.
fn coverage(object: &LodObject, number: usize, levels: &[ChosenLevel]) -> Vec<f64> {
    let diagonal = object.simplified.mesh().diagonal();
    let next = levels.iter().skip(1).map(|level| {
        let error = level.distances[number].error;
        if error > 0.0 { (diagonal / (1080.0 * error)).powi(2).min(1.0) } else { 1.0 }
    });
    next.chain([0.0]).collect()
}
