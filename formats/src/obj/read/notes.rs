//! Warnings about what was repaired, dropped or ignored in an OBJ.

use super::parsed::{Count, Parsed};
use crate::ObjMaterial;
use crate::faces::Assembled;
use std::collections::BTreeSet;

/// Adds a line for each kind of repair, and of what was dropped or ignored.
pub(super) fn warn(parsed: &Parsed, assembled: &Assembled, warnings: &mut Vec<String>) {
    let notes = &parsed.notes;
    let mut warn_lines = |count: Count, problem: &str| {
        if count.times > 0 {
            warnings.push(format!("{} {problem} (first on line {})", count.times, count.line));
        }
    };
    warn_lines(notes.small_faces, "faces with fewer than three corners were dropped");
    warn_lines(notes.lines, "line elements were left out");
    warn_lines(notes.points, "point elements were left out");
    warn_lines(notes.free_form, "free-form curves and surfaces were left out");
    warn_lines(
        notes.extra_values,
        "lines have more numbers than their meaning needs, the last ones were left out",
    );
    warn_lines(notes.weights, "positions have a weight, which was left out");
    let [_, texcoords, normals] = notes.dangling;
    warn_lines(texcoords, "corners name texture coordinates, of which the file has none");
    warn_lines(normals, "corners name normals, of which the file has none");
    if !parsed.faces.colors.is_empty() {
        warn_lines(
            notes.uncolored,
            "positions without a colour beside others that have one were made white",
        );
    }
    warn_lines(
        notes.unknown,
        &format!("lines are no OBJ statements and were left out, like `{}`", notes.unknown_first),
    );

    let mut warn_count = |count: u64, problem: &str| {
        if count > 0 {
            warnings.push(format!("{count} {problem}"));
        }
    };
    warn_count(assembled.polygons, "polygons were triangulated");
    warn_count(
        assembled.imperfect_polygons,
        "of these cross themselves or turn back: their triangles may overlap",
    );
    warn_count(
        assembled.filled_texcoords,
        "corners without texture coordinates beside others that have them were given (0, 0)",
    );
    warn_count(
        assembled.filled_normals,
        "faces without normals beside others that have them were given their own",
    );
    warn_count(
        assembled.joined_labels,
        "groups share a material with others: they are kept as one submesh with all their names",
    );
}

/// Says which materials no library has.
pub(super) fn warn_undefined(
    assembled: &Assembled,
    list: &[ObjMaterial],
    warnings: &mut Vec<String>,
) {
    let defined: BTreeSet<&str> = list.iter().map(|m| m.name.as_str()).collect();
    let mut missing = assembled
        .submeshes
        .iter()
        .filter_map(|s| s.material.as_deref())
        .filter(|m| !defined.contains(m));
    if let Some(first) = missing.next() {
        let count = 1 + missing.count();
        warnings.push(format!(
            "{count} materials are used but not defined (first `{}`)",
            first.escape_debug()
        ));
    }
}
