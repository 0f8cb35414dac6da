//! Chooses the grid of each material's texture coordinates, and dequantises them through
//! `KHR_texture_transform`.

use super::coding::Coding;
use super::grid::{Bounds, Grid};
use super::{Subject, bounds, primitives};
use crate::gltf::extensions::add as add_extension;
use crate::gltf::json::{Json, Object};
use crate::gltf::texture_transform::TRANSFORM;
use lodc_mesh::{Attribute, Component, DisjointSets, Semantic};
use std::collections::{BTreeMap, BTreeSet};

/// A set of texture coordinates as the textures of a material read it.
type Key = (usize, u32);

/// The grids of texture coordinates.
#[derive(Debug, Default)]
pub(super) struct TextureGrids {
    grids: BTreeMap<Key, Grid<2>>,
    /// Submeshes' coordinates, by object, submesh and set.
    codings: BTreeMap<(usize, usize, u32), CoordinateUse>,
}

/// The meaning of a set of coordinates of a submesh.
#[derive(Clone, Copy, Debug)]
enum CoordinateUse {
    /// Textures read it by a grid.
    Grid(Grid<2>),
    /// No texture reads it: floats that are multiples of this step.
    Multiples(f64),
}

impl TextureGrids {
    /// Grids of `bits` bits, for coordinates that nothing but submeshes' triangles and textures
    /// without rotation and animation use.
    pub(super) fn new(root: &Object, subjects: &[Subject<'_>], bits: u8) -> Self {
        let readers = Readers::new(root, subjects);
        let streams = readers.streams(subjects);
        let grids = readers.grids(&streams, bits);
        let meaning = |stream: &Stream| match stream.keys.first() {
            Some(key) => grids.get(key).copied().map(CoordinateUse::Grid),
            None => stream.bounds.map(|bounds| CoordinateUse::Multiples(bounds.binary_step(bits))),
        };
        let codings =
            streams.iter().filter_map(|s| Some((s.object_submesh_set, meaning(s)?))).collect();
        Self { grids, codings }
    }

    /// The coding of a set of a submesh.
    pub(super) fn coding(&self, object: usize, submesh: usize, set: u32) -> Coding {
        match self.codings.get(&(object, submesh, set)) {
            None => Coding::Exact,
            Some(CoordinateUse::Grid(grid)) => Coding::TextureCoordinates(*grid),
            Some(CoordinateUse::Multiples(step)) => Coding::Multiples(*step),
        }
    }

    /// Gives every texture that reads from a grid the transform of it, before the one it has.
    pub(super) fn transform(&self, root: &mut Object) {
        let materials = root.get_mut("materials").and_then(Json::as_array_mut);
        for (m, material) in materials.into_iter().flatten().enumerate() {
            each_texture(material, &mut |info| {
                if let Some(grid) = self.grids.get(&(m, set_of(info))) {
                    compose(info, grid);
                }
            });
        }
        if !self.grids.is_empty() {
            for list in ["extensionsUsed", "extensionsRequired"] {
                add_extension(root, list, TRANSFORM);
            }
        }
    }
}

/// The materials whose textures read coordinates.
struct Readers<'a> {
    root: &'a Object,
    sets: BTreeSet<Key>,
    /// Those that cannot have a grid.
    blocked: BTreeSet<Key>,
}

/// A set of coordinates of a submesh.
struct Stream {
    /// Object, submesh and set.
    object_submesh_set: (usize, usize, u32),
    /// Sets of materials that read it.
    keys: Vec<Key>,
    /// None if it cannot be put on a grid.
    bounds: Option<Bounds<2>>,
}

impl<'a> Readers<'a> {
    fn new(root: &'a Object, subjects: &[Subject<'_>]) -> Self {
        let (mut sets, mut blocked) = (BTreeSet::new(), BTreeSet::new());
        let animated = root.list("extensionsUsed").iter();
        let animated = animated.into_iter().any(|e| e.as_str() == Some("KHR_animation_pointer"));
        for (m, material) in root.list("materials").iter().enumerate() {
            each_texture(&mut material.clone(), &mut |info| {
                let key = (m, set_of(info));
                sets.insert(key);
                let rotation = &info["extensions"][TRANSFORM]["rotation"];
                if animated || rotation.as_f64().is_some_and(|r| r != 0.0) {
                    blocked.insert(key);
                }
            });
        }
        // What is not written here keeps its coordinates, and its materials their meaning.
        let mut other = BTreeSet::new();
        for (m, mesh) in root.entries("meshes").enumerate() {
            for (p, primitive) in mesh.list("primitives").iter().enumerate() {
                let is_written = |s: &Subject<'_>| s.mesh == m && s.primitives.contains(&p);
                if !subjects.iter().any(is_written) {
                    other.extend(materials(primitive));
                }
            }
        }
        blocked.extend(sets.iter().filter(|(m, _)| other.contains(m)).copied());
        Self { root, sets, blocked }
    }

    /// A grid for each set that can have one; sets that read the same coordinates have the same.
    fn grids(&self, streams: &[Stream], bits: u8) -> BTreeMap<Key, Grid<2>> {
        let keys: Vec<Key> = self.sets.iter().copied().collect();
        let number = |key: &Key| keys.binary_search(key).expect("streams name sets only") as u32;
        let mut joined = DisjointSets::new(keys.len());
        for pair in streams.iter().flat_map(|s| s.keys.windows(2)) {
            joined.join(number(&pair[0]), number(&pair[1]));
        }
        // None where one of the streams or sets rules a grid out.
        let mut boxes: BTreeMap<u32, Option<Bounds<2>>> = BTreeMap::new();
        for stream in streams {
            let Some(key) = stream.keys.first() else { continue };
            let all = boxes.entry(joined.find(number(key))).or_insert(Some(Bounds::EMPTY));
            match (all.as_mut(), &stream.bounds) {
                (Some(all), Some(bounds)) => all.join(bounds),
                _ => *all = None,
            }
        }
        for key in &self.blocked {
            boxes.insert(joined.find(number(key)), None);
        }
        let mut grid = |key: &Key| {
            let bounds = boxes.get(&joined.find(number(key))).copied().flatten()?;
            Some((*key, Grid::spanning(&bounds, bits)))
        };
        keys.iter().filter_map(&mut grid).collect()
    }

    /// All sets of coordinates of all submeshes.
    fn streams(&self, subjects: &[Subject<'_>]) -> Vec<Stream> {
        let mut streams = Vec::new();
        for (o, subject) in subjects.iter().enumerate() {
            let mesh = &subject.geometry;
            for (s, &number) in subject.primitives.iter().enumerate() {
                let primitive = primitives(self.root, subject.mesh).get(number);
                let materials = primitive.map(materials).unwrap_or_default();
                for &a in &mesh.submeshes()[s].attributes {
                    let stream = &mesh.attributes()[a as usize];
                    let Semantic::TexCoord(set) = stream.semantic else { continue };
                    let keys = materials.iter().map(|&m| (m, set));
                    let keys = keys.filter(|key| self.sets.contains(key)).collect();
                    let bounds = is_plain(stream).then(|| bounds(mesh, s, stream)).flatten();
                    streams.push(Stream { object_submesh_set: (o, s, set), keys, bounds });
                }
            }
        }
        streams
    }
}

fn is_plain(stream: &Attribute) -> bool {
    stream.component == Component::F32 && stream.components == 2 && stream.morph_target.is_none()
}

/// The materials that a primitive may be drawn with.
fn materials(primitive: &Json) -> Vec<usize> {
    let variants = &primitive["extensions"]["KHR_materials_variants"]["mappings"];
    let all = variants.list().iter().chain([primitive]).filter_map(|m| m["material"].as_index());
    let mut all: Vec<usize> = all.collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Visits the textures of a material: objects with an `index` under names that end with `Texture`.
fn each_texture(value: &mut Json, visit: &mut dyn FnMut(&mut Json)) {
    let Some(object) = value.as_object_mut() else { return };
    for (name, value) in object.iter_mut() {
        if name.ends_with("Texture") && value["index"].as_u64().is_some() {
            visit(value);
        } else {
            each_texture(value, visit);
        }
    }
}

/// The set of coordinates that a texture reads.
fn set_of(info: &Json) -> u32 {
    let number = |value: &Json| value.as_u64().and_then(|n| u32::try_from(n).ok());
    let there = number(&info["extensions"][TRANSFORM]["texCoord"]);
    there.or_else(|| number(&info["texCoord"])).unwrap_or(0)
}

/// A point is scaled and moved from the grid, then by the transform that is there.
fn compose(info: &mut Json, grid: &Grid<2>) {
    let there = &info["extensions"][TRANSFORM];
    let [x, y] = there["offset"].numbers([0.0; 2]);
    let [sx, sy] = there["scale"].numbers([1.0; 2]);
    let offset = [x + sx * grid.offset[0], y + sy * grid.offset[1]];
    let transform = &mut info["extensions"][TRANSFORM];
    transform["offset"] = offset.into();
    transform["scale"] = [sx * grid.step, sy * grid.step].into();
}
