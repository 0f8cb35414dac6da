//! Members of a glTF document: one table for checking types, resolving references and
//! renumbering them.

use super::extension_table::{EXTENSIONS, LISTS_OF_BINDS};
use super::json::{Json, Object, malformed};
pub(crate) use super::pool::Pool;
use crate::FormatError;
use std::fmt::Write;

#[derive(Clone, Copy)]
enum Kind {
    Object,
    Whole,
    Number,
    /// An array of exactly this many finite numbers.
    Numbers(usize),
    Text,
    Flag,
    Index(Pool),
}

use Kind::{Flag, Index, Number, Numbers, Object as Obj, Text, Whole};

/// Path → kind, of the core; `extension_table` has indices in extensions. `[]` means every element
/// of an array, `{}` every member of an object. A member that is not there is no error here. Only
/// what this package reads or what others point to is listed; what else accessors, buffer views and
/// buffers hold is checked by `typed`.
const TABLE: &[(&str, Kind)] = &[
    ("asset", Obj),
    ("asset.version", Text),
    ("asset.minVersion", Text),
    ("extensions{}", Obj),
    ("extensionsUsed[]", Text),
    ("extensionsRequired[]", Text),
    ("scene", Index(Pool::Scenes)),
    ("scenes[]", Obj),
    ("scenes[].nodes[]", Index(Pool::Nodes)),
    ("nodes[]", Obj),
    ("nodes[].extensions{}", Obj),
    ("nodes[].children[]", Index(Pool::Nodes)),
    ("nodes[].mesh", Index(Pool::Meshes)),
    ("nodes[].skin", Index(Pool::Skins)),
    ("nodes[].camera", Index(Pool::Cameras)),
    ("nodes[].matrix", Numbers(16)),
    ("nodes[].translation", Numbers(3)),
    ("nodes[].rotation", Numbers(4)),
    ("nodes[].scale", Numbers(3)),
    ("nodes[].weights[]", Number),
    ("cameras[]", Obj),
    ("skins[]", Obj),
    ("skins[].joints[]", Index(Pool::Nodes)),
    ("skins[].skeleton", Index(Pool::Nodes)),
    ("skins[].inverseBindMatrices", Index(Pool::Accessors)),
    ("animations[]", Obj),
    ("animations[].samplers[]", Obj),
    ("animations[].samplers[].input", Index(Pool::Accessors)),
    ("animations[].samplers[].output", Index(Pool::Accessors)),
    ("animations[].channels[]", Obj),
    ("animations[].channels[].sampler", Whole),
    ("animations[].channels[].target", Obj),
    ("animations[].channels[].target.node", Index(Pool::Nodes)),
    ("animations[].channels[].target.path", Text),
    ("meshes[]", Obj),
    ("meshes[].extensions{}", Obj),
    ("meshes[].weights[]", Number),
    ("meshes[].primitives[]", Obj),
    ("meshes[].primitives[].extensions{}", Obj),
    ("meshes[].primitives[].mode", Whole),
    ("meshes[].primitives[].indices", Index(Pool::Accessors)),
    ("meshes[].primitives[].attributes{}", Index(Pool::Accessors)),
    ("meshes[].primitives[].targets[]{}", Index(Pool::Accessors)),
    ("meshes[].primitives[].material", Index(Pool::Materials)),
    ("materials[]", Obj),
    ("materials[].extensions{}", Obj),
    ("materials[].pbrMetallicRoughness", Obj),
    ("materials[].pbrMetallicRoughness.baseColorTexture.index", Index(Pool::Textures)),
    ("materials[].pbrMetallicRoughness.metallicRoughnessTexture.index", Index(Pool::Textures)),
    ("materials[].normalTexture", Obj),
    ("materials[].normalTexture.index", Index(Pool::Textures)),
    ("materials[].normalTexture.scale", Number),
    ("materials[].occlusionTexture", Obj),
    ("materials[].occlusionTexture.index", Index(Pool::Textures)),
    ("materials[].occlusionTexture.strength", Number),
    ("materials[].emissiveTexture", Obj),
    ("materials[].emissiveTexture.index", Index(Pool::Textures)),
    ("materials[].doubleSided", Flag),
    ("materials[].alphaMode", Text),
    ("materials[].alphaCutoff", Number),
    ("textures[]", Obj),
    ("textures[].source", Index(Pool::Images)),
    ("textures[].sampler", Index(Pool::Samplers)),
    ("textures[].extensions{}", Obj),
    ("images[]", Obj),
    ("images[].uri", Text),
    ("images[].bufferView", Index(Pool::BufferViews)),
    ("samplers[]", Obj),
    ("accessors[]", Obj),
    ("accessors[].bufferView", Index(Pool::BufferViews)),
    ("accessors[].sparse.indices.bufferView", Index(Pool::BufferViews)),
    ("accessors[].sparse.values.bufferView", Index(Pool::BufferViews)),
    ("bufferViews[]", Obj),
    ("bufferViews[].extensions{}", Obj),
    ("bufferViews[].buffer", Index(Pool::Buffers)),
    ("buffers[]", Obj),
    ("buffers[].extensions{}", Obj),
];

/// Extensions in which an index that leads nowhere makes a document malformed, as in the core. In
/// others such numbers are left alone: many avatars have −1 for nothing.
const STRICT: [&str; 18] = [
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_astc",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_audio_emitter",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_variants",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "MSFT_audio_emitter",
    "MSFT_lod",
    "MSFT_texture_dds",
    "EXT_lights_ies",
];

/// Checks that everything listed has the right type and that every reference leads somewhere.
pub(crate) fn check(root: &mut Object) -> Result<(), FormatError> {
    for pool in
        Pool::ALL.into_iter().map(Pool::name).filter(|&n| n != "lights").chain(["animations"])
    {
        if root.get(pool).is_some_and(|v| v.as_array().is_none()) {
            return Err(malformed(pool, "must be an array"));
        }
    }
    let lengths = Pool::ALL.map(|pool| pool.len(root));
    let strict = true;
    for (path, kind) in TABLE {
        walk_root(root, path, strict, &mut |value, location| {
            check_one(value, *kind, &lengths, location)
        })?;
    }
    for (_, paths) in EXTENSIONS.iter().filter(|(name, _)| STRICT.contains(name)) {
        for (path, pool) in *paths {
            walk_root(root, path, strict, &mut |value, location| {
                check_one(value, Index(*pool), &lengths, location)
            })?;
        }
    }
    Ok(())
}

/// Calls `visit` for every reference into `pool` and its place. The document has been checked.
pub(crate) fn references(root: &mut Object, pool: Pool, visit: &mut dyn FnMut(&mut Json, &str)) {
    for (path, kind) in TABLE {
        if matches!(kind, Index(p) if *p == pool) {
            let strict = true;
            let walked = walk_root(root, path, strict, &mut |value, location| {
                visit(value, location);
                Ok(())
            });
            walked.expect("the shape of a checked document fits the table");
        }
    }
    references_of_extensions(root, pool, visit);
}

/// The same of references in extensions alone; those that lead nowhere are passed over.
fn references_of_extensions(root: &mut Object, pool: Pool, visit: &mut dyn FnMut(&mut Json, &str)) {
    let length = pool.len(root);
    let strict = false;
    for (path, _) in EXTENSIONS.iter().flat_map(|(_, all)| *all).filter(|(_, p)| *p == pool) {
        let walked = walk_root(root, path, strict, &mut |value, location| {
            if value.as_index().is_some_and(|i| i < length) {
                visit(value, location);
            }
            Ok(())
        });
        walked.expect("nothing is demanded of extensions");
    }
}

/// Takes references of extensions to entries of a pool that will be dropped out of the document:
/// with the entry of a list that is about them, or else alone.
pub(crate) fn forget_references(root: &mut Object, pool: Pool, kept: &[bool]) {
    let mut is_any_dropped = false;
    references_of_extensions(root, pool, &mut |value, _| {
        if value.as_index().is_some_and(|i| !kept[i]) {
            *value = Json::Null;
            is_any_dropped = true;
        }
    });
    if is_any_dropped {
        root.iter_mut().for_each(|(key, value)| forget_nulls(value, key == "extensions"));
    }
}

/// Removes members and elements that are null from extensions.
fn forget_nulls(value: &mut Json, in_extension: bool) {
    match value {
        Json::Object(members) => {
            for (key, member) in members.iter_mut() {
                if LISTS_OF_BINDS.contains(&key.as_str())
                    && let Json::Array(binds) = member
                {
                    let is_gone = |bind: &Json| {
                        bind.as_object().is_some_and(|b| b.values().any(|v| *v == Json::Null))
                    };
                    binds.retain(|bind| !is_gone(bind));
                }
                forget_nulls(member, in_extension || key == "extensions");
            }
            if in_extension {
                members.retain(|_, member| *member != Json::Null);
            }
        }
        Json::Array(elements) => {
            elements.iter_mut().for_each(|element| forget_nulls(element, in_extension));
            if in_extension {
                elements.retain(|element| *element != Json::Null);
            }
        }
        _ => {}
    }
}

/// Returns which entries of a pool something refers to.
pub(crate) fn referenced(root: &mut Object, pool: Pool) -> Vec<bool> {
    let mut marks = vec![false; pool.len(root)];
    references(root, pool, &mut |value, _| {
        if let Some(mark) = value.as_index().and_then(|i| marks.get_mut(i)) {
            *mark = true;
        }
    });
    marks
}

/// A primitive of a mesh, to be changed; none if it is not there.
pub(crate) fn primitive_mut(
    root: &mut Object,
    mesh: usize,
    primitive: usize,
) -> Option<&mut Object> {
    root.object_mut("meshes", mesh)?.object_mut("primitives", primitive)
}

/// Drops the entries of a pool that are not kept and renumbers all references to the others.
/// Nothing may refer to what is dropped. An array without entries goes as a whole.
pub(crate) fn retain(root: &mut Object, pool: Pool, kept: &[bool]) {
    let numbers = renumbered(kept);
    references(root, pool, &mut |value, _| {
        let old = value.as_u64().and_then(|i| numbers.get(i as usize).copied());
        *value = old.expect("the reference has been checked").into();
    });
    if let Some(Json::Array(entries)) = root.get_mut(pool.name())
        && kept.contains(&false)
    {
        let mut keep = kept.iter();
        entries.retain(|_| keep.next().copied().unwrap_or(true));
        if entries.is_empty() {
            root.shift_remove(pool.name());
        }
    }
}

/// Returns for each of some entries how many before it are kept: its number afterwards, if it is.
pub(crate) fn renumbered(kept: &[bool]) -> Vec<u64> {
    let mut next = 0u64;
    let number = |&k: &bool| {
        next += u64::from(k);
        next - u64::from(k)
    };
    kept.iter().map(number).collect()
}

/// Checks a value against its kind; `lengths` are those of all pools.
fn check_one(
    value: &Json,
    kind: Kind,
    lengths: &[usize; Pool::ALL.len()],
    location: &str,
) -> Result<(), FormatError> {
    let finite = |v: &Json| v.as_f64().is_some();
    let (fits, expected) = match kind {
        Obj => (value.is_object(), "an object".to_owned()),
        Whole => (value.as_u64().is_some(), "a whole number".to_owned()),
        Number => (finite(value), "a finite number".to_owned()),
        Numbers(n) => {
            let fits = value.list().len() == n && value.list().iter().all(finite);
            (fits, format!("an array of {n} finite numbers"))
        }
        Text => (value.as_str().is_some(), "a string".to_owned()),
        Flag => (value.as_bool().is_some(), "true or false".to_owned()),
        Index(pool) => {
            let position = Pool::ALL.iter().position(|&p| p == pool).expect("ALL has every pool");
            let length = lengths[position];
            let fits = value.as_u64().is_some_and(|i| i < length as u64);
            (fits, format!("the index of one of the {length} {}", pool.name()))
        }
    };
    if fits {
        return Ok(());
    }
    let mut shown = value.to_string();
    if shown.len() > 40 {
        shown = format!("{}…", shown.chars().take(39).collect::<String>());
    }
    Err(malformed(location, format!("must be {expected}, not {shown}")))
}

type Visit<'a> = dyn FnMut(&mut Json, &str) -> Result<(), FormatError> + 'a;

/// Calls `visit` for every value that a path leads to, and its location. What has another shape
/// than the path says is an error if the walk is `strict`; else it is passed over.
fn walk_root(
    root: &mut Object,
    path: &str,
    strict: bool,
    visit: &mut Visit<'_>,
) -> Result<(), FormatError> {
    let mut location = String::new();
    walk_member(root, path, strict, &mut location, visit)
}

/// `path` starts with a member's name.
fn walk_member(
    object: &mut Object,
    path: &str,
    strict: bool,
    location: &mut String,
    visit: &mut Visit<'_>,
) -> Result<(), FormatError> {
    let end = path.find(['.', '[', '{']).unwrap_or(path.len());
    let Some(value) = object.get_mut(&path[..end]) else { return Ok(()) };
    let length_before = location.len();
    if length_before > 0 {
        location.push('.');
    }
    location.push_str(&path[..end]);
    walk_value(value, &path[end..], strict, location, visit)?;
    location.truncate(length_before);
    Ok(())
}

/// `path` is what follows a value: nothing, `.member…`, `[]…` or `{}…`.
fn walk_value(
    value: &mut Json,
    path: &str,
    strict: bool,
    location: &mut String,
    visit: &mut Visit<'_>,
) -> Result<(), FormatError> {
    let length_before = location.len();
    if let Some(rest) = path.strip_prefix("[]") {
        let Json::Array(elements) = value else {
            return misshapen(strict, location, "must be an array");
        };
        for (i, element) in elements.iter_mut().enumerate() {
            write!(location, "[{i}]").expect("a string takes everything");
            walk_value(element, rest, strict, location, visit)?;
            location.truncate(length_before);
        }
    } else if let Some(rest) = path.strip_prefix("{}") {
        let Json::Object(members) = value else {
            return misshapen(strict, location, "must be an object");
        };
        for (name, member) in members.iter_mut() {
            location.push('.');
            location.push_str(name);
            walk_value(member, rest, strict, location, visit)?;
            location.truncate(length_before);
        }
    } else if let Some(rest) = path.strip_prefix('.') {
        let Json::Object(members) = value else {
            return misshapen(strict, location, "must be an object");
        };
        walk_member(members, rest, strict, location, visit)?;
    } else {
        visit(value, location)?;
    }
    Ok(())
}

fn misshapen(strict: bool, location: &str, problem: &str) -> Result<(), FormatError> {
    if strict { Err(malformed(location, problem)) } else { Ok(()) }
}
