//! The visible area of every triangle of a scene, by pictures from cameras all around.

use glam::DVec3;
use lodc_raster::{Camera, Fragment, Point, Window, scan, spread_cameras};
use rayon::prelude::*;

/// Cameras around the scene. Chosen by hand, as is the size of their pictures.
const VIEWS: u32 = 24;
/// Pixels of a picture, across and down.
const SIZE: u32 = 512;
/// Pictures that are drawn at one time, each with a depth buffer. Chosen by hand, to bound memory.
const PICTURES_AT_ONCE: usize = 4;

/// A surface that may hide others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<'a> {
    /// Vertices in world space.
    pub(crate) positions: &'a [DVec3],
    /// Triangles between them.
    pub(crate) triangles: &'a [[u32; 3]],
}

impl Part<'_> {
    /// The corners of all triangles.
    fn corners(&self) -> impl Iterator<Item = DVec3> {
        self.triangles.as_flattened().iter().map(|&v| self.positions[v as usize])
    }
}

/// Returns for each triangle of each part the area of it that is visible, in square world units:
/// four times the mean area that it takes in pictures from all sides. A triangle that nothing hides
/// covers half its area on average, so that a closed convex surface, which hides one side of each,
/// gets its own area; what both sides of a triangle show counts twice. All are 0 if the parts have
/// no extent or one that is not finite.
pub(crate) fn visible_areas(parts: &[Part<'_>]) -> Vec<Vec<f64>> {
    let corners = || parts.iter().flat_map(|p| p.corners());
    let lo = corners().fold(DVec3::INFINITY, DVec3::min);
    let hi = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
    let count: usize = parts.iter().map(|p| p.triangles.len()).sum();
    let centre = 0.5 * (lo + hi);
    let radius = corners().map(|p| p.distance(centre)).fold(0.0, f64::max);
    // For each triangle of all parts, one after another, the pixels of all pictures that show it.
    let mut pixels = vec![0u32; count];
    // The length of a pixel's side in world units, the same for all cameras.
    let mut pixel = 0.0;
    if radius > 0.0 && radius.is_finite() {
        let cameras = spread_cameras(VIEWS, centre, radius, SIZE);
        pixel = 1.0 / cameras[0].scale;
        let empty = vec![Fragment::NOTHING; (SIZE * SIZE) as usize];
        let mut depth_buffers = vec![empty; PICTURES_AT_ONCE];
        for views in cameras.chunks(depth_buffers.len()) {
            views
                .par_iter()
                .zip(&mut depth_buffers)
                .for_each(|(camera, depth_buffer)| draw(parts, camera, depth_buffer));
            for fragment in depth_buffers[..views.len()].iter_mut().flatten() {
                let nearest = std::mem::replace(fragment, Fragment::NOTHING);
                if nearest != Fragment::NOTHING {
                    pixels[nearest.item() as usize] += 1;
                }
            }
        }
    }
    // What one pixel of one picture adds.
    let area = 4.0 * pixel * pixel / f64::from(VIEWS);
    let mut areas = Vec::with_capacity(parts.len());
    let mut rest = &pixels[..];
    for part in parts {
        let (of_part, others) = rest.split_at(part.triangles.len());
        areas.push(of_part.iter().map(|&n| f64::from(n) * area).collect());
        rest = others;
    }
    areas
}

/// Draws all parts into an empty depth buffer: for each pixel the nearest triangle, by its number
/// over all parts.
fn draw(parts: &[Part<'_>], camera: &Camera, depth_buffer: &mut [Fragment]) {
    let mut number = 0;
    for part in parts {
        let points: Vec<Point> = part.positions.iter().map(|&p| camera.project(p)).collect();
        for triangle in part.triangles {
            let corners = triangle.map(|v| points[v as usize]);
            scan(corners, Window::whole(SIZE), |column, row, depth| {
                let nearest = &mut depth_buffer[(row * SIZE as i32 + column) as usize];
                *nearest = Fragment::new(number, depth).min(*nearest);
            });
            number += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::Mesh;

    fn cube(mesh: &Mesh, half: f64) -> Vec<DVec3> {
        let lo = mesh.positions().iter().flatten().fold(f32::INFINITY, |l, c| l.min(*c));
        let hi = mesh.positions().iter().flatten().fold(f32::NEG_INFINITY, |h, c| h.max(*c));
        let middle = 0.5 * f64::from(lo + hi);
        let scale = 2.0 * half / f64::from(hi - lo);
        let at = |p: &[f32; 3]| (DVec3::from(p.map(f64::from)) - middle) * scale;
        mesh.positions().iter().map(at).collect()
    }

    #[test]
    fn what_is_inside_is_not_seen_and_what_is_outside_has_its_area() {
        let mesh = lodc_fixtures::named("cube").expect("a shape");
        let cubes = [1.0, 0.5].map(|half| cube(&mesh, half));
        let part = |positions| Part { positions, triangles: mesh.triangles() };
        let seen = visible_areas(&[part(&cubes[0]), part(&cubes[1])]);
        let total: f64 = seen[0].iter().sum();
        assert!((total - 24.0).abs() < 1.5, "{total}");
        assert_eq!(seen[1].iter().sum::<f64>(), 0.0);
        assert!(visible_areas(&[]).is_empty());
    }
}
