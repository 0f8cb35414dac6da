//! Measures how two surfaces differ: in space, by distances of points on either from the other, and
//! in pictures taken from all sides. Simplifications are judged by it; it knows none of them.
//!
//! ```
//! use lodc_measure::{
//!     Sampling, ShadingOptions, Surface, Viewing, compare_pictures, distances, pictures,
//! };
//!
//! let square = |z: f32| Surface {
//!     positions: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
//!         .map(|[x, y]| glam::Vec3::new(x, y, z))
//!         .to_vec(),
//!     triangles: vec![[0, 1, 2], [0, 2, 3]],
//!     ..Surface::default()
//! };
//! let (a, b) = (square(0.0), square(0.25));
//! let apart = distances(&a, &b, &Sampling::DEFAULT);
//! assert!((apart.hausdorff[0] - 0.25).abs() < 1e-9 && (apart.rms[1] - 0.25).abs() < 1e-9);
//!
//! let cameras = Viewing { views: 6, size: 64 }.cameras(&a);
//! let shown = pictures(&a, &cameras, ShadingOptions::default());
//! assert_eq!(compare_pictures(&shown, &shown).rmse, 0.0);
//! ```

mod baseline;
mod beyond;
mod colours;
mod distance;
mod field;
mod heat;
mod picture;
mod reference;
pub mod render;
mod scene;
mod spread;
mod surface;
mod texture;

pub use baseline::{Numbers, Recorded, Regression};
pub use beyond::share_beyond;
pub use colours::{distinct, heat};
pub use distance::{Distances, Original, Sampling, distances};
pub use field::DistanceField;
pub use heat::heat_sheet;
pub use lodc_nearest::{TriangleTree, distance_squared};
pub use picture::{
    Difference, ImageError, Picture, ShadingOptions, Viewing, compare_pictures, pictures,
};
pub use reference::{ReferenceKinds, ReferencePictures};
pub use scene::SceneSurface;
pub use surface::Surface;
pub use texture::Pyramid;

#[cfg(test)]
mod tests;
