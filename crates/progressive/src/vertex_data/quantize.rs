//! Quantisation: streams on a regular grid, with bounds of the error.

use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::vertex_layout::VertexLayout;
use lodc_mesh::{Component, Mesh, Semantic};

/// Bits per value for each kind of stream, from 2 to 24; `None` keeps the values as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quantize {
    /// Positions: the longest side of an object's bounding box has 2^n − 1 steps.
    pub position: Option<u8>,
    /// Normals and tangents: −1 to 1 has 2^n − 2 steps, 0 being one of them.
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
        if let Some(bits) = self.position {
            let values = mesh.positions().iter().map(|p| &p[..]);
            bounds.extend(grid(layout, 0, bits, &range(values, 3), "position".to_owned()));
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
            let span = range(all.chunks_exact(channels), channels);
            let unit = span.iter().all(|(lo, hi)| *lo >= -1.0 && *hi <= 1.0);
            let whole = vec![(-1.0, 1.0); channels];
            bounds.extend(match (&a.semantic, self.normal, self.uv) {
                (Semantic::Normal, Some(bits), _) if unit => {
                    grid(layout, i + 1, bits, &whole, "normal".to_owned())
                }
                (Semantic::Tangent, Some(bits), _) if unit => {
                    grid(layout, i + 1, bits, &whole, "tangent".to_owned())
                }
                (Semantic::TexCoord(set), _, Some(bits)) => {
                    grid(layout, i + 1, bits, &span, format!("uv {set}"))
                }
                _ => None,
            });
        }
        bounds
    }
}

/// Returns the least and greatest value of each channel; NaN for a channel that is not finite.
fn range<'a>(values: impl Iterator<Item = &'a [f32]>, channels: usize) -> Vec<(f32, f32)> {
    let mut range = vec![(f32::INFINITY, f32::NEG_INFINITY); channels];
    for v in values {
        for ((lo, hi), &x) in range.iter_mut().zip(v) {
            (*lo, *hi) = if x.is_finite() { (lo.min(x), hi.max(x)) } else { (f32::NAN, f32::NAN) };
        }
    }
    range
}

/// Puts one stream on a grid of `bits` over `range`. Returns `None`, and changes nothing, if the
/// range is not finite or its step not a normal float.
fn grid(
    layout: &mut VertexLayout,
    stream: usize,
    bits: u8,
    range: &[(f32, f32)],
    name: String,
) -> Option<ErrorBound> {
    let stream = &layout.streams[stream];
    let side = range.iter().map(|(lo, hi)| f64::from(*hi) - f64::from(*lo)).fold(0.0, f64::max);
    let symmetric = range.iter().all(|&r| r == (-1.0, 1.0));
    let steps = f64::from((1u32 << bits.clamp(2, 24)) - if symmetric { 2 } else { 1 });
    let step = (side / steps) as f32;
    let finite = range.iter().all(|(lo, hi)| lo.is_finite() && hi.is_finite());
    if !(finite && step.is_normal() && f64::from(step) * steps * 1.01 < f64::from(f32::MAX)) {
        return None;
    }
    for (system, (lo, _)) in layout.systems[stream.first..].iter_mut().zip(range) {
        *system = NumberSystem::Grid { origin: *lo, step };
    }
    // Half a step, and the rounding of the sum to f32.
    let far = range.iter().map(|(lo, hi)| lo.abs().max(hi.abs())).fold(0.0, f32::max);
    let coordinate = f64::from(step) / 2.0 + f64::from(far) * f64::from(f32::EPSILON);
    let distance = coordinate * (stream.channels as f64).sqrt();
    Some(ErrorBound { stream: name, bits, coordinate, distance })
}
