//! Writes the HTML of the report page, part by part.

use super::PageContent;
use super::levels::PageLevel;
use crate::chart::{Chart, Curve, Scale};
use crate::html::{base64, escaped};
use crate::text::{count, distance, grouped, size};
use crate::{CheckReport, ErrorsOver};
use lodc_model::{Layout, Model};
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// Height in pixels of the screen for which distances are stated.
const HEIGHT: f64 = 1080.0;
/// Vertical field of view in degrees of that screen.
const FOVY: f64 = 60.0;

/// The page, one file that needs no other: its parts in their order.
#[must_use]
pub fn page(content: &PageContent<'_>) -> String {
    let title = escaped(&content.title);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"generator\" content=\"lodc {}\">\n\
         <title>{title} – report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n",
        env!("CARGO_PKG_VERSION")
    );
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<header>\n<h1>{title}</h1>\n<p>{}</p>\n{}</header>",
        summary(content),
        verdict(content)
    );
    out.push_str("<h2>Levels</h2>\n");
    content.levels.iter().for_each(|level| put_level(&mut out, level, content));
    put_charts(&mut out, content);
    put_storage(&mut out, content);
    put_warnings(&mut out, &content.warnings);
    put_checks(&mut out, &content.checks);
    out.push_str("</body>\n</html>\n");
    out
}

fn summary(content: &PageContent<'_>) -> String {
    let objects = content.objects;
    let vertices: u64 = objects.iter().map(|o| o.simplified.mesh().vertex_count() as u64).sum();
    let steps: u64 = objects.iter().map(|o| o.simplified.collapses().steps() as u64).sum();
    let mut parts = vec![
        count(content.levels[0].triangles, "triangle"),
        count(vertices, "vertex"),
        count(objects.len() as u64, "object"),
        count(steps + objects.len() as u64, "level"),
        format!("diagonal {}", distance(content.diagonal)),
    ];
    let over = ErrorsOver::of(objects.iter().map(|o| &o.info));
    parts.extend((over != ErrorsOver::REST).then(|| over.to_string()));
    parts.extend(content.bytes.map(size));
    parts.join(" · ")
}

/// One line that says whether anything is wrong.
fn verdict(content: &PageContent<'_>) -> String {
    let failed = content.checks.iter().filter(|c| c.ok == Some(false)).count();
    let passed = content.checks.iter().filter(|c| c.ok == Some(true)).count();
    let warnings = match content.warnings.len() {
        0 => "no warning".to_owned(),
        n => count(n as u64, "warning"),
    };
    let (class, checks) = if failed == 0 {
        ("good", format!("✓ {} passed", count(passed as u64, "check")))
    } else {
        ("bad", format!("✗ {} failed", count(failed as u64, "check")))
    };
    format!("<p class=\"verdict {class}\"><b>{checks}</b> · {warnings}</p>\n")
}

fn put_level(out: &mut String, level: &PageLevel, content: &PageContent<'_>) {
    let is_input = level.distance_pictures.is_empty();
    let name = if is_input { "Input".to_owned() } else { share(level.share) };
    let _ = writeln!(out, "<section class=\"level\">\n<div class=\"numbers\">\n<h3>{name}</h3>");
    let _ = writeln!(out, "<p>{}</p>", count(level.triangles, "triangle"));
    if !is_input {
        let percent = 100.0 * level.error / content.diagonal;
        let rows = [
            ("Error", format!("{} ({percent:.3} %)", distance(level.error))),
            ("Root mean square", level.rms.map_or_else(|| "–".to_owned(), distance)),
            ("Pictures differ by", format!("{:.1} of 255", level.image.rmse)),
            ("Outlines differ by", format!("{:.2} %", 100.0 * level.image.silhouette)),
            ("Below one pixel beyond", distance(one_pixel_distance(level.error))),
        ];
        out.push_str("<dl>\n");
        for (name, value) in rows {
            let _ = writeln!(out, "<dt>{name}</dt><dd>{value}</dd>");
        }
        out.push_str("</dl>\n");
        for gone in &level.gone {
            let _ = writeln!(out, "<p class=\"bad\"><b>{}</b></p>", escaped(&gone.to_string()));
        }
    }
    out.push_str("</div>\n<div class=\"pictures\">\n");
    for (side, png) in (1..).zip(&level.pictures) {
        put_picture(out, png, &format!("{name} from side {side}"));
    }
    if !is_input {
        let (losses, distances) = (&level.loss_pictures, &level.distance_pictures);
        for (pictures, a, b, what) in [
            (losses, "the input", &*name, "The input by its distance from the level"),
            (distances, &*name, "the input", "The level by its distance from the input"),
        ] {
            for (side, png) in (1..).zip(pictures) {
                put_picture(out, png, &format!("distance of {a} from {b}, side {side}"));
            }
            let _ = writeln!(
                out,
                "<p class=\"scale\">{what}: <span>0</span><i></i><span>{}</span></p>",
                distance(level.error)
            );
        }
    }
    out.push_str("</div>\n</section>\n");
}

fn put_picture(out: &mut String, png: &[u8], alt: &str) {
    let data = base64(png);
    let _ = writeln!(out, "<img alt=\"{alt}\" src=\"data:image/png;base64,{data}\">");
}

/// The distance from the eye at which an error is one pixel high.
fn one_pixel_distance(error: f64) -> f64 {
    error * HEIGHT / (2.0 * (FOVY / 2.0).to_radians().tan())
}

fn share(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 9.95 { format!("{percent:.0} %") } else { format!("{percent:.1} %") }
}

fn put_charts(out: &mut String, content: &PageContent<'_>) {
    let chart = |points: &[[f64; 2]], labels| {
        let (name, points) = (String::new(), points.to_vec());
        let curves = vec![Curve { name, colour: 0, dashed: false, points }];
        Chart { labels, scales: [Scale::Log; 2], curves }.svg()
    };
    let by_error: Vec<[f64; 2]> = content.curve.iter().map(|&[t, e]| [e, t]).collect();
    let by_distance: Vec<[f64; 2]> =
        by_error.iter().map(|&[e, t]| [one_pixel_distance(e), t]).collect();
    let charts = [
        ("Triangles against error", chart(&by_error, ["error", "triangles"]), String::new()),
        (
            "Triangles against distance",
            chart(&by_distance, ["distance", "triangles"]),
            format!(" Coarsest level within one pixel: {HEIGHT} pixels high, {FOVY}° of view."),
        ),
    ];
    if charts.iter().all(|(_, svg, _)| svg.is_empty()) {
        return;
    }
    out.push_str("<h2>Triangles</h2>\n<div class=\"charts\">\n");
    for (name, svg, note) in charts {
        let _ = writeln!(out, "<figure>\n{svg}<figcaption>{name}.{note}</figcaption>\n</figure>");
    }
    out.push_str("</div>\n");
}

fn put_storage(out: &mut String, content: &PageContent<'_>) {
    let objects = content.objects;
    let mut models: Vec<(&str, u64)> = Vec::new();
    for model in objects.iter().flat_map(|o| &o.models) {
        let bytes: u64 = model.arrays(Layout::Packed).iter().map(|a| a.bytes.len() as u64).sum();
        match models.iter_mut().find(|(name, _)| *name == model.name()) {
            Some((_, sum)) => *sum += bytes,
            None => models.push((model.name(), bytes)),
        }
    }
    let vertices: usize = objects.iter().map(|o| o.simplified.mesh().vertex_count()).sum();
    out.push_str("<h2>Storage</h2>\n");
    if models.is_empty() {
        out.push_str(
            "<p>No models are stored: the collapse sequence alone shows every level.</p>\n",
        );
        return;
    }
    out.push_str("<table>\n<tr><th>Model</th><th>Bytes</th><th>Bits per vertex</th></tr>\n");
    for (name, bytes) in models {
        let bits = 8.0 * bytes as f64 / vertices.max(1) as f64;
        let bytes = grouped(bytes);
        let _ = writeln!(out, "<tr><td>{name}</td><td>{bytes}</td><td>{bits:.1}</td></tr>");
    }
    out.push_str("</table>\n<p>Beside positions, attributes, triangles and the sequence.</p>\n");
}

fn put_warnings(out: &mut String, warnings: &[String]) {
    out.push_str("<h2>Warnings</h2>\n");
    if warnings.is_empty() {
        out.push_str("<p>None.</p>\n");
        return;
    }
    out.push_str("<ul>\n");
    for warning in warnings {
        let _ = writeln!(out, "<li>{}</li>", escaped(warning));
    }
    out.push_str("</ul>\n");
}

/// One row for each kind of check, over all objects.
fn put_checks(out: &mut String, checks: &[CheckReport]) {
    let mut rows: Vec<Vec<&CheckReport>> = Vec::new();
    for check in checks {
        let is_kind = |row: &&mut Vec<&CheckReport>| {
            (row[0].model, row[0].check) == (check.model, check.check)
        };
        match rows.iter_mut().find(is_kind) {
            Some(row) => row.push(check),
            None => rows.push(vec![check]),
        }
    }
    out.push_str("<h2>Checks</h2>\n<table>\n");
    out.push_str("<tr><th>Of</th><th>Check</th><th>Levels</th><th>Result</th></tr>\n");
    for row in rows {
        let (model, name) = (row[0].model, row[0].check);
        let failed = row.iter().find(|c| c.ok == Some(false));
        let skipped = row.iter().find_map(|c| c.skipped.as_deref());
        let result = match (failed, skipped) {
            (Some(check), _) => {
                let what = check.first_difference.as_deref().unwrap_or_default();
                format!("<b class=\"bad\">different</b> {}", escaped(what))
            }
            (None, Some(why)) => format!("skipped: {}", escaped(why)),
            _ => "<b class=\"good\">✓</b>".to_owned(),
        };
        let lods = grouped(row.iter().map(|c| c.lods).sum());
        let _ = writeln!(
            out,
            "<tr><td>{model}</td><td>{name}</td><td>{lods}</td><td>{result}</td></tr>"
        );
    }
    out.push_str("</table>\n");
}
