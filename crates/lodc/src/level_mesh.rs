//! Levels of detail as meshes of their own, in the order of the file or in one for vertex caches.

use crate::{Error, LodObject, levels};
#[cfg(feature = "export")]
use lodc_formats::{
    Document, FormatError,
    export::{ExportObject, Precision},
};
use lodc_lod::ModelKind;
use lodc_mesh::{Lod, Mesh};
use lodc_select::decimal;
use lodc_strip::{codec_order, order};
use rayon::prelude::*;

/// Vertices in the cache that triangles are ordered for.
pub const CACHE: u32 = 16;

/// Orders of triangles and vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// For vertex caches; vertices by first use, identical ones once.
    #[default]
    Cache,
    /// For compression; vertices by first use, identical ones once.
    Size,
    /// As in the input.
    File,
}

/// The way in which levels become meshes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shape {
    /// The model to replay; the reference if none.
    pub model: Option<ModelKind>,
    /// The order of its triangles and vertices.
    pub order: Order,
}

/// An object at one level, in mesh units.
#[derive(Clone, Debug)]
pub struct LevelMesh {
    /// The triangles of the level and the vertices that they use.
    pub mesh: Mesh,
    /// Of a refitted mesh measured, else as the object states it.
    pub error: f64,
    /// Likewise; none if it was not measured.
    pub rms: Option<f64>,
}

/// Makes the meshes of the objects at `lods`, one each.
///
/// # Errors
/// If a model shows what is no mesh: a bug.
pub fn meshes(objects: &[LodObject], lods: &[Lod], shape: Shape) -> Result<Vec<LevelMesh>, Error> {
    let one = |(object, &lod)| {
        let level = stored(object, lod, shape)?;
        Ok(LevelMesh { mesh: ordered(level.mesh, shape.order), ..level })
    };
    objects.par_iter().zip(lods).map(one).collect()
}

/// Makes the meshes of the objects at `lods` as the reference shows them, in the input's order.
///
/// # Errors
/// If one is no mesh: a bug.
pub fn plain(objects: &[LodObject], lods: &[Lod]) -> Result<Vec<Mesh>, Error> {
    let shape = Shape { order: Order::File, ..Shape::default() };
    let one = |(object, &lod)| stored(object, lod, shape).map(|level| level.mesh);
    objects.par_iter().zip(lods).map(one).collect()
}

/// Puts triangles and vertices into an order.
pub fn ordered(mesh: Mesh, wanted: Order) -> Mesh {
    match wanted {
        Order::Cache => mesh.arranged(|mesh| order(mesh, CACHE)),
        Order::Size => mesh.arranged(codec_order),
        Order::File => mesh,
    }
}

fn stored(object: &LodObject, lod: Lod, shape: Shape) -> Result<LevelMesh, Error> {
    let mut live = levels::triangles(object, shape.model, lod);
    if shape.order != Order::File {
        // Every model shows them in an order of its own; what is written is to be the same.
        live.sort_unstable();
    }
    let mesh =
        object.simplified.mesh().extract(&live).map_err(|e| {
            Error::Bug(format!("{}: LOD {} is no mesh: {e}", object.info.name, lod.0))
        })?;
    let collapses = object.simplified.collapses();
    let (error, rms) = (collapses.error_at(lod), collapses.rms_at(lod));
    Ok(LevelMesh { mesh, error: decimal(error), rms: rms.map(decimal) })
}

/// The largest error and root mean square distance of an object: in mesh units for one object, in
/// world units for several.
pub fn distance(objects: &[LodObject], meshes: &[LevelMesh]) -> (f64, Option<f64>) {
    largest(objects, meshes.iter().map(|m| (m.error, m.rms)))
}

/// The largest of errors and root mean square distances, those of each object in mesh units: in
/// mesh units for one object, in world units for several.
pub fn largest(
    objects: &[LodObject],
    distances: impl Iterator<Item = (f64, Option<f64>)>,
) -> (f64, Option<f64>) {
    let larger = |(error, rms): (f64, Option<f64>),
                  (o, (e, r)): (&LodObject, (f64, Option<f64>))| {
        let unit = unit(objects, o);
        (error.max(unit * e), rms.zip(r).map(|(rms, r)| rms.max(unit * r)))
    };
    objects.iter().zip(distances).fold((0.0, Some(0.0)), larger)
}

fn unit(objects: &[LodObject], object: &LodObject) -> f64 {
    if objects.len() > 1 { object.info.world_scale } else { 1.0 }
}

/// Returns how far quantising moves the vertices of exported meshes, the farthest one of each, in
/// mesh units: a level errs no more than it did and that.
///
/// # Errors
/// If the document is damaged.
#[cfg(feature = "export")]
pub fn rounding<'a>(
    objects: &'a [LodObject],
    document: &Document,
    meshes: impl Iterator<Item = &'a Mesh>,
    precision: Precision,
) -> Result<Rounding, FormatError> {
    let one = |(o, mesh): (&'a LodObject, &'a Mesh)| ExportObject { info: &o.info, mesh };
    let exported: Vec<ExportObject<'_>> = objects.iter().zip(meshes).map(one).collect();
    let of_object = lodc_formats::export::rounding(document, &exported, precision)?;
    let scaled = |(o, moved): (&LodObject, &f64)| unit(objects, o) * moved;
    let largest = objects.iter().zip(&of_object).map(scaled).fold(0.0, f64::max);
    Ok(Rounding { of_object, largest })
}

/// The farthest that quantising moves vertices.
#[cfg(feature = "export")]
#[derive(Clone, Debug)]
pub struct Rounding {
    /// Of each object, in mesh units.
    pub of_object: Vec<f64>,
    /// Of all, in the units of [`distance`].
    pub largest: f64,
}

/// Adds to what levels state how far quantising will move their vertices.
///
/// # Errors
/// If the document is damaged.
#[cfg(feature = "export")]
pub fn round(
    objects: &[LodObject],
    document: &Document,
    meshes: &mut [LevelMesh],
    precision: Precision,
) -> Result<(), FormatError> {
    let rounding = rounding(objects, document, meshes.iter().map(|m| &m.mesh), precision)?;
    for (mesh, moved) in meshes.iter_mut().zip(rounding.of_object) {
        add_rounding(&mut mesh.error, &mut mesh.rms, moved);
    }
    Ok(())
}

/// Adds what quantising moves to the error and the root mean square distance of a level.
pub fn add_rounding(error: &mut f64, rms: &mut Option<f64>, moved: f64) {
    *error += moved;
    // Three coordinates, each uniform over a cell, have a mean square of a quarter of a step.
    *rms = rms.map(|rms| rms.hypot(moved / 3f64.sqrt()));
}

/// The objects as they are exported.
#[cfg(feature = "export")]
pub fn exported<'a>(objects: &'a [LodObject], meshes: &'a [LevelMesh]) -> Vec<ExportObject<'a>> {
    let one = |(o, level): (&'a LodObject, &'a LevelMesh)| ExportObject {
        info: &o.info,
        mesh: &level.mesh,
    };
    objects.iter().zip(meshes).map(one).collect()
}
