//! Chooses the grid of each material's texture coordinates, and dequantises them through
//! `KHR_texture_transform`.

use super::coding::Coding;
use super::grid::{Bounds, Grid};
use super::{WrittenObject, bounds, primitives};
use crate::gltf::extensions::{add as add_extension, uses};
use crate::gltf::json::{Json, Object};
use crate::gltf::texture_transform::TRANSFORM;
use lodc_mesh::{Attribute, Component, DisjointSets, Semantic};
use std::collections::{BTreeMap, BTreeSet};

/// The number of a material, and that of a set of texture coordinates which its textures read.
type MaterialSet = (usize, u32);

/// The grids of texture coordinates.
#[derive(Debug, Default)]
pub(super) struct TextureGrids {
    grids: BTreeMap<MaterialSet, Grid<2>>,
    /// How submeshes' coordinates are used, by object, submesh and set.
    uses: BTreeMap<(usize, usize, u32), CoordinateUse>,
}

/// How the coordinates of a submesh's set are used.
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
    pub(super) fn new(root: &Object, written_objects: &[WrittenObject<'_>], bits: u8) -> Self {
        let readers = Readers::new(root, written_objects);
        let streams = readers.streams(written_objects);
        let grids = readers.grids(&streams, bits);
        let coordinate_use = |stream: &Stream| match stream.read_by.first() {
            Some(set) => grids.get(set).copied().map(CoordinateUse::Grid),
            None => stream.bounds.map(|bounds| CoordinateUse::Multiples(bounds.binary_step(bits))),
        };
        let uses = streams.iter();
        let uses = uses.filter_map(|s| Some((s.object_submesh_set, coordinate_use(s)?))).collect();
        Self { grids, uses }
    }

    /// The coding of a set of a submesh.
    pub(super) fn coding(&self, object: usize, submesh: usize, set: u32) -> Coding {
        match self.uses.get(&(object, submesh, set)) {
            None => Coding::Exact,
            Some(CoordinateUse::Grid(grid)) => Coding::TextureCoordinates(*grid),
            Some(CoordinateUse::Multiples(step)) => Coding::Multiples(*step),
        }
    }

    /// Gives every texture that reads from a grid the transform from its numbers to coordinates,
    /// which comes before the transform that the texture has.
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

/// The sets of coordinates that the textures of materials read.
struct Readers<'a> {
    root: &'a Object,
    sets: BTreeSet<MaterialSet>,
    /// Those that cannot have a grid.
    blocked: BTreeSet<MaterialSet>,
}

/// A set of coordinates of a submesh.
struct Stream {
    /// Object, submesh and set.
    object_submesh_set: (usize, usize, u32),
    /// The sets of materials whose textures read it.
    read_by: Vec<MaterialSet>,
    /// The box of the coordinates; none if they cannot be put on a grid.
    bounds: Option<Bounds<2>>,
}

impl<'a> Readers<'a> {
    fn new(root: &'a Object, written_objects: &[WrittenObject<'_>]) -> Self {
        let (mut sets, mut blocked) = (BTreeSet::new(), BTreeSet::new());
        // An animation may move any texture's transform.
        let animated = uses(root, "KHR_animation_pointer");
        for (m, material) in root.list("materials").iter().enumerate() {
            each_texture(&mut material.clone(), &mut |info| {
                let set = (m, set_of(info));
                sets.insert(set);
                let rotation = &info["extensions"][TRANSFORM]["rotation"];
                if animated || rotation.as_f64().is_some_and(|r| r != 0.0) {
                    blocked.insert(set);
                }
            });
        }
        // Primitives that are not written here keep their coordinates, so the textures of their
        // materials must go on reading these.
        let mut used_elsewhere = BTreeSet::new();
        for (m, mesh) in root.entries("meshes").enumerate() {
            for (p, primitive) in mesh.list("primitives").iter().enumerate() {
                let is_written = |s: &WrittenObject<'_>| s.mesh == m && s.primitives.contains(&p);
                if !written_objects.iter().any(is_written) {
                    used_elsewhere.extend(materials(primitive));
                }
            }
        }
        blocked.extend(sets.iter().filter(|(m, _)| used_elsewhere.contains(m)).copied());
        Self { root, sets, blocked }
    }

    /// A grid for each set that can have one; sets that read the same coordinates have the same.
    fn grids(&self, streams: &[Stream], bits: u8) -> BTreeMap<MaterialSet, Grid<2>> {
        let sets: Vec<MaterialSet> = self.sets.iter().copied().collect();
        let number =
            |set: &MaterialSet| sets.binary_search(set).expect("streams name sets only") as u32;
        let mut joined = DisjointSets::new(sets.len());
        for pair in streams.iter().flat_map(|s| s.read_by.windows(2)) {
            joined.join(number(&pair[0]), number(&pair[1]));
        }
        // None where one of the streams or sets rules a grid out.
        let mut boxes: BTreeMap<u32, Option<Bounds<2>>> = BTreeMap::new();
        for stream in streams {
            let Some(set) = stream.read_by.first() else { continue };
            let all = boxes.entry(joined.find(number(set))).or_insert(Some(Bounds::EMPTY));
            match (all.as_mut(), &stream.bounds) {
                (Some(all), Some(bounds)) => all.join(bounds),
                _ => *all = None,
            }
        }
        for set in &self.blocked {
            boxes.insert(joined.find(number(set)), None);
        }
        let mut grid = |set: &MaterialSet| {
            let bounds = boxes.get(&joined.find(number(set))).copied().flatten()?;
            Some((*set, Grid::spanning(&bounds, bits)))
        };
        sets.iter().filter_map(&mut grid).collect()
    }

    /// All sets of coordinates of all submeshes.
    fn streams(&self, written_objects: &[WrittenObject<'_>]) -> Vec<Stream> {
        let mut streams = Vec::new();
        for (o, written) in written_objects.iter().enumerate() {
            let mesh = &written.geometry;
            for (s, &number) in written.primitives.iter().enumerate() {
                let primitive = primitives(self.root, written.mesh).get(number);
                let materials = primitive.map(materials).unwrap_or_default();
                for &a in &mesh.submeshes()[s].attributes {
                    let stream = &mesh.attributes()[a as usize];
                    let Semantic::TexCoord(set) = stream.semantic else { continue };
                    let read_by = materials.iter().map(|&m| (m, set));
                    let read_by = read_by.filter(|set| self.sets.contains(set)).collect();
                    let bounds = is_two_floats(stream).then(|| bounds(mesh, s, stream)).flatten();
                    streams.push(Stream { object_submesh_set: (o, s, set), read_by, bounds });
                }
            }
        }
        streams
    }
}

/// Returns whether a stream has two floats per vertex, at rest.
fn is_two_floats(stream: &Attribute) -> bool {
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
    let overriding = number(&info["extensions"][TRANSFORM]["texCoord"]);
    overriding.or_else(|| number(&info["texCoord"])).unwrap_or(0)
}

/// Puts the transform of a grid before the one that a texture has.
fn compose(info: &mut Json, grid: &Grid<2>) {
    let existing = &info["extensions"][TRANSFORM];
    let [x, y] = existing["offset"].numbers([0.0; 2]);
    let [sx, sy] = existing["scale"].numbers([1.0; 2]);
    let offset = [x + sx * grid.offset[0], y + sy * grid.offset[1]];
    let transform = &mut info["extensions"][TRANSFORM];
    transform["offset"] = offset.into();
    transform["scale"] = [sx * grid.step, sy * grid.step].into();
}
