//! Levels of detail as meshes of their own: as a model shows them or refitted, in the order of the
//! file or in one for vertex caches.

use crate::exit::{Failure, Outcome, Status};
use crate::levels;
use crate::paints::Paints;
use crate::refitted::refitted;
use clap::ValueEnum;
use lodc::LodObject;
use lodc_formats::export::ExportObject;
use lodc_lod::ModelKind;
use lodc_mesh::{Lod, Mesh};
use lodc_select::decimal;
use lodc_strip::{codec_order, order};
use rayon::prelude::*;

/// Vertices in the cache that triangles are ordered for.
pub(crate) const CACHE: u32 = 16;

/// Orders of triangles and vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Order {
    /// For vertex caches; vertices by first use, identical ones once
    #[default]
    Cache,
    /// For compression; vertices by first use, identical ones once
    Size,
    /// As in the input
    File,
}

/// The way in which levels become meshes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shape {
    /// The model to replay; none stands for the reference.
    pub(crate) model: Option<ModelKind>,
    /// Vertices move to where they fit the input best.
    pub(crate) refit: bool,
    pub(crate) order: Order,
}

/// An object at one level, in mesh units.
#[derive(Debug)]
pub(crate) struct LevelMesh {
    pub(crate) mesh: Mesh,
    /// Of a refitted mesh measured, else as the object states it.
    pub(crate) error: f64,
    pub(crate) rms: Option<f64>,
}

/// Makes the meshes of the objects at `lods`, one each; `paints` is what refitted ones are judged
/// in.
///
/// # Errors
/// If a model shows what is no mesh: a bug.
pub(crate) fn meshes(
    objects: &[LodObject],
    lods: &[Lod],
    shape: Shape,
    paints: &Paints,
) -> Outcome<Vec<LevelMesh>> {
    let levels = objects.par_iter().zip(lods).enumerate();
    levels.map(|(i, (object, &lod))| one(object, lod, shape, (paints, i))).collect()
}

/// Makes the meshes of the objects at `lods` as the reference shows them, in the input's order.
///
/// # Errors
/// If one is no mesh: a bug.
pub(crate) fn plain(objects: &[LodObject], lods: &[Lod]) -> Outcome<Vec<Mesh>> {
    let shape = Shape { order: Order::File, ..Shape::default() };
    let one = |(object, &lod)| stored(object, lod, shape).map(|level| level.mesh);
    objects.par_iter().zip(lods).map(one).collect()
}

fn one(
    object: &LodObject,
    lod: Lod,
    shape: Shape,
    (paints, i): (&Paints, usize),
) -> Outcome<LevelMesh> {
    let level = if shape.refit {
        let (mesh, error, rms) = refitted(object, lod, (paints, i));
        LevelMesh { mesh, error, rms: Some(rms) }
    } else {
        stored(object, lod, shape)?
    };
    Ok(LevelMesh { mesh: ordered(level.mesh, shape.order), ..level })
}

/// Puts triangles and vertices into an order.
pub(crate) fn ordered(mesh: Mesh, wanted: Order) -> Mesh {
    match wanted {
        Order::Cache => mesh.arranged(|mesh| order(mesh, CACHE)),
        Order::Size => mesh.arranged(codec_order),
        Order::File => mesh,
    }
}

fn stored(object: &LodObject, lod: Lod, shape: Shape) -> Outcome<LevelMesh> {
    let mut live = levels::triangles(object, shape.model, lod);
    if shape.order != Order::File {
        // Every model shows them in an order of its own; what is written is to be the same.
        live.sort_unstable();
    }
    let mesh = object.simplified.mesh().extract(&live).map_err(|e| {
        Failure::new(Status::Bug, format!("{}: LOD {} is no mesh: {e}", object.info.name, lod.0))
    })?;
    let collapses = object.simplified.collapses();
    let (error, rms) = (collapses.error_at(lod), collapses.rms_at(lod));
    Ok(LevelMesh { mesh, error: decimal(error), rms: rms.map(decimal) })
}

/// The largest error and root mean square distance of an object: in mesh units for one object, in
/// world units for several.
pub(crate) fn distance(objects: &[LodObject], meshes: &[LevelMesh]) -> (f64, Option<f64>) {
    let unit = |o: &LodObject| if objects.len() > 1 { o.info.world_scale } else { 1.0 };
    let pairs = || objects.iter().zip(meshes);
    let error = pairs().map(|(o, m)| unit(o) * m.error).fold(0.0, f64::max);
    let rms = pairs().map(|(o, m)| Some(unit(o) * m.rms?)).collect::<Option<Vec<f64>>>();
    (error, rms.map(|all| all.into_iter().fold(0.0, f64::max)))
}

/// The objects as they are exported.
pub(crate) fn exported<'a>(
    objects: &'a [LodObject],
    meshes: &'a [LevelMesh],
) -> Vec<ExportObject<'a>> {
    let one = |(o, level): (&'a LodObject, &'a LevelMesh)| ExportObject {
        info: &o.info,
        mesh: &level.mesh,
    };
    objects.iter().zip(meshes).map(one).collect()
}
