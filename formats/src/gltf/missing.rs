//! A valid document from the prefix of a stream: textures, animations, skins and instances whose
//! bytes have not arrived are removed, and offsets are changed to those of the bytes that have.

use super::buffer_runs::{PartialBuffer, has_unknown_references, view_bytes};
use super::extensions::INSTANCING;
use super::json::{Json, Object, object, parse};
use super::schema::{self, Pool, forget_references, references, retain};
use crate::{FormatError, GltfDocument, Limits, ObjectInfo};

/// A document without the parts whose bytes are missing, and these parts by kind with their counts.
pub(crate) type Shortened = (GltfDocument, Vec<String>);

/// Removes from a document what refers to bytes of its buffer that have not arrived. Returns `None`
/// if the document refers to its buffer in a way that is not known.
///
/// # Errors
/// If the document is malformed.
pub(crate) fn gltf_without_missing(
    json: &str,
    buffer: PartialBuffer,
) -> Result<Option<Shortened>, FormatError> {
    let mut root = parse(json.as_bytes(), &Limits::DEFAULT)?;
    schema::check(&mut root)?;
    if has_unknown_references(&root) {
        return Ok(None);
    }
    let missing = Missing::of(&root, &buffer);
    let mut removed = Vec::new();
    let mut note = |count: usize, kind: &str| match count {
        0 => {}
        1 => removed.push(format!("1 {kind}")),
        n => removed.push(format!("{n} {kind}s")),
    };
    note(missing.drop_textures(&mut root), "texture");
    note(missing.drop_animations(&mut root), "animation");
    note(missing.drop_skins(&mut root), "skin");
    note(missing.drop_instances(&mut root), "set of instances");
    // Points and lines may still refer to missing bytes, and cannot be removed.
    let mut is_complete = missing.drop_arrays(&mut root);
    for view in root.objects_mut("bufferViews") {
        let offsets = view_bytes(view).map(|bytes| (bytes.start, buffer.find(&bytes)));
        if let Some((before, Some(now))) = offsets
            && before != now
        {
            view.insert("byteOffset".to_owned(), now.into());
        }
    }
    if buffer.is_empty() {
        root.shift_remove("buffers");
        is_complete &= Pool::BufferViews.len(&root) == 0;
    }
    let blob = buffer.into_bytes();
    if let Some(buffer) = root.objects_mut("buffers").next() {
        buffer["byteLength"] = (blob.len() as u64).into();
    }
    Ok(is_complete.then(|| (GltfDocument::new(root.to_string(), blob), removed)))
}

/// Makes a document with a mesh and a node for each object, and changes `infos` to refer to it.
/// `targets` counts the morph targets of each object.
pub(crate) fn bare_gltf(infos: &mut [ObjectInfo], targets: &[usize]) -> GltfDocument {
    let mut meshes: Vec<Json> = Vec::new();
    for ((number, info), &targets) in (0..).zip(infos).zip(targets) {
        info.document_mesh = number;
        for (primitive, submesh) in (0..).zip(&mut info.submeshes) {
            submesh.document_primitive = primitive;
        }
        let primitive = |_| match targets {
            0 => object! {},
            n => object! { "targets" => vec![object! {}; n] },
        };
        let primitives: Json = info.submeshes.iter().map(primitive).collect();
        meshes.push(object! { "name" => &*info.name, "primitives" => primitives });
    }
    let mut root = object! { "asset" => object! { "version" => "2.0", "generator" => "lodc" } };
    if !meshes.is_empty() {
        let roots: Vec<usize> = (0..meshes.len()).collect();
        root["nodes"] = roots.iter().map(|&i| object! { "mesh" => i }).collect();
        root["scenes"] = [object! { "nodes" => roots }].into();
        root["scene"] = 0u32.into();
        root["meshes"] = meshes.into();
    }
    GltfDocument::new(root.to_string(), Vec::new())
}

/// The entries of a document that refer to missing bytes.
struct Missing {
    views: Vec<bool>,
    accessors: Vec<bool>,
    images: Vec<bool>,
}

impl Missing {
    /// Finds what refers to bytes that have not arrived.
    fn of(root: &Object, buffer: &PartialBuffer) -> Self {
        let arrived = |view| view_bytes(view).is_some_and(|bytes| buffer.find(&bytes).is_some());
        let views: Vec<bool> = root.entries("bufferViews").map(|view| !arrived(view)).collect();
        let accessor = |a: &Object| {
            let sparse = ["indices", "values"].map(|key| &a["sparse"][key]["bufferView"]);
            [&a["bufferView"], sparse[0], sparse[1]].into_iter().any(|v| is_marked(&views, v))
        };
        let accessors = root.entries("accessors").map(accessor).collect();
        let images = root.entries("images").map(|i| is_marked(&views, &i["bufferView"])).collect();
        Self { views, accessors, images }
    }

    /// Drops textures without an image, also from materials. Returns their number.
    fn drop_textures(&self, root: &mut Object) -> usize {
        // Which textures have lost their only image.
        let mut without_image = Vec::new();
        for texture in root.objects_mut("textures") {
            let has_image =
                |t: &Object| ["source", "extensions"].iter().any(|key| t.contains_key(*key));
            let had_image = has_image(texture);
            if is_marked(&self.images, &texture["source"]) {
                texture.shift_remove("source");
            }
            if let Some(Json::Object(extensions)) = texture.get_mut("extensions") {
                extensions.retain(|_, e| !is_marked(&self.images, &e["source"]));
                if extensions.is_empty() {
                    texture.shift_remove("extensions");
                }
            }
            without_image.push(had_image && !has_image(texture));
        }
        if let Some(materials) = root.get_mut("materials") {
            forget_textures(materials, &without_image);
        }
        let kept: Vec<bool> = without_image.iter().map(|lost| !lost).collect();
        forget_references(root, Pool::Textures, &kept);
        retain(root, Pool::Textures, &kept);
        without_image.iter().filter(|lost| **lost).count()
    }

    /// Drops animations with missing samplers, and those that point into materials.
    fn drop_animations(&self, root: &mut Object) -> usize {
        let Some(Json::Array(animations)) = root.get_mut("animations") else { return 0 };
        let count_before = animations.len();
        let is_missing = |sampler: &Json| {
            ["input", "output"].iter().any(|key| is_marked(&self.accessors, &sampler[*key]))
        };
        let has_pointer =
            |channel: &Json| channel["target"]["extensions"].get("KHR_animation_pointer").is_some();
        animations.retain(|a| {
            !a["samplers"].list().iter().any(is_missing)
                && !a["channels"].list().iter().any(has_pointer)
        });
        let dropped = count_before - animations.len();
        if animations.is_empty() {
            root.shift_remove("animations");
        }
        dropped
    }

    /// Drops skins without their matrices; nodes stay.
    fn drop_skins(&self, root: &mut Object) -> usize {
        let missing = |s: &Object| is_marked(&self.accessors, &s["inverseBindMatrices"]);
        let skins: Vec<bool> = root.entries("skins").map(missing).collect();
        for node in root.objects_mut("nodes") {
            if is_marked(&skins, &node["skin"]) {
                node.shift_remove("skin");
            }
        }
        drop_marked(root, Pool::Skins, &skins);
        skins.iter().filter(|s| **s).count()
    }

    /// Takes missing instances off nodes, which then show their meshes once. Returns the number of
    /// these nodes.
    fn drop_instances(&self, root: &mut Object) -> usize {
        let mut dropped = 0;
        for node in root.objects_mut("nodes") {
            let attributes = node.extension(INSTANCING).and_then(|e| e["attributes"].as_object());
            let mut accessors = attributes.into_iter().flat_map(|a| a.values());
            if accessors.any(|a| is_marked(&self.accessors, a)) {
                node.remove_extension(INSTANCING);
                dropped += 1;
            }
        }
        dropped
    }

    /// Drops missing images, accessors and buffer views; false if something still refers to one.
    fn drop_arrays(&self, root: &mut Object) -> bool {
        // The thumbnail of an avatar.
        let kept: Vec<bool> = self.images.iter().map(|missing| !missing).collect();
        forget_references(root, Pool::Images, &kept);
        let pools = [
            (Pool::Images, &self.images),
            (Pool::Accessors, &self.accessors),
            (Pool::BufferViews, &self.views),
        ];
        pools.into_iter().all(|(pool, missing)| {
            let mut is_unused = true;
            references(root, pool, &mut |value, _| is_unused &= !is_marked(missing, value));
            if is_unused {
                drop_marked(root, pool, missing);
            }
            is_unused
        })
    }
}

fn is_marked(marks: &[bool], index: &Json) -> bool {
    index.as_index().and_then(|i| marks.get(i)).copied().unwrap_or(false)
}

/// Drops the marked entries of a pool, to which nothing refers.
fn drop_marked(root: &mut Object, pool: Pool, marks: &[bool]) {
    let kept: Vec<bool> = marks.iter().map(|m| !m).collect();
    retain(root, pool, &kept);
}

/// Removes every `…Texture` whose index is marked.
fn forget_textures(value: &mut Json, marked: &[bool]) {
    match value {
        Json::Array(values) => values.iter_mut().for_each(|v| forget_textures(v, marked)),
        Json::Object(members) => {
            members.retain(|key, v| !(key.ends_with("Texture") && is_marked(marked, &v["index"])));
            members.values_mut().for_each(|member| forget_textures(member, marked));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// Three images of one texture each; the bytes of the second have arrived.
    fn shortened(extensions: &Value, material: &Value) -> Value {
        let view = |i: u32| json!({ "buffer": 0, "byteOffset": 8 * i, "byteLength": 8 });
        let image = |i: u32| json!({ "bufferView": i, "mimeType": "image/png" });
        let root = json!({
            "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 24 }],
            "bufferViews": [view(0), view(1), view(2)], "images": [image(0), image(1), image(2)],
            "textures": [{ "source": 0 }, { "source": 1 }, { "source": 2 }],
            "materials": [material], "extensions": extensions,
        });
        let buffer = PartialBuffer::new(std::iter::once(8..16), &[7; 8]);
        let made = gltf_without_missing(&root.to_string(), buffer).expect("a sound document");
        let (document, removed) = made.expect("every reference is known");
        assert_eq!(removed, ["2 textures"]);
        serde_json::from_str(document.json()).expect("JSON")
    }

    #[test]
    fn what_has_come_keeps_its_textures_and_nothing_names_others() {
        let index = |i: u32| json!({ "index": i });
        let pbr = json!({ "baseColorTexture": index(1), "metallicRoughnessTexture": index(0) });
        let material = json!({
            "pbrMetallicRoughness": pbr, "normalTexture": index(2),
            "extensions": { "MOZ_lightmap": index(1) },
        });
        let root = shortened(&json!({}), &material);
        let pbr = json!({ "baseColorTexture": index(0) });
        let wanted =
            json!({ "pbrMetallicRoughness": pbr, "extensions": { "MOZ_lightmap": index(0) } });
        assert_eq!(root["materials"][0], wanted);
        assert_eq!(root["textures"], json!([{ "source": 0 }]));
    }

    #[test]
    fn avatars_keep_the_textures_that_have_come() {
        let vrm = |meta: Value, textures: Value| {
            let properties = json!([{ "textureProperties": textures }]);
            json!({ "VRM": { "meta": meta, "materialProperties": properties } })
        };
        let before = vrm(json!({ "texture": 2 }), json!({ "_MainTex": 1, "_ShadeTexture": 0 }));
        let root = shortened(&before, &json!({}));
        assert_eq!(root["extensions"], vrm(json!({}), json!({ "_MainTex": 0 })));

        let vrm = |meta: Value| json!({ "VRMC_vrm": { "meta": meta } });
        let root = shortened(&vrm(json!({ "name": "A", "thumbnailImage": 2 })), &json!({}));
        assert_eq!(root["extensions"], vrm(json!({ "name": "A" })));
        let root = shortened(&vrm(json!({ "thumbnailImage": 1 })), &json!({}));
        assert_eq!(root["extensions"], vrm(json!({ "thumbnailImage": 0 })));
    }
}
