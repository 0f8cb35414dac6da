//! The summary of `unpack`: JSON for scripts, a sentence for people.

use super::{Stream, UnpackArgs};
use crate::commands::stream_objects;
use crate::console::{self, Loudness, note, wants};
use crate::exit::Outcome;
use crate::output::Target;
use lodc_formats::lods::Arrived;
use lodc_report::SCHEMA_VERSION;
use lodc_report::documents::{UnpackReport, UnpackedReport};
use lodc_report::text::{count, distance, grouped, size};

/// Prints warnings and what was unpacked.
///
/// # Errors
/// If standard output cannot be written.
pub(super) fn print(
    args: &UnpackArgs,
    stream: &Stream,
    arrived: &Arrived<'_>,
    warnings: Vec<String>,
    target: &Target,
) -> Outcome<()> {
    console::warnings(&stream.name, &warnings);
    let Stream { unpacker, damaged, .. } = stream;
    let report = UnpackReport {
        schema_version: SCHEMA_VERSION,
        input: args.input.display().to_string(),
        output: target.name(),
        whole: unpacker.is_complete(),
        damaged: damaged.as_ref().map(ToString::to_string),
        bytes: unpacker.bytes(),
        all_objects: unpacker.all_objects().unwrap_or(0),
        left_out: arrived.left_out.clone(),
        objects: stream_objects::reports(unpacker, &arrived.infos),
        warnings,
    };
    if args.json {
        console::json(&report)?;
    } else if wants(Loudness::Normal) {
        note(&sentence(&report));
    }
    Ok(())
}

/// What was unpacked in a sentence, and in a second one what has not come.
fn sentence(report: &UnpackReport) -> String {
    let output = if report.output == "-" { "standard output" } else { &report.output };
    let sum = |of: fn(&UnpackedReport) -> u32| {
        report.objects.iter().map(|o| u64::from(of(o))).sum::<u64>()
    };
    let (triangles, all) = (sum(|o| o.triangles), sum(|o| o.of_triangles));
    let worst = report.objects.iter().map(|o| o.world_error).fold(0.0, f64::max);
    let bytes = size(report.bytes);
    if report.whole {
        return format!(
            "{output}: {}, the complete stream of {bytes}",
            count(triangles, "triangle")
        );
    }
    // The numbers of triangles of objects that have not come are unknown.
    let is_known = report.objects.len() == report.all_objects as usize && all > 0;
    let of = if is_known { format!(" of {}", grouped(all)) } else { String::new() };
    let mut text = format!(
        "{output}: {}{of} triangles, error {}: from the first {bytes} of the stream",
        grouped(triangles),
        distance(worst)
    );
    if !report.left_out.is_empty() {
        text += &format!("\n{output}: not received: {}", report.left_out.join(", "));
    }
    text
}
