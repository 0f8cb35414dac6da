//! Reading OBJ files and their material libraries.
//!
//! One file is one object. Its submeshes are its materials, in order of first use; the faces
//! without a material are a submesh of their own.

mod chunk;
#[cfg(test)]
mod faces_tests;
mod libraries;
mod lines;
mod notes;
mod number;
mod parse;
mod parsed;
#[cfg(test)]
mod tests;

use crate::faces::FaceFile;
use crate::loose::Loose;
use crate::options::ImportOptions;
use crate::words::counted;
use crate::{Assets, FormatError, ObjDocument, Scene, Source, SourceFormat, faces};
use parsed::{Count, Parsed};
use xxhash_rust::xxh3::xxh3_128;

/// Reads an OBJ; `bytes` is the main file.
///
/// # Errors
/// See [`crate::import::import`].
pub(crate) fn import(
    bytes: Vec<u8>,
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let content_hash = xxh3_128(&bytes);
    let mut parsed = parse::parse(&bytes, assets.limits())?;
    parse::check_faces(&parsed)?;
    let painted = if parsed.faces.colors.is_empty() { polypaint(&bytes) } else { Vec::new() };
    let (mut offset, mut exact) = ([0.0; 3], Vec::new());
    if faces::may_be_far(&parsed.faces.positions, &parsed.faces.corner_v) {
        exact = chunk::exact_positions(&bytes, assets.limits())?;
        if let Some(local) = faces::local(&exact, &parsed.faces.corner_v) {
            (offset, parsed.faces.positions) = local;
        }
    }
    // The text is the largest thing in memory, and is not needed any more.
    drop(bytes);
    let libraries = std::mem::take(&mut parsed.libraries);
    let materials = if libraries.is_empty() && !parsed.faces.materials.is_empty() {
        libraries::Materials::beside(assets)?
    } else {
        libraries::Materials::read(&libraries, assets)?
    };

    let mut warnings = materials.warnings;
    let (colors, positions) = (painted.len(), parsed.faces.positions.len());
    if colors > 0 && colors != positions {
        let colors = counted(colors, "colour", "colours");
        warnings.push(format!("#MRGB lines have {colors} for {positions} positions: ignored"));
    } else if colors > 0 {
        parsed.faces.colors = painted;
        parsed.notes.uncolored = Count::default();
    }
    let loose = loose(&mut parsed, &exact).statements();
    drop(exact);
    let assembled = faces::assemble(&parsed.faces, content_hash as u64);
    notes::warn(&parsed, &assembled, &mut warnings);
    notes::warn_undefined(&assembled, &materials.list, &mut warnings);
    let name = parsed.faces.name(assets);
    drop(parsed);

    let source = Source { format: SourceFormat::Obj, content_hash };
    let document = ObjDocument { libraries, materials: materials.list, loose, offset };
    faces::scene(FaceFile { assembled, name, source, document, warnings }, assets, options)
}

/// The points and lines of a file; vertices that are not there are left out. `exact` is empty or
/// has the positions in double precision.
fn loose(parsed: &mut Parsed, exact: &[[f64; 3]]) -> Loose {
    let count = parsed.faces.positions.len() as i64;
    let there = |v: &i64| u32::try_from(*v).ok().filter(|_| *v < count);
    let points: Vec<u32> = parsed.points.iter().filter_map(there).collect();
    let elements = std::mem::take(&mut parsed.line_elements);
    let lines: Vec<Vec<u32>> =
        elements.iter().map(|line| line.iter().filter_map(there).collect()).collect();
    Loose::of_file(&parsed.faces.positions, exact, &parsed.faces.colors, &points, &lines)
}

/// The colours that ZBrush writes into comments: `#MRGB`, then eight hexadecimal digits for each
/// position, a mask and red, green, blue.
fn polypaint(bytes: &[u8]) -> Vec<[f32; 4]> {
    let lines = bytes.split(|&b| b == b'\n' || b == b'\r');
    let mut colors = Vec::new();
    for line in lines.filter_map(|line| line.strip_prefix(b"#MRGB")) {
        for digits in line.trim_ascii().as_chunks::<8>().0 {
            let value =
                std::str::from_utf8(digits).ok().and_then(|d| u32::from_str_radix(d, 16).ok());
            let Some(value) = value else { return Vec::new() };
            let [_, r, g, b] = value.to_be_bytes().map(|c| f32::from(c) / 255.0);
            colors.push([r, g, b, 1.0]);
        }
    }
    colors
}
