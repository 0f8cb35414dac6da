//! The animations of a glTF document as keyframes: channels, samplers, times and values, checked.

use super::document::Stored;
use super::extensions::{of_mesh, of_node, pointer_of, whole};
use super::graph::{Numbers, scene_graph};
use super::json::{Object, malformed};
use crate::{Document, FormatError, Limits, ObjectInfo};
use lodc_scene::{Animation, Channel, Interpolation, Motion, Property};

/// Returns the names of a document's animations, in order; empty where they have none.
///
/// # Errors
/// If the stored document is damaged.
pub fn animation_names(document: &Document, limits: &Limits) -> Result<Vec<String>, FormatError> {
    let Document::Gltf(gltf) = document else { return Ok(Vec::new()) };
    Stored::read(gltf, limits, |_, root| Ok(root.entries("animations").map(name).collect()))
}

fn name(animation: &Object) -> String {
    animation["name"].as_str().unwrap_or_default().to_owned()
}

/// Reads an animation by its number. What it changes beside nodes and their morph weights is left
/// out.
///
/// # Errors
/// If there is none of that number, or it is damaged.
pub fn animation(
    document: &Document,
    number: usize,
    limits: &Limits,
) -> Result<Animation, FormatError> {
    let location = format!("animations[{number}]");
    let Document::Gltf(gltf) = document else { return Err(malformed(location, "is not there")) };
    Stored::read(gltf, limits, |stored, root| {
        let missing = || malformed(&*location, "is not there");
        let animation = root.entries("animations").nth(number).ok_or_else(missing)?;
        read_animation(root, &|accessor| stored.numbers(accessor), animation, &location)
    })
}

/// Reads all animations, in order; damaged ones move nothing.
///
/// # Errors
/// If the stored document is damaged.
fn animations(document: &Document, limits: &Limits) -> Result<Vec<Animation>, FormatError> {
    let Document::Gltf(gltf) = document else { return Ok(Vec::new()) };
    Stored::read(gltf, limits, |stored, root| {
        Ok(sound_animations(root, &|accessor| stored.numbers(accessor)))
    })
}

/// Reads all animations of a glTF document, in order; damaged ones move nothing.
pub(super) fn sound_animations(root: &Object, read: &Numbers<'_>) -> Vec<Animation> {
    let animation = |(i, animation): (usize, _)| {
        read_animation(root, read, animation, &format!("animations[{i}]")).unwrap_or_default()
    };
    (0..).zip(root.entries("animations")).map(animation).collect()
}

/// Reads a scene at rest and its animations, as [`scene_graph`] and [`animation`] do; damaged
/// animations move nothing.
///
/// # Errors
/// If the stored document is damaged.
pub fn scene_motion(
    document: &Document,
    objects: &[&ObjectInfo],
    limits: &Limits,
) -> Result<Motion, FormatError> {
    let graph = scene_graph(document, objects, limits)?;
    Ok(Motion::new(graph, animations(document, limits)?, objects.len()))
}

fn read_animation(
    root: &Object,
    read: &Numbers<'_>,
    animation: &Object,
    location: &str,
) -> Result<Animation, FormatError> {
    let samplers: Vec<&Object> = animation.entries("samplers").collect();
    let mut channels = Vec::new();
    for (i, channel) in animation.entries("channels").enumerate() {
        let sampler = channel["sampler"].as_index().and_then(|s| samplers.get(s));
        let target = channel["target"].as_object();
        let (Some(sampler), Some(target)) = (sampler, target) else { continue };
        let location = format!("{location}.channels[{i}]");
        for (node, property) in moved(root, target) {
            channels.push(read_channel(read, sampler, (node, property), &location)?);
        }
    }
    Ok(Animation { name: name(animation), channels })
}

/// What a channel moves: properties of nodes, also of those whose mesh it gives other weights; none
/// if it changes something else.
fn moved(root: &Object, target: &Object) -> Vec<(u32, Property)> {
    let path = target["path"].as_str().unwrap_or_default();
    if path != "pointer" {
        let node = target["node"].as_index();
        return node.zip(property(path)).map(|(n, p)| (n as u32, p)).into_iter().collect();
    }
    let Some(pointer) = pointer_of(target) else { return Vec::new() };
    if let Some((node, path)) = of_node(pointer) {
        return property(path).map(|p| (node as u32, p)).into_iter().collect();
    }
    let Some((mesh, path)) = of_mesh(pointer) else { return Vec::new() };
    let Some(property) = property(path).filter(|p| p.is_of_targets()) else { return Vec::new() };
    // Weights of a node count instead of those of its mesh.
    let shows =
        |node: &Object| node["mesh"].as_index() == Some(mesh) && !node.contains_key("weights");
    let nodes = (0..).zip(root.entries("nodes")).filter(|(_, node)| shows(node));
    nodes.map(|(number, _)| (number, property)).collect()
}

fn property(path: &str) -> Option<Property> {
    Some(match path {
        "translation" => Property::Translation,
        "rotation" => Property::Rotation,
        "scale" => Property::Scale,
        "weights" => Property::Weights,
        _ => {
            let target = u16::try_from(whole(path.strip_prefix("weights/")?)?).ok()?;
            Property::Weight(target.into())
        }
    })
}

fn read_channel(
    read: &Numbers<'_>,
    sampler: &Object,
    (node, property): (u32, Property),
    location: &str,
) -> Result<Channel, FormatError> {
    let interpolation = match sampler["interpolation"].as_str() {
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        _ => Interpolation::Linear,
    };
    let numbers = |key: &str| match sampler[key].as_index() {
        Some(accessor) => read(accessor),
        None => Err(malformed(location, format!("its sampler has no {key}"))),
    };
    let ((times, _), (values, components)) = (numbers("input")?, numbers("output")?);
    let rising = times.windows(2).all(|pair| pair[0] < pair[1]);
    if !rising || times.iter().chain(&values).any(|v| !v.is_finite()) {
        return Err(malformed(
            location,
            "its times do not rise, or it has numbers that are not finite",
        ));
    }
    let keys = times.len() * interpolation.values_per_key();
    let width = match property {
        Property::Translation | Property::Scale => Some(3),
        Property::Rotation => Some(4),
        Property::Weight(_) => Some(1),
        Property::Weights => None,
    };
    let fits = match width {
        Some(width) => components == width && values.len() == keys * width,
        None => components == 1 && keys > 0 && values.len().is_multiple_of(keys),
    };
    if !fits {
        let problem = format!("has {} values for {} keys", values.len(), times.len());
        return Err(malformed(location, problem));
    }
    Ok(Channel { node, property, interpolation, times, values })
}

#[cfg(test)]
#[path = "animations_tests.rs"]
mod tests;
