//! Measures the distances between two files: from A to each requested level of B, and back.

use super::baseline::{self, Baseline, options};
use super::surface::{ComparedScene, LevelChoice};
use super::{CompareArgs, ROUNDING_SHARE};
use crate::exit::Outcome;
use crate::output;
use crate::progress::Progress;
use crate::stages::Stages;
use lodc::Errors;
use lodc_formats::images::png;
use lodc_measure::{
    Original, Recorded, ReferencePictures, Sampling, SceneSurface, ShadingOptions, Viewing,
    heat_sheet,
};
use lodc_report::{Comparison, ImageReport, PairReport};
use lodc_select::Target;
use std::path::Path;

/// Result of the comparison of two files.
pub(super) struct Measured {
    pub(super) report: PairReport,
    /// What the baseline records of it.
    pub(super) recorded: Recorded,
}

/// Compares two files. `name` is the pair's in the baseline.
///
/// # Errors
/// If one cannot be read or has no such level, the baseline does not suit, or the heatmap cannot
/// be written.
pub(super) fn compare(
    args: &CompareArgs,
    [path_a, path_b]: [&Path; 2],
    name: &str,
    baseline: Option<&Baseline>,
    progress: &Progress,
) -> Outcome<Measured> {
    let recorded_before = baseline.map(|b| baseline::recorded(b, name, args)).transpose()?;
    let mut stages = Stages::new(args.import.clock(path_b));
    let choice_a = LevelChoice { target: args.level_a, per_object: false };
    let level_a = args.level_a.map(|target| Errors::to_choose([target]));
    let a = ComparedScene::read(path_a, level_a, args, &mut stages, progress)?;
    let level_choices = args.level_choices();
    let targets: Vec<Target> =
        level_choices.iter().filter_map(|(_, choice)| choice.target).collect();
    let levels = (!targets.is_empty()).then(|| Errors::to_choose(targets));
    let b = ComparedScene::read(path_b, levels, args, &mut stages, progress)?;
    progress.clear();
    let centre = a.centre(args)?;
    let (a, mut pictures_of_a) = (a.surface(choice_a, centre, args)?, None);
    let sampling =
        Sampling { samples: args.samples as usize, seed: args.seed, ..Sampling::DEFAULT };
    let original = stages.run("distance", || Original::new(&a.surface, &sampling));
    let diagonal = a.surface.diagonal();
    let (mut comparisons, mut names) = (Vec::new(), Vec::new());
    for (level, choice) in level_choices {
        let surface = b.surface(choice, centre, args)?;
        let mut comparison =
            comparison(args, (&a, &original), &surface, &mut pictures_of_a, &mut stages);
        let level_name = level.clone().unwrap_or_else(|| baseline_name(choice.target));
        comparison.check(&args.limits_on_differences(), diagonal);
        if let Some(recorded_before) = &recorded_before {
            let recorded_before =
                recorded_before.as_ref().and_then(|recorded| recorded.levels.get(&level_name));
            comparison.check_baseline(recorded_before, args.tolerance, diagonal);
        }
        if let Some(path) = &args.heatmap {
            let shading = shading(&a, &surface, args);
            let largest = comparison.hausdorff.a_to_b.max(ROUNDING_SHARE * diagonal);
            let sheet = || heat_sheet(&a.surface, &surface.surface, shading, largest);
            let bytes = stages.run("heatmap", || png(&sheet()));
            output::write(&output::Target::File(path.clone()), bytes)?;
        }
        comparisons.push((level, comparison));
        names.push(level_name);
    }
    let levels = names.into_iter().zip(comparisons.iter().map(|(_, c)| c.numbers())).collect();
    let recorded = Recorded { options: options(args), levels };
    let paths = [path_a, path_b].map(|path| path.display().to_string());
    Ok(Measured { report: PairReport::new(paths, diagonal, comparisons), recorded })
}

fn comparison(
    args: &CompareArgs,
    (a, original): (&SceneSurface, &Original),
    b: &SceneSurface,
    pictures_of_a: &mut Option<ReferencePictures>,
    stages: &mut Stages,
) -> Comparison {
    let shading = shading(a, b, args);
    let (a, b) = (&a.surface, &b.surface);
    let space = stages.run("distance", || original.distances(b));
    let image = (args.views > 0).then(|| {
        let viewing = Viewing { views: args.views, size: args.size };
        stages.run("pictures", || {
            // Most levels are shaded alike, so the pictures of A serve again.
            let reusable = pictures_of_a.take().filter(|reference| reference.shading() == shading);
            let pictures_of_a = pictures_of_a
                .insert(reusable.unwrap_or_else(|| ReferencePictures::new(a, viewing, shading)));
            ImageReport::new(viewing, shading, pictures_of_a.compare(b))
        })
    });
    Comparison::new([a.triangles.len(), b.triangles.len()], space, image)
}

/// Normals, textures and texture coordinates as far as both meshes have them.
fn shading(a: &SceneSurface, b: &SceneSurface, args: &CompareArgs) -> ShadingOptions {
    if args.no_attributes { ShadingOptions::default() } else { a.common_shading(b) }
}

/// The name of a level in a baseline, of one that the command line does not name.
fn baseline_name(target: Option<Target>) -> String {
    match target {
        None => "all".to_owned(),
        Some(Target::Lod(lod)) => format!("LOD {lod}"),
        Some(Target::Ratio(share)) => format!("{}%", share * 100.0),
        Some(Target::Triangles(n)) => format!("{n} triangles"),
        Some(Target::Error(e)) => format!("error {e}"),
        Some(Target::ErrorShare(e)) => format!("error {}%", e * 100.0),
        Some(Target::Rms(e)) => format!("rms {e}"),
        Some(Target::RmsShare(e)) => format!("rms {}%", e * 100.0),
    }
}
