//! Borders of different meshes that meet: each mesh is simplified by itself, so that unless borders
//! are locked the meshes part.

use crate::LodObject;
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_graph};
use lodc_mesh::{Lod, PositionIds, Simplified};
use lodc_scene::{Arrangement, centre, posed_positions};
use rayon::prelude::*;

/// Border edges of all placements above which none are compared, to save time and memory. Chosen by
/// hand.
const MAX_EDGES: usize = 1 << 22;
/// Triangles of all objects above which no borders are searched for, likewise.
const MAX_TRIANGLES: usize = 1 << 24;

/// A border edge in the world.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    /// The bits of its ends in single precision, the smaller first.
    ends: [[u32; 3]; 2],
    /// The number of its placement, over all objects.
    placement: usize,
    object: usize,
    /// Whether the object's level lacks one of its ends.
    is_gone: bool,
}

/// Returns the names of objects whose borders meet those of others (or their own, in another place)
/// in the scene at rest, and come apart at `lods`, as at least one side loses vertices there.
///
/// # Errors
/// If the stored document is damaged.
pub fn parting_borders<'a>(
    objects: &'a [LodObject],
    lods: &[Lod],
    document: &Document,
    limits: &Limits,
) -> Result<Vec<&'a str>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let graph = scene_graph(document, &infos, limits)?;
    let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
    let triangles = |o: usize| objects[o].simplified.mesh().triangles().len();
    let all: usize = (0..objects.len()).map(triangles).sum();
    if scene.placements().len() < 2 || all > MAX_TRIANGLES {
        return Ok(Vec::new());
    }
    let scene = scene.moved(centre(&scene, |o| objects[o].simplified.mesh()).map(|c| -c));
    let borders: Vec<Vec<[u32; 2]>> =
        objects.par_iter().map(|o| o.simplified.mesh().border_edges()).collect();
    let edges_in_all = |o: usize| borders[o].len().saturating_mul(scene.of(o).count());
    if (0..objects.len()).map(edges_in_all).fold(0, usize::saturating_add) > MAX_EDGES {
        return Ok(Vec::new());
    }
    let mut edges: Vec<Edge> = Vec::new();
    let mut placement_number = 0;
    for (o, border) in borders.iter().enumerate().filter(|(_, border)| !border.is_empty()) {
        let simplified = &objects[o].simplified;
        let gone_vertices = gone(simplified, lods[o]);
        for placement in scene.of(o) {
            let positions = posed_positions(simplified.mesh(), placement);
            // −0 and +0 are one position.
            let end = |v: u32| {
                let position = positions[v as usize].as_vec3().to_array();
                position.map(|c| (c + 0.0).to_bits())
            };
            edges.extend(border.iter().map(|&ends| {
                let [a, b] = ends.map(end);
                let is_gone = ends.iter().any(|&v| gone_vertices[v as usize]);
                let ends = [a.min(b), a.max(b)];
                Edge { ends, placement: placement_number, object: o, is_gone }
            }));
            placement_number += 1;
        }
    }
    edges.par_sort_unstable();
    let mut comes_apart = vec![false; objects.len()];
    for same in edges.chunk_by(|a, b| a.ends == b.ends) {
        let meet = same.iter().any(|edge| edge.placement != same[0].placement);
        if meet && same.iter().any(|edge| edge.is_gone) {
            same.iter().for_each(|edge| comes_apart[edge.object] = true);
        }
    }
    let names = objects.iter().zip(comes_apart).filter(|(_, comes_apart)| *comes_apart);
    Ok(names.map(|(o, _)| o.info.name.as_str()).collect())
}

/// For each vertex: whether a level has none at its position.
fn gone(simplified: &Simplified, lod: Lod) -> Vec<bool> {
    let ids = PositionIds::new(simplified.mesh().positions());
    let mut is_there = vec![false; ids.len()];
    for &id in &ids.of_vertex[(lod.0 as usize).min(ids.of_vertex.len())..] {
        is_there[id as usize] = true;
    }
    ids.of_vertex.iter().map(|&id| !is_there[id as usize]).collect()
}

/// One line about objects whose borders part, if there are any.
#[must_use]
pub fn parting_line(names: &[&str]) -> Option<String> {
    const MAX_NAMES: usize = 8;
    let more = if names.len() > MAX_NAMES { ", …" } else { "" };
    (!names.is_empty()).then(|| {
        format!(
            "borders that touch separate here: {}{more}; --lock-border keeps them together",
            names[..names.len().min(MAX_NAMES)].join(", ")
        )
    })
}
