//! What `render` draws: objects, their materials and textures, and their transforms in the scene.

use super::RenderArgs;
use super::options::ColorMode;
use crate::commands::asset::{self, SimplifyArgs};
use crate::commands::input::Objects;
use crate::exit::{Failure, Outcome, Status};
use crate::output::{self, Target};
use crate::stages::Stages;
use lodc::{Input, read_input};
use lodc_formats::{Document, Scene, appearance as read_appearance, scene_graph};
use lodc_scene::{Appearance, Arrangement};

/// Triangles of the input, with all instances, that one picture is made of at most. Chosen by hand,
/// as is the next: both bound the memory.
const MAX_TRIANGLES: u64 = 1 << 25;
/// Placements that one picture shows at most.
const MAX_PLACEMENTS: usize = 1 << 20;

/// An asset that can be drawn.
pub(super) struct DrawableScene {
    pub(super) objects: Objects,
    pub(super) document: Document,
    pub(super) appearance: Appearance,
    /// The placements of objects.
    pub(super) arrangement: Arrangement,
    /// What was repaired, dropped or left out while reading.
    pub(super) warnings: Vec<String>,
}

/// Reads the input, and simplifies a mesh as `build` would if levels of detail are asked for.
///
/// # Errors
/// If the input cannot be read, or there is too much to draw.
pub(super) fn read(
    args: &RenderArgs,
    target: &Target,
    stages: &mut Stages,
) -> Outcome<DrawableScene> {
    let options = args.import.options();
    let read = stages.run("read", || read_input(&args.input, &options))?;
    let (objects, document, warnings) = match read {
        Input::Lodc(file) => (Objects::Simplified(file.objects), file.document, file.left_out),
        Input::Scene(scene) => objects_of_scene(args, scene, stages)?,
    };
    let infos = objects.infos();
    let name = args.input.display().to_string();
    let mut assets = args.import.assets(&args.input, args.textures.as_ref());
    let appearance = stages
        .run("textures", || read_appearance(&document, &infos, &mut assets))
        .map_err(|e| e.in_file(&name))?;
    output::refuse_replacing(target.file(), assets.files())?;
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
    Ok(DrawableScene { objects, document, appearance, arrangement, warnings })
}

/// The objects of a scene: meshes, or simplified if levels or strips are asked for.
fn objects_of_scene(
    args: &RenderArgs,
    scene: Scene,
    stages: &mut Stages,
) -> Outcome<(Objects, Document, Vec<String>)> {
    let needs_levels = args.selector.target().is_some()
        || args.views.criterion.is_some()
        || !args.contact_sheet.is_empty();
    if !needs_levels && args.color != ColorMode::Strips {
        return Ok((Objects::Meshes(scene.objects), scene.document, scene.warnings));
    }
    let simplify_args = SimplifyArgs::default();
    let errors = Some(lodc::Errors::Curve);
    let asset =
        asset::simplified(&args.input, &args.import, &simplify_args, errors, scene, stages)?;
    Ok((Objects::Simplified(asset.objects), asset.document, asset.warnings))
}
