//! Extensions that this package reads, passes through, or must refuse.

use super::json::{Json, Object, malformed};
use crate::{Fault, FormatError};

/// Compressed vertex and index data: decoded.
pub(crate) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Returns whether buffer views of a document are compressed.
pub(super) fn is_compressed(root: &Object) -> bool {
    let mut views = root.entries("bufferViews");
    views.any(|view| MESHOPT.iter().any(|name| view["extensions"].get(name).is_some()))
}
/// Streams of short integers.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";
/// Compressed primitives: decoded unless the same data is there uncompressed.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// Extensions of a primitive that count its vertices or triangles, which change: dropped from
/// primitives with triangles.
pub(super) const DROPPED_FROM_PRIMITIVES: [&str; 3] =
    [DRACO, "CESIUM_primitive_outline", "FB_ngon_encoding"];

/// Extensions that can be required without a reader of triangles having to know them, and in whose
/// objects no number is the index of an accessor or buffer view that `schema` does not list.
const HARMLESS: [&str; 22] = [
    QUANTIZATION,
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_instance_features",
    "EXT_feature_metadata",
    "EXT_lights_image_based",
    "EXT_lights_ies",
    "KHR_animation_pointer",
    "KHR_audio_emitter",
    "KHR_lights_punctual",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "MSFT_audio_emitter",
    "AGI_articulations",
    "CESIUM_RTC",
];

/// Beginnings of names of further such extensions: those of materials and textures.
const HARMLESS_PREFIXES: [&str; 8] = [
    "KHR_materials_",
    "EXT_materials_",
    "MSFT_materials_",
    "ADOBE_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_techniques_",
];

fn is_harmless(name: &str) -> bool {
    HARMLESS.contains(&name) || HARMLESS_PREFIXES.iter().any(|p| name.starts_with(p))
}

/// Refuses glTF versions other than 2, and required extensions that are not known here. Draco is
/// decoded later, where there is no fallback.
pub(super) fn check(root: &Object) -> Result<(), FormatError> {
    let asset = root["asset"].as_object();
    let asset = asset.ok_or_else(|| malformed("asset", "is missing: not a glTF 2.0 document"))?;
    let version = asset["version"].as_str();
    let version = version.ok_or_else(|| malformed("asset.version", "is missing"))?;
    let Some((major, minor)) = numbers(version) else {
        return Err(malformed("asset.version", format!("`{version}` is not a version")));
    };
    let minimum = asset["minVersion"].as_str().map(numbers);
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
        if name != DRACO && !is_harmless(name) {
            return unsupported(
                "extensionsRequired",
                format!("the extension {name} is required, but not supported"),
            );
        }
    }
    Ok(())
}

fn numbers(version: &str) -> Option<(u32, u32)> {
    let (major, minor) = version.split_once('.')?;
    let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit()).then(|| s.parse().ok()).flatten();
    Some((digits(major)?, digits(minor)?))
}

/// The first unknown extension with a whole number somewhere, which might be the index of an
/// accessor or buffer view. While there is one, nothing must be renumbered.
pub(crate) fn opaque(root: &Object) -> Option<String> {
    root.iter().find_map(|(key, value)| opaque_below(key, value))
}

// The document's depth is bounded, so recursion is.
fn opaque_below(key: &str, value: &Json) -> Option<String> {
    match value {
        Json::Object(members) if key == "extensions" => members.iter().find_map(|(name, body)| {
            if !is_harmless(name)
                && !DROPPED_FROM_PRIMITIVES.contains(&name.as_str())
                && has_whole_number(body)
            {
                return Some(name.clone());
            }
            opaque_below("", body)
        }),
        Json::Object(_) if key == "extras" => None,
        Json::Object(members) => members.iter().find_map(|(name, body)| opaque_below(name, body)),
        Json::Array(elements) => elements.iter().find_map(|body| opaque_below("", body)),
        _ => None,
    }
}

fn has_whole_number(value: &Json) -> bool {
    match value {
        Json::Number(_) => value.as_u64().is_some(),
        Json::Array(elements) => elements.iter().any(has_whole_number),
        Json::Object(members) => members.values().any(has_whole_number),
        _ => false,
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

/// Takes a member out of an object's extras, and the extras with the last one.
pub(super) fn forget_extra(entry: &mut Object, key: &str) {
    if let Some(extras) = entry.get_mut("extras").and_then(Json::as_object_mut) {
        extras.shift_remove(key);
        if extras.is_empty() {
            entry.shift_remove("extras");
        }
    }
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

/// The node of a pointer such as `/nodes/7/weights`, and what follows it.
pub(super) fn of_node(pointer: &str) -> Option<(usize, &str)> {
    let (number, rest) = pointer.strip_prefix("/nodes/")?.split_once('/')?;
    let node: usize = number.parse().ok()?;
    // Numbers have no sign and no zeros before them (RFC 6901, section 4).
    (node.to_string() == number).then_some((node, rest))
}

/// The compression of a buffer view, by whichever name.
pub(super) fn meshopt(view: &Object) -> Option<(&'static str, &Object)> {
    MESHOPT.into_iter().find_map(|name| Some((name, view.extension(name)?)))
}
