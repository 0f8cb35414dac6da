//! The numbers of a comparison and those that were recorded earlier: tells which have become worse,
//! for `lodc compare --baseline`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Differences of distances, as a share of the diagonal, that count as rounding. Chosen by hand.
const DISTANCE_ROUNDING: f64 = 1e-6;
/// Differences of pixels, of 255, that count as rounding. Chosen by hand.
const PIXEL_ROUNDING: f64 = 0.01;

/// The numbers of a comparison that tell whether a level is worse than another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Numbers {
    /// Triangles of the level.
    pub triangles: usize,
    /// Root mean square distance, the greater of both ways.
    pub rms: f64,
    /// Largest distance, the greater of both ways.
    pub hausdorff: f64,
    /// Root mean square difference of pixels; null if no pictures were compared.
    pub image_rmse: Option<f64>,
}

/// A number that is worse than the recorded one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regression {
    /// Its name.
    pub name: &'static str,
    /// As measured now.
    pub now: f64,
    /// As recorded.
    pub then: f64,
}

impl Numbers {
    /// Returns every number that is worse than it was by more than the share `tolerance`;
    /// `diagonal` is that of the surface that levels are compared with.
    #[must_use]
    pub fn worse_than(&self, then: &Self, tolerance: f64, diagonal: f64) -> Vec<Regression> {
        let images = then.image_rmse.zip(self.image_rmse);
        let slack = DISTANCE_ROUNDING * diagonal;
        let pairs = [
            Some(("rms distance", then.rms, self.rms, slack)),
            Some(("hausdorff distance", then.hausdorff, self.hausdorff, slack)),
            images.map(|(then, now)| ("image RMSE", then, now, PIXEL_ROUNDING)),
        ];
        let worse = |(name, then, now, slack): (&'static str, f64, f64, f64)| {
            (now > then * (1.0 + tolerance) + slack).then_some(Regression { name, now, then })
        };
        pairs.into_iter().flatten().filter_map(worse).collect()
    }
}

/// The recorded numbers of an asset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Recorded {
    /// Options that the numbers depend on, as text.
    pub options: String,
    /// By the name of the level.
    pub levels: BTreeMap<String, Numbers>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_worse_beyond_tolerance_and_rounding() {
        let then = Numbers { triangles: 9, rms: 1.0, hausdorff: 2.0, image_rmse: Some(3.0) };
        let names = |now: &Numbers, diagonal| -> Vec<&str> {
            now.worse_than(&then, 0.1, diagonal).iter().map(|worse| worse.name).collect()
        };
        assert!(names(&then, 1.0).is_empty());
        let now = Numbers { rms: 1.2, hausdorff: 2.1, image_rmse: Some(4.0), ..then };
        assert_eq!(names(&now, 1.0), ["rms distance", "image RMSE"]);
        assert_eq!(names(&now, 1e6), ["image RMSE"], "a millionth of the diagonal is rounding");
        assert!(names(&Numbers { image_rmse: None, ..then }, 1.0).is_empty());
    }
}
