//! The area of every face of a scene that is seen from all sides.

use glam::DVec3;
use lodc_raster::{Camera, Fragment, Point, Window, scan, spread_cameras};
use rayon::prelude::*;

/// Cameras around the scene.
const VIEWS: u32 = 24;
/// Pixels across and down.
const SIZE: u32 = 512;

/// A surface that may hide others.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Corners in world space.
    pub(crate) triangles: Vec<[DVec3; 3]>,
}

/// Returns four times the mean area that each triangle of each part shows in pictures from all
/// sides: its own area if nothing hides it and it is seen from one side.
pub(crate) fn seen_areas(parts: &[Part]) -> Vec<Vec<f64>> {
    let corners = || parts.iter().flat_map(|p| p.triangles.as_flattened());
    let lo = corners().fold(DVec3::INFINITY, |lo, p| lo.min(*p));
    let hi = corners().fold(DVec3::NEG_INFINITY, |hi, p| hi.max(*p));
    let count: usize = parts.iter().map(|p| p.triangles.len()).sum();
    let center = 0.5 * (lo + hi);
    let radius = corners().map(|p| p.distance(center)).fold(0.0, f64::max);
    let mut pixels = vec![0u32; count];
    // The length of a pixel's side, the same for all cameras.
    let mut pixel = 0.0;
    if radius > 0.0 && radius.is_finite() {
        let cameras = spread_cameras(VIEWS, center, radius, SIZE);
        pixel = 1.0 / cameras[0].scale;
        // A few pictures at a time: each has a depth for every pixel.
        for views in cameras.chunks(4) {
            let fronts: Vec<Vec<Fragment>> = views.par_iter().map(|c| picture(parts, c)).collect();
            for fragment in fronts.iter().flatten().filter(|f| **f != Fragment::NOTHING) {
                pixels[fragment.item() as usize] += 1;
            }
        }
    }
    let area = 4.0 * pixel * pixel / f64::from(VIEWS);
    let mut first = 0;
    let mut of_part = |part: &Part| -> Vec<f64> {
        let range = first..first + part.triangles.len();
        first = range.end;
        pixels[range].iter().map(|&n| f64::from(n) * area).collect()
    };
    parts.iter().map(&mut of_part).collect()
}

fn picture(parts: &[Part], camera: &Camera) -> Vec<Fragment> {
    let mut front = vec![Fragment::NOTHING; (SIZE * SIZE) as usize];
    let triangles = parts.iter().flat_map(|p| &p.triangles);
    for (number, triangle) in (0..).zip(triangles) {
        let points: [Point; 3] = triangle.map(|p| camera.project(p));
        scan(points, Window::whole(SIZE), |column, row, depth| {
            let nearest = &mut front[(row * SIZE as i32 + column) as usize];
            *nearest = Fragment::new(number, depth).min(*nearest);
        });
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(half: f64) -> Part {
        let mesh = lodc_fixtures::named("cube").expect("a shape");
        let lo = mesh.positions().iter().flatten().fold(f32::INFINITY, |l, c| l.min(*c));
        let hi = mesh.positions().iter().flatten().fold(f32::NEG_INFINITY, |h, c| h.max(*c));
        let middle = 0.5 * f64::from(lo + hi);
        let scale = 2.0 * half / f64::from(hi - lo);
        let at =
            |v: u32| (DVec3::from(mesh.positions()[v as usize].map(f64::from)) - middle) * scale;
        Part { triangles: mesh.triangles().iter().map(|t| t.map(at)).collect() }
    }

    #[test]
    fn what_is_inside_is_not_seen_and_what_is_outside_has_its_area() {
        let seen = seen_areas(&[cube(1.0), cube(0.5)]);
        let total: f64 = seen[0].iter().sum();
        assert!((total - 24.0).abs() < 1.5, "{total}");
        assert_eq!(seen[1].iter().sum::<f64>(), 0.0);
        assert!(seen_areas(&[]).is_empty());
    }
}
