//! Writes where each level's vertices move as the next level takes over (geomorph): one more morph
//! target for each mesh, at which every vertex that disappears lies on the one that it collapses
//! into. Weights, their animations and the targets' names get one entry more.

use super::differences::MovedStreams;
use super::writer::Writer;
use crate::gltf::document::Stored;
use crate::gltf::extensions::{animation_pointer, put_extra};
use crate::gltf::json::{Json, Object, object};
use crate::{Document, FormatError, GEOMORPH_TARGET, Limits};
use lodc_mesh::Mesh;
use std::collections::BTreeSet;
use std::ops::Range;

/// The way from each level of an object to the next.
#[derive(Clone, Debug)]
pub struct Geomorph<'a> {
    /// The object's mesh with every vertex where it goes; it needs no triangles.
    pub next: &'a Mesh,
    /// By level the vertices that move; none of a level that nothing comes after.
    pub moving: Vec<Option<Range<u32>>>,
    /// The streams that move besides positions and normals.
    pub streams: MovedStreams,
}

/// Names the last target of a mesh, which has `targets` others.
pub(super) fn name_target(mesh: &mut Object, targets: usize) {
    if mesh.get("weights").is_some() || targets == 0 {
        mesh.append("weights", vec![0u32.into()]);
    }
    let mut names = mesh["extras"]["targetNames"].list().to_vec();
    let unnamed = names.len() != targets;
    if unnamed {
        names = (0..targets).map(|t| format!("target_{t}").into()).collect();
    }
    names.push(GEOMORPH_TARGET.into());
    put_extra(mesh, "targetNames", names.into());
    let mut own = object! { "next" => targets };
    if unnamed && targets > 0 {
        own["unnamed"] = true.into();
    }
    put_extra(mesh, "lodc", own);
}

/// Adds an entry for the target that these meshes got to the weights of nodes and to animations of
/// weights.
///
/// # Errors
/// If the stored document is damaged.
pub(super) fn widen(
    root: &mut Object,
    writer: &mut Writer,
    document: &Document,
    meshes: &BTreeSet<usize>,
) -> Result<(), FormatError> {
    let mut nodes = BTreeSet::new();
    for (n, node) in root.objects_mut("nodes").enumerate() {
        if node["mesh"].as_index().is_some_and(|mesh| meshes.contains(&mesh)) {
            nodes.insert(n);
            if node.get("weights").is_some() {
                node.append("weights", vec![0u32.into()]);
            }
        }
    }
    let Document::Gltf(stored) = document else { return Ok(()) };
    let moves_weights = |channel: &Json| {
        let mut target = channel["target"].clone();
        let is_weights_of = |pool: &str, all: &BTreeSet<usize>, pointer: &str| {
            let number =
                pointer.strip_prefix(pool).and_then(|suffixed| suffixed.strip_suffix("/weights"));
            number.and_then(|n| n.parse().ok()).is_some_and(|n: usize| all.contains(&n))
        };
        match animation_pointer(&mut target) {
            Some(p) => is_weights_of("/nodes/", &nodes, p) || is_weights_of("/meshes/", meshes, p),
            None => {
                let node = target["node"].as_index().filter(|node| nodes.contains(node));
                node.is_some() && target["path"].as_str() == Some("weights")
            }
        }
    };
    let is_animated =
        root.entries("animations").any(|a| a.list("channels").iter().any(moves_weights));
    if !is_animated {
        return Ok(());
    }
    Stored::read(stored, &Limits::DEFAULT, |stored, _| {
        for animation in root.objects_mut("animations") {
            // The samplers of weights.
            let channels = animation.list("channels").iter().filter(|c| moves_weights(c));
            let samplers: BTreeSet<usize> =
                channels.filter_map(|channel| channel["sampler"].as_index()).collect();
            for sampler in samplers {
                let Some(source) = animation["samplers"].list().get(sampler) else { continue };
                let mut wide = source.clone();
                let keys =
                    |key: &str| source[key].as_index().map(|a| stored.numbers(a)).transpose();
                let (Some((times, _)), Some((values, _))) = (keys("input")?, keys("output")?)
                else {
                    continue;
                };
                let per_key =
                    if source["interpolation"].as_str() == Some("CUBICSPLINE") { 3 } else { 1 };
                let rows = times.len() * per_key;
                if rows == 0 || values.len() < rows || !values.len().is_multiple_of(rows) {
                    continue;
                }
                let grown = values.chunks_exact(values.len() / rows);
                let grown = grown.flat_map(|row| row.iter().map(|&w| w as f32).chain([0.0]));
                wide["output"] = writer.scalars("weights", &grown.collect::<Vec<f32>>());
                // The narrow sampler is what channels of levels without the target use, and what a
                // reader puts back.
                wide["extras"] = object! { "lodc" => object! { "narrow" => sampler } };
                let number = animation.list("samplers").len();
                animation.append("samplers", vec![wide]);
                for channel in animation["channels"].as_array_mut().into_iter().flatten() {
                    if channel["sampler"].as_index() == Some(sampler) && moves_weights(channel) {
                        channel["sampler"] = number.into();
                    }
                }
            }
        }
        Ok(())
    })
}
