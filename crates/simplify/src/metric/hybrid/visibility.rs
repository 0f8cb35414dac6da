//! The visible share of each sample, over 20 cameras.

use super::samples::Samples;
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

/// Multiplies every sample's weight by its visible share: the mean projected area that is seen, 1
/// for one side of a surface with nothing in front of it. Both sides of a face are seen.
pub(super) fn weigh(mesh: &WorkingMesh, samples: &mut Samples) {
    let size = PIXELS_PER_FACE.saturating_mul(mesh.live_faces).isqrt();
    let size = size.clamp(*SIZES.start(), *SIZES.end());
    let cameras = cameras(mesh, size);
    let pictures: Vec<Vec<i32>> =
        cameras.par_iter().map(|camera| farthest_around(&depths(mesh, camera), size)).collect();
    let views = cameras.len() as f32;
    samples.scale_weights(mesh, |position, normal| {
        let seen = |(camera, picture): (&Camera, &Vec<i32>)| {
            let p = camera.project(position.as_dvec3());
            let pixel =
                (p.y.div_euclid(SUBPIXELS) * size as i32 + p.x.div_euclid(SUBPIXELS)) as usize;
            let is_seen = p.z <= picture[pixel].saturating_add(TOLERANCE);
            if is_seen { projected_share(normal, camera) } else { 0.0 }
        };
        // A plane is seen from half of all directions, on average at a cosine of one half.
        cameras.iter().zip(&pictures).map(seen).sum::<f32>() * 4.0 / views
    });
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

/// The greatest depth at every pixel and the eight around it, so that a sloping surface is not
/// taken for hidden by its own neighbourhood.
fn farthest_around(depths: &[i32], size: u32) -> Vec<i32> {
    let size = size as usize;
    let around = |pixel: usize, step: usize, at: usize, source: &[i32]| {
        let mut farthest = source[pixel];
        if at > 0 {
            farthest = farthest.max(source[pixel - step]);
        }
        if at + 1 < size {
            farthest = farthest.max(source[pixel + step]);
        }
        farthest
    };
    let rows: Vec<i32> = (0..depths.len()).map(|i| around(i, 1, i % size, depths)).collect();
    (0..depths.len()).map(|i| around(i, size, i / size, &rows)).collect()
}
