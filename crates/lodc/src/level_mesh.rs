//! Levels of detail as meshes of their own, with triangles and vertices in a chosen order; their
//! distances from the input.

use crate::{Error, LodObject, levels};
use lodc_lod::ModelKind;
use lodc_mesh::{Lod, Mesh};
use lodc_select::decimal;
use lodc_strip::{codec_order, order};
use rayon::prelude::*;

/// Vertices in the cache that triangles are ordered for: what ACMR is stated for.
pub const CACHE_VERTICES: u32 = 16;

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

/// How levels become meshes.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshOptions {
    /// The model whose triangles are taken; the reference if none.
    pub model: Option<ModelKind>,
    /// The order of triangles and vertices.
    pub order: Order,
}

/// An object at one level, in mesh units.
#[derive(Clone, Debug)]
pub struct LevelMesh {
    /// The triangles of the level and the vertices that they use.
    pub mesh: Mesh,
    /// Upper bound of the Hausdorff distance from the input: measured for a refitted mesh, else as
    /// the object states it.
    pub error: f64,
    /// Root mean square distance, likewise; none if it was not measured.
    pub rms: Option<f64>,
    /// Whether vertices are elsewhere, or have other normals, than in the input: see
    /// [`refitted_meshes`](crate::pipeline::refitted_meshes).
    pub refitted: bool,
}

/// Makes the meshes of the objects at `lods`, one each.
///
/// # Errors
/// If a model gives triangles that are no mesh: a bug.
pub fn meshes(
    objects: &[LodObject],
    lods: &[Lod],
    options: MeshOptions,
) -> Result<Vec<LevelMesh>, Error> {
    let one = |(object, &lod)| {
        let level = extracted(object, lod, options)?;
        Ok(LevelMesh { mesh: ordered(level.mesh, options.order), ..level })
    };
    objects.par_iter().zip(lods).map(one).collect()
}

/// Makes the meshes of the objects at `lods` by the reference, in the input's order.
///
/// # Errors
/// If one is no mesh: a bug.
pub fn reference_meshes(objects: &[LodObject], lods: &[Lod]) -> Result<Vec<Mesh>, Error> {
    let options = MeshOptions { order: Order::File, ..MeshOptions::default() };
    let one = |(object, &lod)| extracted(object, lod, options).map(|level| level.mesh);
    objects.par_iter().zip(lods).map(one).collect()
}

/// Puts triangles and vertices into an order.
pub fn ordered(mesh: Mesh, wanted: Order) -> Mesh {
    match wanted {
        Order::Cache => mesh.arranged(|mesh| order(mesh, CACHE_VERTICES)),
        Order::Size => mesh.arranged(codec_order),
        Order::File => mesh,
    }
}

/// The mesh of an object at a LOD before its triangles are ordered, with its stated distances.
pub(crate) fn extracted(
    object: &LodObject,
    lod: Lod,
    options: MeshOptions,
) -> Result<LevelMesh, Error> {
    let mut live = levels::triangles(object, options.model, lod);
    if options.order != Order::File {
        // Every model has an order of its own; what is written must not depend on the model.
        live.sort_unstable();
    }
    let mesh =
        object.simplified.mesh().extract(&live).map_err(|e| {
            Error::Bug(format!("{}: LOD {} is no mesh: {e}", object.info.name, lod.0))
        })?;
    let collapses = object.simplified.collapses();
    let (error, rms) = (collapses.error_at(lod), collapses.rms_at(lod));
    let (error, rms) = (decimal(error), rms.map(decimal));
    Ok(LevelMesh { mesh, error, rms, refitted: false })
}

/// The largest error and root mean square distance of all meshes, in world units.
pub fn largest_of_meshes(objects: &[LodObject], meshes: &[LevelMesh]) -> (f64, Option<f64>) {
    largest_distance(objects, meshes.iter().map(|m| (m.error, m.rms)))
}

/// The largest of errors and root mean square distances in world units, given by object in mesh
/// units.
pub fn largest_distance(
    objects: &[LodObject],
    distances: impl Iterator<Item = (f64, Option<f64>)>,
) -> (f64, Option<f64>) {
    let larger = |(error, rms): (f64, Option<f64>),
                  (o, (e, r)): (&LodObject, (f64, Option<f64>))| {
        let unit = o.info.world_scale;
        (error.max(unit * e), rms.zip(r).map(|(rms, r)| rms.max(unit * r)))
    };
    objects.iter().zip(distances).fold((0.0, Some(0.0)), larger)
}
