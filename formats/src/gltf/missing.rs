//! A glTF whose buffer has not come to its end: everything that refers to missing bytes is left
//! out, so that the rest is a valid document.

use super::extensions::opaque as opaque_extension;
use super::json::{self, Object, entries, integer, list};
use super::schema::{self, Pool, references, retain};
use crate::{FormatError, GltfDocument, Limits};
use serde_json::Value;

const INSTANCING: &str = "EXT_mesh_gpu_instancing";
/// Extensions that refer to images and textures in a way that is not listed.
const UNLISTED: [&str; 5] = [
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_feature_metadata",
    "KHR_techniques_webgl",
];

/// A document, and what was left out of it with counts.
pub(crate) type Shortened = (GltfDocument, Vec<String>);

/// Leaves out what refers to bytes behind the end of the document's buffer. Returns `None` if the
/// document refers to its buffer in a way that is not known.
///
/// # Errors
/// If the document is malformed.
pub(crate) fn gltf_without_missing(
    document: &GltfDocument,
) -> Result<Option<Shortened>, FormatError> {
    let mut root = json::parse(document.json.as_bytes(), &Limits::DEFAULT)?;
    schema::check(&mut root)?;
    let used = list(&root, "extensionsUsed").iter().filter_map(Value::as_str);
    let is_listed =
        !used.into_iter().any(|e| UNLISTED.contains(&e)) && opaque_extension(&root).is_none();
    if !is_listed {
        return Ok(None);
    }
    let missing = Missing::of(&mut root, document.blob.len() as u64);
    let mut left_out = Vec::new();
    let mut note = |number: usize, what: &str| match number {
        0 => {}
        1 => left_out.push(format!("1 {what}")),
        n => left_out.push(format!("{n} {what}s")),
    };
    note(missing.drop_textures(&mut root), "texture");
    note(missing.drop_animations(&mut root), "animation");
    note(missing.drop_skins(&mut root), "skin");
    note(missing.drop_instances(&mut root), "set of instances");
    // Points and lines still need theirs.
    let mut is_free = missing.drop_arrays(&mut root);
    if document.blob.is_empty() {
        root.shift_remove("buffers");
        is_free &= Pool::BufferViews.len(&root) == 0;
    } else if let Some(buffer) = objects(&mut root, "buffers").next() {
        let length = buffer.get("byteLength").and_then(integer).unwrap_or(0);
        buffer.insert("byteLength".to_owned(), length.min(document.blob.len() as u64).into());
    }
    let json = serde_json::to_string(&root).expect("values from JSON can be written as JSON");
    Ok(is_free.then(|| (GltfDocument { json, blob: document.blob.clone() }, left_out)))
}

/// The entries of a document that refer to missing bytes.
struct Missing {
    views: Vec<bool>,
    accessors: Vec<bool>,
    images: Vec<bool>,
}

impl Missing {
    /// Finds what refers to bytes from number `end` on.
    fn of(root: &mut Object, end: u64) -> Self {
        let number = |view: &Object, key: &str| view.get(key).and_then(integer);
        let ends = |view: &Object| {
            let length = number(view, "byteLength")?;
            number(view, "byteOffset").unwrap_or(0).checked_add(length)
        };
        let views: Vec<bool> =
            entries(root, "bufferViews").map(|view| ends(view).is_none_or(|e| e > end)).collect();
        let is_missing = |v: Option<&Value>| {
            let view = v.and_then(integer).and_then(|i| views.get(i as usize));
            view.copied().unwrap_or(false)
        };
        let accessor = |a: &Object| {
            let sparse = |key: &str| a.get("sparse").and_then(|s| s.get(key)?.get("bufferView"));
            [a.get("bufferView"), sparse("indices"), sparse("values")].into_iter().any(is_missing)
        };
        let accessors = entries(root, "accessors").map(accessor).collect();
        let images =
            entries(root, "images").map(|image| is_missing(image.get("bufferView"))).collect();
        Self { views, accessors, images }
    }

    fn is_missing_accessor(&self, value: Option<&Value>) -> bool {
        is_marked(&self.accessors, value)
    }

    /// Drops textures without an image, also from materials. Returns their number.
    fn drop_textures(&self, root: &mut Object) -> usize {
        let mut bare = Vec::new();
        for texture in objects(root, "textures") {
            let had = texture.contains_key("source") || texture.contains_key("extensions");
            let is_missing = |v: Option<&Value>| is_marked(&self.images, v);
            if is_missing(texture.get("source")) {
                texture.shift_remove("source");
            }
            if let Some(Value::Object(extensions)) = texture.get_mut("extensions") {
                extensions.retain(|_, e| !is_missing(e.get("source")));
                if extensions.is_empty() {
                    texture.shift_remove("extensions");
                }
            }
            let has = texture.contains_key("source") || texture.contains_key("extensions");
            bare.push(had && !has);
        }
        let dropped = bare.iter().filter(|b| **b).count();
        if let (Some(materials), true) = (root.get_mut("materials"), dropped > 0) {
            renumber_textures(materials, &bare);
        }
        if dropped == bare.len() {
            root.shift_remove("textures");
        } else if let Some(Value::Array(textures)) = root.get_mut("textures") {
            let mut bare = bare.iter();
            textures.retain(|_| !bare.next().copied().unwrap_or(false));
        }
        dropped
    }

    /// Drops animations with missing samplers, and those that point into materials.
    fn drop_animations(&self, root: &mut Object) -> usize {
        let Some(Value::Array(animations)) = root.get_mut("animations") else { return 0 };
        let before = animations.len();
        let is_missing = |sampler: &Value| {
            ["input", "output"].iter().any(|key| self.is_missing_accessor(sampler.get(*key)))
        };
        let points = |channel: &Value| {
            let target = channel.get("target").and_then(|t| t.get("extensions"));
            target.is_some_and(|e| e.get("KHR_animation_pointer").is_some())
        };
        let all = |animation: &Value, key: &str| -> Vec<Value> {
            animation.get(key).and_then(Value::as_array).cloned().unwrap_or_default()
        };
        animations.retain(|a| {
            !all(a, "samplers").iter().any(is_missing) && !all(a, "channels").iter().any(points)
        });
        let dropped = before - animations.len();
        if animations.is_empty() {
            root.shift_remove("animations");
        }
        dropped
    }

    /// Drops skins without their matrices; nodes stay.
    fn drop_skins(&self, root: &mut Object) -> usize {
        let missing = |s: &Object| self.is_missing_accessor(s.get("inverseBindMatrices"));
        let skins: Vec<bool> = entries(root, "skins").map(missing).collect();
        for node in objects(root, "nodes") {
            if is_marked(&skins, node.get("skin")) {
                node.shift_remove("skin");
            }
        }
        keep(root, Pool::Skins, &skins);
        skins.iter().filter(|s| **s).count()
    }

    /// Shows nodes once whose instances are missing.
    fn drop_instances(&self, root: &mut Object) -> usize {
        let mut dropped = 0;
        for node in objects(root, "nodes") {
            let attributes = json::extension(node, INSTANCING).and_then(|e| e.get("attributes"));
            let Some(attributes) = attributes.and_then(Value::as_object) else { continue };
            if attributes.values().any(|a| self.is_missing_accessor(Some(a))) {
                json::remove_extension(node, INSTANCING);
                dropped += 1;
            }
        }
        dropped
    }

    /// Drops missing images, accessors and buffer views. Returns whether nothing refers to any.
    fn drop_arrays(&self, root: &mut Object) -> bool {
        let pools = [
            (Pool::Images, &self.images),
            (Pool::Accessors, &self.accessors),
            (Pool::BufferViews, &self.views),
        ];
        pools.into_iter().all(|(pool, missing)| {
            let mut is_free = true;
            references(root, pool, &mut |value, _| is_free &= !is_marked(missing, Some(value)));
            if is_free {
                keep(root, pool, missing);
            }
            is_free
        })
    }
}

fn is_marked(marks: &[bool], index: Option<&Value>) -> bool {
    let mark = index.and_then(integer).and_then(|i| marks.get(usize::try_from(i).ok()?));
    mark.copied().unwrap_or(false)
}

/// Drops the marked entries of a pool to which nothing refers.
fn keep(root: &mut Object, pool: Pool, missing: &[bool]) {
    let kept: Vec<bool> = missing.iter().map(|m| !m).collect();
    retain(root, pool, &kept);
}

fn objects<'a>(parent: &'a mut Object, key: &str) -> impl Iterator<Item = &'a mut Object> {
    let array = parent.get_mut(key).and_then(Value::as_array_mut);
    array.into_iter().flatten().filter_map(Value::as_object_mut)
}

/// Drops every `…Texture` whose index is marked, and renumbers the others.
fn renumber_textures(value: &mut Value, marked: &[bool]) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|v| renumber_textures(v, marked)),
        Value::Object(members) => {
            members
                .retain(|key, v| !(key.ends_with("Texture") && is_marked(marked, v.get("index"))));
            for (key, member) in members.iter_mut() {
                if key.ends_with("Texture")
                    && let Some(index) = member.get_mut("index")
                    && let Some(number) = integer(index)
                {
                    let before = marked.iter().take(number as usize);
                    *index = before.filter(|m| !**m).count().into();
                }
                renumber_textures(member, marked);
            }
        }
        _ => {}
    }
}
