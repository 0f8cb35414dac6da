//! Lossy quantisation of positions, normals and texture coordinates to regular grids, with a bound
//! of the error of each stream.

use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::octahedral::Octahedral;
use crate::vertex_data::vertex_layout::VertexLayout;
use lodc_mesh::{Component, Mesh, Semantic};

/// Bits per value for each kind of stream, from 2 to 24; `None` keeps the values as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quantize {
    /// Positions: the longest side of an object's bounding box has 2^n − 1 steps.
    pub position: Option<u8>,
    /// Normals and tangents: two numbers on an octahedron of 2^n − 2 steps; three from −1 to 1 if
    /// they have other lengths than 1.
    pub normal: Option<u8>,
    /// Texture coordinates: the longest side of their range has 2^n − 1 steps.
    pub uv: Option<u8>,
}

/// A bound of the quantisation error of one stream.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorBound {
    /// Name of the stream: `position`, `normal`, `tangent`, or `uv` and its set.
    pub stream: String,
    /// Bits per value.
    pub bits: u8,
    /// Greatest change of a coordinate, in the stream's units.
    pub coordinate: f64,
    /// Greatest distance that a point moves.
    pub distance: f64,
}

impl Quantize {
    /// Puts streams of a layout on grids. Returns a bound of the error of each.
    #[must_use = "the error bounds are for the user"]
    pub fn apply(&self, mesh: &Mesh, layout: &mut VertexLayout) -> Vec<ErrorBound> {
        let mut bounds = Vec::new();
        let mut octahedral = vec![None; mesh.attributes().len()];
        if let Some(bits) = self.position {
            let values = mesh.positions().iter().map(|p| &p[..]);
            let ranges = channel_ranges(values, 3);
            bounds.extend(put_on_grid(layout, 0, bits, &ranges, "position".to_owned()));
        }
        for (i, a) in mesh.attributes().iter().enumerate() {
            let channels = usize::from(a.components);
            if a.component != Component::F32 || a.morph_target.is_some() {
                continue;
            }
            let all: Vec<f32> = a
                .bytes
                .chunks_exact(4)
                .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
                .collect();
            let ranges = channel_ranges(all.chunks_exact(channels), channels);
            let is_within_unit = ranges.iter().all(|(lo, hi)| *lo >= -1.0 && *hi <= 1.0);
            let unit_ranges = vec![(-1.0, 1.0); channels];
            let mut direction = |bits, name: &str| {
                let grid_bound = put_on_grid(layout, i + 1, bits, &unit_ranges, name.to_owned())?;
                let values = all.chunks_exact(channels);
                let bound = octahedral_bound(values, Octahedral { bits }, &grid_bound);
                octahedral[i] = bound.is_some().then_some(Octahedral { bits });
                Some(bound.unwrap_or(grid_bound))
            };
            bounds.extend(match (&a.semantic, self.normal, self.uv) {
                (Semantic::Normal, Some(bits), _) if is_within_unit => direction(bits, "normal"),
                (Semantic::Tangent, Some(bits), _) if is_within_unit => direction(bits, "tangent"),
                (Semantic::TexCoord(set), _, Some(bits)) => {
                    put_on_grid(layout, i + 1, bits, &ranges, format!("uv {set}"))
                }
                _ => None,
            });
        }
        layout.set_octahedral(mesh.attributes(), &octahedral);
        bounds
    }
}

/// How far from 1 the length of a vector may be if it is to be stored as a direction alone. Chosen
/// by hand: it allows for rounding, and refuses vectors whose length has a meaning.
const MAX_LENGTH_ERROR: f64 = 0.01;

/// Returns by how much directions change on an octahedron, with further components (the handedness
/// of tangents) on a grid; `None` if the directions are not all of length 1.
fn octahedral_bound<'a>(
    values: impl Iterator<Item = &'a [f32]>,
    octahedral: Octahedral,
    grid_bound: &ErrorBound,
) -> Option<ErrorBound> {
    // Rounding to f32 may make a change larger by this factor.
    const ROUNDING: f64 = 1.0 + 1e-6;
    let mut bound = ErrorBound { coordinate: 0.0, distance: 0.0, ..grid_bound.clone() };
    let mut has_more_components = false;
    for value in values {
        let direction = <[f32; 3]>::try_from(value.get(..3)?).ok()?.map(f64::from);
        let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (length - 1.0).abs() > MAX_LENGTH_ERROR || length.is_nan() {
            return None;
        }
        let decoded = octahedral.direction(octahedral.indices(direction)).map(|c| c as f32);
        let change = [0, 1, 2].map(|c| (direction[c] - f64::from(decoded[c])).abs() * ROUNDING);
        bound.coordinate = change.iter().copied().fold(bound.coordinate, f64::max);
        bound.distance = bound.distance.max(change.iter().map(|c| c * c).sum::<f64>().sqrt());
        has_more_components |= value.len() > 3;
    }
    if has_more_components {
        bound.coordinate = bound.coordinate.max(grid_bound.coordinate);
        bound.distance += grid_bound.coordinate;
    }
    Some(bound)
}

/// Returns the least and greatest value of each channel; NaN for a channel that is not finite.
fn channel_ranges<'a>(values: impl Iterator<Item = &'a [f32]>, channels: usize) -> Vec<(f32, f32)> {
    let mut ranges = vec![(f32::INFINITY, f32::NEG_INFINITY); channels];
    for v in values {
        for ((lo, hi), &x) in ranges.iter_mut().zip(v) {
            // A minimum with NaN is the other value.
            let stays_finite = x.is_finite() && !lo.is_nan();
            (*lo, *hi) = if stays_finite { (lo.min(x), hi.max(x)) } else { (f32::NAN, f32::NAN) };
        }
    }
    ranges
}

/// Puts one stream on a grid of `bits` over the ranges of its channels. Returns `None`, and changes
/// nothing, if a range is not finite, the grid's step is not a normal float, or its end is near the
/// largest float.
fn put_on_grid(
    layout: &mut VertexLayout,
    stream: usize,
    bits: u8,
    ranges: &[(f32, f32)],
    name: String,
) -> Option<ErrorBound> {
    let stream = &layout.streams[stream];
    let side = ranges.iter().map(|(lo, hi)| f64::from(*hi) - f64::from(*lo)).fold(0.0, f64::max);
    // An even number of steps puts 0 on a grid from -1 to 1.
    let symmetric = ranges.iter().all(|&r| r == (-1.0, 1.0));
    let steps = f64::from((1u32 << bits.clamp(2, 24)) - if symmetric { 2 } else { 1 });
    let step = (side / steps) as f32;
    // The far end must be finite, with some room for rounding.
    let finite = ranges.iter().all(|(lo, hi)| lo.is_finite() && hi.is_finite());
    if !(finite && step.is_normal() && f64::from(step) * steps * 1.01 < f64::from(f32::MAX)) {
        return None;
    }
    for (system, (lo, _)) in layout.systems[stream.first_channel..].iter_mut().zip(ranges) {
        *system = NumberSystem::Grid { origin: *lo, step };
    }
    // Half a step, and the rounding of the sum to f32.
    let largest = ranges.iter().map(|(lo, hi)| lo.abs().max(hi.abs())).fold(0.0, f32::max);
    let coordinate = f64::from(step) / 2.0 + f64::from(largest) * f64::from(f32::EPSILON);
    let distance = coordinate * (stream.channels as f64).sqrt();
    Some(ErrorBound { stream: name, bits, coordinate, distance })
}

#[cfg(test)]
mod tests {
    use super::{ErrorBound, channel_ranges, octahedral_bound};
    use crate::vertex_data::octahedral::Octahedral;

    #[test]
    fn a_channel_that_is_not_finite_anywhere_has_no_range() {
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let values = [[0.0, 1.0], [odd, 2.0], [3.0, -1.0]];
            let found = channel_ranges(values.iter().map(|v| &v[..]), 2);
            assert!(found[0].0.is_nan() && found[0].1.is_nan(), "{found:?}");
            assert_eq!(found[1], (-1.0, 2.0));
        }
    }

    #[test]
    fn what_follows_a_direction_counts_however_much_the_direction_changes() {
        let grid = ErrorBound { stream: "t".to_owned(), bits: 4, coordinate: 1e-3, distance: 2e-3 };
        let tangents = [[0.6, 0.48, 0.64, 1.0], [0.0, 0.6, 0.8, -1.0]];
        let bound = |components: usize| {
            let values = tangents.iter().map(|t| &t[..components]);
            octahedral_bound(values, Octahedral { bits: 4 }, &grid).expect("directions")
        };
        let (alone, followed) = (bound(3), bound(4));
        assert!(alone.coordinate > grid.coordinate, "the direction changes more");
        assert_eq!(followed.coordinate, alone.coordinate);
        assert_eq!(followed.distance, alone.distance + grid.coordinate);
    }
}
