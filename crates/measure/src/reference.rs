//! Pictures of a reference surface from all sides, kept so that other surfaces can be compared with
//! it.

use crate::picture::{
    Difference, ImageError, Picture, ShadedSurface, ShadingOptions, Viewing, compare_pictures,
    image_error, pictures,
};
use crate::surface::Surface;
use lodc_raster::Camera;
use rayon::prelude::*;

/// Pictures of a surface from all sides, and how they were taken.
#[derive(Clone, Debug)]
pub struct ReferencePictures {
    cameras: Vec<Camera>,
    shading: ShadingOptions,
    pictures: Vec<Picture>,
}

impl ReferencePictures {
    /// Takes the pictures.
    #[must_use]
    pub fn new(surface: &Surface, viewing: Viewing, shading: ShadingOptions) -> Self {
        let cameras = viewing.cameras(surface);
        let shaded = ShadedSurface::new(surface, &[shading]);
        let pictures = cameras.par_iter().map(|camera| shaded.picture(camera)).collect();
        Self { cameras, shading, pictures }
    }

    /// How the pictures are shaded.
    #[must_use]
    pub fn shading(&self) -> ShadingOptions {
        self.shading
    }

    /// Takes the same pictures of another surface.
    #[must_use]
    pub fn pictures_of(&self, other: &Surface) -> Vec<Picture> {
        pictures(other, &self.cameras, self.shading)
    }

    /// Compares another surface.
    #[must_use]
    pub fn compare(&self, other: &Surface) -> ImageError {
        let shaded = ShadedSurface::new(other, &[self.shading]);
        let references = self.cameras.par_iter().zip(&self.pictures);
        let difference = |(camera, picture)| Difference::new(picture, &shaded.picture(camera));
        image_error(references.map(difference).collect::<Vec<_>>().into_iter())
    }

    /// Compares the pictures of another surface, taken by [`Self::pictures_of`].
    #[must_use]
    pub fn compare_pictures(&self, others: &[Picture]) -> ImageError {
        compare_pictures(&self.pictures, others)
    }
}

/// Pictures of a surface of several kinds, from some sides.
#[derive(Clone, Debug)]
pub struct ReferenceKinds {
    cameras: Vec<Camera>,
    kinds: Vec<ShadingOptions>,
    /// For each camera a picture of each kind.
    pictures: Vec<Vec<Picture>>,
}

impl ReferenceKinds {
    /// Takes the pictures, of at least one kind. The first says which normals all are shaded by.
    #[must_use]
    pub fn new(surface: &Surface, viewing: Viewing, kinds: Vec<ShadingOptions>) -> Self {
        let cameras = viewing.cameras(surface);
        let shaded = ShadedSurface::new(surface, &kinds);
        let pictures = cameras.par_iter().map(|camera| shaded.kinds(camera)).collect();
        Self { cameras, kinds, pictures }
    }

    /// Compares another surface: the differences by kind.
    #[must_use]
    pub fn compare(&self, other: &Surface) -> Vec<Difference> {
        let shaded = ShadedSurface::new(other, &self.kinds);
        let of_camera = |(camera, pictures): (&Camera, &Vec<Picture>)| -> Vec<Difference> {
            let others = shaded.kinds(camera);
            pictures.iter().zip(&others).map(|(a, b)| Difference::new(a, b)).collect()
        };
        let by_camera: Vec<Vec<Difference>> =
            self.cameras.par_iter().zip(&self.pictures).map(of_camera).collect();
        let of_kind =
            |kind| by_camera.iter().map(|d| d[kind]).fold(Difference::default(), Difference::and);
        (0..self.kinds.len()).map(of_kind).collect()
    }
}
