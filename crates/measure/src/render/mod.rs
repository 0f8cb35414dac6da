//! Pictures for people: triangles, materials and a camera become pixels. Which triangles are shown
//! is decided before; [`Scene`] poses them and gives them normals and colours.
//!
//! A pixel has 16 samples, no two of them in one row or column. Which triangle each of them sees is
//! decided in integers by [`lodc_raster::scan`]; colours are computed for each quarter of a pixel
//! and averaged in linear light. Everything is computed from sums, products, quotients and square
//! roots, so that the same bytes come out on every machine and for any number of threads.

mod angles;
mod camera;
mod painter;
mod projection;
mod scene;
mod shader;

pub use camera::{Camera, Framing, Lens, Up, Viewpoint};
pub use painter::{Painter, Run};
pub use scene::{Colours, DrawnMesh, Scene, Subdivision};

/// A corner of a triangle. Three in a row are one, counter-clockwise from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corner {
    /// Relative to the camera's centre ([`Camera::centre`]), in the scene's units.
    pub position: [f32; 3],
    /// Of any length but zero.
    pub normal: [f32; 3],
    /// Texture coordinates, the first row of texels at 0.
    pub uv: [f32; 2],
    /// Linear colour and opacity, multiplied with those of the material.
    pub colour: [f32; 4],
}

/// The treatment of triangles that turn their back to the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackFaces {
    /// As their material says.
    #[default]
    AsMaterial,
    /// All are drawn.
    Shown,
    /// None is drawn.
    Hidden,
    /// All are drawn, in a colour that warns.
    Marked,
}

/// Settings of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Pixels, across and down.
    pub size: [u32; 2],
    /// sRGB colour and opacity behind everything, 0 to 1.
    pub background: [f32; 4],
    /// Back faces.
    pub back_faces: BackFaces,
    /// Width of the edges drawn over the triangles, in pixels; none are drawn at 0.
    pub wire: f32,
}

#[cfg(test)]
mod tests;
