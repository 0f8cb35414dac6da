//! Extensions that this package reads, passes through, or must refuse; pointers of animations;
//! members of `extras`.

use super::extension_table::{EXTENSIONS, PREFIXES};
use super::json::{Json, Object, malformed, object};
use crate::{Fault, FormatError};
use std::collections::BTreeSet;

/// Compressed vertex and index data: decoded.
pub(crate) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
/// Streams of short integers.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";
/// Compressed primitives: decoded unless the same data is there uncompressed.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
/// Repeats a node's mesh.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";
/// Names the coarser levels of a node or material.
pub(super) const MSFT_LOD: &str = "MSFT_lod";

/// Extensions of a texture that name an image in another format.
pub(super) const IMAGE_EXTENSIONS: [&str; 4] =
    ["EXT_texture_webp", "KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"];

fn is_known(name: &str) -> bool {
    EXTENSIONS.iter().any(|(known, _)| *known == name)
        || PREFIXES.iter().any(|beginning| name.starts_with(beginning))
}

/// Refuses glTF versions other than 2, and required extensions that are not known here. Draco is
/// decoded later, where there is no fallback.
pub(super) fn check(root: &Object) -> Result<(), FormatError> {
    let asset = root["asset"].as_object();
    let asset = asset.ok_or_else(|| malformed("asset", "is missing: not a glTF 2.0 document"))?;
    let version = asset["version"].as_str();
    let version = version.ok_or_else(|| malformed("asset.version", "is missing"))?;
    let Some((major, minor)) = version_numbers(version) else {
        return Err(malformed("asset.version", format!("`{version}` is not a version")));
    };
    let minimum = asset["minVersion"].as_str().map(version_numbers);
    let unsupported = |location: &str, problem: String| {
        Err(FormatError::new(Fault::Unsupported, location, problem))
    };
    match minimum {
        _ if major != 2 => {
            return unsupported("asset.version", format!("glTF {major}.{minor}, only 2.0 is read"));
        }
        Some(None) => return Err(malformed("asset.minVersion", "is not a version")),
        Some(Some(needed)) if needed > (2, 0) => {
            return unsupported(
                "asset.minVersion",
                format!("needs glTF {}.{}, only 2.0 is read", needed.0, needed.1),
            );
        }
        _ => {}
    }
    for name in root.list("extensionsRequired").iter().filter_map(Json::as_str) {
        if name != DRACO && !is_known(name) {
            return unsupported(
                "extensionsRequired",
                format!("the extension {name} is required, but not supported"),
            );
        }
    }
    Ok(())
}

/// Major and minor number of a version; none if it has others.
fn version_numbers(version: &str) -> Option<(u32, u32)> {
    let (major, minor) = version.split_once('.')?;
    let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit()).then(|| s.parse().ok()).flatten();
    Some((digits(major)?, digits(minor)?))
}

/// Extensions whose specification is not known here, if a number in them might be the index of an
/// accessor or buffer view.
pub(crate) struct Unknown {
    /// The name of the first.
    pub(crate) name: String,
    /// The whole numbers in them.
    pub(crate) numbers: BTreeSet<usize>,
}

impl Unknown {
    /// Returns whether an entry with this number must keep it: the extensions may mean it, or one
    /// after it, which moves up if it goes.
    pub(crate) fn may_name(&self, number: usize) -> bool {
        self.numbers.last().is_some_and(|&largest| number <= largest)
    }
}

/// Looks for unknown extensions with a whole number somewhere. While there is one, what it might
/// name must not be renumbered.
pub(crate) fn unknown(root: &Object) -> Option<Unknown> {
    let mut found = None;
    root.iter().for_each(|(key, value)| unknown_below(key, value, &mut found));
    found
}

// The document's depth is bounded, so recursion is.
fn unknown_below(key: &str, value: &Json, found: &mut Option<Unknown>) {
    match value {
        Json::Object(members) if key == "extensions" => {
            for (name, body) in members.iter() {
                let mut numbers = BTreeSet::new();
                if !is_known(name) {
                    whole_numbers(body, &mut numbers);
                }
                if !numbers.is_empty() {
                    let first = || Unknown { name: name.clone(), numbers: BTreeSet::new() };
                    found.get_or_insert_with(first).numbers.extend(numbers);
                }
                unknown_below("", body, found);
            }
        }
        Json::Object(_) if key == "extras" => {}
        Json::Object(members) => members.iter().for_each(|(k, v)| unknown_below(k, v, found)),
        Json::Array(elements) => elements.iter().for_each(|v| unknown_below("", v, found)),
        _ => {}
    }
}

fn whole_numbers(value: &Json, found: &mut BTreeSet<usize>) {
    match value {
        Json::Number(_) => found.extend(value.as_index()),
        Json::Array(elements) => elements.iter().for_each(|v| whole_numbers(v, found)),
        Json::Object(members) => members.values().for_each(|v| whole_numbers(v, found)),
        _ => {}
    }
}

/// Returns whether a document says that it uses an extension.
pub(super) fn uses(root: &Object, name: &str) -> bool {
    root.list("extensionsUsed").iter().any(|used| used.as_str() == Some(name))
}

/// Returns whether a document says that its export put values on grids of its own.
pub(super) fn is_requantized(root: &Object) -> bool {
    root.get("extras").is_some_and(|extras| extras["lodc"]["quantized"].as_bool() == Some(true))
}

/// Takes a name off `extensionsUsed` and `extensionsRequired`.
pub(super) fn forget(root: &mut Object, name: &str) {
    for key in ["extensionsUsed", "extensionsRequired"] {
        let Some(Json::Array(names)) = root.get_mut(key) else { continue };
        let count_before = names.len();
        names.retain(|n| n.as_str() != Some(name));
        // An array that the file had empty stays.
        if names.is_empty() && count_before > 0 {
            root.shift_remove(key);
        }
    }
}

/// The member of `extras.lodc` that has extras which are no object.
const KEPT: &str = "extras";

/// Puts a member into an object's extras. Extras that are no object, which glTF allows, are kept as
/// `extras.lodc.extras`.
pub(super) fn put_extra(entry: &mut Object, key: &str, mut value: Json) {
    match entry.get_mut("extras") {
        Some(extras) if !extras.is_object() => {
            let kept = object! { KEPT => std::mem::replace(extras, Json::Null) };
            *extras = object! { "lodc" => kept };
        }
        _ => {}
    }
    let extras = &mut entry["extras"];
    if key == "lodc"
        && let Some(kept) = extras["lodc"].get(KEPT)
    {
        value[KEPT] = kept.clone();
    }
    extras[key] = value;
}

/// Takes a member out of an object's extras, and the extras with the last one. What
/// [`put_extra`] kept takes their place.
pub(super) fn forget_extra(entry: &mut Object, key: &str) {
    let Some(extras) = entry.get_mut("extras").and_then(Json::as_object_mut) else { return };
    let kept = extras.get("lodc").and_then(|lodc| lodc.get(KEPT)).cloned();
    extras.shift_remove(key);
    match kept {
        Some(kept) => {
            let own = object! { KEPT => kept.clone() };
            if key == "lodc" && !extras.is_empty() {
                extras["lodc"] = own;
            } else if extras.is_empty() || extras.len() == 1 && extras["lodc"] == own {
                entry["extras"] = kept;
            }
        }
        None if extras.is_empty() => {
            entry.shift_remove("extras");
        }
        None => {}
    }
}

/// What to say of extras that are no objects where levels may add to them; none if there are none.
pub(super) fn kept_extras(root: &Object) -> Option<String> {
    let is_kept = |entry: &Object| entry.get("extras").is_some_and(|extras| !extras.is_object());
    let of = |pool: &str| {
        let entries = root.entries(pool).enumerate();
        let may_be_added_to = |entry: &Object| pool == "meshes" || entry.contains_key("mesh");
        let kept = entries.filter(|(_, entry)| may_be_added_to(entry) && is_kept(entry));
        kept.map(|(number, _)| format!("{pool}[{number}].extras")).collect::<Vec<_>>()
    };
    let of_root = is_kept(root).then(|| "extras".to_owned());
    let all: Vec<String> = of_root.into_iter().chain(of("meshes")).chain(of("nodes")).collect();
    let more = match all.len() {
        0 => return None,
        1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    let first = &all[0];
    Some(format!(
        "{first}{more}: no object; where levels add to it, its value is at `lodc.extras` in it"
    ))
}

/// Names an extension in one of the lists of the document.
pub(crate) fn add(root: &mut Object, list: &str, name: &str) {
    if !root.list(list).iter().any(|n| n.as_str() == Some(name)) {
        root.append(list, vec![name.into()]);
    }
}

/// The pointer of an animation channel's target (KHR_animation_pointer).
pub(crate) fn animation_pointer(target: &mut Json) -> Option<&mut String> {
    let extension = target.get_mut("extensions")?.get_mut("KHR_animation_pointer")?;
    match extension.get_mut("pointer")? {
        Json::String(pointer) => Some(pointer),
        _ => None,
    }
}

/// The same, to read.
pub(super) fn pointer_of(target: &Object) -> Option<&str> {
    target.extension("KHR_animation_pointer")?["pointer"].as_str()
}

/// The node of a pointer such as `/nodes/7/weights`, and what follows it.
pub(super) fn of_node(pointer: &str) -> Option<(usize, &str)> {
    entry(pointer, "/nodes/")
}

/// The mesh of a pointer such as `/meshes/7/weights`, and what follows it.
pub(super) fn of_mesh(pointer: &str) -> Option<(usize, &str)> {
    entry(pointer, "/meshes/")
}

fn entry<'a>(pointer: &'a str, pool: &str) -> Option<(usize, &'a str)> {
    let (number, rest) = pointer.strip_prefix(pool)?.split_once('/')?;
    Some((whole(number)?, rest))
}

/// A number in a pointer: it has no sign and no zeros before it (RFC 6901, section 4).
pub(super) fn whole(number: &str) -> Option<usize> {
    number.parse().ok().filter(|n: &usize| n.to_string() == number)
}

/// Returns whether buffer views of a document are compressed.
pub(super) fn is_compressed(root: &Object) -> bool {
    let mut views = root.entries("bufferViews");
    views.any(|view| MESHOPT.iter().any(|name| view["extensions"].get(name).is_some()))
}

/// The compression of a buffer view, by whichever name.
pub(super) fn meshopt(view: &Object) -> Option<(&'static str, &Object)> {
    MESHOPT.into_iter().find_map(|name| Some((name, view.extension(name)?)))
}
