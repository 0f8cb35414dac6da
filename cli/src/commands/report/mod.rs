//! `lodc report`: one offline page for people who approve assets.

mod levels;
mod page;

use super::asset::{self, Asset};
use super::verify;
use super::view::{self, PageArgs};
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::mesh_output;
use crate::output::{self, Rule};
use crate::report::CheckReport;
use crate::selector::SceneLevels;
use crate::stages::Stages;
use crate::text::size;
use lodc_formats::appearance::appearance;
use lodc_formats::{Assets, ObjectInfo, OutputFile, scene_graph};
use lodc_scene::Arrangement;
use lodc_select::scene_diagonal;
use std::path::PathBuf;

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
/// If the input cannot be read or shown, or the page not be written.
pub(crate) fn run(args: &PageArgs) -> Outcome<Status> {
    let target = view::target(args)?;
    let mut stages = Stages::default();
    let asset = asset::read(&args.input, &args.import, &args.simplify, &mut stages)?;
    let facts = facts(args, &asset, &mut stages)?;
    let bytes = page::page(&facts).into_bytes();
    let (length, path) = (bytes.len() as u64, PathBuf::from(target.name()));
    let file = OutputFile { path: path.clone(), bytes };
    stages.run("write", || mesh_output::write(&target, vec![file]))?;
    if let Some(depfile) = &args.depfile {
        let rule = Rule { output: path, inputs: asset.files_read.clone() };
        output::write_depfile(depfile, &[rule])?;
    }
    let name = args.input.display().to_string();
    for warning in &facts.warnings {
        console::warning(&name, warning);
    }
    let failed = facts.checks.iter().filter(|c| c.ok == Some(false)).count();
    if wants(Loudness::Normal) {
        let what = if failed > 0 { format!(", {failed} checks failed") } else { String::new() };
        note(&format!("{}: {}{what}; open it in a browser", target.name(), size(length)));
    }
    Ok(if failed > 0 { Status::Difference } else { Status::Done })
}

fn facts<'a>(args: &PageArgs, asset: &'a Asset, stages: &mut Stages) -> Outcome<Facts<'a>> {
    let name = args.input.display().to_string();
    let options = args.import.options();
    let infos: Vec<&ObjectInfo> = asset.objects.iter().map(|o| &o.info).collect();
    // Only the folder of that path counts: textures are looked for there.
    let beside =
        args.textures.as_ref().map_or_else(|| args.input.clone(), |folder| folder.join("-"));
    let mut assets = Assets::new(&beside, &options.allowed, options.limits);
    let looks = appearance(&asset.document, &infos, &mut assets).map_err(|e| e.in_file(&name))?;
    let graph =
        scene_graph(&asset.document, &infos, &options.limits).map_err(|e| e.in_file(&name))?;
    let arrangement = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let scene = SceneLevels::new(&asset.objects, &asset.document, &options.limits)?;
    let levels = stages.run("pictures", || levels::shown(asset, &scene, &arrangement, &looks))?;
    if levels[0].triangles == 0 {
        let message = format!("{name}: has no triangles: there is nothing to report");
        return Err(Failure::new(Status::Input, message));
    }
    let limits = args.import.options().limits;
    let checks =
        stages.run("check", || verify::models(&asset.objects, &asset.document, 1, &limits))?;
    let warnings = asset.warnings.iter().chain(&looks.warnings).cloned().collect();
    Ok(Facts {
        title: args.title.clone().unwrap_or_else(|| view::title(&args.input)),
        asset,
        curve: curve(&scene, levels[0].triangles)?,
        diagonal: scene_diagonal(&scene.candidates()),
        levels,
        checks,
        warnings,
        bytes: std::fs::metadata(&args.input).ok().map(|m| m.len()),
    })
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
