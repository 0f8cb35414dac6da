//! Compares the document of an exported level with that of its source: everything but triangles has
//! to be equal. Returns the first difference as a JSON path.

use super::document::Stored;
use super::extensions::{
    INSTANCING, MESHOPT, QUANTIZATION, animation_pointer, forget_extra, is_requantized, of_node,
    uses,
};
use super::json::{Json, Object};
use super::schema::{self, Pool, references};
use super::texture_transform::TRANSFORM;
use crate::{FormatError, GltfDocument, Limits};
use std::collections::BTreeMap;

/// Compares what a level's document says besides its geometry with what the source's says: nodes,
/// materials, skins, animations, cameras, names and extras. Where bytes lie and what images are
/// called may differ; with quantisation what it adds; where objects or submeshes are gone what
/// belongs to them. Returns the first difference with its place.
///
/// # Errors
/// If a stored document is damaged.
pub(crate) fn difference(
    source_document: &GltfDocument,
    level_document: &GltfDocument,
    limits: &Limits,
) -> Result<Option<String>, FormatError> {
    let (mut source, mut level) =
        (source_document.root(limits)?.clone(), level_document.root(limits)?.clone());
    let lost = source.list("extensionsUsed").iter().filter_map(Json::as_str);
    let lost = lost.filter(|name| !MESHOPT.contains(name)).find(|name| !uses(&level, name));
    if let Some(name) = lost {
        return Ok(Some(format!("extensionsUsed: {name} is gone")));
    }
    let common = CommonParts {
        nodes: Pool::Nodes.len(&source),
        all_meshes: Pool::Meshes.len(&source) == Pool::Meshes.len(&level),
        grids: !uses(&level, QUANTIZATION)
            || uses(&source, QUANTIZATION) && !is_requantized(&level),
    };
    for (root, document) in [(&mut source, source_document), (&mut level, level_document)] {
        common.put_content(root, document, limits)?;
        common.strip(root);
    }
    compare_stored_images_only(&mut source, &mut level);
    if common.all_meshes {
        leave_out_gone_primitives(&mut source, &level);
    }
    Ok(first_difference(&Json::Object(source), &Json::Object(level), &mut String::new()))
}

/// What both documents have.
struct CommonParts {
    /// Nodes of the source; what follows belongs to the level alone.
    nodes: usize,
    /// No mesh is gone.
    all_meshes: bool,
    /// No mesh of the level is on a grid of its own.
    grids: bool,
}

impl CommonParts {
    /// Puts a hash of what it leads to in the place of every index of an accessor or buffer view.
    fn put_content(
        &self,
        root: &mut Object,
        document: &GltfDocument,
        limits: &Limits,
    ) -> Result<(), FormatError> {
        Stored::read(document, limits, |stored, _| {
            // What quantisation writes anew: vertices and what places them.
            let is_rewritten = |location: &str| {
                !self.grids
                    && (location.starts_with("skins")
                        || location.starts_with("meshes")
                        || location.contains(INSTANCING))
            };
            for pool in [Pool::Accessors, Pool::BufferViews] {
                let mut hashes: BTreeMap<usize, Json> = BTreeMap::new();
                references(root, pool, &mut |value, location| {
                    let number = value.as_index().filter(|_| !is_rewritten(location));
                    *value = number.map_or(Json::Null, |i| {
                        let hash = || match pool {
                            Pool::Accessors => stored.accessor_hash(i),
                            _ => stored.view_hash(i),
                        };
                        let text = || hash().map_or(Json::Null, |h| format!("{h:032x}").into());
                        hashes.entry(i).or_insert_with(text).clone()
                    });
                });
            }
            Ok(())
        })
    }

    /// Takes out what may differ.
    fn strip(&self, root: &mut Object) {
        let buffers = ["accessors", "bufferViews", "buffers"];
        for key in buffers.into_iter().chain(["extensionsUsed", "extensionsRequired"]) {
            root.shift_remove(key);
        }
        if let Some(asset) = root.get_mut("asset").and_then(Json::as_object_mut) {
            asset.shift_remove("generator");
        }
        forget_extra(root, "lodc");
        let kept = ["name", "bufferView"];
        root.objects_mut("images").for_each(|image| image.retain(|key, _| kept.contains(&&**key)));
        self.strip_nodes(root);
        if self.all_meshes {
            for mesh in root.objects_mut("meshes") {
                mesh.objects_mut("primitives").for_each(strip_primitive);
            }
        } else {
            let meshes = Pool::Meshes.len(root);
            schema::forget_references(root, Pool::Meshes, &vec![false; meshes]);
            root.shift_remove("meshes");
            root.shift_remove("animations");
        }
        if !self.grids {
            let materials = root.get_mut("materials").into_iter();
            materials.for_each(forget_transforms);
            for animation in root.objects_mut("animations") {
                for channel in animation.objects_mut("channels") {
                    if channel["target"]["path"].as_str() == Some("weights") {
                        channel["target"]["node"] = Json::Null;
                    }
                    if let Some(pointer) = animation_pointer(&mut channel["target"])
                        && let Some((_, property)) = of_node(pointer)
                        && property.starts_with("weights")
                    {
                        *pointer = property.to_owned();
                    }
                }
            }
        }
    }

    fn strip_nodes(&self, root: &mut Object) {
        if let Some(Json::Array(nodes)) = root.get_mut("nodes") {
            nodes.truncate(self.nodes);
        }
        for node in root.objects_mut("nodes") {
            if let Some(Json::Array(children)) = node.get_mut("children") {
                let length_before = children.len();
                children.retain(|child| child.as_index().is_none_or(|c| c < self.nodes));
                if children.is_empty() && length_before > 0 {
                    node.shift_remove("children");
                }
            }
            if !self.all_meshes || !self.grids {
                for key in ["mesh", "weights"] {
                    node.shift_remove(key);
                }
            }
            if !self.all_meshes {
                node.shift_remove("skin");
                node.remove_extension(INSTANCING);
            }
        }
    }
}

/// Leaves out images that only one of two documents holds itself: the other names a file.
fn compare_stored_images_only(source: &mut Object, level: &mut Object) {
    for (a, b) in source.objects_mut("images").zip(level.objects_mut("images")) {
        if a.contains_key("bufferView") != b.contains_key("bufferView") {
            a.shift_remove("bufferView");
            b.shift_remove("bufferView");
        }
    }
}

/// Triangles are gone from documents; points and lines are still there.
fn strip_primitive(primitive: &mut Object) {
    primitive.shift_remove("targets");
    forget_extra(primitive, "lodc");
}

/// Takes out of the source's meshes the primitives that the level has not: those without a
/// triangle there.
fn leave_out_gone_primitives(source: &mut Object, level: &Object) {
    let level_meshes = level.entries("meshes");
    for (mesh, level_mesh) in source.objects_mut("meshes").zip(level_meshes) {
        let Some(Json::Array(primitives)) = mesh.get_mut("primitives") else { continue };
        let mut level_primitives = level_mesh.list("primitives").iter().peekable();
        if primitives.len() > level_primitives.len() {
            primitives.retain(|primitive| level_primitives.next_if_eq(&primitive).is_some());
        }
    }
}

/// Texture coordinates on a grid are scaled back by the textures of their material.
fn forget_transforms(value: &mut Json) {
    match value {
        Json::Array(all) => all.iter_mut().for_each(forget_transforms),
        Json::Object(members) => {
            members.remove_extension(TRANSFORM);
            members.values_mut().for_each(forget_transforms);
        }
        _ => {}
    }
}

/// The first difference, with its place below `location`; members in alphabetical order.
// The depth of a document is bounded, so recursion is.
fn first_difference(source: &Json, level: &Json, location: &mut String) -> Option<String> {
    let length_before = location.len();
    let difference = match (source, level) {
        (Json::Object(a), Json::Object(b)) => {
            let sorted = |all: &Object| -> BTreeMap<String, Json> {
                all.iter().map(|(key, value)| (key.clone(), value.clone())).collect()
            };
            let (a, b) = (sorted(a), sorted(b));
            a.keys().chain(b.keys()).find_map(|key| {
                location.push_str(if length_before == 0 { "" } else { "." });
                location.push_str(key);
                let difference = match (a.get(key), b.get(key)) {
                    (Some(a), Some(b)) => first_difference(a, b, location),
                    (Some(_), None) => Some(format!("{location}: is gone")),
                    _ => Some(format!("{location}: is new")),
                };
                location.truncate(length_before);
                difference
            })
        }
        (Json::Array(a), Json::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().find_map(|(i, (a, b))| {
                location.push_str(&format!("[{i}]"));
                let difference = first_difference(a, b, location);
                location.truncate(length_before);
                difference
            })
        }
        // However they are spelt: readers take numbers as singles.
        (Json::Number(_), Json::Number(_)) if single(source) == single(level) => None,
        _ => (source != level).then(|| format!("{location}: is {level}, in the source {source}")),
    };
    location.truncate(length_before);
    difference
}

fn single(number: &Json) -> Option<f32> {
    number.as_f64().map(|number| number as f32)
}
