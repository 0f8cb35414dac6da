//! Curves over LODs as SVG: indices drawn (thesis fig. 4.9), extraction time (figs. 3.9, 4.10), and
//! draws on a device.

use super::report::{BenchFile, BenchObject, value};
use crate::chart::{Chart, Curve, Scale};
use serde_json::Value;
use std::path::Path;

/// Names of files and what is in them, of all objects of all inputs. Objects after the first of a
/// name have a number.
pub(super) fn plots(files: &[BenchFile]) -> Vec<(String, String)> {
    let mut plots: Vec<(String, String)> = Vec::new();
    for file in files {
        let stem = Path::new(&file.file).file_stem().unwrap_or_default().to_string_lossy();
        for object in &file.objects {
            let taken = |name: &str| plots.iter().any(|(other, _)| other.starts_with(name));
            let numbered = (2..).map(|i| format!("{stem}-{i}"));
            let mut names = std::iter::once(stem.to_string()).chain(numbered);
            let name = names.find(|name| !taken(&format!("{name}-indices"))).expect("some number");
            let of = |(kind, svg): (&str, String)| (format!("{name}-{kind}.svg"), svg);
            plots.extend(charts(object).into_iter().filter(|(_, svg)| !svg.is_empty()).map(of));
        }
    }
    plots
}

/// The charts of an object; empty ones where nothing was measured.
fn charts(object: &BenchObject) -> [(&'static str, String); 3] {
    let records = object.counts.records.max(1);
    let share = |lod: u32| 100.0 * f64::from(lod) / records as f64;
    let of_models = |path: &str| -> Vec<(String, Vec<f64>)> {
        let list = |row: &Value| -> Option<Vec<f64>> {
            row.pointer(path)?.as_array()?.iter().map(Value::as_f64).collect()
        };
        let models = object.models.iter();
        models.filter_map(|(name, row)| Some(((*name).to_owned(), list(&value(row))?))).collect()
    };
    let curve: Vec<f64> = object.curve.lods.iter().map(|&lod| share(lod)).collect();
    let device = object.gpu.as_ref().map(|gpu| &gpu.curve);
    let on_device: Vec<f64> =
        device.into_iter().flat_map(|c| &c.lods).map(|&lod| share(lod)).collect();
    let draws = device.into_iter().flat_map(|c| &c.structures);
    let draws = draws.map(|(name, drawn)| (name.clone(), drawn.draw_ms.clone())).collect();
    let linear = Scale::Linear;
    [
        ("indices", chart("indices drawn", linear, &curve, of_models("/drawn/curve"))),
        ("extraction", chart("update, µs", Scale::Log, &curve, of_models("/extraction/curve_us"))),
        ("draw", chart("draw, ms", linear, &on_device, draws)),
    ]
}

/// Structures in the order of their colours.
const COLOURED: [&str; 6] =
    ["speed", "masking", "interactive", "progressive_mesh", "lodstrips", "discrete"];

/// The number of a structure's colour, the same in all charts.
pub(super) fn colour_of(structure: &str) -> usize {
    COLOURED.iter().position(|&name| name == structure).unwrap_or(COLOURED.len())
}

/// A chart over the share of the LODs.
fn chart(label: &str, scale: Scale, lods: &[f64], all: Vec<(String, Vec<f64>)>) -> String {
    let curve = |(name, values): (String, Vec<f64>)| {
        let points = lods.iter().zip(values).map(|(&x, y)| [x, y]).collect();
        Curve { colour: colour_of(&name), name, dashed: false, points }
    };
    let curves = all.into_iter().map(curve).collect();
    Chart { labels: ["LOD, % of the last", label], scales: [Scale::Linear, scale], curves }.file()
}
