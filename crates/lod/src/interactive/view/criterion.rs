//! Criteria that decide how fine each part of the surface is.

use lodc_mesh::Lod;

/// A rule for the LOD of a wedge group. Positions and lengths are in the mesh's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// How far the group's cone of normals is from the silhouette (thesis 5.3, algorithm 6): LOD
    /// `edge` where some normal of the cone may be perpendicular to the direction of view, so that
    /// the outline keeps its detail; LOD `face` where the cosine of every normal to it is at least
    /// `width`; linear in the cosine between.
    Silhouette {
        /// The viewpoint.
        eye: [f32; 3],
        /// The finer LOD.
        edge: Lod,
        /// The coarser LOD.
        face: Lod,
        /// Width of the band of detail along the silhouette, as a cosine: 1 is the thesis's rule;
        /// towards 0 the band shrinks to a line. The sines of cones are multiplied by it, too.
        width: f32,
    },
    /// The coarsest LOD whose stored error, at the group's distance from the eye, covers at most
    /// `slope` of that distance, or one that is finer by less than 0.2 % of the error; where less
    /// is allowed than some 16,000th of the largest error, one without error.
    ScreenError {
        /// The viewpoint.
        eye: [f32; 3],
        /// Allowed error per distance: see [`Self::slope`].
        slope: f32,
    },
    /// One LOD in a sphere, another outside (thesis, fig. 5.8).
    Sphere {
        /// Its centre.
        centre: [f32; 3],
        /// Its radius.
        radius: f32,
        /// The LOD inside and on it.
        inside: Lod,
        /// The LOD outside.
        outside: Lod,
    },
    /// One LOD in a box, another outside.
    Region {
        /// Its lowest corner.
        low: [f32; 3],
        /// Its highest corner.
        high: [f32; 3],
        /// The LOD inside and on it.
        inside: Lod,
        /// The LOD outside.
        outside: Lod,
    },
    /// One LOD on the screen, another behind the eye and beside the screen.
    Frustum {
        /// The viewpoint.
        eye: [f32; 3],
        /// The point in the middle of the screen. The y axis is up there; where the eye looks along
        /// it, the z axis.
        target: [f32; 3],
        /// Tangents of half the angles that the screen shows, across and upwards.
        tangents: [f32; 2],
        /// The LOD on the screen.
        inside: Lod,
        /// The LOD elsewhere.
        outside: Lod,
    },
}

impl Criterion {
    /// The slope for [`Self::ScreenError`] at which an error covers `pixels` of a picture that is
    /// `height` pixels high and shows a vertical angle with this tangent of its half.
    #[must_use]
    pub fn slope(pixels: f32, height: f32, tan_half_angle: f32) -> f32 {
        pixels * 2.0 * tan_half_angle / height
    }

    /// One LOD everywhere.
    #[must_use]
    pub fn everywhere(lod: Lod) -> Self {
        Self::Region { low: [f32::MIN; 3], high: [f32::MAX; 3], inside: lod, outside: lod }
    }
}

/// A view: a criterion, and whether vertices move smoothly between LODs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewQuery {
    /// The rule.
    pub criterion: Criterion,
    /// True if positions are interpolated between the steps in which a group moves.
    pub morph: bool,
}
