//! Reads STL, ASCII and binary: separate triangles, whose corners are joined where they are equal.
//!
//! `stl_io` reads facets. Their normals follow from their corners and are left out.

use super::{FACET_BYTES, TEXT_BYTES};
use crate::faces::{self, FaceFile, Faces, NONE, Run, first_equal};
use crate::options::ImportOptions;
use crate::{Assets, Fault, FormatError, Limits, ObjDocument, Scene, Source, SourceFormat};
use std::collections::BTreeMap;
use std::io::{Cursor, ErrorKind};
use xxhash_rust::xxh3::xxh3_128;

/// Bytes before the first facet of a binary file, the number of facets included.
const HEADER_BYTES: usize = TEXT_BYTES + 4;

/// Returns whether `bytes` are as long as the number of facets in a binary file's header demands.
/// The rest of its header may be any text, even `solid`.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    facets(bytes)
        .is_some_and(|count| count > 0 && bytes.len() == HEADER_BYTES + FACET_BYTES * count)
}

/// The number of facets that a binary file announces.
fn facets(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(TEXT_BYTES..HEADER_BYTES)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*count) as usize)
}

/// The number of facets of a file: those that a binary one announces, as far as it has room for
/// them, or those that a text begins.
pub(crate) fn counted(bytes: &[u8]) -> u64 {
    if is_binary(bytes) {
        return facets(bytes).unwrap_or(0) as u64;
    }
    let is_facet = |line: &&[u8]| line.trim_ascii_start().starts_with(b"facet");
    let lines = bytes.split(|&b| b == b'\n').filter(is_facet).count();
    lines.max(facets(bytes).unwrap_or(0).min(bytes.len() / FACET_BYTES)) as u64
}

/// Reads an STL; `bytes` is the main file.
///
/// # Errors
/// See [`crate::import::import`].
pub(crate) fn import(
    mut bytes: Vec<u8>,
    assets: &Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let content_hash = xxh3_128(&bytes);
    let mut loose = Faces::default();
    let mut colors = None;
    let first = bytes.trim_ascii_start();
    let is_text = first.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if is_binary(&bytes) || !is_text {
        colors = FacetColors::of(&bytes);
        binary(&mut bytes, &mut loose, assets.limits())?;
    } else {
        text(&bytes, &mut loose, assets.limits())?;
    }
    drop(bytes);
    let corners = loose.positions.len();
    let mut faces = joined(loose, content_hash as u64);
    let mut warnings = Vec::new();
    if corners > faces.positions.len() {
        warnings.push(format!(
            "{corners} corners of loose triangles were joined to {} vertices where they are equal",
            faces.positions.len()
        ));
    }
    if let Some(FacetColors { numbers, palette }) = colors {
        faces.color_by_face(&numbers, &palette, content_hash as u64);
    }
    let assembled = faces::assemble(&faces, content_hash as u64);
    let source = Source { format: SourceFormat::Stl, content_hash };
    let name = faces.name(assets);
    drop(faces);
    let document = ObjDocument::default();
    faces::scene(FaceFile { assembled, name, source, document, warnings }, assets, options)
}

/// Colours of the facets of a binary file.
struct FacetColors {
    /// For each facet a number in the palette.
    numbers: Vec<u32>,
    palette: Vec<[f32; 4]>,
}

impl FacetColors {
    /// Reads the two bytes after each facet, as Magics or else VisCAM writes them: five bits for a
    /// channel. Magics says so in the header, with the colour of facets without their own; there
    /// red comes first, and the last bit says that there is none. VisCAM has blue first, and the
    /// last bit says that there is a colour. None if no facet has one.
    fn of(bytes: &[u8]) -> Option<Self> {
        let facets = bytes.get(HEADER_BYTES..)?.chunks_exact(FACET_BYTES);
        let attributes =
            facets.map(|f| u16::from_le_bytes([f[FACET_BYTES - 2], f[FACET_BYTES - 1]]));
        let header = &bytes[..TEXT_BYTES];
        let magics = header.windows(6).position(|w| w == b"COLOR=");
        let default = magics.and_then(|at| header.get(at + 6..at + 10));
        let has_own = |a: u16| (a & 0x8000 == 0) == default.is_some();
        // A file that fills the bytes with ones or text means no colours.
        let is_plain = |a: u16| a == 0 || a == u16::MAX;
        if default.is_none() && !attributes.clone().any(|a| has_own(a) && !is_plain(a)) {
            return None;
        }
        let of_file =
            default.map_or([1.0; 4], |rgba| std::array::from_fn(|i| f32::from(rgba[i]) / 255.0));
        let mut palette = vec![[of_file[0], of_file[1], of_file[2], 1.0]];
        let mut known = BTreeMap::new();
        let numbers = attributes.map(|a| match has_own(a) {
            false => 0,
            true => *known.entry(a & 0x7fff).or_insert_with(|| {
                let [mut r, g, mut b] = [0, 5, 10].map(|shift| f32::from(a >> shift & 31) / 31.0);
                if default.is_none() {
                    std::mem::swap(&mut r, &mut b);
                }
                palette.push([r, g, b, 1.0]);
                palette.len() as u32 - 1
            }),
        });
        let numbers = numbers.collect();
        Some(Self { numbers, palette })
    }
}

/// Reads the facets of a binary file.
fn binary(bytes: &mut [u8], faces: &mut Faces, limits: &Limits) -> Result<(), FormatError> {
    let count = facets(bytes).ok_or_else(|| malformed("", "the file ends within its header"))?;
    let capacity = (bytes.len() - HEADER_BYTES) / FACET_BYTES;
    if capacity < count {
        let problem =
            format!("{count} facets do not fit into the file, which has room for {capacity}");
        return Err(malformed("header", &problem));
    }
    faces.runs.push(Run { first_face: 0, material: NONE, label: NONE });
    // `stl_io` takes a file that begins like a text for one.
    bytes[..TEXT_BYTES].fill(0);
    read(bytes, faces, limits, "")
}

/// Reads the solids of a text, each as a part.
fn text(bytes: &[u8], faces: &mut Faces, limits: &Limits) -> Result<(), FormatError> {
    let text = String::from_utf8_lossy(bytes);
    let mut solid: Option<(String, Vec<u8>)> = None;
    for line in text.lines().map(str::trim) {
        let lower = line.to_ascii_lowercase();
        let word = lower.split_ascii_whitespace().next().unwrap_or_default();
        if word == "solid" {
            part(solid.take(), faces, limits)?;
            // The name may be missing, but `stl_io` demands the space in front of it.
            solid = Some((line[word.len()..].trim().to_owned(), b"solid \n".to_vec()));
            continue;
        }
        let Some((_, plain)) = &mut solid else {
            continue;
        };
        // The normals of facets without an area are often no numbers.
        plain.extend_from_slice(match word {
            "facet" => b"facet normal 0 0 0",
            _ => lower.as_bytes(),
        });
        plain.push(b'\n');
    }
    part(solid, faces, limits)
}

/// Reads one solid: its name, and its text in lower case.
fn part(
    solid: Option<(String, Vec<u8>)>,
    faces: &mut Faces,
    limits: &Limits,
) -> Result<(), FormatError> {
    let Some((name, text)) = solid else { return Ok(()) };
    let number = faces.labels.len() as u32;
    faces.runs.push(Run {
        first_face: faces.face_ends.len() as u32,
        material: NONE,
        label: number,
    });
    faces.labels.push(name.clone());
    if !name.is_empty() {
        faces.objects.push(name.clone());
    }
    read(&text, faces, limits, &name)
}

fn read(bytes: &[u8], faces: &mut Faces, limits: &Limits, solid: &str) -> Result<(), FormatError> {
    let mut facet = 0u64;
    let location = |facet: u64| match solid {
        "" => format!("facet {facet}"),
        _ => format!("solid \"{solid}\", facet {facet}"),
    };
    let mut cursor = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut cursor);
    for triangle in reader.map_err(|e| malformed("header", &e.to_string()))? {
        facet += 1;
        let triangle = triangle.map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => malformed(&location(facet), "the file is truncated"),
            _ => malformed(&location(facet), &e.to_string()),
        })?;
        if faces.face_ends.len() as u64 >= limits.triangles.min(u64::from(NONE) / 3 - 1) {
            let problem = format!("more than {} triangles", limits.triangles);
            return Err(FormatError::new(Fault::Limit, location(facet), problem));
        }
        for [x, y, z] in triangle.vertices.map(|v| v.0) {
            if ![x, y, z].iter().all(|c| c.is_finite()) {
                let problem = format!("the position ({x}, {y}, {z}) is not finite");
                return Err(malformed(&location(facet), &problem));
            }
            // Zero has one sign, so that equal positions have equal bits.
            faces.positions.push([x + 0.0, y + 0.0, z + 0.0]);
        }
        faces.face_ends.push(faces.positions.len() as u32);
    }
    Ok(())
}

/// The same faces with one position for all that are equal.
fn joined(loose: Faces, seed: u64) -> Faces {
    let first =
        first_equal(loose.positions.len(), seed, |i| loose.positions[i as usize].map(f32::to_bits));
    let mut positions = Vec::new();
    let mut number = vec![NONE; first.len()];
    let mut corner_v = Vec::with_capacity(first.len());
    for (corner, &first) in first.iter().enumerate() {
        if first as usize == corner {
            number[corner] = positions.len() as u32;
            positions.push(loose.positions[corner]);
        }
        corner_v.push(number[first as usize]);
    }
    Faces { positions, corner_v, ..loose }
}

fn malformed(location: &str, problem: &str) -> FormatError {
    FormatError::new(Fault::Malformed, location, problem)
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
