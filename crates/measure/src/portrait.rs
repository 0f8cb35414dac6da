//! Pictures of one surface, for others to be compared with.

use crate::picture::{ImageError, Picture, ShadingOptions, Viewing, compare_pictures, pictures};
use crate::surface::Surface;
use lodc_raster::Camera;

/// A surface as it is seen from all sides.
#[derive(Clone, Debug)]
pub struct Portrait {
    cameras: Vec<Camera>,
    looks: ShadingOptions,
    pictures: Vec<Picture>,
}

impl Portrait {
    /// Takes the pictures.
    #[must_use]
    pub fn new(surface: &Surface, viewing: Viewing, looks: ShadingOptions) -> Self {
        let cameras = viewing.cameras(surface);
        let pictures = pictures(surface, &cameras, looks);
        Self { cameras, looks, pictures }
    }

    /// The looks that are shown.
    #[must_use]
    pub fn looks(&self) -> ShadingOptions {
        self.looks
    }

    /// Takes the same pictures of another surface.
    #[must_use]
    pub fn pictures_of(&self, other: &Surface) -> Vec<Picture> {
        pictures(other, &self.cameras, self.looks)
    }

    /// Compares another surface.
    #[must_use]
    pub fn compare(&self, other: &Surface) -> ImageError {
        self.compare_pictures(&self.pictures_of(other))
    }

    /// Compares the pictures of another surface, taken by [`Self::pictures_of`].
    #[must_use]
    pub fn compare_pictures(&self, others: &[Picture]) -> ImageError {
        compare_pictures(&self.pictures, others)
    }
}
