//! Cameras around a mesh, a rasteriser that counts pixels exactly, and lists of everything behind
//! every pixel.
//!
//! Points are snapped to a grid of 256ths of a pixel and edges are decided in integers, so a
//! watertight surface covers every pixel centre exactly once, and the same picture comes out on
//! every machine.

mod camera;
mod layers;
mod triangle;

pub use camera::{Camera, Point, SUBPIXELS, metric_cameras, spread_cameras};
pub use layers::{Fragment, Layers};
pub use triangle::{Window, scan};

#[cfg(test)]
mod tests;
