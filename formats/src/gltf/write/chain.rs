//! A chain of levels in one document: all of them over one vertex buffer.
//!
//! `MSFT_lod` puts each level into a node of its own, beside the node that shows the finest one;
//! index ranges put all levels of a primitive into one index accessor, one behind the other.

use super::writer::{Numbering, Writer};
use super::{glb, gltf, prune, source_document, submesh_primitive};
use crate::gltf::extensions;
use crate::gltf::json::{Object, integer};
use crate::gltf::quantize::Quantizer;
use crate::options::Additions;
use crate::{Document, FormatError, ObjectInfo, OutputFile};
use lodc_mesh::Mesh;
use serde_json::{Value, json};
use std::path::Path;

/// An object with several levels.
#[derive(Clone, Debug)]
pub struct ChainObject<'a> {
    /// Its description.
    pub info: &'a ObjectInfo,
    /// All vertices of all levels, those that coarse levels use first: within a submesh each level
    /// uses the first so many.
    pub mesh: &'a Mesh,
    /// Triangles by level and submesh, the finest level first.
    pub levels: Vec<Vec<Vec<[u32; 3]>>>,
    /// Share of the screen below which the next level suits, one per level; the last is 0.
    pub coverage: Vec<f64>,
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
    additions: &Additions,
) -> Result<Vec<OutputFile>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let (mut root, mut blob) = source_document(document, &infos, additions)?;
    let subject = |(i, o): (usize, &ChainObject<'a>)| super::subject(document, i, o.info, o.mesh);
    let subjects = objects.iter().enumerate().map(subject).collect::<Result<Vec<_>, _>>()?;
    let quantizer = Quantizer::new(additions.precision, document, &subjects, &mut root, &mut blob)?;
    let mut writer = Writer::new(&root, additions);
    let mut empty = Vec::new();
    let mut levels = Vec::new();
    for (i, (object, subject)) in objects.iter().zip(&subjects).enumerate() {
        let geometry = quantizer.geometry(i, subject);
        let mut made = Levels::new(object, subject.mesh);
        for (s, &number) in subject.primitives.iter().enumerate() {
            let primitive = submesh_primitive(&mut root, made.mesh, number)?;
            let mut numbering = writer.numbering(&geometry);
            if !made.primitive(&mut numbering, s, number, primitive, shape)? {
                empty.push((made.mesh, number));
            }
        }
        levels.push(made);
    }
    if shape == ChainShape::Nodes {
        levels.iter().for_each(|l| l.put(&mut root));
    }
    prune::without(&mut root, &empty);
    writer.finish(&mut root, &mut blob);
    let mut files = if binary { vec![glb(path, &root, &blob)?] } else { gltf(path, root, blob) };
    files.extend(additions.textures.copies.iter().cloned());
    Ok(files)
}

/// The levels of one mesh of the document.
struct Levels<'a> {
    object: &'a ChainObject<'a>,
    /// The mesh in the document.
    mesh: usize,
    /// Its primitives that are submeshes of the object.
    numbers: Vec<usize>,
    /// For each level the primitives that have triangles there, with their index accessors.
    indices: Vec<Vec<(usize, Value)>>,
}

impl<'a> Levels<'a> {
    fn new(object: &'a ChainObject<'a>, mesh: usize) -> Self {
        Self { object, mesh, numbers: Vec::new(), indices: vec![Vec::new(); object.levels.len()] }
    }

    /// Writes a submesh: its vertices once, its triangles at every level. False if it has none.
    fn primitive(
        &mut self,
        numbering: &mut Numbering<'_>,
        submesh: usize,
        number: usize,
        primitive: &mut Object,
        shape: ChainShape,
    ) -> Result<bool, FormatError> {
        self.numbers.push(number);
        let of_level = |level: &Vec<Vec<[u32; 3]>>| level[submesh].as_flattened().to_vec();
        let levels: Vec<Vec<u32>> = self.object.levels.iter().map(of_level).collect();
        if levels.iter().all(Vec::is_empty) {
            return Ok(false);
        }
        let mut vertices: Vec<u32> = levels.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        numbering.attributes(submesh, &vertices, primitive)?;
        let number_of = |v: &u32| vertices.partition_point(|w| w < v) as u32;
        let local: Vec<Vec<u32>> =
            levels.iter().map(|l| l.iter().map(number_of).collect()).collect();
        if shape == ChainShape::IndexRanges {
            let all = numbering.indices(&local.concat(), vertices.len());
            primitive.insert("indices".to_owned(), all);
            put_ranges(primitive, &local);
            return Ok(true);
        }
        for (level, indices) in local.iter().enumerate().filter(|(_, i)| !i.is_empty()) {
            let accessor = numbering.indices(indices, vertices.len());
            if level == 0 {
                primitive.insert("indices".to_owned(), accessor.clone());
            }
            self.indices[level].push((number, accessor));
        }
        Ok(!levels[0].is_empty())
    }

    /// Puts the coarser levels into the document: a mesh each, and a node each for every node that
    /// shows the mesh. A level that does not differ from the one before has a mesh of its own all
    /// the same: engines dispose of the levels that they have replaced.
    fn put(&self, root: &mut Object) {
        let mut meshes = vec![self.mesh];
        for level in 1..self.indices.len() {
            let before = meshes[level - 1];
            meshes.push(self.put_mesh(root, level).unwrap_or(before));
        }
        let nodes = root.get("nodes").and_then(Value::as_array).map_or(0, Vec::len);
        for node in 0..nodes {
            let shows = root["nodes"][node].get("mesh").and_then(integer);
            if shows == Some(self.mesh as u64) && meshes.len() > 1 {
                self.put_nodes(root, node, &meshes[1..]);
            }
        }
    }

    /// Adds the mesh of a level. None if it would have no primitive, which glTF does not allow.
    fn put_mesh(&self, root: &mut Object, level: usize) -> Option<usize> {
        let list = root["meshes"].as_array_mut()?;
        let mut mesh = list[self.mesh].clone();
        mesh["name"] = format!("{}_LOD{level}", self.object.info.name).into();
        let primitives = std::mem::take(mesh["primitives"].as_array_mut()?);
        // Points and lines are no submeshes: they are shown at every level.
        let at_level = |(number, mut primitive): (usize, Value)| {
            let own = self.indices[level].iter().find(|(n, _)| *n == number);
            if let Some((_, indices)) = own {
                primitive["indices"] = indices.clone();
            }
            (own.is_some() || !self.numbers.contains(&number)).then_some(primitive)
        };
        let kept: Vec<Value> = primitives.into_iter().enumerate().filter_map(at_level).collect();
        if kept.is_empty() {
            return None;
        }
        mesh["primitives"] = kept.into();
        list.push(mesh);
        Some(list.len() - 1)
    }

    /// Adds a node per coarser level beside `node`, with its transform, skin and animations.
    fn put_nodes(&self, root: &mut Object, node: usize, meshes: &[usize]) {
        let mut ids = Vec::with_capacity(meshes.len());
        for (k, &mesh) in meshes.iter().enumerate() {
            let copy = copied(&root["nodes"][node], mesh, k + 1);
            let nodes = root["nodes"].as_array_mut().expect("the document has nodes");
            nodes.push(copy);
            ids.push(nodes.len() - 1);
        }
        for &id in &ids {
            copy_channels(root, node, id);
        }
        let entry = &mut root["nodes"][node];
        entry["extensions"]["MSFT_lod"] = json!({ "ids": ids });
        if !entry["extras"].is_object() {
            entry["extras"] = json!({});
        }
        entry["extras"]["MSFT_screencoverage"] = json!(self.object.coverage);
        extensions::add(root, "extensionsUsed", "MSFT_lod");
    }
}

/// Ranges of the index accessor by level: first index, number of indices, vertices of the prefix.
fn put_ranges(primitive: &mut Object, levels: &[Vec<u32>]) {
    let mut first = 0;
    let range = |indices: &Vec<u32>| {
        let vertices = indices.iter().max().map_or(0, |v| v + 1);
        let range = json!({ "first": first, "count": indices.len(), "vertices": vertices });
        first += indices.len();
        range
    };
    let ranges: Vec<Value> = levels.iter().map(range).collect();
    let extras = primitive.entry("extras").or_insert_with(|| json!({}));
    if !extras.is_object() {
        *extras = json!({});
    }
    extras["lodc"] = json!({ "levels": ranges });
}

/// A node for a coarser level: what places and deforms the mesh, nothing that hangs below it.
fn copied(node: &Value, mesh: usize, level: usize) -> Value {
    let mut copy = Object::new();
    if let Some(name) = node["name"].as_str() {
        copy.insert("name".to_owned(), format!("{name}_LOD{level}").into());
    }
    for key in ["matrix", "translation", "rotation", "scale", "skin", "weights"] {
        if let Some(value) = node.get(key) {
            copy.insert(key.to_owned(), value.clone());
        }
    }
    if let Some(instances) = node.get("extensions").and_then(|e| e.get("EXT_mesh_gpu_instancing")) {
        let extensions = json!({ "EXT_mesh_gpu_instancing": instances });
        copy.insert("extensions".to_owned(), extensions);
    }
    copy.insert("mesh".to_owned(), mesh.into());
    copy.into()
}

/// Repeats the animation channels of a node for its copy.
fn copy_channels(root: &mut Object, node: usize, copy: usize) {
    let animations = root.get_mut("animations").and_then(Value::as_array_mut);
    for animation in animations.into_iter().flatten() {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else {
            continue;
        };
        let mut copies = Vec::new();
        for channel in &*channels {
            let mut own = channel.clone();
            if channel["target"].get("node").and_then(integer) == Some(node as u64) {
                own["target"]["node"] = copy.into();
                copies.push(own);
            } else if let Some(rest) = pointed(channel, node) {
                let pointer = format!("/nodes/{copy}/{rest}");
                own["target"]["extensions"]["KHR_animation_pointer"]["pointer"] = pointer.into();
                copies.push(own);
            }
        }
        channels.extend(copies);
    }
}

/// The property of `node` that a channel's animation pointer leads to.
fn pointed(channel: &Value, node: usize) -> Option<String> {
    let pointer = channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"].as_str()?;
    pointer.strip_prefix(&format!("/nodes/{node}/")).map(str::to_owned)
}
