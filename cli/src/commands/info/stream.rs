//! `lodc info` of a `.lods`: how many steps and bytes of the document have arrived, and of how
//! many.

use crate::commands::stream_objects;
use crate::exit::{Failure, Outcome, one_line};
use lodc_formats::Limits;
use lodc_formats::lods::{self, Unpacker};
use lodc_report::SCHEMA_VERSION;
use lodc_report::documents::StreamInfoReport;
use lodc_report::text::{count, distance, grouped, size};
use std::fmt::Write;

/// Returns how much of a stream there is, and the failure of the first part that cannot be used.
///
/// # Errors
/// If nothing of it can be used.
pub(super) fn report(
    name: &str,
    bytes: &[u8],
    limits: Limits,
) -> Outcome<(StreamInfoReport, Option<Failure>)> {
    let mut unpacker = Unpacker::new(limits);
    let damaged = unpacker.feed(bytes).err();
    let failure = damaged.as_ref().map(|e| Failure::from(e.clone().in_file(name)));
    if let (Some(failure), None) = (&failure, unpacker.all_objects()) {
        return Err(failure.clone());
    }
    let infos: Vec<_> = (0..unpacker.objects()).map(|i| unpacker.info(i).clone()).collect();
    let [document_bytes, of_document_bytes] = unpacker.document_bytes();
    let report = StreamInfoReport {
        schema_version: SCHEMA_VERSION,
        format: "lods",
        format_version: lods::VERSION,
        bytes: bytes.len() as u64,
        used: unpacker.bytes(),
        whole: unpacker.is_complete(),
        damaged: damaged.map(|e| e.to_string()),
        document_bytes,
        of_document_bytes,
        all_objects: unpacker.all_objects(),
        objects: stream_objects::reports(&unpacker, &infos),
    };
    Ok((report, failure))
}

/// The report for people.
pub(super) fn text(name: &str, report: &StreamInfoReport) -> String {
    let state = match &report.damaged {
        None if report.whole => "complete".to_owned(),
        None => format!("a prefix: {} can be used", size(report.used)),
        Some(_) => format!("damaged: the first {} can be used", size(report.used)),
    };
    // Writing to a string cannot fail.
    let mut text = String::new();
    let (version, bytes) = (report.format_version, size(report.bytes));
    let _ = writeln!(text, "{name}: stream of version {version}, {bytes}, {state}");
    let Some(objects) = report.all_objects else { return text };
    let [has, of] = [report.document_bytes, report.of_document_bytes].map(size);
    let _ = writeln!(text, "  names, nodes, materials and buffers: {has} of {of}");
    let begun = report.objects.iter().filter(|o| o.vertices > 0).count() as u64;
    let objects = count(u64::from(objects), "object");
    let _ = writeln!(text, "  {} of {objects} begun", grouped(begun));
    for o in &report.objects {
        let _ = writeln!(
            text,
            "  {}: {} of {} triangles, {} of {} vertices, error {}{}",
            one_line(&o.name),
            grouped(u64::from(o.triangles)),
            grouped(u64::from(o.of_triangles)),
            grouped(u64::from(o.vertices)),
            grouped(u64::from(o.of_vertices)),
            distance(o.error),
            o.rms.map_or(String::new(), |rms| format!(", rms {}", distance(rms)))
        );
    }
    text
}
