//! Curves over LODs as SVG: indices drawn (thesis fig. 4.9), extraction time (figs. 3.9, 4.10), and
//! draws on a device.

use crate::report::{BenchObject, value};
use lodc_report::{Chart, Curve, Scale, colour_of};
use serde_json::Value;

/// Charts of an object as SVG, with the names of their kinds; empty ones where nothing was
/// measured.
#[must_use]
pub fn charts(object: &BenchObject) -> [(&'static str, String); 3] {
    let records = f64::from(object.records.max(1));
    let share = |lod: u32| 100.0 * f64::from(lod) / records;
    let curves_of_models = |path: &str| -> Vec<(String, Vec<f64>)> {
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
        ("indices", chart("indices drawn", linear, &curve, curves_of_models("/drawn/curve"))),
        (
            "extraction",
            chart("update, µs", Scale::Log, &curve, curves_of_models("/extraction/curve_us")),
        ),
        ("draw", chart("draw, ms", linear, &on_device, draws)),
    ]
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
