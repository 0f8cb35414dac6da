//! The colours of a surface, for metrics that see it.

use lodc_mesh::{Mesh, Semantic};

/// Colours of the submeshes of one mesh, by texture coordinates.
pub trait SurfaceColours: Sync {
    /// The set of texture coordinates that a submesh is coloured by, if any.
    fn set(&self, submesh: u32) -> Option<u32>;

    /// The colour of a submesh at texture coordinates, averaged over a `footprint` in squared units
    /// of texture space. Red, green and blue as shown, 0 to 1.
    fn at(&self, submesh: u32, coordinates: [f32; 2], footprint: f32) -> [f32; 3];
}

/// Squares in a unit of texture coordinates, each way, and the shade of the dark ones.
const SQUARES: f32 = 16.0;
const DARK: f32 = 0.5;

/// White surfaces; with texture coordinates everywhere a checkerboard that shows where they slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checkerboard {
    is_shown: bool,
}

impl Checkerboard {
    /// A checkerboard if every submesh with triangles has texture coordinates.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let mut shown = mesh.submeshes().iter().filter(|s| !s.triangles().is_empty());
        let has = |a: &u32| {
            let a = &mesh.attributes()[*a as usize];
            a.semantic == Semantic::TexCoord(0) && a.morph_target.is_none()
        };
        Self { is_shown: shown.all(|s| s.attributes.iter().any(has)) }
    }
}

impl SurfaceColours for Checkerboard {
    fn set(&self, _submesh: u32) -> Option<u32> {
        self.is_shown.then_some(0)
    }

    fn at(&self, _submesh: u32, coordinates: [f32; 2], footprint: f32) -> [f32; 3] {
        if !self.is_shown {
            return [1.0; 3];
        }
        // A triangle wave is the integral of light and dark stripes.
        let width = (footprint.sqrt() * SQUARES).clamp(1e-3, 16.0);
        let wave = |x: f32| {
            let x = x * 0.5;
            ((x - x.floor()) * 2.0 - 1.0).abs()
        };
        let stripes = coordinates.map(|x| {
            let x = if x.is_finite() { x * SQUARES } else { 0.0 };
            (wave(x + 0.5 * width) - wave(x - 0.5 * width)) / width
        });
        let light = 0.5 + 0.5 * stripes[0] * stripes[1];
        [DARK + (1.0 - DARK) * light; 3]
    }
}
