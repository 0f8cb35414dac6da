//! Sheets: what may be tied to each other.
//!
//! Where surfaces lie inside each other or nearly touch (a shell and its core, both sides of a thin
//! plate), the nearest point is often one of another sheet. A sample is tied to its own: to what
//! hangs together with it and faces its way.

use glam::DVec3;
use lodc_nearest::{Nearest, TriangleTree};

/// Cosine of the angle between normals from which on faces are not of one sheet: 107°, so that the
/// faces beside a sharp crease are. Chosen by hand.
const MIN_COSINE: f64 = -0.3;

/// A triangle, or a face of a level, by what may be tied to it.
#[derive(Clone, Copy)]
pub(crate) struct Sheet {
    pub(crate) component: u32,
    /// Along the normal; zero for faces without area.
    pub(crate) normal: DVec3,
}

impl Sheet {
    /// Returns whether samples of one may be tied to the other.
    pub(crate) fn goes_with(self, other: Self) -> bool {
        let cosine = self.normal.dot(other.normal);
        self.component == other.component
            && (cosine >= 0.0
                || cosine >= MIN_COSINE * self.normal.length() * other.normal.length())
    }
}

/// The nearest point of a tree to a sample: of its own sheet, if that is within `reach` or twice as
/// far as the nearest of all, else of any. With the squared distance of the nearest of all.
pub(crate) fn nearest_of_sheet(
    tree: &TriangleTree,
    p: DVec3,
    hint: u32,
    reach: f64,
    is_own: impl Fn(u32) -> bool,
) -> Option<(Nearest, f64)> {
    let nearest = tree.nearest(p, hint)?;
    // Where nothing at all is within reach, what the sample is of is gone.
    let own = if is_own(nearest.triangle) || nearest.squared > reach * reach {
        nearest
    } else {
        let reach = reach.max(2.0 * nearest.squared.sqrt());
        tree.nearest_of(p, reach * reach, is_own).unwrap_or(nearest)
    };
    Some((own, nearest.squared))
}
