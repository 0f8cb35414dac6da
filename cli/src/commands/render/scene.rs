//! What `render` draws: objects, their materials and textures, and their transforms in the scene.

use super::RenderArgs;
use super::options::Colouring;
use crate::commands::asset::{self, SimplifyArgs};
use crate::commands::input::Objects;
use crate::exit::{Failure, Outcome, Status};
use crate::stages::Stages;
use lodc::{Input, read_input};
use lodc_formats::appearance;
use lodc_formats::{Document, Scene, scene_graph};
use lodc_scene::{Appearance, Arrangement};

/// More triangles than this, instances counted, are not drawn in one picture.
const MAX_TRIANGLES: u64 = 1 << 26;
/// More placements than this are not drawn in one picture.
const MAX_PLACEMENTS: usize = 1 << 20;

/// An asset that can be drawn.
pub(super) struct DrawableScene {
    pub(super) objects: Objects,
    pub(super) document: Document,
    pub(super) appearance: Appearance,
    /// The placements of objects.
    pub(super) arrangement: Arrangement,
    /// Repairs, drops and omissions while reading.
    pub(super) warnings: Vec<String>,
}

/// Reads the input, and simplifies a mesh as `build` would if levels of detail are asked for.
///
/// # Errors
/// If the input cannot be read, or there is too much to draw.
pub(super) fn read(args: &RenderArgs, stages: &mut Stages) -> Outcome<DrawableScene> {
    let options = args.import.options();
    let read = stages.run("read", || read_input(&args.input, &options))?;
    let (objects, document, warnings) = match read {
        Input::Levels(file) => (Objects::Levels(file.objects), file.document, file.left_out),
        Input::Scene(scene) => of_scene(args, scene, stages)?,
    };
    let infos = objects.infos();
    let name = args.input.display().to_string();
    let mut assets = args.import.assets(&args.input, args.textures.as_ref());
    let looks = stages
        .run("textures", || appearance(&document, &infos, &mut assets))
        .map_err(|e| e.in_file(&name))?;
    let graph = scene_graph(&document, &infos, &options.limits).map_err(|e| e.in_file(&name))?;
    if graph.placement_count() > MAX_PLACEMENTS {
        let message = format!("{name}: shows objects more than {MAX_PLACEMENTS} times");
        return Err(Failure::new(Status::Limit, message));
    }
    let pose = args.pose.of(&args.input, &document, &graph, &options.limits)?;
    let arrangement = Arrangement::new(&graph, &pose, objects.len());
    let triangles: u64 = arrangement
        .placements()
        .iter()
        .map(|p| objects.mesh(p.object).triangles().len() as u64)
        .sum();
    if triangles > MAX_TRIANGLES {
        let message =
            format!("{name}: {triangles} triangles with all instances, more than {MAX_TRIANGLES}");
        return Err(Failure::new(Status::Limit, message));
    }
    Ok(DrawableScene { objects, document, appearance: looks, arrangement, warnings })
}

fn of_scene(
    args: &RenderArgs,
    scene: Scene,
    stages: &mut Stages,
) -> Outcome<(Objects, Document, Vec<String>)> {
    let levels = args.selector.target().is_some()
        || args.views.criterion.is_some()
        || !args.contact_sheet.is_empty();
    if !levels && args.color != Colouring::Strips {
        return Ok((Objects::Meshes(scene.objects), scene.document, scene.warnings));
    }
    let simplify_args = SimplifyArgs::default();
    let asset = asset::simplified(&args.input, &args.import, &simplify_args, scene, stages)?;
    Ok((Objects::Levels(asset.objects), asset.document, asset.warnings))
}
