//! Curves of a crowd as SVG: triangles over distance (thesis fig. 4.11), triangles and extraction
//! time over the seconds (4.13, 4.14).

use super::report::CrowdReport;
use lodc_report::{Chart, Curve, Scale, colour_of};

/// Charts of a crowd as SVG, with names for their files; no times if none were taken.
#[must_use]
pub fn crowd_charts(report: &CrowdReport) -> Vec<(&'static str, String)> {
    let curve = &report.curve;
    let points = |values: &[f64]| -> Vec<[f64; 2]> {
        curve.seconds.iter().zip(values).map(|(&x, &y)| [x, y]).collect()
    };
    let far = &report.by_distance;
    let over_distance =
        [("no levels", &far.none), ("five levels", &far.discrete), ("continuous", &far.continuous)];
    let over_distance = over_distance.into_iter().enumerate().map(|(colour, (name, values))| {
        let points = far.distance.iter().zip(values).map(|(&x, &y)| [x, y]).collect();
        Curve { name: name.to_owned(), colour, dashed: false, points }
    });
    let over_distance = Chart {
        labels: ["distance", "triangles of a figure"],
        scales: [Scale::Linear; 2],
        curves: over_distance.collect(),
    };
    let policies = [
        ("no levels", &curve.none),
        ("five levels", &curve.discrete),
        ("continuous", &curve.continuous),
    ];
    let triangles = policies.iter().enumerate().map(|(colour, (name, values))| Curve {
        name: (*name).to_owned(),
        colour,
        dashed: false,
        points: points(values),
    });
    let triangles = Chart {
        labels: ["seconds", "triangles per frame"],
        scales: [Scale::Linear; 2],
        curves: triangles.collect(),
    };
    let times = |five: bool| {
        let curves = report.models.iter().filter_map(|(&name, policies)| {
            let frames = if five { &policies.discrete } else { &policies.continuous };
            let points = points(frames.extraction_ms_curve.as_ref()?);
            let (colour, name) = (colour_of(name), name.to_owned());
            Some(Curve { name, colour, dashed: five, points })
        });
        let labels = ["seconds", "extraction per frame, ms"];
        Chart { labels, scales: [Scale::Linear, Scale::Log], curves: curves.collect() }.file()
    };
    let files = [
        ("crowd-distance.svg", over_distance.file()),
        ("crowd-triangles.svg", triangles.file()),
        ("crowd-extraction.svg", times(false)),
        ("crowd-extraction-five-levels.svg", times(true)),
    ];
    files.into_iter().filter(|(_, svg)| !svg.is_empty()).collect()
}
