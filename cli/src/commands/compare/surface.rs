//! The surfaces that are compared: scenes, or levels of them, as their default scenes show them.

use super::CompareArgs;
use crate::commands::asset;
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::level_mesh::{self, Order, Shape};
use crate::selector::SceneLevels;
use crate::stages::Stages;
use lodc_formats::appearance::appearance;
use lodc_formats::import::{Either, either};
use lodc_formats::lodc::LodObject;
use lodc_formats::{Assets, Document, ObjectInfo, scene_graph};
use lodc_measure::SceneSurface;
use lodc_mesh::{Lod, Mesh};
use lodc_scene::{Appearance, Arrangement};
use lodc_select::Target;
use std::path::Path;

/// More triangles than this, instances counted, are not compared.
const MAX_TRIANGLES: usize = 1 << 28;

/// The level of a scene that is compared.
#[derive(Clone, Copy)]
pub(super) struct Wish {
    /// None: all of it.
    pub(super) target: Option<Target>,
    pub(super) per_object: bool,
}

/// A scene, or a level of one.
struct Shown {
    document: Document,
    objects: Vec<(ObjectInfo, Mesh)>,
    warnings: Vec<String>,
}

/// Reads the surface of a scene, or of a level of it.
///
/// # Errors
/// If it cannot be read, has no such level, no triangles or too many.
pub(super) fn surface(
    path: &Path,
    wish: Wish,
    args: &CompareArgs,
    stages: &mut Stages,
) -> Outcome<SceneSurface> {
    let options = args.import.options();
    let name = path.display().to_string();
    let scene = shown(path, wish, args, stages)?;
    for warning in &scene.warnings {
        console::warning(&name, warning);
    }
    let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|(info, _)| info).collect();
    let looks = if args.no_attributes || args.views == 0 {
        Appearance::default()
    } else {
        let mut assets = Assets::new(path, &options.allowed, options.limits);
        appearance(&scene.document, &infos, &mut assets).map_err(|e| e.in_file(&name))?
    };
    for warning in &looks.warnings {
        console::warning(&name, warning);
    }
    let graph =
        scene_graph(&scene.document, &infos, &options.limits).map_err(|e| e.in_file(&name))?;
    let arrangement = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let meshes: Vec<&Mesh> = scene.objects.iter().map(|(_, mesh)| mesh).collect();
    let counts = arrangement.placements().iter().map(|p| meshes[p.object].triangles().len());
    let triangles = counts.fold(0, usize::saturating_add);
    if triangles == 0 {
        let message = format!("{name}: has no triangles: there is nothing to compare");
        return Err(Failure::new(Status::Input, message));
    }
    if triangles > MAX_TRIANGLES {
        let message = format!("{name}: its instances have more than {MAX_TRIANGLES} triangles");
        return Err(Failure::new(Status::Limit, message));
    }
    Ok(SceneSurface::new(&meshes, &arrangement, &looks))
}

/// Reads a scene. A mesh is simplified only if a level of it is wanted.
fn shown(path: &Path, wish: Wish, args: &CompareArgs, stages: &mut Stages) -> Outcome<Shown> {
    if let Some(target) = wish.target {
        let asset = asset::read(path, &args.import, &args.simplify, stages)?;
        let limits = args.import.limits().limits();
        let levels = SceneLevels::new(&asset.objects, &asset.document, &limits)?;
        let chosen = levels.select(target, wish.per_object)?;
        let objects = at_levels(asset.objects, &chosen.lods)?;
        let warnings = [asset.warnings, chosen.warnings].concat();
        return Ok(Shown { document: asset.document, objects, warnings });
    }
    match stages.run("import", || either(path, &args.import.options()))? {
        Either::Scene(scene) => {
            let objects = scene.objects.into_iter().map(|o| (o.info, o.mesh)).collect();
            Ok(Shown { document: scene.document, objects, warnings: scene.warnings })
        }
        Either::Levels(file) => {
            let lods = vec![Lod(0); file.objects.len()];
            let objects = at_levels(file.objects, &lods)?;
            Ok(Shown { document: file.document, objects, warnings: file.left_out })
        }
    }
}

fn at_levels(objects: Vec<LodObject>, lods: &[Lod]) -> Outcome<Vec<(ObjectInfo, Mesh)>> {
    let shape = Shape { order: Order::File, ..Shape::default() };
    let meshes = level_mesh::meshes(&objects, lods, shape)?;
    Ok(objects.into_iter().zip(meshes).map(|(o, level)| (o.info, level.mesh)).collect())
}
