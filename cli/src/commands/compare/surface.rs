//! The surfaces that are compared: scenes as their default scenes show them.

use super::CompareArgs;
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use lodc_formats::appearance::appearance;
use lodc_formats::{Assets, ObjectInfo, import, scene_graph};
use lodc_measure::SceneSurface;
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement};
use std::path::Path;

/// More triangles than this, instances counted, are not compared.
const MAX_TRIANGLES: usize = 1 << 28;

/// Reads the surface of a scene.
pub(super) fn surface(path: &Path, args: &CompareArgs) -> Outcome<SceneSurface> {
    let options = args.import.options();
    let scene = import::import(path, &options)?;
    let name = path.display().to_string();
    for warning in &scene.warnings {
        console::warning(&name, warning);
    }
    let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
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
    let meshes: Vec<&Mesh> = scene.objects.iter().map(|o| &o.mesh).collect();
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
