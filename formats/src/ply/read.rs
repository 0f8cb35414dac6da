//! Reads Stanford PLY, ASCII and binary.
//!
//! `serde-ply` reads headers and values. Which property means what is decided here; properties that
//! a mesh has no use for are ignored, with a warning.

mod columns;

use crate::faces::{self, FaceFile, Faces, NONE, Run};
use crate::loose::Loose;
use crate::options::ImportOptions;
use crate::words::counted;
use crate::{
    Assets, Fault, FormatError, Limits, ObjDocument, ObjMaterial, Scene, Source, SourceFormat,
};
use columns::{Count, FaceColumn, Rows, VertexColumn};
use serde::de::{DeserializeSeed, MapAccess};
use serde_ply::{
    DeserializeError, ElementDef, PlyFormat, PlyHeader, PlyReader, PropertyType, ScalarType,
};
use std::collections::BTreeMap;
use std::io::{BufRead, ErrorKind, Read};
use xxhash_rust::xxh3::xxh3_128;

/// Location of errors before the first element.
const HEADER: &str = "header";

/// Reads a PLY; `bytes` is the main file.
///
/// # Errors
/// See [`crate::import::import`].
pub(crate) fn import(
    bytes: &[u8],
    assets: &Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let content_hash = xxh3_128(bytes);
    // Values of ASCII end at white space, which the last one may lack.
    let mut reader =
        PlyReader::from_reader(bytes.chain(&b"\n"[..])).map_err(|e| header_error(&e))?;
    let header = reader.header().clone();
    check(&header, bytes.len(), assets.limits())?;
    check_faces(&header)?;
    let mut content = Content::default();
    for element in &header.elem_defs {
        content.read(element, &mut reader, assets.limits())?;
    }
    let mut exact = std::mem::take(&mut content.exact_positions);
    if exact.is_empty()
        && header.format == PlyFormat::Ascii
        && faces::may_be_far(&content.faces.positions, &content.faces.corner_v)
    {
        exact = exact_positions(bytes, assets.limits())?;
    }
    let loose = content.loose(&exact);
    let materials = textures(&header);
    let mut warnings = content.warnings;
    let mut faces = content.faces;
    let mut offset = [0.0; 3];
    if let Some(local) = faces::local(&exact, &faces.corner_v) {
        (offset, faces.positions) = local;
    }
    finish(&mut faces, &content.texture_numbers, &materials, &mut warnings)?;
    if !content.face_colors.is_empty() {
        faces.color_has_alpha = content.face_colors.iter().any(|color| color[3] != 1.0);
        let mut known: BTreeMap<[u32; 4], u32> = BTreeMap::new();
        let mut palette = Vec::new();
        let number = |color: &[f32; 4]| {
            *known.entry(color.map(f32::to_bits)).or_insert_with(|| {
                palette.push(*color);
                palette.len() as u32 - 1
            })
        };
        let numbers: Vec<u32> = content.face_colors.iter().map(number).collect();
        faces.color_by_face(&numbers, &palette, content_hash as u64);
    }

    let assembled = faces::assemble(&faces, content_hash as u64);
    if content.small_faces > 0 {
        let faces = counted(content.small_faces, "face was", "faces were");
        warnings.push(format!("{faces} dropped: fewer than three corners"));
    }
    faces::warn(&assembled, &mut warnings);
    let source = Source { format: SourceFormat::Ply, content_hash };
    let loose = loose.statements();
    let document = ObjDocument { libraries: Vec::new(), materials, loose, offset };
    let file = FaceFile { assembled, name: assets.stem(), source, document, warnings };
    faces::scene(file, assets, options)
}

/// More vertices that nothing uses are no points that someone placed. Chosen by hand.
const MAX_POINTS: usize = 1 << 20;

/// Everything between the header and the end.
#[derive(Debug, Default)]
struct Content {
    faces: Faces,
    /// Positions as they were read, of a file that has some in double precision.
    exact_positions: Vec<[f64; 3]>,
    /// For each face the number of its texture; empty if faces have none.
    texture_numbers: Vec<u32>,
    /// The ends of edges, which are no edges of faces but lines.
    lines: Vec<Vec<u32>>,
    /// For each face its colour; empty if faces have none.
    face_colors: Vec<[f32; 4]>,
    /// Faces with fewer than three corners, and those corners.
    small_faces: u64,
    small_corners: Vec<u32>,
    warnings: Vec<String>,
}

impl Content {
    fn read<R: BufRead>(
        &mut self,
        element: &ElementDef,
        reader: &mut PlyReader<R>,
        limits: &Limits,
    ) -> Result<(), FormatError> {
        let count = Count::default();
        let name = element.name.as_str();
        let mut unused = Vec::new();
        let read = match name {
            "vertex" => {
                let columns = VertexColumn::of(element, &mut unused);
                let exact = element.properties.iter().zip(&columns).any(|(property, column)| {
                    matches!(column, VertexColumn::Position(_))
                        && matches!(property.property_type, PropertyType::Scalar(ScalarType::F64))
                });
                let exact_positions = exact.then_some(&mut self.exact_positions);
                let sink = columns::vertices(&mut self.faces, exact_positions, &columns, &count);
                value(reader, Rows { element, count: &count, sink })
            }
            "face" | "tristrips" => {
                let strips = name == "tristrips";
                let colors = self.faces.colors.is_empty() && !strips;
                let columns = FaceColumn::of(element, colors, &mut unused);
                let max_corners = limits.triangles.saturating_mul(3).min(u64::from(NONE) - 1);
                let sink = columns::faces(self, &columns, strips, max_corners);
                value(reader, Rows { element, count: &count, sink })
            }
            "edge" if columns::ends(element).is_some() => {
                let ends = columns::ends(element).unwrap_or_default();
                let mut edge = [NONE; 2];
                let lines = &mut self.lines;
                let sink = |column: usize, values: &[f64]| {
                    for (end, &wanted) in edge.iter_mut().zip(&ends) {
                        if column == wanted {
                            *end = columns::index(values[0]).unwrap_or(NONE);
                        }
                    }
                    if column + 1 == element.properties.len() {
                        lines.push(edge.to_vec());
                    }
                    Ok(())
                };
                value(reader, Rows { element, count: &count, sink })
            }
            _ => {
                if element.count > 0 {
                    let named = |noun| format!("`{name}` {noun}");
                    let elements = counted(element.count, &named("element"), &named("elements"));
                    self.warnings.push(format!("ignored {elements}"));
                }
                value(reader, Rows { element, count: &count, sink: |_: usize, _: &[f64]| Ok(()) })
            }
        };
        if !unused.is_empty() && element.count > 0 {
            let was = [" was", " were"][usize::from(unused.len() > 1)];
            let properties = counted(unused.len(), "property", "properties");
            let names = unused.join("`, `");
            let text = format!("{properties} of each {name}{was} ignored: `{names}`");
            self.warnings.push(text);
        }
        read.map_err(|e| {
            let location = format!("{name} {}", count.rows());
            let (fault, problem) = fault_and_problem(&e);
            FormatError::new(fault, location, problem)
        })
    }

    /// Edges as lines, and vertices that nothing uses as points. `exact` is empty or has the
    /// positions in double precision.
    fn loose(&mut self, exact: &[[f64; 3]]) -> Loose {
        let positions = &self.faces.positions;
        self.lines.retain(|ends| ends.iter().all(|&v| (v as usize) < positions.len()));
        let mut used = vec![false; positions.len()];
        let ends = self.lines.iter().flatten();
        for &v in self.faces.corner_v.iter().chain(&self.small_corners).chain(ends) {
            if let Some(used) = used.get_mut(v as usize) {
                *used = true;
            }
        }
        let mut points: Vec<u32> =
            (0..).zip(&used).filter_map(|(v, used)| (!used).then_some(v)).collect();
        if !self.lines.is_empty() {
            let edges = counted(self.lines.len(), "edge passes", "edges pass");
            self.warnings.push(format!("{edges} through unchanged, as lines"));
        }
        if points.len() > MAX_POINTS {
            let text = format!("{} vertices that no face uses were dropped", points.len());
            self.warnings.push(format!("{text}: more than {MAX_POINTS}"));
            points.clear();
        }
        if !points.is_empty() {
            let vertices = counted(points.len(), "vertex", "vertices");
            let pass = if points.len() == 1 { "passes" } else { "pass" };
            let text = format!("{vertices} that no face uses {pass} through unchanged, as points");
            self.warnings.push(text);
        }
        Loose::of_file(positions, exact, &self.faces.colors, &points, &self.lines)
    }
}

/// The positions of an ASCII file with all the digits that it has, where its header says that they
/// are in single precision.
fn exact_positions(bytes: &[u8], limits: &Limits) -> Result<Vec<[f64; 3]>, FormatError> {
    let mut header = Vec::new();
    let mut rest = bytes;
    for line in bytes.split_inclusive(|&b| b == b'\n') {
        rest = &rest[line.len()..];
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words[..] {
            ["property", "float" | "float32", axis @ ("x" | "y" | "z")] => {
                header.extend(format!("property double {axis}\n").bytes());
            }
            _ => header.extend(line),
        }
        if words == ["end_header"] {
            break;
        }
    }
    let mut reader = PlyReader::from_reader(header.as_slice().chain(rest).chain(&b"\n"[..]))
        .map_err(|e| header_error(&e))?;
    let mut content = Content::default();
    for element in &reader.header().clone().elem_defs {
        content.read(element, &mut reader, limits)?;
        if element.name == "vertex" {
            break;
        }
    }
    Ok(content.exact_positions)
}

/// Reads the next element.
fn value<R: BufRead>(
    mut reader: &mut PlyReader<R>,
    rows: impl DeserializeSeed<'static, Value = ()>,
) -> Result<(), DeserializeError> {
    MapAccess::next_value_seed(&mut reader, rows)
}

/// Checks counts against the size of the file and the limits, before memory is taken for them.
fn check(header: &PlyHeader, bytes: usize, limits: &Limits) -> Result<(), FormatError> {
    for (number, element) in header.elem_defs.iter().enumerate() {
        let name = &element.name;
        let this_and_later = &header.elem_defs[number..];
        if name == "face" && this_and_later.iter().any(|e| e.name == "vertex") {
            let problem = "element `face` comes before element `vertex`";
            return Err(FormatError::new(Fault::Unsupported, HEADER, problem));
        }
        if matches!(name.as_str(), "vertex" | "face" | "tristrips")
            && header.elem_defs[..number].iter().any(|e| e.name == *name)
        {
            let problem = format!("element `{name}` is declared twice");
            return Err(FormatError::new(Fault::Malformed, HEADER, problem));
        }
        let min_bytes: u64 = match header.format {
            // A digit and white space.
            PlyFormat::Ascii => 2 * element.properties.len() as u64,
            _ => element.properties.iter().map(|p| columns::min_bytes(&p.property_type)).sum(),
        };
        let count = element.count as u64;
        if count > 0 && min_bytes == 0 {
            let problem = format!("element `{name}` has no properties");
            return Err(FormatError::new(Fault::Malformed, HEADER, problem));
        }
        // One byte more is the line end that may be missing.
        if count.saturating_mul(min_bytes) > bytes as u64 + 1 {
            let problem = format!("{count} `{name}` elements do not fit into the file");
            return Err(FormatError::new(Fault::Malformed, HEADER, problem));
        }
        let limit = match name.as_str() {
            "vertex" => limits.vertices.min(u64::from(NONE) - 1),
            "face" => limits.triangles,
            _ => u64::MAX,
        };
        if count > limit {
            let problem = format!("{count} `{name}` elements: the limit is {limit}");
            return Err(FormatError::new(Fault::Limit, HEADER, problem));
        }
    }
    Ok(())
}

/// Refuses a file without faces, and says what it is instead.
fn check_faces(header: &PlyHeader) -> Result<(), FormatError> {
    let count = |name: &str| {
        header.elem_defs.iter().find(|e| e.name == name).map_or(0, |element| element.count)
    };
    if count("face") + count("tristrips") > 0 || header.elem_defs.is_empty() {
        return Ok(());
    }
    let has =
        |name: &str| header.elem_defs.iter().any(|e| e.name == "vertex" && e.has_property(name));
    let kind = if has("f_dc_0") && has("rot_0") {
        "a Gaussian splat"
    } else if count("edge") > 0 {
        "lines"
    } else {
        "a point cloud"
    };
    let vertices = counted(count("vertex"), "vertex", "vertices");
    let problem = match count("vertex") {
        0 => "not a mesh: no vertex and no face".to_owned(),
        _ => format!("{kind}, not a mesh: {vertices} and no face"),
    };
    Err(FormatError::new(Fault::Unsupported, HEADER, problem))
}

/// Checks indices, gives corners the attributes of their vertices, and makes a run of faces for
/// each change of texture.
fn finish(
    faces: &mut Faces,
    texture_numbers: &[u32],
    materials: &[ObjMaterial],
    warnings: &mut Vec<String>,
) -> Result<(), FormatError> {
    let vertices = faces.positions.len();
    if let Some(corner) = faces.corner_v.iter().position(|&v| v as usize >= vertices) {
        let face = faces.face_ends.partition_point(|&end| end as usize <= corner);
        let problem = format!(
            "vertex {} does not exist (the file has {vertices}, counted from 0)",
            faces.corner_v[corner]
        );
        return Err(FormatError::new(Fault::Malformed, format!("face {}", face + 1), problem));
    }
    if !faces.normals.is_empty() {
        faces.corner_n.clone_from(&faces.corner_v);
    }
    if faces.corner_t.is_empty() && !faces.texcoords.is_empty() {
        faces.corner_t.clone_from(&faces.corner_v);
    }
    faces.materials = materials.iter().map(|m| m.name.clone()).collect();
    let mut missing = 0u64;
    for face in 0..faces.face_ends.len() {
        let number = texture_numbers.get(face).copied().unwrap_or(0);
        let exists = (number as usize) < materials.len();
        missing += u64::from(!exists && !texture_numbers.is_empty());
        let material = if exists { number } else { NONE };
        if faces.runs.last().is_none_or(|run| run.material != material) {
            faces.runs.push(Run { first_face: face as u32, material, label: NONE });
        }
    }
    if missing > 0 && !materials.is_empty() {
        let faces = counted(missing, "face names", "faces name");
        warnings.push(format!("{faces} a texture that the file does not have"));
    }
    Ok(())
}

/// The textures that comments name (`comment TextureFile wood.png`, as MeshLab and others write
/// it), as materials.
fn textures(header: &PlyHeader) -> Vec<ObjMaterial> {
    let names = header.comments.iter().filter_map(|c| c.strip_prefix("TextureFile "));
    (0..)
        .zip(names)
        .map(|(number, name): (usize, &str)| ObjMaterial {
            name: format!("texture{number}"),
            lines: vec![format!("map_Kd {}", name.trim())],
        })
        .collect()
}

fn header_error(error: &DeserializeError) -> FormatError {
    let (fault, problem) = fault_and_problem(error);
    FormatError::new(fault, HEADER, problem)
}

/// Whose fault an error of `serde-ply` or a sink is, and its message.
fn fault_and_problem(error: &DeserializeError) -> (Fault, String) {
    if error.0.kind() == ErrorKind::UnexpectedEof {
        return (Fault::Malformed, "the file is truncated".to_owned());
    }
    let text = error.0.to_string();
    if let Some(limit) = text.strip_prefix(columns::LIMIT) {
        return (Fault::Limit, limit.to_owned());
    }
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_ascii_lowercase());
    (Fault::Malformed, first.into_iter().chain(letters).collect())
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
