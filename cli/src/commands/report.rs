//! `lodc report`: an offline HTML page with pictures, distances and checks of an asset, for people
//! who approve assets.

use super::view::{Page, PageArgs, PageInput};
use crate::exit::{Failure, Outcome, Status};
use lodc::scene_levels;
use lodc_formats::appearance;
use lodc_formats::{ObjectInfo, scene_graph};
use lodc_report::{PageContent, PartInventory, check_models, error_curve, page, page_levels};
use lodc_scene::Arrangement;
use lodc_select::scene_diagonal;

/// Examples in the help.
pub(crate) const EXAMPLES: &str = "\
Examples:
  lodc report chair.glb -o chair.html
  lodc report chair.lodc -o chair.html --depfile chair.d";

/// Writes the page. A failed check is on the page, and makes the exit status 1.
///
/// # Errors
/// If the input cannot be read or shown, or the page not be written.
pub(crate) fn run(args: &PageArgs) -> Outcome<Status> {
    let mut input = PageInput::read(args)?;
    let (content, warnings) = content(args, &mut input)?;
    let text = page(&content);
    let (status, after_size) = match content.checks.iter().filter(|c| c.ok == Some(false)).count() {
        0 => (Status::Done, String::new()),
        failed => (Status::Difference, format!(", {failed} checks failed")),
    };
    input.finish(args, Page { text, warnings, before_size: String::new(), after_size })?;
    Ok(status)
}

/// The content of the page, and warnings about textures.
fn content<'a>(
    args: &PageArgs,
    input: &'a mut PageInput,
) -> Outcome<(PageContent<'a>, Vec<String>)> {
    let PageInput { asset, assets, title, stages, .. } = input;
    let name = args.input.display().to_string();
    let options = args.import.options();
    let infos: Vec<&ObjectInfo> = asset.objects.iter().map(|o| &o.info).collect();
    let appearance = appearance(&asset.document, &infos, assets).map_err(|e| e.in_file(&name))?;
    let graph =
        scene_graph(&asset.document, &infos, &options.limits).map_err(|e| e.in_file(&name))?;
    let arrangement = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let scene = scene_levels(&asset.objects, &asset.document, &options.limits)?;
    let inventory = PartInventory::new(&asset.objects, &scene, &asset.document)?;
    let levels = stages.run("pictures", || {
        page_levels(&asset.objects, &scene, &inventory, &arrangement, &appearance)
    })?;
    if levels[0].triangles == 0 {
        let message = format!("{name}: has no triangles: there is nothing to report");
        return Err(Failure::new(Status::Input, message));
    }
    let stride = 1;
    let check = || check_models(&asset.objects, &asset.document, stride, &options.limits);
    let checks = stages.run("check", check)?;
    let content = PageContent {
        title: title.clone(),
        objects: &asset.objects,
        curve: error_curve(&scene, levels[0].triangles)?,
        diagonal: scene_diagonal(&scene.candidates()),
        levels,
        checks,
        warnings: [&asset.warnings[..], &appearance.warnings].concat(),
        bytes: std::fs::metadata(&args.input).ok().map(|m| m.len()),
    };
    Ok((content, appearance.warnings))
}
