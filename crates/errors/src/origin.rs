//! Where samples were taken, in four bytes each.

use crate::input::Input;
use lodc_mesh::NONE;

/// Where a sample was taken on the input: twice a point, or twice a triangle plus 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Origin(u32);

impl Origin {
    /// That of no sample.
    pub(crate) const NONE: Self = Self(NONE);

    pub(crate) fn point(point: u32) -> Self {
        Self(2 * point)
    }

    pub(crate) fn triangle(triangle: u32) -> Self {
        Self(2 * triangle + 1)
    }

    /// Returns the triangles of the input that meet there, at least one.
    pub(crate) fn triangles(self, input: &Input) -> OriginTriangles<'_> {
        let which = self.0 / 2;
        if self.0.is_multiple_of(2) {
            OriginTriangles::Around(input.triangles_around.row(which))
        } else {
            OriginTriangles::Inside(which)
        }
    }
}

/// The triangles around a point, or one that a sample is inside of.
pub(crate) enum OriginTriangles<'a> {
    Around(&'a [u32]),
    Inside(u32),
}

impl OriginTriangles<'_> {
    pub(crate) fn as_slice(&self) -> &[u32] {
        match self {
            Self::Around(row) => row,
            Self::Inside(triangle) => std::slice::from_ref(triangle),
        }
    }
}
