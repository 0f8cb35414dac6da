//! Reads the morph targets in which an exported chain stores where each level's vertices move
//! (geomorph) as the next level takes over, and removes them from the document.

use super::primitive::{self, Read};
use super::{Opened, open};
use crate::exported::{Geomorph, GeomorphPart};
use crate::gltf::accessor::Accessor;
use crate::gltf::budget::Budget;
use crate::gltf::extensions::forget_extra;
use crate::gltf::json::{Json, Object};
use crate::gltf::schema::Pool;
use crate::gltf::uri;
use crate::gltf::views::Views;
use crate::options::ImportOptions;
use crate::{Assets, FormatError, GEOMORPH_TARGET};
use lodc_mesh::{Attribute, Component, Semantic};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

/// The number of the morph target that moves a mesh to the next level.
fn geomorph_target(mesh: &Object) -> Option<usize> {
    let number = mesh["extras"]["lodc"]["next"].as_index()?;
    let is_named =
        mesh["extras"]["targetNames"].list().get(number)?.as_str() == Some(GEOMORPH_TARGET);
    is_named.then_some(number)
}

/// Takes these targets out of a document, with their weights and the animations of these.
pub(super) fn strip(root: &mut Object) {
    let targets: BTreeMap<usize, usize> = root
        .entries("meshes")
        .enumerate()
        .filter_map(|(m, mesh)| Some((m, geomorph_target(mesh)?)))
        .collect();
    if targets.is_empty() {
        return;
    }
    let unsparse = bases_of_sparse(root);
    // The target is the last one, so its number is the count of those that stay.
    for (m, mesh) in root.objects_mut("meshes").enumerate() {
        let Some(&count) = targets.get(&m) else { continue };
        shorten(mesh, "weights", count);
        for primitive in mesh.objects_mut("primitives") {
            shorten(primitive, "targets", count);
            let attributes = primitive.get_mut("attributes").and_then(Json::as_object_mut);
            for (_, accessor) in attributes.into_iter().flat_map(|a| a.iter_mut()) {
                if let Some(base) = accessor.as_index().and_then(|a| unsparse.get(&a)) {
                    *accessor = (*base).into();
                }
            }
        }
        // Names of targets that had none were made up for the export.
        let names_gone = mesh["extras"]["lodc"]["unnamed"].as_bool() == Some(true) || count == 0;
        match mesh.get_mut("extras").and_then(Json::as_object_mut) {
            Some(extras) if !names_gone => shorten(extras, "targetNames", count),
            _ => forget_extra(mesh, "targetNames"),
        }
        forget_extra(mesh, "lodc");
    }
    for node in root.objects_mut("nodes") {
        if let Some(&count) = node["mesh"].as_index().and_then(|mesh| targets.get(&mesh)) {
            shorten(node, "weights", count);
        }
    }
    for animation in root.objects_mut("animations") {
        // A sampler of weights with one more for the target names the one without it (`narrow`).
        // They are the last samplers.
        let narrow = |sampler: &Json| sampler["extras"]["lodc"]["narrow"].as_index();
        let narrow: Vec<Option<usize>> = animation.list("samplers").iter().map(narrow).collect();
        for channel in animation.objects_mut("channels") {
            let sampler = channel["sampler"].as_index().and_then(|s| *narrow.get(s)?);
            if let Some(narrow) = sampler {
                channel["sampler"] = narrow.into();
            }
        }
        let remaining = narrow.iter().rposition(Option::is_none).map_or(0, |last| last + 1);
        if let Some(Json::Array(samplers)) = animation.get_mut("samplers") {
            samplers.truncate(remaining);
        }
    }
}

/// Leaves the first `count` elements of a list; removes it if there are none.
fn shorten(object: &mut Object, key: &str, count: usize) {
    if let Some(Json::Array(all)) = object.get_mut(key) {
        all.truncate(count);
        if all.is_empty() {
            object.shift_remove(key);
        }
    }
}

/// Maps each sparse accessor to the one that is the same but for the replaced elements.
fn bases_of_sparse(root: &Object) -> BTreeMap<usize, usize> {
    let all: Vec<&Object> = root.entries("accessors").collect();
    // Only those that levels share are sparse over a view: few, so each may search all others.
    let replaced = all.iter().enumerate().filter_map(|(a, accessor)| {
        let mut base = (*accessor).clone();
        base.shift_remove("sparse")?;
        base.get("bufferView")?;
        Some((a, all.iter().position(|other| **other == base)?))
    });
    replaced.collect()
}

/// Reads how the vertices of each level move to the next one, in this file or in the one that it
/// names as next. `pairs` has levels, each with its mesh and that of the next level.
///
/// # Errors
/// If the file of the next level cannot be read.
pub(super) fn morphs(
    root: &Object,
    file: &Opened<'_>,
    pairs: &[(usize, [usize; 2])],
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<Vec<Geomorph>, FormatError> {
    let is_morphing = root.entries("meshes").any(|mesh| geomorph_target(mesh).is_some());
    if !is_morphing {
        return Ok(Vec::new());
    }
    let budget = Budget::new(file.bytes.saturating_mul(MAX_READS));
    let views = Views::new(root, &file.buffers, &budget)?;
    let this_file = Meshes { root, accessors: &Accessor::all(root, &views)?, views: &views };
    let mut all = Vec::new();
    let mut add = |level: usize, mesh: usize, next: Option<(&Meshes<'_>, usize)>| {
        if let Some(from) = this_file.moved(mesh)? {
            let names = moved_attributes(root, mesh);
            let to = next.map(|(file, mesh)| file.parts(mesh, None, &names)).transpose()?;
            let (location, to) = (format!("meshes[{mesh}]"), to.unwrap_or_default());
            all.push(Geomorph { level, location, from, to });
        }
        Ok::<_, FormatError>(())
    };
    for &(level, [mesh, next]) in pairs {
        add(level, mesh, Some((&this_file, next)))?;
    }
    let Some(name) = root["extras"]["lodc"]["next"].as_str() else { return Ok(all) };
    let bytes = uri::read(name, "extras.lodc.next", assets)?;
    let (other, other_file) = open(&bytes, assets, options)?;
    let budget = Budget::new(other_file.bytes.saturating_mul(MAX_READS));
    let views = Views::new(&other, &other_file.buffers, &budget)?;
    let accessors = Accessor::all(&other, &views)?;
    let next_file = Meshes { root: &other, accessors: &accessors, views: &views };
    let same_meshes = Pool::Meshes.len(root) == Pool::Meshes.len(&other);
    for (mesh, entry) in root.entries("meshes").enumerate() {
        let by_name = || other.entries("meshes").position(|m| m["name"] == entry["name"]);
        let next = if same_meshes { Some(mesh) } else { by_name() };
        add(0, mesh, next.map(|next| (&next_file, next)))?;
    }
    Ok(all)
}

/// How often a file's vertices may be read, on average: each level is read where its vertices
/// begin, where they end and as the next one, and levels share vertices. Chosen by hand, to bound
/// the work that a crafted file asks for.
const MAX_READS: u64 = 8;

/// The names of the attributes that the geomorph target of a mesh moves.
fn moved_attributes(root: &Object, mesh: usize) -> BTreeSet<String> {
    let mesh = &root["meshes"][mesh];
    let Some(number) = mesh.as_object().and_then(geomorph_target) else { return BTreeSet::new() };
    let primitives = mesh["primitives"].list().iter();
    let moved = primitives.filter_map(|p| p["targets"].list().get(number)?.as_object());
    moved.flat_map(|target| target.keys().cloned()).collect()
}

/// The meshes of a document.
struct Meshes<'a> {
    root: &'a Object,
    accessors: &'a [Option<Accessor>],
    views: &'a Views<'a>,
}

impl Meshes<'_> {
    /// The primitives of a mesh that have triangles, moved by its geomorph target. None without
    /// one.
    fn moved(&self, mesh: usize) -> Result<Option<Vec<GeomorphPart>>, FormatError> {
        let number = self.root["meshes"][mesh].as_object().and_then(geomorph_target);
        let parts = number.map(|_| self.parts(mesh, number, &moved_attributes(self.root, mesh)));
        parts.transpose()
    }

    /// The primitives of a mesh that have triangles: their attributes of these names, moved by the
    /// target of this number.
    fn parts(
        &self,
        mesh: usize,
        target: Option<usize>,
        names: &BTreeSet<String>,
    ) -> Result<Vec<GeomorphPart>, FormatError> {
        let Meshes { root, accessors, views } = *self;
        let entry = &root["meshes"][mesh];
        // The primitives that have triangles, and for each accessor of positions how many of its
        // elements they use: several primitives may share it, and it is read once.
        let (mut primitives, mut counts) = (Vec::new(), BTreeMap::new());
        for (p, primitive) in entry["primitives"].list().iter().enumerate() {
            let Some(primitive) = primitive.as_object() else { continue };
            let location = format!("meshes[{mesh}].primitives[{p}]");
            let Read::Triangles(read) = primitive::read(primitive, location, accessors)? else {
                continue;
            };
            let position = accessors.get(read.position).and_then(Option::as_ref);
            let corners = read.corners(position.map_or(0, |p| p.count), accessors, views)?;
            let count = counts.entry(read.position).or_insert(0);
            *count = corners.iter().map(|&v| v as usize + 1).fold(*count, usize::max);
            let mut triangles = Vec::new();
            read.triangles(&corners, |t| triangles.push(t));
            primitives.push((primitive, read.position, triangles));
        }
        let mut streams: BTreeMap<(usize, usize), Attribute> = BTreeMap::new();
        let mut all = Vec::new();
        for (primitive, position, mut triangles) in primitives {
            let count = counts[&position];
            let mut vertices = triangles.concat();
            vertices.sort_unstable();
            vertices.dedup();
            let number = |v: u32| vertices.partition_point(|&w| w < v) as u32;
            triangles.as_flattened_mut().iter_mut().for_each(|v| *v = number(*v));
            let has = |name: &&String| primitive["attributes"].get(name).is_some();
            let mut present: Vec<&String> = names.iter().filter(has).collect();
            // Positions come first.
            present.sort_by_key(|name| *name != "POSITION");
            let moves = &primitive["targets"][target.unwrap_or(usize::MAX)];
            let mut part = GeomorphPart {
                kind: format!("{} {present:?}", primitive["material"]),
                triangles,
                ..GeomorphPart::default()
            };
            let mut columns = Vec::new();
            for name in present {
                let mut key = |value: &Json| -> Result<Option<(usize, usize)>, FormatError> {
                    let Some(number) = value.as_index() else { return Ok(None) };
                    let Some(Some(accessor)) = accessors.get(number) else { return Ok(None) };
                    if let Entry::Vacant(vacant) = streams.entry((number, count)) {
                        vacant.insert(stream(accessor, count, views)?);
                    }
                    Ok(Some((number, count)))
                };
                let Some(stored) = key(&primitive["attributes"][&**name])? else { continue };
                let delta = key(&moves[&**name])?;
                columns.push((name, stored, delta));
            }
            let columns = columns.iter().map(|(name, stored, delta)| {
                let (stored, delta) = (&streams[stored], delta.map(|delta| &streams[&delta]));
                // Tangents keep their handedness.
                let width = match (delta, &***name) {
                    (Some(delta), _) => delta.components.min(stored.components),
                    (None, "TANGENT") => 3,
                    _ => stored.components,
                };
                (stored, delta, usize::from(width))
            });
            let columns: Vec<_> = columns.collect();
            part.width = columns.iter().map(|(.., width)| width).sum();
            for &v in &vertices {
                for (stored, delta, width) in &columns {
                    for c in 0..*width {
                        let value = stored.value(v, c);
                        let by = delta.map_or(0.0, |delta| delta.value(v, c));
                        part.values.push(value);
                        part.moved.push(value + by);
                    }
                }
            }
            all.push(part);
        }
        Ok(all)
    }
}

/// All elements of an accessor; zeros where it has fewer than there are vertices.
fn stream(
    accessor: &Accessor,
    vertices: usize,
    views: &Views<'_>,
) -> Result<Attribute, FormatError> {
    let components = accessor.shape.components();
    views.budget.charge(vertices as u64, components as u64 * 12, "")?;
    let reader = accessor.reader(views)?;
    let mut bytes = Vec::new();
    (0..accessor.count.min(vertices) as u32).for_each(|i| reader.append(i, &mut bytes));
    bytes.resize(vertices * components * accessor.component.size(), 0);
    Ok(Attribute {
        semantic: Semantic::Custom(String::new()),
        morph_target: None,
        component: accessor.component,
        components: components as u8,
        normalized: accessor.normalized && accessor.component != Component::F32,
        bytes,
    })
}
