//! Writes a chain of discrete levels as one glTF document over one shared vertex buffer: as
//! `MSFT_lod` nodes, one for each level beside that of the finest, or as index ranges, all levels
//! of a primitive one after another in one index accessor.

use super::avatars::{self, Copies};
use super::buffers::{Drawn, VertexBuffers, Ways};
use super::differences::Deltas;
use super::geomorph::{self, Geomorph};
use super::writer::{MeshWriter, Writer};
use super::{glb, gltf, source_document, submesh_primitive};
use crate::gltf::extensions;
use crate::gltf::json::{Json, Object, object};
use crate::gltf::prune;
use crate::gltf::quantize::{Quantizer, WrittenObject};
use crate::options::ExportOptions;
use crate::{Document, FormatError, ObjectInfo, OutputFile};
use lodc_mesh::{LevelTriangles, Mesh};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// An object with several levels.
#[derive(Clone, Debug)]
pub struct ChainObject<'a> {
    /// Its description.
    pub info: &'a ObjectInfo,
    /// All vertices of all levels, those that coarse levels use first: within a submesh each level
    /// uses a number of the first ones.
    pub mesh: &'a Mesh,
    /// Triangles by level and submesh, the finest level first.
    pub levels: Vec<Vec<Vec<[u32; 3]>>>,
    /// Share of the screen below which the next level suits, one per level; the last is 0.
    pub coverage: Vec<f64>,
    /// The way from each level to the next, if it goes into the document.
    pub geomorph: Option<Geomorph<'a>>,
}

/// The way in which a document holds several levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChainShape {
    /// A node per level, tied together by `MSFT_lod`.
    Nodes,
    /// One index accessor per primitive, its ranges in `extras.lodc.levels`.
    IndexRanges,
}

/// Makes the `.glb`, or the `.gltf` and the `.bin` beside it, and copies of image files.
///
/// # Errors
/// If the format cannot hold the scene.
pub fn export_chain<'a>(
    path: &Path,
    binary: bool,
    document: &Document,
    objects: &[ChainObject<'a>],
    shape: ChainShape,
    options: &ExportOptions,
) -> Result<Vec<OutputFile>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let (mut root, mut blob) = source_document(document, &infos, options)?;
    let written_object = |(i, o): (usize, &ChainObject<'a>)| {
        let written_object = super::written_object(document, i, o.info, o.mesh)?;
        let geomorph_target =
            o.geomorph.as_ref().map(|geomorph| super::adapted(document, geomorph.next));
        Ok::<_, FormatError>(WrittenObject { geomorph_target, ..written_object })
    };
    let written_objects =
        objects.iter().enumerate().map(written_object).collect::<Result<Vec<_>, _>>()?;
    let quantizer =
        Quantizer::new(options.precision, document, &written_objects, &mut root, &mut blob)?;
    let mut writer = Writer::new(&root, options);
    let nodes_showing = nodes_showing(&root);
    let mut empty = Vec::new();
    let mut levels = Vec::new();
    for (i, (object, written_object)) in objects.iter().zip(&written_objects).enumerate() {
        let geometry = quantizer.geometry(i, written_object);
        let next = quantizer.next(i, written_object);
        let next = next.as_deref();
        let is_shown = nodes_showing.contains_key(&written_object.mesh);
        let mut object_levels = ChainedObject::new(object, written_object.mesh, is_shown);
        let buffers = vertex_buffers(object, object_levels.written(shape), &geometry, next);
        let mut mesh_writer = writer.mesh_writer(&geometry, buffers);
        for (s, &number) in written_object.primitives.iter().enumerate() {
            let primitive = submesh_primitive(&mut root, object_levels.mesh, number)?;
            if !object_levels.primitive(&mut mesh_writer, (s, number), primitive, next, shape)? {
                empty.push((object_levels.mesh, number));
            }
        }
        levels.push(object_levels);
    }
    let mut morphing = BTreeSet::new();
    if shape == ChainShape::Nodes {
        put_levels(&mut root, &mut writer, &levels, &nodes_showing, &mut morphing);
    }
    geomorph::widen(&mut root, &mut writer, document, &morphing)?;
    prune::without(&mut root, &empty);
    writer.finish(&mut root, &mut blob);
    let mut files = if binary { vec![glb(path, &root, &blob)?] } else { gltf(path, root, blob) };
    files.extend(options.textures.copies.iter().cloned());
    Ok(files)
}

/// By mesh the nodes that show it.
fn nodes_showing(root: &Object) -> BTreeMap<usize, Vec<usize>> {
    let mut nodes_showing: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (node, entry) in root.entries("nodes").enumerate() {
        if let Some(mesh) = entry["mesh"].as_index() {
            nodes_showing.entry(mesh).or_default().push(node);
        }
    }
    nodes_showing
}

/// The vertex buffers of some levels of an object, in each what coarse levels draw first. `next` is
/// what vertices move to.
fn vertex_buffers(
    object: &ChainObject<'_>,
    levels: &[LevelTriangles],
    mesh: &Mesh,
    next: Option<&Mesh>,
) -> VertexBuffers {
    let mut last_level = vec![0; mesh.vertex_count()];
    for (level, submeshes) in (0..).zip(levels) {
        submeshes.iter().flatten().flatten().for_each(|&v| last_level[v as usize] = level);
    }
    let drawn = |s: usize| {
        let corners = || levels.iter().flat_map(|level| level[s].as_flattened());
        let mut vertices: Vec<u32> = corners().copied().collect();
        let indices = vertices.len();
        vertices.sort_unstable();
        vertices.dedup();
        Drawn { vertices, indices }
    };
    let drawn = (0..mesh.submeshes().len()).map(drawn).collect();
    let last_level = |v: u32| last_level[v as usize];
    match object.geomorph.as_ref().zip(next) {
        Some((geomorph, next)) => {
            let Geomorph { moving, streams, .. } = geomorph;
            let ways = Ways { mesh, next, moving, streams: *streams };
            VertexBuffers::morphing(drawn, last_level, ways)
        }
        None => VertexBuffers::new(mesh, drawn, last_level),
    }
}

/// Puts the coarser levels of all meshes into the document, and the ways to the next one. Meshes
/// that morph are added to `morphing`.
fn put_levels(
    root: &mut Object,
    writer: &mut Writer,
    levels: &[ChainedObject<'_>],
    nodes_showing: &BTreeMap<usize, Vec<usize>>,
    morphing: &mut BTreeSet<usize>,
) {
    let (mut copies, mut of_avatars) = (Vec::new(), Copies::default());
    for level in levels {
        let Some(nodes) = nodes_showing.get(&level.mesh) else { continue };
        let meshes = level.put(root, writer, morphing);
        let mut coarser = meshes[1..].to_vec();
        coarser.dedup();
        coarser.retain(|mesh| *mesh != level.mesh);
        of_avatars.meshes.insert(level.mesh, coarser);
        if meshes.len() > 1 {
            for &node in nodes {
                copies.extend(level.put_nodes(root, node, &meshes[1..]));
            }
        }
    }
    copy_channels(root, &copies, &of_avatars.meshes);
    for [node, copy] in copies {
        of_avatars.nodes.entry(node).or_default().push(copy);
    }
    avatars::repeat_binds(root, &of_avatars);
}

/// The levels of one mesh of the document.
struct ChainedObject<'a> {
    object: &'a ChainObject<'a>,
    /// The mesh in the document.
    mesh: usize,
    /// Whether a node shows it.
    is_shown: bool,
    /// Its primitives that are submeshes of the object.
    numbers: Vec<usize>,
    /// For each level the primitives that have triangles there.
    primitives: Vec<Vec<LevelPrimitive>>,
}

/// How a primitive of one level differs from those of other levels.
#[derive(Clone, Debug)]
struct LevelPrimitive {
    /// The primitive.
    number: usize,
    indices: Json,
    /// The morph target towards the next level.
    target: Option<Object>,
    /// Attributes that are not those of the other levels.
    attributes: Object,
}

impl<'a> ChainedObject<'a> {
    fn new(object: &'a ChainObject<'a>, mesh: usize, is_shown: bool) -> Self {
        let primitives = vec![Vec::new(); object.levels.len()];
        Self { object, mesh, is_shown, numbers: Vec::new(), primitives }
    }

    /// The levels that are written. Engines reach levels by nodes: what none shows has one.
    fn written(&self, shape: ChainShape) -> &'a [LevelTriangles] {
        let all = &self.object.levels[..];
        let is_whole = self.is_shown || shape == ChainShape::IndexRanges;
        if is_whole { all } else { &all[..all.len().min(1)] }
    }

    /// Writes a submesh: its vertices once, its triangles at every level, and the way to `next`.
    /// False if it has none.
    fn primitive(
        &mut self,
        mesh_writer: &mut MeshWriter<'_>,
        (submesh, number): (usize, usize),
        primitive: &mut Object,
        next: Option<&Mesh>,
        shape: ChainShape,
    ) -> Result<bool, FormatError> {
        self.numbers.push(number);
        let indices = |level: &LevelTriangles| mesh_writer.numbers(level[submesh].as_flattened());
        let levels: Vec<Vec<u32>> = self.written(shape).iter().map(indices).collect();
        if levels.iter().all(Vec::is_empty) {
            return Ok(false);
        }
        mesh_writer.attributes(submesh, primitive)?;
        if shape == ChainShape::IndexRanges {
            primitive["indices"] = mesh_writer.indices(submesh, &levels.concat());
            put_ranges(primitive, &levels);
            return Ok(true);
        }
        for (level, indices) in levels.iter().enumerate().filter(|(_, i)| !i.is_empty()) {
            let accessor = mesh_writer.indices(submesh, indices);
            if level == 0 {
                primitive["indices"] = accessor.clone();
            }
            let mut level_primitive = LevelPrimitive {
                number,
                indices: accessor,
                target: None,
                attributes: Object::default(),
            };
            if let (Some(geomorph), Some(next)) = (&self.object.geomorph, next)
                && geomorph.moving[level].is_some()
                && self.is_shown
            {
                let next = (next, geomorph.streams);
                let attributes = &primitive["attributes"];
                let (target, replaced) = mesh_writer.target(submesh, level, next, attributes);
                (level_primitive.target, level_primitive.attributes) = (Some(target), replaced);
            }
            self.primitives[level].push(level_primitive);
        }
        Ok(!levels[0].is_empty())
    }

    /// Puts the coarser levels into the document, a mesh each; returns the meshes of all levels. A
    /// level that does not differ from the one before has a mesh of its own all the same: engines
    /// dispose of the levels that they have replaced.
    ///
    /// Meshes that morph are added to `morphing`.
    fn put(
        &self,
        root: &mut Object,
        writer: &mut Writer,
        morphing: &mut BTreeSet<usize>,
    ) -> Vec<usize> {
        let mut meshes = vec![self.mesh];
        for level in 1..self.primitives.len() {
            let before = meshes[level - 1];
            meshes.push(self.put_mesh(root, level).unwrap_or(before));
        }
        for (level, &mesh) in meshes.iter().enumerate() {
            if self.morphs(level) && morphing.insert(mesh) {
                self.put_targets(root, writer, mesh, level);
            }
        }
        meshes
    }

    /// Adds the mesh of a level. None if it would have no primitive, which glTF does not allow.
    fn put_mesh(&self, root: &mut Object, level: usize) -> Option<usize> {
        let mut mesh = root["meshes"][self.mesh].clone();
        mesh["name"] = format!("{}_LOD{level}", self.object.info.name).into();
        let primitives = std::mem::take(mesh["primitives"].as_array_mut()?);
        let level_primitives: BTreeMap<usize, &LevelPrimitive> = self.primitives[level]
            .iter()
            .map(|level_primitive| (level_primitive.number, level_primitive))
            .collect();
        let numbers: BTreeSet<usize> = self.numbers.iter().copied().collect();
        // Points and lines are no submeshes: they are shown at every level.
        let at_level = |(number, mut primitive): (usize, Json)| {
            let level_primitive = level_primitives.get(&number);
            if let Some(level_primitive) = level_primitive {
                primitive["indices"] = level_primitive.indices.clone();
            }
            (level_primitive.is_some() || !numbers.contains(&number)).then_some(primitive)
        };
        let remaining: Vec<Json> =
            primitives.into_iter().enumerate().filter_map(at_level).collect();
        if remaining.is_empty() {
            return None;
        }
        mesh["primitives"] = remaining.into();
        root.append("meshes", vec![mesh]);
        Some(root.list("meshes").len() - 1)
    }

    /// Returns whether the vertices of a level move towards the next one.
    fn morphs(&self, level: usize) -> bool {
        self.object.geomorph.as_ref().is_some_and(|geomorph| geomorph.moving[level].is_some())
    }

    /// Gives the primitives of a level the target that moves them to the next one. Those that are
    /// no submeshes, or have no triangles, get one that moves nothing: the primitives of a mesh
    /// must have the same number of targets.
    fn put_targets(&self, root: &mut Object, writer: &mut Writer, mesh: usize, level: usize) {
        let vertex_count = |primitive: &Object| -> Option<usize> {
            let accessor = primitive["attributes"]["POSITION"].as_index()?;
            root["accessors"][accessor]["count"].as_index()
        };
        let vertex_counts = root["meshes"][mesh]["primitives"].list().iter();
        let vertex_counts: Vec<_> =
            vertex_counts.map(|p| p.as_object().and_then(vertex_count)).collect();
        let Some(entry) = root.object_mut("meshes", mesh) else { return };
        let mut targets = 0;
        let mut level_primitives = self.primitives[level].iter();
        for (p, primitive) in entry.objects_mut("primitives").enumerate() {
            // A level's mesh has the primitives with triangles in their order; the finest has all.
            let has_indices = |p: &&LevelPrimitive| primitive["indices"] == p.indices;
            let target = match level_primitives.clone().next().filter(has_indices) {
                Some(level) => {
                    level_primitives.next();
                    for (name, accessor) in level.attributes.iter() {
                        primitive["attributes"][&**name] = accessor.clone();
                    }
                    level.target.clone()
                }
                None => vertex_counts[p].map(|count| {
                    let (name, values) = ("POSITION".to_owned(), Vec::new());
                    let no_movement = Deltas { name, components: 3, values };
                    let accessor = writer.deltas(&no_movement, 0..0, count);
                    Object::from_iter([(no_movement.name, accessor)])
                }),
            };
            targets = targets.max(primitive.list("targets").len());
            primitive.append("targets", target.into_iter().map(Json::Object).collect());
        }
        geomorph::name_target(entry, targets);
    }

    /// Adds a node per coarser level beside `node`, with its transform and skin. Returns the number
    /// of `node` with that of each.
    fn put_nodes(&self, root: &mut Object, node: usize, meshes: &[usize]) -> Vec<[usize; 2]> {
        let first = root.list("nodes").len();
        let ids: Vec<usize> = (first..first + meshes.len()).collect();
        let source = &root["nodes"][node];
        let coarser_nodes =
            (1..).zip(meshes).map(|(level, &mesh)| level_node(source, mesh, level)).collect();
        root.append("nodes", coarser_nodes);
        let copies = ids.iter().map(|&id| [node, id]).collect();
        let entry = root.object_mut("nodes", node).expect("the node that was copied");
        entry["extensions"][extensions::MSFT_LOD] = object! { "ids" => ids };
        let shares = self.object.coverage.iter().map(share).collect();
        extensions::put_extra(entry, "MSFT_screencoverage", shares);
        extensions::add(root, "extensionsUsed", extensions::MSFT_LOD);
        copies
    }
}

/// A share of the screen, to six digits: every node that shows a mesh has all of them.
fn share(share: &f64) -> Json {
    format!("{share:.5e}").parse().unwrap_or(*share).into()
}

/// Ranges of the index accessor by level: first index, number of indices, vertices of the prefix.
fn put_ranges(primitive: &mut Object, levels: &[Vec<u32>]) {
    let mut first = 0;
    let range = |indices: &Vec<u32>| {
        let vertices = indices.iter().max().map_or(0, |v| v + 1);
        let count = indices.len();
        first += count;
        object! { "first" => first - count, "count" => count, "vertices" => vertices }
    };
    let ranges: Vec<Json> = levels.iter().map(range).collect();
    extensions::put_extra(primitive, "lodc", object! { "levels" => ranges });
}

/// A node for a coarser level: what places, deforms and otherwise concerns the mesh (visibility,
/// say), without children.
fn level_node(node: &Json, mesh: usize, level: usize) -> Json {
    let mut copy = Object::default();
    if let Some(name) = node["name"].as_str() {
        copy["name"] = format!("{name}_LOD{level}").into();
    }
    for key in ["matrix", "translation", "rotation", "scale", "skin", "weights"] {
        if let Some(value) = node.get(key) {
            copy[key] = value.clone();
        }
    }
    let mut kept = node["extensions"].as_object().cloned().unwrap_or_default();
    kept.shift_remove(extensions::MSFT_LOD);
    if !kept.is_empty() {
        copy["extensions"] = Json::Object(kept);
    }
    copy["mesh"] = mesh.into();
    Json::Object(copy)
}

/// Repeats the animation channels of nodes for their copies, and those of the weights of meshes for
/// those of coarser levels; `copies` has pairs of node and copy, `coarser` these meshes.
fn copy_channels(root: &mut Object, copies: &[[usize; 2]], coarser: &BTreeMap<usize, Vec<usize>>) {
    let mut copies_of: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (number, [node, _]) in copies.iter().enumerate() {
        copies_of.entry(*node).or_default().push(number);
    }
    let copy_numbers = |node: usize| copies_of.get(&node).into_iter().flatten();
    for animation in root.objects_mut("animations") {
        let mut channels: Vec<(usize, Json)> = Vec::new();
        let mut of_meshes = Vec::new();
        for channel in animation.list("channels") {
            let node = channel["target"]["node"].as_index();
            channels.extend(node.into_iter().flat_map(copy_numbers).map(|&number| {
                let mut copy = channel.clone();
                copy["target"]["node"] = copies[number][1].into();
                (number, copy)
            }));
            let Some(pointer) = channel["target"].as_object().and_then(extensions::pointer_of)
            else {
                continue;
            };
            let pointing = |pointer: String| {
                let mut copy = channel.clone();
                if let Some(own) = extensions::animation_pointer(&mut copy["target"]) {
                    *own = pointer;
                }
                copy
            };
            if let Some((target, property)) = extensions::of_node(pointer) {
                for &number in copy_numbers(target).filter(|_| node != Some(target)) {
                    let copy = pointing(format!("/nodes/{}/{property}", copies[number][1]));
                    channels.push((number, copy));
                }
            }
            if let Some((target, property)) = extensions::of_mesh(pointer)
                && property.starts_with("weights")
            {
                let meshes = coarser.get(&target).into_iter().flatten();
                of_meshes.extend(meshes.map(|m| pointing(format!("/meshes/{m}/{property}"))));
            }
        }
        // All channels of a copy, then those of the next.
        channels.sort_by_key(|(number, _)| *number);
        let channels = channels.into_iter().map(|(_, channel)| channel).chain(of_meshes);
        animation.append("channels", channels.collect());
    }
}
