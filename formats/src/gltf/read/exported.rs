//! Reads files that `extract` and `chain` wrote: each level becomes a scene of its own, as if its
//! document held nothing else, so that it can be verified against the source.

use super::primitive::{self, Read};
use super::{Opened, geomorph, open};
use crate::exported::{ExportedLevels, NOT_EXPORTED};
use crate::gltf::accessor::{Accessor, numbered_component};
use crate::gltf::budget::Budget;
use crate::gltf::extensions::{MSFT_LOD, animation_pointer, forget_extra, of_mesh, pointer_of};
use crate::gltf::glb;
use crate::gltf::json::{self, Json, Object, malformed};
use crate::gltf::prune;
use crate::gltf::schema::{Pool, forget_references, primitive_mut, retain};
use crate::gltf::views::Views;
use crate::options::ImportOptions;
use crate::provenance::{GeomorphFacts, LevelFacts, Provenance, ScreenFacts};
use crate::words::without_mark;
use crate::{Assets, FormatError};
use lodc_mesh::{Component, PoseKey};
use std::collections::{BTreeMap, BTreeSet};

/// Keys of a node that place and deform what it shows.
const PLACING: [&str; 6] = ["matrix", "translation", "rotation", "scale", "skin", "weights"];

/// Returns whether a glTF or GLB states levels.
pub(crate) fn states_levels(bytes: &[u8], options: &ImportOptions) -> bool {
    let text = if glb::is_glb(bytes) {
        glb::split(bytes).ok().map(|chunks| &bytes[chunks.json])
    } else {
        Some(without_mark(bytes))
    };
    let root = text.and_then(|text| json::parse(text, &options.limits).ok());
    root.is_some_and(|root| stated(&root).is_ok())
}

/// Reads the levels of a glTF or GLB.
///
/// # Errors
/// As of an import, and if it states no levels or has others than it states.
pub(crate) fn exported(
    bytes: &[u8],
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<ExportedLevels, FormatError> {
    let (mut root, opened) = open(bytes, assets, options)?;
    let stated = stated(&root)?;
    let pairs = Chain::of(&root, stated.levels.len()).pairs(&root);
    let morphs = geomorph::morphs(&root, &opened, &pairs, assets, options)?;
    geomorph::strip(&mut root);
    let chain = Chain::of(&root, stated.levels.len());
    let is_chain = !chain.nodes.is_empty() || chain.has_ranges;
    if stated.levels.len() > 1 && !is_chain && primitives(&root).next().is_some() {
        let problem = format!(
            "states {} levels, of which no node or primitive has more than one",
            stated.levels.len()
        );
        return Err(malformed("extras.lodc.levels", problem));
    }
    let difference = chain.difference(&root, &opened)?;
    let scene = |level| opened.scene(chain.level(&root, level)?, assets, options);
    let levels = (0..stated.levels.len()).map(scene).collect::<Result<_, _>>()?;
    Ok(ExportedLevels { stated, levels, difference, morphs })
}

/// What `extras.lodc` of a document says.
fn stated(root: &Object) -> Result<Provenance, FormatError> {
    let all = &root["extras"]["lodc"];
    let source = all["source"].as_str().and_then(|hash| u128::from_str_radix(hash, 16).ok());
    let source = source.ok_or_else(|| malformed("extras.lodc", NOT_EXPORTED))?;
    let facts = |level: &Json| LevelFacts {
        lod: level["lod"].as_u64().and_then(|lod| u32::try_from(lod).ok()),
        error: level["error"].as_f64().unwrap_or(f64::INFINITY),
        rms: level["rms"].as_f64(),
        geomorph: level.get("morph_from").map(|from| GeomorphFacts {
            distance: level["distance"].as_f64(),
            morph_from: from.as_f64(),
            pose_error: level["geomorph_pose_error"].as_f64(),
            staying: level["geomorph_staying"].as_u64().unwrap_or(0),
        }),
    };
    let screen_number = |key: &str| all["screen"][key].as_f64();
    let screen = screen_number("pixels").zip(screen_number("height")).zip(screen_number("fovy"));
    let screen = screen.map(|((pixels, height), fovy)| ScreenFacts { pixels, height, fovy });
    let levels = match all["levels"].list() {
        [] => vec![facts(all)],
        several => several.iter().map(facts).collect(),
    };
    let refitted = all["refitted"].as_bool().unwrap_or(false);
    let object_poses = |object: &Json| object.list().iter().filter_map(pose_key).collect();
    let states_poses = all["errors_over"]["rest"].as_bool() == Some(true);
    let poses = states_poses.then(|| all["poses"].list().iter().map(object_poses).collect());
    let next = all["next"].as_str().map(str::to_owned);
    Ok(Provenance { source, levels, refitted, screen, next, poses })
}

/// A pose that errors are the largest over.
fn pose_key(pose: &Json) -> Option<PoseKey> {
    let number = |key: &str| pose[key].as_u64().and_then(|n| u32::try_from(n).ok());
    let moment = || {
        let seconds = pose["seconds"].as_f64().filter(|seconds| *seconds >= 0.0)?;
        Some(PoseKey::Moment { animation: number("animation")?, seconds })
    };
    number("target").map(PoseKey::Target).or_else(moment)
}

/// Where a document has several levels.
struct Chain {
    /// Number of levels.
    levels: usize,
    /// For each node that shows the finest level, the nodes of the coarser ones in order.
    nodes: BTreeMap<usize, Vec<usize>>,
    /// True if a primitive has the triangles of all levels in one index accessor.
    has_ranges: bool,
}

impl Chain {
    fn of(root: &Object, levels: usize) -> Self {
        let ids = |node: &Object| -> Vec<usize> {
            let ids = node.extension(MSFT_LOD).map_or(&[][..], |lod| lod.list("ids"));
            ids.iter().filter_map(Json::as_index).collect()
        };
        let nodes = root.entries("nodes").enumerate();
        let nodes = nodes.filter(|(_, node)| levels > 1 && node["mesh"].as_index().is_some());
        let nodes = nodes.map(|(n, node)| (n, ids(node)));
        let nodes = nodes.filter(|(_, ids)| ids.len() + 1 == levels).collect();
        let has_ranges = levels > 1 && primitives(root).any(|(_, p)| ranges(p).len() == levels);
        Self { levels, nodes, has_ranges }
    }

    /// The meshes of levels that follow each other, each pair once, and the level of the first.
    fn pairs(&self, root: &Object) -> Vec<(usize, [usize; 2])> {
        let mut pairs = Vec::new();
        for (&node, ids) in &self.nodes {
            let level_nodes = std::iter::once(&node).chain(ids);
            let meshes: Vec<usize> =
                level_nodes.filter_map(|&n| root["nodes"][n]["mesh"].as_index()).collect();
            pairs.extend(meshes.windows(2).enumerate().map(|(k, pair)| (k, [pair[0], pair[1]])));
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Returns the document of one level.
    fn level(&self, root: &Object, level: usize) -> Result<Object, FormatError> {
        let mut level_document = root.clone();
        let mut empty = Vec::new();
        if self.has_ranges {
            for (m, p) in primitives(root).map(|(numbers, _)| numbers) {
                if !take_range(&mut level_document, (m, p), level, self.levels)? {
                    empty.push((m, p));
                }
            }
        }
        self.take_nodes(root, &mut level_document, level);
        prune::without(&mut level_document, &empty);
        Ok(level_document)
    }

    /// Gives the meshes of level 0 the primitives of another level, whose own meshes and nodes go.
    fn take_nodes(&self, root: &Object, level_root: &mut Object, level: usize) {
        let mesh_of = |node: usize| root["nodes"][node]["mesh"].as_index();
        let mut nodes_kept = vec![true; Pool::Nodes.len(root)];
        let mut meshes_kept = vec![true; Pool::Meshes.len(root)];
        for (&node, ids) in &self.nodes {
            let finest = mesh_of(node);
            let level_mesh = std::iter::once(&node).chain(ids).nth(level).and_then(|&n| mesh_of(n));
            if let (Some(finest), Some(level_mesh)) = (finest, level_mesh) {
                level_root["meshes"].as_array_mut().into_iter().for_each(|meshes| {
                    meshes[finest]["primitives"] = root["meshes"][level_mesh]["primitives"].clone();
                });
            }
            for &id in ids {
                nodes_kept[id] = false;
                if let Some(mesh) = mesh_of(id).filter(|&mesh| Some(mesh) != finest) {
                    meshes_kept[mesh] = false;
                }
            }
            if let Some(entry) = level_root.object_mut("nodes", node) {
                entry.remove_extension(MSFT_LOD);
                forget_extra(entry, "MSFT_screencoverage");
            }
        }
        if self.nodes.is_empty() {
            return;
        }
        for (node, is_kept) in level_root.objects_mut("nodes").zip(&nodes_kept) {
            if !is_kept {
                node.shift_remove("mesh");
            }
        }
        for animation in level_root.objects_mut("animations") {
            if let Some(Json::Array(channels)) = animation.get_mut("channels") {
                channels.retain_mut(|channel| {
                    let is_gone = |number: Option<usize>, kept: &[bool]| {
                        number.is_some_and(|number| kept.get(number) == Some(&false))
                    };
                    !is_gone(target(channel), &nodes_kept)
                        && !is_gone(morphed(channel), &meshes_kept)
                });
            }
        }
        forget_references(level_root, Pool::Meshes, &meshes_kept);
        forget_references(level_root, Pool::Nodes, &nodes_kept);
        retain(level_root, Pool::Meshes, &meshes_kept);
        retain(level_root, Pool::Nodes, &nodes_kept);
    }

    /// Returns what levels do not share although they should: the vertices, of which coarser levels
    /// use a shorter prefix, and what places and moves their nodes.
    fn difference(&self, root: &Object, file: &Opened<'_>) -> Result<Option<String>, FormatError> {
        let budget = Budget::new(file.bytes);
        let views = Views::new(root, &file.buffers, &budget)?;
        let accessors = Accessor::all(root, &views)?;
        let indices = |(m, p): (usize, usize), primitive: &Object| {
            let location = format!("meshes[{m}].primitives[{p}]");
            let Read::Triangles(read) = primitive::read(primitive, location, &accessors)? else {
                return Ok(Vec::new());
            };
            let positions = accessors.get(read.position).and_then(Option::as_ref);
            let vertices = positions.map_or(0, |positions| positions.count);
            read.corners(vertices, &accessors, &views)
        };
        for ((m, p), primitive) in primitives(root) {
            let location = || format!("meshes[{m}].primitives[{p}].extras.lodc.levels");
            let ranges = ranges(primitive);
            if ranges.len() != self.levels || !self.has_ranges {
                continue;
            }
            if let Some(problem) = wrong_ranges(ranges, &indices((m, p), primitive)?) {
                return Ok(Some(format!("{}: {problem}", location())));
            }
        }
        for (&node, ids) in &self.nodes {
            if let Some(problem) = wrong_nodes(root, node, ids) {
                return Ok(Some(problem));
            }
            let meshes = std::iter::once(&node)
                .chain(ids)
                .filter_map(|&n| root["nodes"][n]["mesh"].as_index());
            // Primitives of the finest level; and by buffer, which several primitives may share,
            // the number of vertices that the level before uses.
            let (mut finest, mut prefixes) = (BTreeSet::new(), BTreeMap::new());
            for (k, mesh) in meshes.enumerate() {
                let mut used_by = BTreeMap::new();
                for (p, primitive) in mesh_primitives(root, mesh) {
                    let used = indices((mesh, p), primitive)?
                        .into_iter()
                        .max()
                        .map_or(0, |v| v as usize + 1);
                    let buffer = format!("{} {}", primitive["attributes"], primitive["targets"]);
                    let kind = format!("{buffer} {}", primitive["material"]);
                    if k == 0 {
                        finest.insert(kind);
                    } else if !finest.contains(&kind) {
                        return Ok(Some(format!(
                            "meshes[{mesh}].primitives[{p}]: has other vertices than the finest \
                             level"
                        )));
                    }
                    let all = used_by.entry(buffer).or_insert((0, p));
                    *all = (used, p).max(*all);
                }
                for (buffer, (used, p)) in used_by {
                    let before = prefixes.insert(buffer, used).unwrap_or(usize::MAX);
                    if k > 0 && used > before {
                        return Ok(Some(format!(
                            "meshes[{mesh}].primitives[{p}]: needs {used} vertices, the finer \
                             level {before}"
                        )));
                    }
                }
            }
        }
        Ok(None)
    }
}

/// All primitives, each with the number of its mesh and its own.
pub(super) fn primitives(root: &Object) -> impl Iterator<Item = ((usize, usize), &Object)> {
    (0..Pool::Meshes.len(root))
        .flat_map(|m| mesh_primitives(root, m).map(move |(p, primitive)| ((m, p), primitive)))
}

fn mesh_primitives(root: &Object, mesh: usize) -> impl Iterator<Item = (usize, &Object)> {
    let all = root["meshes"][mesh]["primitives"].list().iter().enumerate();
    all.filter_map(|(p, primitive)| Some((p, primitive.as_object()?)))
}

/// The ranges of a primitive's index accessor, one for each level; none without them.
pub(super) fn ranges(primitive: &Object) -> &[Json] {
    primitive["extras"]["lodc"]["levels"].list()
}

/// First index, number of indices, and number of vertices of a range.
fn range(range: &Json) -> Option<[usize; 3]> {
    let [first, count, vertices] = ["first", "count", "vertices"].map(|key| range[key].as_index());
    Some([first?, count?, vertices?])
}

fn wrong_ranges(ranges: &[Json], indices: &[u32]) -> Option<String> {
    let (mut next, mut max_vertices) = (0, usize::MAX);
    for (level, entry) in ranges.iter().enumerate() {
        let Some([first, count, vertices]) = range(entry) else {
            return Some(format!("level {level} has no first, count and vertices"));
        };
        let Some(level_indices) = indices.get(first..first.saturating_add(count)) else {
            return Some(format!("level {level} ends beyond the {} indices", indices.len()));
        };
        let used = level_indices.iter().max().map_or(0, |&v| v as usize + 1);
        if used != vertices || used > max_vertices || first != next {
            return Some(format!(
                "level {level} is at {first}, not {next}, or uses {used} vertices, not {vertices}"
            ));
        }
        (next, max_vertices) = (first + count, used);
    }
    (next != indices.len())
        .then(|| format!("the ranges end at {next} of {} indices", indices.len()))
}

/// Returns how the nodes of coarser levels differ from the one of the finest.
fn wrong_nodes(root: &Object, node: usize, ids: &[usize]) -> Option<String> {
    let finest = &root["nodes"][node];
    let coverage = finest["extras"]["MSFT_screencoverage"].list();
    let coverage: Vec<f64> = coverage.iter().filter_map(Json::as_f64).collect();
    if coverage.len() != ids.len() + 1 || !coverage.is_sorted_by(|a, b| a >= b) {
        return Some(format!(
            "nodes[{node}].extras.MSFT_screencoverage: no share for each level, falling"
        ));
    }
    let channels = |wanted: usize| -> Vec<(usize, Json)> {
        let mesh = root["nodes"][wanted]["mesh"].as_index();
        let animations = root.entries("animations").enumerate();
        let all = animations.flat_map(|(a, animation)| {
            animation.list("channels").iter().map(move |channel| (a, channel.clone()))
        });
        let channels_of_node = all.filter_map(|(a, mut channel)| {
            (target(&mut channel) == Some(wanted) || mesh.is_some() && mesh == morphed(&channel))
                .then_some((a, channel))
        });
        let mut channels: Vec<(usize, Json)> = channels_of_node.collect();
        // Those of meshes are repeated after those of nodes.
        channels.sort_by_key(|(a, channel)| (*a, morphed(channel).is_some()));
        channels
            .into_iter()
            .map(|(a, mut channel)| {
                // The node differs; what moves there has to be the same.
                let pointer = animation_pointer(&mut channel["target"]).map(|pointer| {
                    let pool = pointer.split('/').nth(1).unwrap_or_default();
                    let property = pointer.splitn(4, '/').last().unwrap_or_default();
                    *pointer = format!("{pool}/{property}");
                });
                if pointer.is_none() {
                    channel["target"]["node"] = Json::Null;
                }
                (a, channel)
            })
            .collect()
    };
    let finest_channels = channels(node);
    ids.iter().find_map(|&id| {
        let coarser = &root["nodes"][id];
        let key = PLACING.into_iter().find(|key| coarser[*key] != finest[*key]);
        let extensions = |of: &Json| {
            let mut extensions = of["extensions"].as_object().cloned().unwrap_or_default();
            extensions.shift_remove(MSFT_LOD);
            extensions
        };
        let key =
            key.or_else(|| (extensions(coarser) != extensions(finest)).then_some("extensions"));
        let problem = key.map(|key| format!("nodes[{id}].{key}: is not that of nodes[{node}]"));
        problem.or_else(|| {
            (channels(id) != finest_channels)
                .then(|| format!("nodes[{id}]: is not animated as nodes[{node}] is"))
        })
    })
}

/// The node that an animation channel moves.
fn target(channel: &mut Json) -> Option<usize> {
    let target = channel.get_mut("target")?;
    target["node"].as_index().or_else(|| {
        let pointer = animation_pointer(target)?;
        pointer.strip_prefix("/nodes/")?.split('/').next()?.parse().ok()
    })
}

/// The mesh whose weights an animation channel changes.
fn morphed(channel: &Json) -> Option<usize> {
    let (mesh, property) = of_mesh(pointer_of(channel["target"].as_object()?)?)?;
    property.starts_with("weights").then_some(mesh)
}

/// Gives a primitive an index accessor of one level alone; false if it has no triangle there.
pub(super) fn take_range(
    document: &mut Object,
    (mesh, primitive): (usize, usize),
    level: usize,
    levels: usize,
) -> Result<bool, FormatError> {
    let location = || format!("meshes[{mesh}].primitives[{primitive}]");
    let entry = primitive_mut(document, mesh, primitive);
    let Some(entry) = entry else { return Ok(true) };
    let ranges = ranges(entry);
    if ranges.len() != levels {
        return Ok(true);
    }
    let (range, accessor) = (range(&ranges[level]), entry["indices"].as_index());
    let (Some([first, count, _]), Some(accessor)) = (range, accessor) else {
        return Err(malformed(location(), "has no range for each level"));
    };
    if count == 0 {
        return Ok(false);
    }
    let mut level_accessor = document["accessors"][accessor].clone();
    let component = level_accessor["componentType"].as_u64().and_then(numbered_component);
    let size = component.map_or(0, Component::size);
    let offset = level_accessor["byteOffset"].as_index().unwrap_or(0) + first * size;
    level_accessor["byteOffset"] = offset.into();
    level_accessor["count"] = count.into();
    for key in ["min", "max"] {
        level_accessor.as_object_mut().map(|members| members.shift_remove(key));
    }
    let number = Pool::Accessors.len(document);
    document.append("accessors", vec![level_accessor]);
    if let Some(entry) = primitive_mut(document, mesh, primitive) {
        entry["indices"] = number.into();
        forget_extra(entry, "lodc");
    }
    Ok(true)
}
