//! `KHR_texture_transform`: which texture coordinates a texture of a glTF material reads, and how
//! it moves them.

use super::json::Json;
use lodc_scene::Coordinates;

/// The name of the extension.
pub(crate) const TRANSFORM: &str = "KHR_texture_transform";
/// `CLAMP_TO_EDGE` of a sampler.
pub(crate) const CLAMP: u32 = 33071;

/// The texture coordinates that a texture reads.
pub(super) fn texture_coordinates(info: &Json) -> Coordinates {
    let moved = &info["extensions"][TRANSFORM];
    let set = moved["texCoord"].as_index().or(info["texCoord"].as_index()).unwrap_or(0);
    Coordinates { set: u32::try_from(set).unwrap_or(u32::MAX), transform: transform(moved) }
}

/// `KHR_texture_transform`: first scaled, then turned, then moved.
fn transform(source: &Json) -> [[f32; 3]; 2] {
    let [x, y] = source["offset"].numbers([0.0; 2]);
    let [sx, sy] = source["scale"].numbers([1.0; 2]);
    let (sine, cosine) = source["rotation"].as_f64().unwrap_or(0.0).sin_cos();
    [[cosine * sx, sine * sy, x], [-sine * sx, cosine * sy, y]].map(|row| row.map(|v| v as f32))
}
