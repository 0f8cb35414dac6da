//! Sections by which an engine chooses a level before it reads an object: bounding box and sphere,
//! and a table of up to 64 levels with their errors.

use super::table::{location, tag};
use crate::{Fault, FormatError};
use bincode::{Decode, Encode};
use lodc_mesh::{CollapseSequence, Lod, Simplified};

/// Largest number of levels in a table. Chosen by hand.
pub const MAX_LEVELS: usize = 64;
/// Bytes of a level in a table: five words of four bytes.
const LEVEL_BYTES: usize = 20;

/// Bounds of all vertices of an object at rest, and so of each of its levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Encode, Decode)]
pub struct Bounds {
    /// The lowest coordinates.
    pub low: [f32; 3],
    /// The highest coordinates.
    pub high: [f32; 3],
    /// The middle of the box.
    pub center: [f32; 3],
    /// Distance of the vertex farthest from the middle, rounded up.
    pub radius: f32,
}

impl Bounds {
    /// The bounds of vertices; zeros without any.
    #[must_use]
    pub fn of(positions: &[[f32; 3]]) -> Self {
        let Some(&first) = positions.first() else { return Self::default() };
        let (mut low, mut high) = (first, first);
        for p in positions {
            for i in 0..3 {
                low[i] = low[i].min(p[i]);
                high[i] = high[i].max(p[i]);
            }
        }
        // −0 and +0 are one coordinate, and which comes first must not matter.
        let [low, high] = [low, high].map(|corner| corner.map(|x| x + 0.0));
        let middle = |i| ((f64::from(low[i]) + f64::from(high[i])) / 2.0) as f32;
        let center = [middle(0), middle(1), middle(2)];
        let square = |p: &[f32; 3]| {
            let [x, y, z] = [0, 1, 2].map(|i| f64::from(p[i]) - f64::from(center[i]));
            x * x + y * y + z * z
        };
        let distance = positions.iter().map(square).fold(0.0, f64::max).sqrt();
        let nearest = distance as f32;
        let radius = if f64::from(nearest) < distance { nearest.next_up() } else { nearest };
        Self { low, high, center, radius }
    }
}

/// A level in the table of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableLevel {
    /// Its LOD, after which some step ends.
    pub lod: Lod,
    /// Its triangles.
    pub triangles: u32,
    /// Vertices that are left: the last ones of the object.
    pub vertices: u32,
    /// Its error.
    pub error: f32,
    /// Its root mean square distance; none if it was not measured.
    pub rms: Option<f32>,
}

impl TableLevel {
    fn of(sequence: &CollapseSequence, lod: Lod) -> Self {
        Self {
            lod,
            triangles: sequence.triangles_at(lod),
            vertices: sequence.records() + 1 - lod.0,
            error: sequence.error_at(lod),
            rms: sequence.rms_at(lod),
        }
    }

    fn bytes(&self) -> [u8; LEVEL_BYTES] {
        let words = [
            self.lod.0,
            self.triangles,
            self.vertices,
            self.error.to_bits(),
            self.rms.unwrap_or(-1.0).to_bits(),
        ];
        let mut bytes = [0; LEVEL_BYTES];
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

/// Chooses levels for a table: from all triangles to few, each with 1/2, 1/√2, 1/∜2 … of those of
/// the one before, as near as they fit. None without vertices.
#[must_use]
pub fn table_of_levels(simplified: &Simplified) -> Vec<TableLevel> {
    if simplified.mesh().vertex_count() == 0 {
        return Vec::new();
    }
    let sequence = simplified.collapses();
    let all_triangles = sequence.triangles_at(Lod(0));
    let octaves = all_triangles.checked_ilog2().unwrap_or(0) as usize + 1;
    // Roots are the same on every machine, other powers are not.
    let (mut ratio, mut levels_per_octave) = (2.0f64, 1);
    while 2 * levels_per_octave * octaves < MAX_LEVELS {
        (ratio, levels_per_octave) = (ratio.sqrt(), 2 * levels_per_octave);
    }
    let (mut lods, mut wanted) = (vec![Lod(0)], f64::from(all_triangles) / ratio);
    while wanted >= 0.5 {
        let lod = sequence.lod_for_triangles((wanted + 0.5) as u32).min(sequence.last_visible());
        lods.extend((lods.last() < Some(&lod)).then_some(lod));
        wanted /= ratio;
    }
    lods.into_iter().map(|lod| TableLevel::of(sequence, lod)).collect()
}

pub(super) fn put_levels(out: &mut Vec<u8>, levels: &[TableLevel]) {
    levels.iter().for_each(|level| out.extend_from_slice(&level.bytes()));
}

/// Compares a table with the object's sequence.
pub(super) fn check_levels(
    stored: &[u8],
    number: u32,
    simplified: &Simplified,
) -> Result<(), FormatError> {
    let wrong = |problem: &str| {
        Err(FormatError::new(Fault::Malformed, location(tag::LEVELS, number, 0), problem))
    };
    let sequence = simplified.collapses();
    if !stored.len().is_multiple_of(LEVEL_BYTES) || stored.len() > MAX_LEVELS * LEVEL_BYTES {
        return wrong("is not a table of at most 64 levels");
    }
    let mut previous = None;
    for entry in stored.chunks_exact(LEVEL_BYTES) {
        let lod = Lod(u32::from_le_bytes([entry[0], entry[1], entry[2], entry[3]]));
        let is_level = lod <= sequence.last() && sequence.floor(lod) == lod;
        if !is_level || previous >= Some(lod) || simplified.mesh().vertex_count() == 0 {
            return wrong("has a level that the object has not, or not in order");
        }
        if entry != TableLevel::of(sequence, lod).bytes() {
            return wrong("has other numbers than the object's curves");
        }
        previous = Some(lod);
    }
    Ok(())
}
