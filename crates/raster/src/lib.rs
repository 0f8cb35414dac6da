//! Cameras around a mesh, a rasteriser that covers pixels exactly, and lists of all fragments at
//! each pixel.
//!
//! Points are snapped to a grid of 256ths of a pixel and edges are decided in integers, so a
//! watertight surface covers every pixel centre exactly once, and the same picture comes out on
//! every machine.
//!
//! ```
//! use lodc_raster::{Camera, Window, scan};
//!
//! // Half of a square, in a picture of 64 by 64 pixels.
//! let camera = Camera::new([0.0, 0.0, 1.0].into(), [0.0; 3].into(), 1.0, 64);
//! let corners = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0]];
//! let corners = corners.map(|corner| camera.project(corner.into()));
//! let mut pixels = 0;
//! scan(corners, Window::whole(64), |_x, _y, _depth| pixels += 1);
//! let area = (camera.scale * camera.scale / 2.0) as i32;
//! assert!((pixels - area).abs() <= 32, "{pixels} pixels for an area of {area}");
//! ```

mod camera;
mod layers;
mod triangle;

pub use camera::{Camera, Point, SUBPIXELS, metric_cameras, spread_cameras};
pub use layers::{Fragment, Layers};
pub use triangle::{Window, scan};

#[cfg(test)]
mod tests;
