//! How the values of one attribute stream are quantised: the integer type and its bits for
//! positions, texture coordinates, colours, weights, normals and morph targets.

use super::grid::{Grid, last_number};
use crate::gltf::meshopt::{packed_direction, unpacked_direction};
use crate::gltf::semantic;
use lodc_mesh::{Attribute, Component, Mesh, MeshParts};

/// The coding of a stream of one submesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Coding {
    /// Values stay as they are.
    Exact,
    /// Positions on a grid.
    Positions(Grid<3>),
    /// Differences of positions, as morph targets have them, in steps of this length in mesh units.
    Offsets(f64),
    /// Texture coordinates on a grid.
    TextureCoordinates(Grid<2>),
    /// Floats, rounded to multiples of this number; in files it is a power of two.
    Multiples(f64),
    /// Numbers from 0 to 1 with this number of bits.
    Fractions(u8),
    /// Numbers from 0 to 1, whose sum is 1, with this number of bits.
    Shares(u8),
    /// Numbers from −1 to 1 with this number of bits.
    Deltas(u8),
    /// Unit vectors on the octahedron with this number of bits, and a fourth number of −1 or 1.
    Directions(u8),
}

impl Coding {
    /// The type of the integers, and whether they stand for fractions (glTF's `normalized`); none
    /// if values stay.
    fn format(self) -> Option<(Component, bool)> {
        let sized = |bits, narrow, wide| (if bits <= 8 { narrow } else { wide }, true);
        Some(match self {
            Self::Exact => return None,
            Self::Positions(_) | Self::TextureCoordinates(_) => (Component::U16, false),
            Self::Offsets(_) => (Component::I16, false),
            Self::Multiples(_) => (Component::F32, false),
            Self::Fractions(bits) | Self::Shares(bits) => {
                sized(bits, Component::U8, Component::U16)
            }
            Self::Deltas(bits) | Self::Directions(bits) => {
                sized(bits, Component::I8, Component::I16)
            }
        })
    }

    /// The integers of one vertex; of floats their bits.
    fn integers(self, values: &[f32]) -> Vec<i32> {
        let three = |values: &[f32]| [values[0], values[1], values[2]];
        match self {
            Self::Exact => Vec::new(),
            Self::Positions(grid) => grid.numbers(three(values)).map(i32::from).to_vec(),
            Self::Offsets(step) => {
                values.iter().map(|&v| (f64::from(v) / step).round() as i32).collect()
            }
            Self::TextureCoordinates(grid) => {
                grid.numbers([values[0], values[1]]).map(i32::from).to_vec()
            }
            Self::Multiples(step) => {
                let multiple = |v: f32| ((f64::from(v) / step).round() * step + 0.0) as f32;
                values.iter().map(|&v| multiple(v).to_bits() as i32).collect()
            }
            Self::Fractions(bits) => values.iter().map(|&v| fraction(v.into(), bits)).collect(),
            Self::Shares(bits) => shares(values, bits),
            Self::Deltas(bits) => values.iter().map(|&v| signed(v.into(), bits)).collect(),
            Self::Directions(bits) => {
                let w = values.get(3).copied().unwrap_or(0.0);
                // What meshopt's filter gives back, so that it loses nothing.
                let packed = packed_direction(bits, three(values), w);
                unpacked_direction(bits, packed)[..values.len()].to_vec()
            }
        }
    }
}

/// Bytes of an integer of 1 to 16 bits.
pub(super) const fn size(bits: u8) -> usize {
    if bits <= 8 { 1 } else { 2 }
}

/// The largest integer of the bytes that `bits` bits need.
fn largest(bits: u8) -> f64 {
    last_number(8 * size(bits) as u8)
}

/// A number from 0 to 1 as one of 2^bits levels, spread over all values of its bytes.
fn fraction(value: f64, bits: u8) -> i32 {
    let level = (value.clamp(0.0, 1.0) * last_number(bits)).round();
    (level / last_number(bits) * largest(bits)).round() as i32
}

/// A number from −1 to 1 as one of 2^bits − 1 levels, spread over all values of its bytes.
fn signed(value: f64, bits: u8) -> i32 {
    let levels = last_number(bits - 1);
    let level = (value.clamp(-1.0, 1.0) * levels).round();
    let largest = last_number(8 * size(bits) as u8 - 1);
    (level / levels * largest).round() as i32
}

/// Integers that stand for numbers whose sum is 1: they add up to the integer that stands for 1,
/// and the largest takes what rounding leaves. All are 0 if the numbers are.
fn shares(values: &[f32], bits: u8) -> Vec<i32> {
    let sum: f64 = values.iter().map(|&v| f64::from(v.max(0.0))).sum();
    if sum <= 0.0 || !sum.is_finite() {
        return vec![0; values.len()];
    }
    let mut out: Vec<i32> = values.iter().map(|&v| fraction(f64::from(v) / sum, bits)).collect();
    let deficit = largest(bits) as i32 - out.iter().sum::<i32>();
    let largest_share = (0..out.len()).max_by_key(|&i| (out[i], std::cmp::Reverse(i)));
    largest_share.into_iter().for_each(|i| out[i] += deficit);
    out
}

/// A mesh whose streams are coded as `coding` says, given the number of a submesh and a stream that
/// it uses. With `positions`, its positions are one more stream, coded on that grid.
pub(super) fn coded(
    mesh: &Mesh,
    positions: Option<Grid<3>>,
    coding: impl Fn(usize, &Attribute) -> Coding,
) -> Mesh {
    let mut parts = mesh.clone().into_parts();
    let streams = std::mem::take(&mut parts.attributes);
    let users: Vec<Vec<u32>> =
        parts.submeshes.iter_mut().map(|s| std::mem::take(&mut s.attributes)).collect();
    for (number, stream) in streams.into_iter().enumerate() {
        let uses = |s: &usize| users[*s].contains(&(number as u32));
        let codings: Vec<(usize, Coding)> =
            (0..users.len()).filter(uses).map(|s| (s, coding(s, &stream))).collect();
        put(&mut parts, &stream, &codings);
    }
    if let Some(grid) = positions {
        let stream = semantic::positions(mesh.positions());
        let all: Vec<_> = (0..users.len()).map(|s| (s, Coding::Positions(grid))).collect();
        put(&mut parts, &stream, &all);
    }
    Mesh::try_from(parts).expect("only values of attributes have changed")
}

/// Adds a stream that some submeshes use, given the number of each and how it codes the stream:
/// once for each format that it is stored in.
fn put(parts: &mut MeshParts, stream: &Attribute, codings: &[(usize, Coding)]) {
    let mut formats = Vec::new();
    for (_, coding) in codings {
        if !formats.contains(&coding.format()) {
            formats.push(coding.format());
        }
    }
    for format in formats {
        let same_format: Vec<_> = codings.iter().filter(|(_, c)| c.format() == format).collect();
        for (submesh, _) in &same_format {
            parts.submeshes[*submesh].attributes.push(parts.attributes.len() as u32);
        }
        parts.attributes.push(match format {
            None => stream.clone(),
            Some((component, normalized)) => {
                let mut coded = Attribute { component, normalized, ..stream.described() };
                coded.bytes = vec![0; coded.stride() * parts.vertex_submesh.len()];
                fill(&mut coded, stream, &parts.vertex_submesh, &same_format);
                coded
            }
        });
    }
}

/// Writes the values of a stream, coded, for the vertices of some submeshes.
fn fill(to: &mut Attribute, from: &Attribute, submesh: &[u32], codings: &[&(usize, Coding)]) {
    let (width, stride) = (to.component.size(), to.stride());
    let mut by_submesh: Vec<Option<Coding>> = Vec::new();
    for (s, coding) in codings {
        by_submesh.resize(by_submesh.len().max(s + 1), None);
        by_submesh[*s] = Some(*coding);
    }
    let mut values = vec![0.0; usize::from(from.components)];
    for (v, (bytes, &s)) in to.bytes.chunks_exact_mut(stride).zip(submesh).enumerate() {
        let Some(coding) = by_submesh.get(s as usize).copied().flatten() else { continue };
        for (c, value) in values.iter_mut().enumerate() {
            *value = from.value(v as u32, c);
        }
        for (bytes, integer) in bytes.chunks_exact_mut(width).zip(coding.integers(&values)) {
            bytes.copy_from_slice(&integer.to_le_bytes()[..width]);
        }
    }
}
