//! The way from each level of a chain to the next, as a morph target of its own: every vertex that
//! leaves goes to the one that it becomes. Weights, their animations and the targets' names grow by
//! one number each.

use super::writer::Writer;
use crate::gltf::document::Stored;
use crate::gltf::extensions::animation_pointer;
use crate::gltf::json::{Json, Object, object};
use crate::gltf::semantic;
use crate::{Document, FormatError, GLIDE_TARGET, Limits};
use lodc_mesh::{Attribute, Mesh, Semantic};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The way from each level of an object to the next.
#[derive(Clone, Debug)]
pub struct Glide<'a> {
    /// The object's mesh with every vertex where it goes; it needs no triangles.
    pub next: &'a Mesh,
    /// By level the vertices that move; none of a level that nothing comes after.
    pub moving: Vec<Option<Range<u32>>>,
    /// What moves besides positions and normals.
    pub carried: Carried,
}

/// Streams that a glide moves besides positions and normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Carried {
    /// Directions of tangents; their handedness stays.
    pub tangents: bool,
    /// Texture coordinates.
    pub texture_coordinates: bool,
    /// Colours.
    pub colours: bool,
    /// At the level where a vertex moves it has the joints and weights of the one that it becomes.
    pub joints: bool,
}

impl Carried {
    /// Number of components that move; none of a stream that stays.
    fn components(self, stream: &Attribute) -> Option<usize> {
        match stream.semantic {
            _ if stream.morph_target.is_some() => None,
            Semantic::Normal => Some(3),
            Semantic::Tangent if self.tangents => Some(3),
            Semantic::TexCoord(_) if self.texture_coordinates => Some(2),
            Semantic::Color(_) if self.colours => Some(usize::from(stream.components)),
            _ => None,
        }
    }
}

/// The stream of a submesh with this meaning, at rest.
pub(super) fn stream<'m>(
    mesh: &'m Mesh,
    submesh: usize,
    wanted: &Semantic,
) -> Option<&'m Attribute> {
    let streams = mesh.submeshes()[submesh].attributes.iter();
    let streams = streams.map(|&a| &mesh.attributes()[a as usize]);
    streams.into_iter().find(|a| a.semantic == *wanted && a.morph_target.is_none())
}

/// The differences of a submesh's values for some vertices, each with its name and the number of
/// its components.
pub(super) fn differences(
    now: &Mesh,
    next: &Mesh,
    submesh: usize,
    vertices: &[u32],
    carried: Carried,
) -> Vec<(String, usize, Vec<f32>)> {
    let position = Semantic::Position;
    let stored = [now, next].map(|mesh| stream(mesh, submesh, &position));
    let place = |mesh: &Mesh, stored: Option<&Attribute>, v: u32, c: usize| match stored {
        Some(stored) => stored.value(v, c),
        None => mesh.positions()[v as usize][c],
    };
    let moved = |v: u32, c: usize| match stored {
        [Some(a), Some(b)] => difference(a.value(v, c), b.value(v, c)),
        _ => difference(place(now, None, v, c), place(next, None, v, c)),
    };
    let mut all = vec![(semantic::to_name(&position), 3, flat(vertices, 3, moved))];
    for &a in &now.submeshes()[submesh].attributes {
        let a = &now.attributes()[a as usize];
        let Some(components) = carried.components(a) else { continue };
        let Some(b) = stream(next, submesh, &a.semantic) else { continue };
        let moved = |v: u32, c: usize| difference(a.value(v, c), b.value(v, c));
        all.push((semantic::to_name(&a.semantic), components, flat(vertices, components, moved)));
    }
    all
}

fn flat(vertices: &[u32], components: usize, value: impl Fn(u32, usize) -> f32) -> Vec<f32> {
    vertices
        .iter()
        .flat_map(|&v| (0..components).map(move |c| (v, c)))
        .map(|(v, c)| value(v, c))
        .collect()
}

/// What has to be added to one number to get another; 0 where no float says it.
fn difference(from: f32, to: f32) -> f32 {
    let difference = (f64::from(to) - f64::from(from)) as f32;
    // Without negative zeros.
    if difference.is_finite() { difference + 0.0 } else { 0.0 }
}

/// Names the last target of a mesh, which has `targets` others.
pub(super) fn name_target(mesh: &mut Object, targets: usize) {
    if mesh.get("weights").is_some() || targets == 0 {
        mesh.append("weights", vec![0u32.into()]);
    }
    if mesh.get("extras").is_some_and(|extras| !extras.is_object()) {
        return;
    }
    let mut names = mesh["extras"]["targetNames"].list().to_vec();
    let unnamed = names.len() != targets;
    if unnamed {
        names = (0..targets).map(|t| format!("target_{t}").into()).collect();
    }
    names.push(GLIDE_TARGET.into());
    mesh["extras"]["targetNames"] = names.into();
    mesh["extras"]["lodc"] = object! { "next" => targets };
    if unnamed && targets > 0 {
        mesh["extras"]["lodc"]["unnamed"] = true.into();
    }
}

/// Lets weights of nodes, and animations of them, know of the target that their meshes got.
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
    let is_ours = |channel: &Json| {
        let mut target = channel["target"].clone();
        let of = |pool: &str, all: &BTreeSet<usize>, pointer: &str| {
            let number = pointer.strip_prefix(pool).and_then(|rest| rest.strip_suffix("/weights"));
            number.and_then(|n| n.parse().ok()).is_some_and(|n: usize| all.contains(&n))
        };
        match animation_pointer(&mut target) {
            Some(p) => of("/nodes/", &nodes, p) || of("/meshes/", meshes, p),
            None => {
                let node = target["node"].as_index().filter(|node| nodes.contains(node));
                node.is_some() && target["path"].as_str() == Some("weights")
            }
        }
    };
    let wanted = root.entries("animations").any(|a| a.list("channels").iter().any(is_ours));
    if !wanted {
        return Ok(());
    }
    Stored::read(stored, &Limits::DEFAULT, |stored, _| {
        for animation in root.objects_mut("animations") {
            // Samplers by how many channels of either kind use them.
            let mut users: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
            for channel in animation.list("channels") {
                if let Some(sampler) = channel["sampler"].as_index() {
                    users.entry(sampler).or_default()[usize::from(is_ours(channel))] += 1;
                }
            }
            for (sampler, [others, ours]) in users {
                let Some(source) = animation["samplers"].list().get(sampler) else { continue };
                if ours == 0 {
                    continue;
                }
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
                if others == 0 {
                    animation["samplers"].as_array_mut().into_iter().for_each(|all| {
                        all[sampler] = wide.clone();
                    });
                    continue;
                }
                // Levels without the target go on as before.
                wide["extras"] = object! { "lodc" => object! { "narrow" => sampler } };
                let number = animation.list("samplers").len();
                animation.append("samplers", vec![wide]);
                for channel in animation["channels"].as_array_mut().into_iter().flatten() {
                    if channel["sampler"].as_index() == Some(sampler) && is_ours(channel) {
                        channel["sampler"] = number.into();
                    }
                }
            }
        }
        Ok(())
    })
}
