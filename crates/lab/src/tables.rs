//! The figures of an object as tables for people.

use crate::report::{BenchObject, PrefixReport, StreamReport, value};
use crate::timings::Spread;
use indexmap::IndexMap;
use lodc_report::text::grouped;
use serde::Serialize;
use serde_json::Value;
use std::fmt::{Display, Write};

/// A column: its heading, the JSON pointer of its number in a row, and the digits after the point.
type Column = (&'static str, &'static str, usize);

/// As the thesis counts, with positions and with normals; the same down to 95 % of the LODs; in a
/// file; and what the structure really holds (`tight`).
const STORAGE: &[Column] = &[
    ("thesis", "/bits_per_vertex/thesis", 1),
    ("normals", "/bits_per_vertex/thesis_normals", 1),
    ("to 95 %", "/bits_per_vertex/thesis_95", 1),
    ("normals", "/bits_per_vertex/thesis_normals_95", 1),
    ("file", "/bits_per_vertex/file", 1),
    ("tight", "/bits_per_vertex/tight", 1),
];
/// Also as multiples of the mean of Progressive Meshes (PM) and LodStrips, and a jump as one of a
/// rebuild from scratch.
const EXTRACTION: &[Column] = &[
    ("coarser", "/extraction/coarser_us", 3),
    ("finer", "/extraction/finer_us", 3),
    ("mean", "/extraction/mean_us", 3),
    ("× PM", "/extraction/per_progressive_mesh", 2),
    ("× LodStrips", "/extraction/per_lodstrips", 2),
    ("jump", "/extraction/jump_us", 1),
    ("× rebuild", "/extraction/jump_per_rebuild", 2),
];
/// Means of all rounds, each with its deviation.
const SPREAD: &[Column] = &[
    ("coarser", "/extraction/spread/coarser/mean", 3),
    ("±", "/extraction/spread/coarser/deviation", 3),
    ("finer", "/extraction/spread/finer/mean", 3),
    ("±", "/extraction/spread/finer/deviation", 3),
    ("jump", "/extraction/spread/jump/mean", 1),
    ("±", "/extraction/spread/jump/deviation", 1),
];
/// The first three are for each update, the others for each LOD.
const TRAFFIC: &[Column] = &[
    ("bytes", "/traffic/bytes_per_update", 0),
    ("upload", "/traffic/upload_bytes_per_update", 0),
    ("rewritten", "/traffic/rewritten_per_update", 1),
    ("drawn", "/drawn/indices_per_lod", 0),
    ("per triangle", "/drawn/indices_per_triangle", 3),
    ("less degen.", "/drawn/degenerates_removed", 2),
];
/// Updates on a device.
const GPU: &[Column] = &[
    ("runs", "/runs", 0),
    ("ms", "/milliseconds", 3),
    ("mean", "/spread/mean", 3),
    ("±", "/spread/deviation", 3),
    ("bytes sent", "/bytes", 0),
    ("M vertices/s", "/million_vertices_per_second", 1),
];
/// Meshes of a stream's prefixes.
const PREFIXES: &[Column] = &[
    ("bytes", "/bytes", 0),
    ("triangles", "/triangles", 0),
    ("RMS %", "/rms", 4),
    ("Hausdorff %", "/hausdorff", 3),
    ("image", "/image", 2),
];
/// Words for each vertex on a device.
const MEMORY: &[Column] = &[("positions", "/positions", 1), ("and normals", "/normals", 1)];
/// Strips and lists of one LOD.
const PRIMITIVES: &[Column] = &[
    ("strips", "/strips", 0),
    ("indices", "/indices", 0),
    ("per triangle", "/indices_per_triangle", 3),
    ("ACMR", "/acmr_fifo16", 3),
];
/// Milliseconds for each draw.
const DRAWS: &[Column] = &[("LOD 0", "/draw_ms", 3), ("20 %", "/draw_ms_20", 3)];

/// All tables of an object; `share` is that of the LODs from one update to the next.
#[must_use]
pub fn tables(object: &BenchObject, share: f64) -> String {
    let mut text = String::new();
    // As `f32` the product has none of the digits that rounding added.
    let percent = (share * 100.0) as f32;
    table(&mut text, "storage, bits per vertex", &object.models, STORAGE);
    table(&mut text, &format!("µs per update of {percent} %"), &object.models, EXTRACTION);
    if let Some(rebuild_us) = object.rebuild_us {
        let lod = grouped(u64::from(object.jump_lod));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  (jump: LOD 0 to {lod}, 1 % of the triangles; from scratch {rebuild_us:.1} µs)"
        );
    }
    table(&mut text, "the same, mean ± deviation", &object.models, SPREAD);
    table(&mut text, "per update, and per LOD", &object.models, TRAFFIC);
    table(&mut text, "primitives at LOD 0", &object.primitives, PRIMITIVES);
    table(&mut text, "where 20 % is left", &object.primitives_20, PRIMITIVES);
    if let Some(stream) = &object.stream {
        put_stream(&mut text, stream);
    }
    let Some(gpu) = &object.gpu else { return text };
    let adapter = gpu.adapter.replace(char::is_control, "");
    let _ = writeln!(text, "\n  on {adapter}, by the clock of the {}", gpu.clock);
    if let Some(limit) = &gpu.limit {
        let _ = writeln!(text, "  ({limit})");
    }
    for (name, why) in &gpu.left_out {
        let _ = writeln!(text, "  {name} left out: {why}");
    }
    table(&mut text, "draws of primitives, ms", &gpu.primitives, DRAWS);
    for (model, words) in &gpu.words_per_vertex {
        table(&mut text, &format!("{model}, words per vertex"), words, MEMORY);
    }
    for (model, cases) in &gpu.models {
        table(&mut text, &format!("{model}, per update"), cases, GPU);
    }
    text
}

/// Appends the figures of a stream.
fn put_stream(text: &mut String, stream: &StreamReport) {
    let StreamReport {
        lossless,
        lossless_exact,
        quantized,
        packages,
        packages_normals,
        progressive_mesh,
        progressive_mesh_normals,
        ..
    } = stream;
    let _ = writeln!(
        text,
        "\n  stream, bits per vertex: {lossless:.1}, exact {lossless_exact:.1}, \
         in 16 bits {quantized:.1}; as packages {packages:.0}, \
         with normals {packages_normals:.0}; as Progressive Meshes {progressive_mesh:.0}, \
         with normals {progressive_mesh_normals:.0}"
    );
    if let Some(speed) = stream.speed {
        let (encode, decode) =
            (speed.encode_million_triangles_per_second, speed.decode_million_triangles_per_second);
        let _ = writeln!(
            text,
            "  encoded {encode:.2}, decoded {decode:.2} \
             million triangles per second\n  encoded in {} ms, decoded in {} ms (mean ± deviation)",
            mean_and_deviation(&speed.encode_spread),
            mean_and_deviation(&speed.decode_spread)
        );
    }
    let row = |p: &PrefixReport| (format!("{} %", p.percent), *p);
    table(text, "of the stream's bytes", &stream.prefixes.iter().map(row).collect(), PREFIXES);
}

/// Mean and deviation of timings as text.
fn mean_and_deviation(spread: &Spread) -> String {
    let deviation = spread.deviation.map(|d| format!(" ± {d:.1}"));
    format!("{:.1}{}", spread.mean, deviation.unwrap_or_default())
}

/// Appends a table. Rows that have none of the columns' numbers are left out, and so is a table
/// without rows.
fn table<N: Display>(
    text: &mut String,
    title: &str,
    rows: &IndexMap<N, impl Serialize>,
    columns: &[Column],
) {
    let number = |row: &Value, pointer: &str| row.pointer(pointer).and_then(Value::as_f64);
    let rows = rows.iter().map(|(name, row)| (name, value(row)));
    let rows: Vec<_> = rows
        .filter(|(_, row)| columns.iter().any(|&(_, pointer, _)| number(row, pointer).is_some()))
        .collect();
    if rows.is_empty() {
        return;
    }
    let _ = write!(text, "\n  {title:<26}");
    for (heading, ..) in columns {
        let _ = write!(text, "{heading:>13}");
    }
    text.push('\n');
    for (name, row) in rows {
        let _ = write!(text, "    {name:<24}");
        for &(_, pointer, decimals) in columns {
            let cell = match number(&row, pointer) {
                None => "-".to_owned(),
                Some(n) if decimals == 0 => grouped(n.round() as u64),
                Some(n) => format!("{n:.decimals$}"),
            };
            let _ = write!(text, "{cell:>13}");
        }
        text.push('\n');
    }
}
