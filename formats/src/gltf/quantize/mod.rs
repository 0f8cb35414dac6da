//! Quantised geometry (KHR_mesh_quantization): streams become integers of few bits, and nodes,
//! skins and textures get the transforms that turn integers back into what they were.

mod coding;
mod grid;
mod placement;
mod positions;
mod skins;
#[cfg(test)]
mod tests;
mod textures;

use crate::gltf::extensions::{QUANTIZATION, add as add_extension};
use crate::gltf::json::{Json, Object};
use crate::options::Precision;
use crate::{Document, FormatError, ObjectInfo};
use coding::{Coding, coded};
use grid::{Bounds, Grid};
use lodc_mesh::{Attribute, Component, Mesh, Semantic};
use std::borrow::Cow;
use std::collections::BTreeMap;
use textures::TextureGrids;

/// An object to be written, and which mesh and primitives of the document it is.
#[derive(Clone, Debug)]
pub(super) struct WrittenObject<'a> {
    pub(super) info: &'a ObjectInfo,
    /// The number of its mesh in the document.
    pub(super) mesh: usize,
    /// The numbers of its submeshes' primitives there.
    pub(super) primitives: Vec<usize>,
    /// Its geometry as it will be written.
    pub(super) geometry: Cow<'a, Mesh>,
    /// The same vertices where the next level has them, if they morph there.
    pub(super) geomorph_target: Option<Cow<'a, Mesh>>,
}

/// The quantisation of a scene.
#[derive(Debug)]
pub(super) struct Quantizer {
    precision: Precision,
    /// By object.
    positions: Vec<Option<Grid<3>>>,
    textures: TextureGrids,
    /// True if colours were sRGB values: as light they take 16 bits to stay apart.
    keeps_srgb: bool,
}

impl Quantizer {
    /// Decides what becomes of every stream, and puts the transforms into the document. Streams
    /// stay as they are where no transform can say what integers mean, or they are integers.
    pub(super) fn new(
        precision: Precision,
        document: &Document,
        written_objects: &[WrittenObject<'_>],
        root: &mut Object,
        blob: &mut [u8],
    ) -> Result<Self, FormatError> {
        let positions = position_grids(precision, document, root, written_objects)?;
        let textures = match precision.uv {
            Some(bits) => TextureGrids::new(root, written_objects, bits),
            None => TextureGrids::default(),
        };
        let mesh_grids: BTreeMap<usize, Grid<3>> = written_objects
            .iter()
            .zip(&positions)
            .filter_map(|(s, g)| Some((s.mesh, (*g)?)))
            .collect();
        placement::move_to_grids(root, blob, &mesh_grids);
        textures.transform(root);
        if precision != Precision::default() {
            shorten_numbers(root);
            for list in ["extensionsUsed", "extensionsRequired"] {
                add_extension(root, list, QUANTIZATION);
            }
        }
        let keeps_srgb = matches!(document, Document::Obj(_));
        Ok(Self { precision, positions, textures, keeps_srgb })
    }

    /// The geometry of an object, quantised.
    pub(super) fn geometry<'a>(&self, object: usize, written: &WrittenObject<'a>) -> Cow<'a, Mesh> {
        if self.precision == Precision::default() {
            return written.geometry.clone();
        }
        let grid = self.positions[object];
        let coding = |submesh: usize, stream: &Attribute| {
            self.coding(object, submesh, stream, &written.geometry)
        };
        Cow::Owned(coded(&written.geometry, grid, coding))
    }

    /// The vertices of an object where they morph to, quantised as its geometry is.
    pub(super) fn next<'a>(
        &self,
        object: usize,
        written: &WrittenObject<'a>,
    ) -> Option<Cow<'a, Mesh>> {
        let next = written.geomorph_target.clone()?;
        if self.precision == Precision::default() {
            return Some(next);
        }
        let coding =
            |submesh: usize, stream: &Attribute| self.coding(object, submesh, stream, &next);
        Some(Cow::Owned(coded(&next, self.positions[object], coding)))
    }

    /// How the values of a submesh's stream are stored.
    fn coding(&self, object: usize, submesh: usize, stream: &Attribute, mesh: &Mesh) -> Coding {
        let bits = &self.precision;
        let float = stream.component == Component::F32;
        let at_rest = stream.morph_target.is_none();
        let coding = match &stream.semantic {
            Semantic::Position if !at_rest => {
                self.positions[object].map(|grid| Coding::Offsets(grid.step))
            }
            Semantic::Normal | Semantic::Tangent if float && at_rest => {
                bits.normal.map(Coding::Directions)
            }
            Semantic::Normal | Semantic::Tangent if float && is_within(mesh, stream, -1.0, 1.0) => {
                bits.normal.map(Coding::Deltas)
            }
            Semantic::TexCoord(set) if float && at_rest => {
                Some(self.textures.coding(object, submesh, *set))
            }
            Semantic::Color(_) if at_rest && is_within(mesh, stream, 0.0, 1.0) => {
                let is_narrower = |&bits: &u8| coding::size(bits) < stream.component.size();
                let bits = bits.color.map(|bits| if self.keeps_srgb { 16 } else { bits });
                bits.filter(is_narrower).map(Coding::Fractions)
            }
            Semantic::Weights(0) if float && has_one_set(mesh, submesh) => {
                bits.weight.map(Coding::Shares)
            }
            _ => None,
        };
        coding.unwrap_or(Coding::Exact)
    }
}

fn position_grids(
    precision: Precision,
    document: &Document,
    root: &Object,
    written_objects: &[WrittenObject<'_>],
) -> Result<Vec<Option<Grid<3>>>, FormatError> {
    match precision.position {
        Some(bits) => positions::grids(document, root, written_objects, bits),
        None => Ok(vec![None; written_objects.len()]),
    }
}

/// What rounding does to the places of an object's vertices.
#[derive(Clone, Debug)]
pub struct RoundedObject {
    /// The largest distance that it moves a vertex at rest: half the diagonal of a cell, in mesh
    /// units.
    pub moved: f64,
    /// The object without triangles, its positions, its targets' and the weights of its joints
    /// rounded, in mesh units.
    pub mesh: Mesh,
    /// Why positions stay as they are although they were to be rounded.
    pub stays: Option<&'static str>,
}

/// What rounding does to each object.
///
/// # Errors
/// If the document is damaged.
pub(super) fn rounded(
    precision: Precision,
    document: &Document,
    root: &Object,
    written_objects: &[WrittenObject<'_>],
) -> Result<Vec<RoundedObject>, FormatError> {
    let positions = position_grids(precision, document, root, written_objects)?;
    let stays = match precision.position {
        Some(_) => positions::reasons_to_stay(root, written_objects),
        None => vec![None; written_objects.len()],
    };
    let textures = TextureGrids::default();
    let quantizer = Quantizer { precision, positions, textures, keeps_srgb: false };
    let rounded_object = |(object, written): (usize, &WrittenObject<'_>)| {
        let geometry = &*written.geometry;
        let coding = |submesh: usize, stream: &Attribute| match stream.semantic {
            Semantic::Position | Semantic::Weights(_) => {
                match quantizer.coding(object, submesh, stream, geometry) {
                    Coding::Offsets(step) => Coding::Multiples(step),
                    other => other,
                }
            }
            _ => Coding::Exact,
        };
        let mut parts = coded(geometry, None, coding).into_parts();
        // Rounding may bring corners of a triangle together.
        parts.triangles.clear();
        for submesh in &mut parts.submeshes {
            (submesh.first_triangle, submesh.triangle_count) = (0, 0);
        }
        let grid = quantizer.positions[object];
        if let Some(grid) = grid {
            parts.positions.iter_mut().for_each(|p| *p = grid.rounded(*p));
        }
        RoundedObject {
            moved: grid.map_or(0.0, |grid| 0.5 * 3f64.sqrt() * grid.step),
            mesh: Mesh::try_from(parts).expect("positions of no triangle"),
            stays: stays[object],
        }
    };
    Ok(written_objects.iter().enumerate().map(rounded_object).collect())
}

/// Spells the numbers of materials as shortly as single precision allows. Those of nodes stay: in
/// the world single precision may be too little.
fn shorten_numbers(root: &mut Object) {
    root.get_mut("materials").into_iter().for_each(shorten);
}

fn shorten(value: &mut Json) {
    match value {
        Json::Array(values) => values.iter_mut().for_each(shorten),
        Json::Object(members) => {
            members.iter_mut().filter(|(key, _)| *key != "extras").for_each(|(_, v)| shorten(v));
        }
        Json::Number(spelt) if spelt.contains(['.', 'e', 'E']) => {
            let single = spelt.parse::<f64>().map_or(f32::NAN, |v| v as f32);
            // The shortest text that means the same float, as the number that it states.
            let short: f64 = single.to_string().parse().unwrap_or(f64::NAN);
            if single.is_normal() || single == 0.0 {
                let is_integer = short.fract() == 0.0 && short.abs() < 1e9;
                *value = if is_integer { (short as i64).into() } else { short.into() };
            }
        }
        _ => {}
    }
}

/// Returns whether all numbers of a stream are between two others.
fn is_within(mesh: &Mesh, stream: &Attribute, lo: f32, hi: f32) -> bool {
    let components = usize::from(stream.components);
    (0..mesh.vertex_count() as u32)
        .all(|v| (0..components).all(|c| (lo..=hi).contains(&stream.value(v, c))))
}

/// Returns whether a submesh has one set of weights: only then is their sum known to be 1.
fn has_one_set(mesh: &Mesh, submesh: usize) -> bool {
    let streams = mesh.submeshes()[submesh].attributes.iter();
    let semantics = streams.map(|&a| &mesh.attributes()[a as usize].semantic);
    semantics.filter(|s| matches!(s, Semantic::Weights(_))).count() == 1
}

/// The primitives of a mesh of the document.
fn primitives(root: &Object, mesh: usize) -> &[Json] {
    root["meshes"][mesh]["primitives"].list()
}

/// The box of a stream of `N` floats at the vertices of a submesh; none if one is not finite.
fn bounds<const N: usize>(mesh: &Mesh, submesh: usize, stream: &Attribute) -> Option<Bounds<N>> {
    let mut bounds = Bounds::EMPTY;
    for (v, _) in (0..).zip(mesh.vertex_submesh()).filter(|(_, s)| **s as usize == submesh) {
        let value: [f32; N] = std::array::from_fn(|c| stream.value(v, c));
        value.iter().all(|c| c.is_finite()).then(|| bounds.add(value.map(f64::from)))?;
    }
    Some(bounds)
}
