//! Pictures: triangles, materials and a camera become pixels, off screen. Which triangles are shown
//! is decided before; [`Scene`] poses them and gives them normals and colours.
//!
//! Pictures are drawn at twice their size with four samples for each pixel, and halved in linear
//! light. On one machine the same input gives the same bytes; drivers differ by a shade at edges.

mod camera;
mod frame;
#[cfg(feature = "sheets")]
mod label;
mod painter;
mod pixels;
mod scene;
#[cfg(feature = "sheets")]
mod sheet;

pub use camera::{Camera, Framing, Lens, Up, Viewpoint};
pub use frame::Frame;
pub use painter::Painter;
#[cfg(test)]
pub(crate) use pixels::read_back;
pub use scene::{Colours, Division, Level, Scene};
#[cfg(feature = "sheets")]
pub use sheet::{Legend, Sheet};

/// A corner of a triangle. Three in a row are one, counter-clockwise from outside.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
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
