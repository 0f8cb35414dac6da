//! How far two surfaces are apart: in space, by points spread over both and their distance to the
//! other, and in pictures taken from all sides. The instrument that simplifications are judged by;
//! it knows none of them.

mod bvh;
mod distance;
mod field;
mod picture;
mod scene;
mod spread;
mod surface;
mod texture;

pub use bvh::Bvh;
pub use distance::{Distances, Sampling, distances};
pub use field::DistanceField;
pub use picture::{ImageError, Looks, Picture, Viewing, compare_pictures, pictures};
pub use scene::SceneSurface;
pub use surface::Surface;
pub use texture::Pyramid;

#[cfg(test)]
mod tests;
