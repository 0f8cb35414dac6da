//! Leaves the finest level of a glTF that has levels inside already: nodes that are coarser levels
//! of others (MSFT_lod), ranges of index accessors, and morph targets towards the next level.

use super::exported::{primitives, ranges, take_range};
use super::forest::children;
use super::geomorph;
use crate::gltf::extensions::{MSFT_LOD, animation_pointer, forget, forget_extra};
use crate::gltf::json::{Json, Object};
use crate::gltf::prune;
use crate::gltf::schema::{Pool, forget_references, renumbered, retain};
use crate::words::counted;
use crate::{Fault, FormatError};

/// Takes coarser levels out of a document, with what belongs to them alone: meshes, skins, entries
/// of animations. Their accessors stay, and nothing names them.
///
/// # Errors
/// If coarser levels cannot be told from what the scene shows besides.
pub(super) fn keep_finest(
    root: &mut Object,
    warnings: &mut Vec<String>,
) -> Result<(), FormatError> {
    geomorph::strip(root);
    take_ranges(root)?;
    if !root.entries("nodes").any(|node| node.extension(MSFT_LOD).is_some()) {
        return Ok(());
    }
    let dropped = coarser_nodes(root)?;
    drop_nodes(root, &dropped)?;
    let count = dropped.iter().filter(|is_dropped| **is_dropped).count();
    if count > 0 {
        let nodes = counted(count, "node of a coarser one is", "nodes of coarser ones are");
        warnings.push(format!("the file has levels of its own ({MSFT_LOD}): {nodes} left out"));
    }
    Ok(())
}

/// Leaves the range of the finest level of index accessors that hold several.
fn take_ranges(root: &mut Object) -> Result<(), FormatError> {
    let levels = root["extras"]["lodc"]["levels"].list().len();
    if levels < 2 {
        return Ok(());
    }
    let ranged = primitives(root).filter(|(_, primitive)| ranges(primitive).len() == levels);
    let ranged: Vec<(usize, usize)> = ranged.map(|(number, _)| number).collect();
    let mut empty = Vec::new();
    for number in ranged {
        if !take_range(root, number, 0, levels)? {
            empty.push(number);
        }
    }
    prune::without(root, &empty);
    Ok(())
}

/// The nodes that a node names as its coarser levels.
fn levels_of(node: &Object) -> impl Iterator<Item = usize> {
    let ids = node.extension(MSFT_LOD).map_or(&[][..], |lod| lod.list("ids"));
    ids.iter().filter_map(Json::as_index)
}

/// Returns which nodes are coarser levels of others, or below one.
fn coarser_nodes(root: &Object) -> Result<Vec<bool>, FormatError> {
    let nodes: Vec<&Object> = root.entries("nodes").collect();
    let count = nodes.len();
    let mut is_level = vec![false; count];
    let mut parents = vec![None; count];
    for (number, node) in nodes.iter().enumerate() {
        levels_of(node).filter(|&id| id < count).for_each(|id| is_level[id] = true);
        for child in children(node).filter(|&child| child < count) {
            parents[child] = Some(number);
        }
    }
    let mut is_topmost = vec![false; count];
    let shown = root.entries("scenes").flat_map(|scene| scene.list("nodes"));
    shown.filter_map(Json::as_index).filter(|&n| n < count).for_each(|n| is_topmost[n] = true);

    let mut dropped = vec![false; count];
    for finest in (0..count).filter(|&n| !is_level[n]) {
        let mut stack: Vec<usize> = levels_of(nodes[finest]).collect();
        while let Some(id) = stack.pop().filter(|&id| id < count) {
            if std::mem::replace(&mut dropped[id], true) {
                continue;
            }
            // What stands elsewhere in the scene may be an object of its own.
            let is_beside = match parents[id] {
                Some(parent) => {
                    parent == finest || Some(parent) == parents[finest] || dropped[parent]
                }
                None => !is_topmost[id] || parents[finest].is_none(),
            };
            if !is_beside {
                return Err(unsupported(
                    format!("nodes[{id}]"),
                    format!(
                        "is a coarser level of nodes[{finest}] ({MSFT_LOD}), but shown by itself, \
                         too"
                    ),
                ));
            }
            stack.extend(levels_of(nodes[id]));
        }
    }
    if let Some(node) = (0..count).find(|&n| is_level[n] && !dropped[n]) {
        let problem = format!("is a level of itself ({MSFT_LOD})");
        return Err(unsupported(format!("nodes[{node}]"), problem));
    }
    let mut below: Vec<usize> = (0..count).filter(|&n| dropped[n]).collect();
    while let Some(node) = below.pop() {
        for child in children(nodes[node]).filter(|&child| child < count) {
            if !std::mem::replace(&mut dropped[child], true) {
                below.push(child);
            }
        }
    }
    Ok(dropped)
}

fn unsupported(location: String, problem: String) -> FormatError {
    FormatError::new(Fault::Unsupported, location, problem)
}

fn drop_nodes(root: &mut Object, dropped: &[bool]) -> Result<(), FormatError> {
    let nodes_kept: Vec<bool> = dropped.iter().map(|dropped| !dropped).collect();
    // What only dropped nodes show, or are moved by, goes with them.
    let kept = |pool: Pool, key: &str| -> Vec<bool> {
        let mut users = vec![[false; 2]; pool.len(root)];
        for (node, &is_dropped) in root.entries("nodes").zip(dropped) {
            if let Some(users) = node[key].as_index().and_then(|i| users.get_mut(i)) {
                users[usize::from(is_dropped)] = true;
            }
        }
        users.iter().map(|[kept, dropped]| *kept || !dropped).collect()
    };
    let (meshes_kept, skins_kept) = (kept(Pool::Meshes, "mesh"), kept(Pool::Skins, "skin"));
    for (number, skin) in root.entries("skins").enumerate().filter(|(s, _)| skins_kept[*s]) {
        let mut joints = skin.list("joints").iter().filter_map(Json::as_index);
        if let Some(joint) = joints.find(|&joint| dropped.get(joint) == Some(&true)) {
            return Err(unsupported(
                format!("skins[{number}]"),
                format!(
                    "its joint nodes[{joint}] is of a coarser level ({MSFT_LOD}), which is left out"
                ),
            ));
        }
    }
    for node in root.objects_mut("nodes") {
        node.remove_extension(MSFT_LOD);
        forget_extra(node, "MSFT_screencoverage");
        leave(node, "children", &nodes_kept);
    }
    root.objects_mut("scenes").for_each(|scene| leave(scene, "nodes", &nodes_kept));
    for skin in root.objects_mut("skins") {
        if skin["skeleton"].as_index().is_some_and(|node| nodes_kept.get(node) == Some(&false)) {
            skin.shift_remove("skeleton");
        }
    }
    if !root.entries("materials").any(|material| material.extension(MSFT_LOD).is_some()) {
        forget(root, MSFT_LOD);
    }
    drop_channels(root, &nodes_kept, &meshes_kept);
    for (pool, kept) in
        [(Pool::Skins, &skins_kept), (Pool::Meshes, &meshes_kept), (Pool::Nodes, &nodes_kept)]
    {
        forget_references(root, pool, kept);
        retain(root, pool, kept);
    }
    Ok(())
}

/// Leaves the entries of a list of nodes that are kept; removes it if there are none.
fn leave(object: &mut Object, key: &str, kept: &[bool]) {
    if let Some(Json::Array(all)) = object.get_mut(key) {
        let count_before = all.len();
        all.retain(|node| node.as_index().is_none_or(|n| kept.get(n) != Some(&false)));
        if all.is_empty() && count_before > 0 {
            object.shift_remove(key);
        }
    }
}

/// Drops channels that animate what is gone, and renumbers what the pointers of others name.
fn drop_channels(root: &mut Object, nodes_kept: &[bool], meshes_kept: &[bool]) {
    let pools = [("/nodes/", nodes_kept), ("/meshes/", meshes_kept)]
        .map(|(beginning, kept)| (beginning, kept, renumbered(kept)));
    let remains = |channel: &mut Json| {
        let Some(target) = channel.get_mut("target") else { return true };
        if target["node"].as_index().is_some_and(|node| nodes_kept.get(node) == Some(&false)) {
            return false;
        }
        let Some(pointer) = animation_pointer(target) else { return true };
        for (beginning, kept, numbers) in &pools {
            let Some(path) = pointer.strip_prefix(beginning) else { continue };
            let (number, rest) = path.split_at(path.find('/').unwrap_or(path.len()));
            let Some(old) = number.parse().ok().filter(|&old: &usize| old < kept.len()) else {
                continue;
            };
            if !kept[old] {
                return false;
            }
            *pointer = format!("{beginning}{}{rest}", numbers[old]);
            return true;
        }
        true
    };
    let Some(Json::Array(animations)) = root.get_mut("animations") else { return };
    animations.retain_mut(|animation| {
        let Some(Json::Array(channels)) = animation.get_mut("channels") else { return true };
        let count_before = channels.len();
        channels.retain_mut(remains);
        !channels.is_empty() || count_before == 0
    });
    if animations.is_empty() {
        root.shift_remove("animations");
    }
}
