//! `lodc report`: one offline page for people who approve assets.

mod levels;
mod page;

use super::asset::Asset;
use super::verify;
use super::view::{self, Page, PageArgs, Shown};
use crate::commands::verify::CheckReport;
use crate::exit::{Failure, Outcome, Status};
use lodc::{SceneLevels, scene_levels};
use lodc_formats::appearance;
use lodc_formats::{ObjectInfo, scene_graph};
use lodc_scene::Arrangement;
use lodc_select::scene_diagonal;

/// Examples in the help.
pub(crate) const EXAMPLES: &str = "\
Examples:
  lodc report chair.glb -o chair.html
  lodc report chair.lodc -o chair.html --depfile chair.d";

/// All that a page is made of.
struct Facts<'a> {
    title: String,
    asset: &'a Asset,
    levels: Vec<levels::Level>,
    /// Triangles and error in world units of many levels, fine to coarse.
    curve: Vec<[f64; 2]>,
    diagonal: f64,
    checks: Vec<CheckReport>,
    warnings: Vec<String>,
    /// Bytes of the input file.
    bytes: Option<u64>,
}

/// Writes the page. A failed check stands on the page and is exit status 1.
///
/// # Errors
/// As [`view::write`].
pub(crate) fn run(args: &PageArgs) -> Outcome<Status> {
    view::write(args, |shown| {
        let (facts, warnings) = facts(args, shown)?;
        let text = page::page(&facts);
        let (status, what) = match facts.checks.iter().filter(|c| c.ok == Some(false)).count() {
            0 => (Status::Done, String::new()),
            failed => (Status::Difference, format!(", {failed} checks failed")),
        };
        Ok((Page { text, warnings, facts: [String::new(), what] }, status))
    })
}

/// The facts, and warnings about textures.
fn facts<'a>(args: &PageArgs, shown: Shown<'a>) -> Outcome<(Facts<'a>, Vec<String>)> {
    let Shown { asset, mut assets, title, stages } = shown;
    let name = args.input.display().to_string();
    let options = args.import.options();
    let infos: Vec<&ObjectInfo> = asset.objects.iter().map(|o| &o.info).collect();
    let looks = appearance(&asset.document, &infos, &mut assets).map_err(|e| e.in_file(&name))?;
    let graph =
        scene_graph(&asset.document, &infos, &options.limits).map_err(|e| e.in_file(&name))?;
    let arrangement = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let scene = scene_levels(&asset.objects, &asset.document, &options.limits)?;
    let levels = stages.run("pictures", || levels::shown(asset, &scene, &arrangement, &looks))?;
    if levels[0].triangles == 0 {
        let message = format!("{name}: has no triangles: there is nothing to report");
        return Err(Failure::new(Status::Input, message));
    }
    let check = || verify::models(&asset.objects, &asset.document, 1, &options.limits);
    let checks = stages.run("check", check)?;
    let facts = Facts {
        title,
        asset,
        curve: curve(&scene, levels[0].triangles)?,
        diagonal: scene_diagonal(&scene.candidates()),
        levels,
        checks,
        warnings: [&asset.warnings[..], &looks.warnings].concat(),
        bytes: std::fs::metadata(&args.input).ok().map(|m| m.len()),
    };
    Ok((facts, looks.warnings))
}

/// Triangles and error of levels that each have nine tenths of the triangles of the one before.
fn curve(scene: &SceneLevels<'_>, triangles: u64) -> Outcome<Vec<[f64; 2]>> {
    let mut points = Vec::new();
    let mut wanted = triangles;
    while wanted > 3 && points.len() < 200 {
        let chosen = scene.select(lodc_select::Target::Triangles(wanted), false)?;
        let candidates = scene.candidates();
        let left: u32 = candidates
            .iter()
            .zip(&chosen.lods)
            .map(|(c, &lod)| c.collapses.triangles_at(lod))
            .sum();
        points.push([f64::from(left), chosen.error]);
        wanted = wanted * 9 / 10;
    }
    Ok(points)
}
