//! Bounding boxes: whether coordinates stand too far from the origin for single precision, and by
//! how much it rounds them.

/// Share of an object's diagonal by which a coordinate may be rounded. Chosen by hand: a little
/// more than single precision rounds where an object stands at the origin.
pub(crate) const MAX_ROUNDING: f64 = 1e-7;
/// By how much single precision rounds a number at most, as a share of it: half a unit in the last
/// place.
pub(crate) const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// A bounding box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) low: [f64; 3],
    pub(crate) high: [f64; 3],
}

impl Extent {
    /// The box around some positions; none without any.
    pub(crate) fn of(mut positions: impl Iterator<Item = [f64; 3]>) -> Option<Self> {
        let first = positions.next()?;
        let wider = |Self { low, high }: Self, p: [f64; 3]| Self {
            low: std::array::from_fn(|k| low[k].min(p[k])),
            high: std::array::from_fn(|k| high[k].max(p[k])),
        };
        Some(positions.fold(Self { low: first, high: first }, wider))
    }

    /// The length of its diagonal.
    pub(crate) fn diagonal(&self) -> f64 {
        (0..3).map(|k| (self.high[k] - self.low[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// By how much single precision rounds a coordinate in it at most.
    pub(crate) fn rounding(&self) -> f64 {
        let coordinates = self.low.iter().chain(&self.high);
        HALF_ULP * coordinates.fold(0.0, |most: f64, c| most.max(c.abs()))
    }

    /// Returns whether single precision may round coordinates by more than a mesh should be off.
    pub(crate) fn is_far(&self) -> bool {
        let rounding = self.rounding();
        rounding.is_finite() && rounding > MAX_ROUNDING * self.diagonal()
    }
}

/// The diagonal of the box around some positions; 0 without any.
#[cfg(feature = "import")]
pub(crate) fn diagonal(positions: &[[f32; 3]]) -> f64 {
    let positions = positions.iter().map(|p| p.map(f64::from));
    Extent::of(positions).map_or(0.0, |extent| extent.diagonal())
}

#[expect(clippy::cast_possible_truncation, reason = "meshes and colours are in single precision")]
pub(crate) const fn single(c: f64) -> f32 {
    c as f32
}
