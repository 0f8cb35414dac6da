//! Reads the rows of a PLY's elements: which property of a vertex or face is which coordinate,
//! colour or index, and its values converted.

use super::Content;
use crate::faces::{Faces, NONE};
use crate::far::single;
use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_ply::{ElementDef, PropertyType, ScalarType};
use std::cell::Cell;
use std::fmt;

/// Beginning of a sink's message when a limit is reached.
pub(super) const LIMIT: &str = "limit: ";

/// Number of the row that is being read, from 1.
#[derive(Debug, Default)]
pub(super) struct Count(Cell<u64>);

impl Count {
    pub(super) fn rows(&self) -> u64 {
        self.0.get()
    }
}

/// Reads all rows of an element. `sink` gets each property's number and values: one, or those of a
/// list.
pub(super) struct Rows<'a, F> {
    pub(super) element: &'a ElementDef,
    pub(super) count: &'a Count,
    pub(super) sink: F,
}

impl<'de, F: FnMut(usize, &[f64]) -> Result<(), String>> DeserializeSeed<'de> for Rows<'_, F> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, rows: D) -> Result<(), D::Error> {
        rows.deserialize_seq(self)
    }
}

impl<'de, F: FnMut(usize, &[f64]) -> Result<(), String>> Visitor<'de> for Rows<'_, F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("rows")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut rows: A) -> Result<(), A::Error> {
        let mut values = Vec::new();
        for row in 1..=self.element.count {
            self.count.0.set(row as u64);
            rows.next_element_seed(Row { sink: &mut self.sink, values: &mut values })?;
        }
        Ok(())
    }
}

/// Reads one row.
struct Row<'a, F> {
    sink: &'a mut F,
    values: &'a mut Vec<f64>,
}

impl<'de, F: FnMut(usize, &[f64]) -> Result<(), String>> DeserializeSeed<'de> for Row<'_, F> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, row: D) -> Result<(), D::Error> {
        row.deserialize_map(self)
    }
}

impl<'de, F: FnMut(usize, &[f64]) -> Result<(), String>> Visitor<'de> for Row<'_, F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a row")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut row: A) -> Result<(), A::Error> {
        let mut column = 0;
        // Properties come in the order of the header, so their names do not matter.
        while row.next_key::<IgnoredAny>()?.is_some() {
            self.values.clear();
            row.next_value_seed(Numbers(self.values))?;
            (self.sink)(column, self.values).map_err(A::Error::custom)?;
            column += 1;
        }
        Ok(())
    }
}

/// Reads a number or a list of numbers.
struct Numbers<'a>(&'a mut Vec<f64>);

impl<'de> DeserializeSeed<'de> for Numbers<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, value: D) -> Result<(), D::Error> {
        value.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Numbers<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("numbers")
    }

    // Narrower numbers come here as well; none has more bits than an f64 holds.
    fn visit_i64<E>(self, v: i64) -> Result<(), E> {
        self.0.push(v as f64);
        Ok(())
    }

    fn visit_u64<E>(self, v: u64) -> Result<(), E> {
        self.0.push(v as f64);
        Ok(())
    }

    fn visit_f64<E>(self, v: f64) -> Result<(), E> {
        self.0.push(v);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        // No memory is reserved for a length that is only claimed.
        while list.next_element_seed(Numbers(self.0))?.is_some() {}
        Ok(())
    }
}

/// Smallest number of bytes that a property takes in a binary file.
pub(super) const fn min_bytes(kind: &PropertyType) -> u64 {
    let (PropertyType::Scalar(number) | PropertyType::List { count_type: number, .. }) = kind;
    match number {
        ScalarType::I8 | ScalarType::U8 => 1,
        ScalarType::I16 | ScalarType::U16 => 2,
        ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
        ScalarType::F64 => 8,
    }
}

/// The meaning of a property of a vertex, with the component that it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum VertexColumn {
    Position(usize),
    Normal(usize),
    Texcoord(usize),
    /// Channel, and the value of full intensity.
    Color(usize, f64),
    Unused,
}

impl VertexColumn {
    /// The meaning of each property; names of those that have none go to `unused`.
    pub(super) fn of(element: &ElementDef, unused: &mut Vec<String>) -> Vec<Self> {
        let has = |name: &str| element.has_property(name);
        let (normals, colors) =
            (has("nx") && has("ny") && has("nz"), has("red") || has("diffuse_red") || has("r"));
        // One letter means a colour only together.
        let letters = has("r") && has("g") && has("b");
        let meaning = |name: &str, number: ScalarType| match name {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "nx" if normals => Self::Normal(0),
            "ny" if normals => Self::Normal(1),
            "nz" if normals => Self::Normal(2),
            "s" | "u" | "texture_u" | "s0" => Self::Texcoord(0),
            "t" | "v" | "texture_v" | "t0" => Self::Texcoord(1),
            "red" | "diffuse_red" => Self::Color(0, full_intensity(number)),
            "green" | "diffuse_green" => Self::Color(1, full_intensity(number)),
            "blue" | "diffuse_blue" => Self::Color(2, full_intensity(number)),
            "r" if letters => Self::Color(0, full_intensity(number)),
            "g" if letters => Self::Color(1, full_intensity(number)),
            "b" if letters => Self::Color(2, full_intensity(number)),
            "a" if letters => Self::Color(3, full_intensity(number)),
            "alpha" if colors => Self::Color(3, full_intensity(number)),
            _ => Self::Unused,
        };
        let mut seen = Vec::new();
        let properties = element.properties.iter();
        let columns = properties.map(|property| {
            let column = match &property.property_type {
                PropertyType::Scalar(number) => meaning(&property.name, *number),
                PropertyType::List { .. } => Self::Unused,
            };
            if column == Self::Unused || seen.contains(&column) {
                unused.push(property.name.clone());
                return Self::Unused;
            }
            seen.push(column);
            column
        });
        columns.collect()
    }
}

/// The value of full intensity of a colour channel.
const fn full_intensity(number: ScalarType) -> f64 {
    match number {
        ScalarType::I8 => i8::MAX as f64,
        ScalarType::U8 => u8::MAX as f64,
        ScalarType::I16 => i16::MAX as f64,
        ScalarType::U16 => u16::MAX as f64,
        ScalarType::I32 => i32::MAX as f64,
        ScalarType::U32 => u32::MAX as f64,
        ScalarType::F32 | ScalarType::F64 => 1.0,
    }
}

/// Returns a sink that adds vertices to `faces`, value by value, and their positions to
/// `exact_positions`, if that is there.
pub(super) fn vertices<'a>(
    faces: &'a mut Faces,
    mut exact_positions: Option<&'a mut Vec<[f64; 3]>>,
    columns: &'a [VertexColumn],
    count: &'a Count,
) -> impl FnMut(usize, &[f64]) -> Result<(), String> + 'a {
    let has = |column: fn(&VertexColumn) -> bool| columns.iter().any(column);
    let normals = has(|c| matches!(c, VertexColumn::Normal(_)));
    let texcoords = has(|c| matches!(c, VertexColumn::Texcoord(_)));
    let colors = has(|c| matches!(c, VertexColumn::Color(..)));
    faces.color_has_alpha = has(|c| matches!(c, VertexColumn::Color(3, _)));
    move |column, values| {
        let vertex = count.rows() as usize - 1;
        if faces.positions.len() <= vertex {
            faces.positions.push([0.0; 3]);
            if let Some(exact) = &mut exact_positions {
                exact.push([0.0; 3]);
            }
            faces.normals.resize(if normals { vertex + 1 } else { 0 }, [0.0; 3]);
            faces.texcoords.resize(if texcoords { vertex + 1 } else { 0 }, [0.0; 2]);
            faces.colors.resize(if colors { vertex + 1 } else { 0 }, [1.0; 4]);
        }
        match columns[column] {
            VertexColumn::Position(axis) => {
                let value = single(values[0]);
                if !value.is_finite() {
                    return Err(format!("the coordinate {} is not finite", values[0]));
                }
                faces.positions[vertex][axis] = value;
                if let Some(exact) = &mut exact_positions {
                    exact[vertex][axis] = values[0];
                }
            }
            VertexColumn::Normal(axis) => faces.normals[vertex][axis] = single(values[0]),
            VertexColumn::Texcoord(axis) => faces.texcoords[vertex][axis] = single(values[0]),
            VertexColumn::Color(channel, full_intensity) => {
                faces.colors[vertex][channel] = single(values[0] / full_intensity);
            }
            VertexColumn::Unused => {}
        }
        Ok(())
    }
}

/// The meaning of a property of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FaceColumn {
    Corners,
    /// Two numbers for each corner.
    Texcoords,
    Texture,
    /// Channel, and the value of full intensity.
    Color(usize, f64),
    Unused,
}

impl FaceColumn {
    /// The meaning of each property; names of those that have none go to `unused`. Colours count
    /// if vertices have none.
    pub(super) fn of(element: &ElementDef, colors: bool, unused: &mut Vec<String>) -> Vec<Self> {
        let mut seen = Vec::new();
        let channel = |name: &str| {
            let names = ["red", "green", "blue", "alpha"];
            names.iter().position(|n| *n == name).filter(|_| colors)
        };
        let columns = element.properties.iter().map(|property| {
            let list = matches!(property.property_type, PropertyType::List { .. });
            let column = match (property.name.as_str(), list) {
                ("vertex_indices" | "vertex_index", true) => Self::Corners,
                ("texcoord", true) => Self::Texcoords,
                ("texnumber", false) => Self::Texture,
                (name, false) => match (channel(name), &property.property_type) {
                    (Some(i), PropertyType::Scalar(n)) => Self::Color(i, full_intensity(*n)),
                    _ => Self::Unused,
                },
                _ => Self::Unused,
            };
            if column == Self::Unused || seen.contains(&column) {
                unused.push(property.name.clone());
                return Self::Unused;
            }
            seen.push(column);
            column
        });
        columns.collect()
    }
}

/// Returns a sink that adds faces, or strips of triangles separated by -1, to `content`; at most
/// `max_corners` corners together.
pub(super) fn faces<'a>(
    content: &'a mut Content,
    columns: &'a [FaceColumn],
    strips: bool,
    max_corners: u64,
) -> impl FnMut(usize, &[f64]) -> Result<(), String> + 'a {
    let textures = columns.contains(&FaceColumn::Texture);
    let colors = columns.iter().any(|c| matches!(c, FaceColumn::Color(..)));
    let mut color = [1.0; 4];
    let (mut corners, mut texcoords, mut texture) = (Vec::new(), Vec::new(), 0.0);
    move |column, values| {
        match columns[column] {
            FaceColumn::Corners => values.clone_into(&mut corners),
            FaceColumn::Texcoords => values.clone_into(&mut texcoords),
            FaceColumn::Texture => texture = values[0],
            FaceColumn::Color(channel, full_intensity) => {
                color[channel] = single(values[0] / full_intensity);
            }
            FaceColumn::Unused => {}
        }
        if column + 1 < columns.len() {
            return Ok(());
        }
        if strips {
            strip_triangles(&corners, &mut content.faces)?;
        } else if corners.len() < 3 {
            content.small_faces += 1;
            content.small_corners.extend(corners.iter().copied().filter_map(index));
        } else {
            face(&corners, &texcoords, &mut content.faces)?;
            if textures {
                content.texture_numbers.push(index(texture).unwrap_or(NONE));
            }
            if colors {
                content.face_colors.push(color);
            }
        }
        corners.clear();
        texcoords.clear();
        if content.faces.corner_v.len() as u64 > max_corners {
            return Err(format!(
                "{LIMIT}more than {max_corners} corners of faces: the limit on triangles"
            ));
        }
        Ok(())
    }
}

/// Adds a face. If it has texture coordinates, they are used instead of those of its vertices.
fn face(corners: &[f64], texcoords: &[f64], faces: &mut Faces) -> Result<(), String> {
    for &corner in corners {
        faces.corner_v.push(vertex(corner)?);
    }
    faces.face_ends.push(faces.corner_v.len() as u32);
    if texcoords.len() == 2 * corners.len() {
        // Faces before the first with coordinates of its own have none.
        faces.corner_t.resize(faces.corner_v.len() - corners.len(), NONE);
        for uv in texcoords.as_chunks::<2>().0 {
            faces.corner_t.push(faces.texcoords.len() as u32);
            faces.texcoords.push(uv.map(single));
        }
    } else if !faces.corner_t.is_empty() {
        faces.corner_t.resize(faces.corner_v.len(), NONE);
    }
    Ok(())
}

/// Adds the triangles of strips, of which every second one is turned over.
fn strip_triangles(strips: &[f64], faces: &mut Faces) -> Result<(), String> {
    for strip in strips.split(|&corner| corner == -1.0) {
        for (number, triangle) in strip.windows(3).enumerate() {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
            let turned = if number % 2 == 0 { [a, b, c] } else { [b, a, c] };
            face(&turned, &[], faces)?;
        }
    }
    Ok(())
}

fn vertex(corner: f64) -> Result<u32, String> {
    index(corner).ok_or_else(|| format!("{corner} is not the number of a vertex"))
}

/// Which properties of an element are the two ends of an edge; none if it has none.
pub(super) fn ends(element: &ElementDef) -> Option<[usize; 2]> {
    let number = |name: &str| element.properties.iter().position(|p| p.name == name);
    Some([number("vertex1")?, number("vertex2")?])
}

/// A number as an index; none if it cannot be one.
pub(super) fn index(value: f64) -> Option<u32> {
    let whole = value.fract() == 0.0 && (0.0..f64::from(NONE)).contains(&value);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is one")]
    whole.then_some(value as u32)
}
