//! Warnings about what was repaired, dropped or ignored in an OBJ.

use super::parsed::{Count, Parsed};
use crate::ObjMaterial;
use crate::faces::{self, Assembled};
use crate::words::counted;
use std::collections::BTreeSet;

/// Adds a line for each kind of repair, and of what was dropped or ignored.
pub(super) fn warn(parsed: &Parsed, assembled: &Assembled, warnings: &mut Vec<String>) {
    let notes = &parsed.notes;
    let mut warn_lines = |count: Count, one: &str, several: &str| {
        if count.times > 0 {
            let what = counted(count.times, one, several);
            warnings.push(format!("{what} ({} {})", place(count), count.line));
        }
    };
    warn_lines(
        notes.small_faces,
        "face with fewer than three corners was dropped",
        "faces with fewer than three corners were dropped",
    );
    warn_lines(
        notes.lines,
        "line element passes through unchanged",
        "line elements pass through unchanged",
    );
    warn_lines(
        notes.points,
        "point element passes through unchanged",
        "point elements pass through unchanged",
    );
    warn_lines(
        notes.free_form,
        "free-form curve or surface was left out",
        "free-form curves and surfaces were left out",
    );
    warn_lines(
        notes.extra_values,
        "line has more numbers than its statement takes: the last ones were ignored",
        "lines have more numbers than their statements take: the last ones were ignored",
    );
    warn_lines(
        notes.weights,
        "position has a weight, which was ignored",
        "positions have a weight, which was ignored",
    );
    let [_, texcoords, normals] = notes.dangling;
    warn_lines(
        texcoords,
        "corner uses texture coordinates, but the file has none",
        "corners use texture coordinates, but the file has none",
    );
    warn_lines(
        normals,
        "corner uses a normal, but the file has none",
        "corners use normals, but the file has none",
    );
    warn_lines(
        notes.zeros,
        "index 0 of texture coordinates or a normal is taken for none",
        "indices 0 of texture coordinates or normals are taken for none",
    );
    if !parsed.faces.colors.is_empty() {
        warn_lines(
            notes.uncolored,
            "position without a colour beside others that have one was made white",
            "positions without a colour beside others that have one were made white",
        );
    }
    if notes.unknown.times > 0 {
        let (first, line) = (&notes.unknown_first, notes.unknown.line);
        let place = place(notes.unknown);
        let lines = counted(
            notes.unknown.times,
            "line that is not an OBJ statement",
            "lines that are not OBJ statements",
        );
        warnings.push(format!("skipped {lines} ({place} {line}: `{first}`)"));
    }
    faces::warn(assembled, warnings);
    let mut warn_count = |count: u64, one: &str, several: &str| {
        if count > 0 {
            warnings.push(counted(count, one, several));
        }
    };
    warn_count(
        assembled.filled_normals,
        "face without normals beside others that have them was given its own",
        "faces without normals beside others that have them were given their own",
    );
    warn_count(
        assembled.joined_labels,
        "group shares a material with others: they are kept as one submesh with all their names",
        "groups share a material with others: they are kept as one submesh with all their names",
    );
}

/// What stands before the number of the first line of some.
const fn place(count: Count) -> &'static str {
    if count.times == 1 { "line" } else { "first on line" }
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
        let materials = counted(count, "material is", "materials are");
        let first_of = if count == 1 { "" } else { "first " };
        let name = first.escape_debug();
        warnings.push(format!("{materials} used but not defined: {first_of}`{name}`"));
    }
}
