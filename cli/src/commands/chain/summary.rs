//! The summary of one chain: JSON for scripts, text for people.

use super::Files;
use super::levels::ChosenLevel;
use crate::console::{Loudness, note, result, wants};
use crate::exit::Outcome;
use lodc_report::documents::{ChainLevel, ChainReport, GeomorphReport};
use lodc_report::text::{count, distance, grouped, size};
use lodc_report::{ErrorsOver, SCHEMA_VERSION};

/// The document of a chain.
pub(super) fn report(
    input: String,
    levels: &[ChosenLevel],
    made: &Files,
    warnings: Vec<String>,
    errors_over: ErrorsOver,
) -> ChainReport {
    let numbered = levels.iter().zip(&made.of_level).enumerate();
    let levels: Vec<ChainLevel> =
        numbered.map(|(level, (l, path))| l.report(level, path)).collect();
    let moving = || levels.iter().filter(|l| l.morph_from.is_some());
    let geomorph = moving().next().is_some().then(|| GeomorphReport {
        pairs: moving().count() as u64,
        max_pose_error: moving().filter_map(|l| l.geomorph_pose_error).max_by(f64::total_cmp),
    });
    ChainReport {
        schema_version: SCHEMA_VERSION,
        input,
        outputs: made.files.iter().map(Into::into).collect(),
        errors_over,
        levels,
        geomorph,
        warnings,
    }
}

/// Prints what was made: a table, or of one of several a line on standard error. With `json` the
/// document follows later.
///
/// # Errors
/// If standard output cannot be written.
pub(super) fn print(report: &ChainReport, several: bool, json: bool) -> Outcome<()> {
    if several {
        note(&line(report));
    }
    if several || json || !wants(Loudness::Normal) {
        return Ok(());
    }
    result(" level   triangles    vertices       error         rms    distance")?;
    for l in &report.levels {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), distance);
        result(&format!(
            "{:6} {:>11} {:>11} {:>11} {:>11} {:>11}",
            l.level,
            grouped(l.triangles),
            grouped(l.vertices),
            number(l.error),
            number(l.rms),
            number(l.distance)
        ))?;
    }
    for file in &report.outputs {
        result(&format!("{}: {}", file.path, size(file.bytes)))?;
    }
    Ok(())
}

fn line(report: &ChainReport) -> String {
    let path = report.outputs.first().map_or("", |file| &file.path);
    let triangles: Vec<String> = report.levels.iter().map(|l| grouped(l.triangles)).collect();
    let bytes = report.outputs.iter().map(|file| file.bytes).sum();
    let levels = count(report.levels.len() as u64, "level");
    format!("{path}: {levels} of {} triangles, {}", triangles.join(", "), size(bytes))
}
