//! Levels of detail as meshes of their own, with triangles and vertices in a chosen order; their
//! distances from the input.

#[cfg(feature = "export")]
use crate::shapes::{bends, farthest_vertex, stated_shapes};
use crate::{Error, LodObject, levels};
#[cfg(feature = "export")]
use lodc_formats::{
    Document, FormatError, Limits,
    export::{ExportFormat, ExportObject, Precision, flattening, reading, rounded},
};
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

/// Returns how far rounding moves vertices of exported meshes at most: of coordinates as the input
/// was read and as the format stores them, and by quantising. This counts in the placements and
/// poses that errors are the largest over: where targets add to each other or joints move vertices,
/// farther than at rest. A level's error grows by no more than that.
///
/// # Errors
/// If the document is damaged.
#[cfg(feature = "export")]
pub fn rounding<'a>(
    objects: &'a [LodObject],
    document: &Document,
    meshes: impl Iterator<Item = &'a Mesh>,
    format: ExportFormat,
    precision: Precision,
) -> Result<Rounding, FormatError> {
    let one = |(o, mesh): (&'a LodObject, &'a Mesh)| ExportObject { info: &o.info, mesh };
    let exported: Vec<ExportObject<'_>> = objects.iter().zip(meshes).map(one).collect();
    let mut by_object = flattening(format, document, &exported)?;
    for (moved, object) in by_object.iter_mut().zip(objects) {
        *moved += reading(document, object.simplified.mesh());
    }
    if let Some(rounded) = rounded(document, &exported, precision)? {
        let bending = exported.iter().any(|object| bends(object.mesh));
        let shapes = match bending {
            true => stated_shapes(objects, document, &Limits::DEFAULT)?,
            false => Vec::new(),
        };
        let quantised = |o: usize| -> f64 {
            let (mesh, rounded) = (exported[o].mesh, &rounded[o]);
            if !bends(mesh) {
                return rounded.moved;
            }
            let all = 0..mesh.vertex_count() as u32;
            farthest_vertex(shapes[o].all(), mesh, &rounded.mesh, &all).max(rounded.moved)
        };
        by_object.iter_mut().enumerate().for_each(|(o, moved)| *moved += quantised(o));
    }
    let scaled = |(o, moved): (&LodObject, &f64)| o.info.world_scale * moved;
    let largest = objects.iter().zip(&by_object).map(scaled).fold(0.0, f64::max);
    Ok(Rounding { by_object, largest })
}

/// The farthest that rounding moves vertices.
#[cfg(feature = "export")]
#[derive(Clone, Debug)]
pub struct Rounding {
    /// By object, in mesh units.
    pub by_object: Vec<f64>,
    /// Of all objects, in world units.
    pub largest: f64,
}

/// The error and the root mean square distance of each mesh as a file has it: with what writing
/// rounds, see [`rounding`].
///
/// # Errors
/// If the document is damaged.
#[cfg(feature = "export")]
pub(crate) fn written_distances(
    objects: &[LodObject],
    document: &Document,
    meshes: &[LevelMesh],
    format: ExportFormat,
    precision: Precision,
) -> Result<Vec<(f64, Option<f64>)>, FormatError> {
    let only_meshes = meshes.iter().map(|m| &m.mesh);
    let rounding = rounding(objects, document, only_meshes, format, precision)?;
    let with_rounding = |(mesh, moved): (&LevelMesh, f64)| {
        let (mut error, mut rms) = (mesh.error, mesh.rms);
        add_rounding(&mut error, &mut rms, moved);
        (error, rms)
    };
    Ok(meshes.iter().zip(rounding.by_object).map(with_rounding).collect())
}

/// Adds how far rounding moves vertices to the error and the root mean square distance of a
/// level.
pub fn add_rounding(error: &mut f64, rms: &mut Option<f64>, moved: f64) {
    *error += moved;
    // `moved` is half the diagonal of a cell of the grid, √3/2 steps. Three coordinates, each off
    // by a uniformly distributed part of a step, have a mean square of a quarter of a step squared.
    *rms = rms.map(|rms| rms.hypot(moved / 3f64.sqrt()));
}
