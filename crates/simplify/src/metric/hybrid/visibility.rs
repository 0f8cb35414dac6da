//! The visible share of each sample, over 20 cameras, and the layer that it must not pass.

use super::DISTANCE_SHARE;
use super::samples::{Layer, Sample, Samples};
use crate::cut::WorkingMesh;
use crate::metric::reevaluate::cameras;
use glam::Vec3;
use lodc_raster::{Camera, SUBPIXELS, Window, scan};
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Limits of the width, in pixels, of the pictures that say what is hidden. Chosen by hand.
const SIZES: RangeInclusive<u32> = 64..=512;
/// Pixels of a picture for each face of the mesh, within those limits. Chosen by hand.
const PIXELS_PER_FACE: u32 = 20;
/// A sample is visible if it is at most this far behind the nearest surface around it, in the depth
/// unit of cameras: half a pixel. So faces that coincide do not hide each other.
const TOLERANCE: i32 = 512;
/// Cameras tell of layers above a surface if they look at it from at most 45°.
const LEAST_COSINE: f32 = 0.7;

/// Multiplies every sample's weight by its visible share: the mean projected area that is seen, 1
/// for one side of a surface with nothing in front of it. Both sides of a face are seen. Stores its
/// layer, too.
pub(super) fn weigh(mesh: &WorkingMesh, samples: &mut Samples, diagonal: f64) {
    let size = PIXELS_PER_FACE.saturating_mul(mesh.live_faces).isqrt();
    let size = size.clamp(*SIZES.start(), *SIZES.end());
    let cameras = cameras(mesh, size);
    let pictures: Vec<Vec<i32>> =
        cameras.par_iter().map(|camera| around(&depths(mesh, camera), size, i32::max)).collect();
    let views = cameras.len() as f32;
    samples.set_layers(layers(&cameras, &pictures, samples, diagonal));
    samples.scale_weights(mesh, |position, normal| {
        let seen = |(camera, picture): (&Camera, &Vec<i32>)| {
            let is_seen = is_seen(pixel(camera, position), picture);
            if is_seen { projected_share(normal, camera) } else { 0.0 }
        };
        // A plane is seen from half of all directions, on average at a cosine of one half.
        cameras.iter().zip(&pictures).map(seen).sum::<f32>() * 4.0 / views
    });
}

/// The pixel that a camera sees a point in, and its depth.
fn pixel(camera: &Camera, position: Vec3) -> (usize, i32) {
    let p = camera.project(position.as_dvec3());
    let [column, row] = [p.x, p.y].map(|x| x.div_euclid(SUBPIXELS));
    ((row * camera.size as i32 + column) as usize, p.z)
}

/// Whether nothing is before what is in a pixel at a depth, by the depths that the camera sees.
fn is_seen((pixel, depth): (usize, i32), depths: &[i32]) -> bool {
    depth <= depths[pixel].saturating_add(TOLERANCE)
}

/// For every sample the layer that hides it, or else the one that it hides, both facing the same
/// way: water and the bed of a pond. Sides that face away belong to the same body, or are not seen.
fn layers(cameras: &[Camera], pictures: &[Vec<i32>], samples: &Samples, size: f64) -> Vec<Layer> {
    let all = samples.all();
    let most = (DISTANCE_SHARE * size) as f32;
    // Samples that no camera sees, with the least distance to what hides them.
    let hidden = |s: &Sample| {
        let mut nearest = None;
        for (camera, depths) in cameras.iter().zip(pictures) {
            let Some(view) = View::new(camera, s) else { continue };
            if view.is_seen(depths) {
                return None;
            }
            let before = view.along(camera, depths[view.pixel], view.depth);
            nearest = Some(nearest.map_or(before, |n: f32| n.min(before)));
        }
        nearest
    };
    let hidden: Vec<Option<f32>> = all.par_iter().with_min_len(1024).map(hidden).collect();
    // What lies next behind the surface that each camera sees.
    let next = |camera: &Camera| {
        let mut depths = vec![i32::MAX; (camera.size * camera.size) as usize];
        for (s, _) in all.iter().zip(&hidden).filter(|(_, hidden)| hidden.is_some()) {
            if let Some(View { pixel, depth, .. }) = View::new(camera, s) {
                depths[pixel] = depth.min(depths[pixel]);
            }
        }
        around(&depths, camera.size, i32::min)
    };
    let next: Vec<Vec<i32>> = cameras.par_iter().map(next).collect();
    let layer = |(s, hidden): (&Sample, &Option<f32>)| {
        if let Some(before) = hidden {
            return Layer::in_front(*before, most);
        }
        let mut nearest = f32::INFINITY;
        for ((camera, depths), next) in cameras.iter().zip(pictures).zip(&next) {
            let Some(view) = View::new(camera, s).filter(|view| view.is_seen(depths)) else {
                continue;
            };
            let behind = next[view.pixel];
            if behind > view.depth && behind < i32::MAX {
                nearest = nearest.min(view.along(camera, view.depth, behind));
            }
        }
        if nearest.is_finite() { Layer::behind(nearest, most) } else { Layer::default() }
    };
    all.par_iter().zip(&hidden).with_min_len(1024).map(layer).collect()
}

/// A sample in a camera's picture.
struct View {
    /// Between its normal and the direction to the camera.
    cosine: f32,
    pixel: usize,
    depth: i32,
}

impl View {
    /// None if the camera looks at the sample from aside or behind.
    fn new(camera: &Camera, s: &Sample) -> Option<Self> {
        let cosine = s.normal.dot(camera.toward.as_vec3());
        // Most samples end here, before they are projected.
        (cosine > LEAST_COSINE).then(|| {
            let (pixel, depth) = pixel(camera, s.position);
            Self { cosine, pixel, depth }
        })
    }

    fn is_seen(&self, depths: &[i32]) -> bool {
        is_seen((self.pixel, self.depth), depths)
    }

    /// The distance along the normal between two depths.
    fn along(&self, camera: &Camera, from: i32, to: i32) -> f32 {
        let steps = f64::from(to) - f64::from(from);
        (steps / camera.depth_steps()) as f32 * self.cosine
    }
}

/// The share of a face's area that a camera sees.
fn projected_share(normal: Vec3, camera: &Camera) -> f32 {
    normal.dot(camera.toward.as_vec3()).abs()
}

/// The least depth at every pixel.
fn depths(mesh: &WorkingMesh, camera: &Camera) -> Vec<i32> {
    let size = camera.size;
    let mut depths = vec![i32::MAX; (size * size) as usize];
    for f in &mesh.faces {
        let corners = f.groups.map(|g| camera.project(mesh.position(g)));
        scan(corners, Window::whole(size), |column, row, depth| {
            let nearest = &mut depths[(row * size as i32 + column) as usize];
            *nearest = depth.min(*nearest);
        });
    }
    depths
}

/// For every pixel the depth at it and the eight around it that `pick` chooses of two: the
/// greatest, so that a sloping surface is not taken for hidden by its own neighbourhood, or the
/// least, where few pixels have one.
fn around(depths: &[i32], size: u32, pick: fn(i32, i32) -> i32) -> Vec<i32> {
    let size = size as usize;
    let pick_of_three = |pixel: usize, step: usize, at: usize, source: &[i32]| {
        let mut picked = source[pixel];
        if at > 0 {
            picked = pick(picked, source[pixel - step]);
        }
        if at + 1 < size {
            picked = pick(picked, source[pixel + step]);
        }
        picked
    };
    let rows: Vec<i32> = (0..depths.len()).map(|i| pick_of_three(i, 1, i % size, depths)).collect();
    (0..depths.len()).map(|i| pick_of_three(i, size, i / size, &rows)).collect()
}
