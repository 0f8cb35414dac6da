//! The share of a surface that is farther from another one than a distance, by samples.

use crate::spread::over_weights;
use crate::surface::Surface;
use lodc_mesh::NONE;
use lodc_nearest::TriangleTree;
use rayon::prelude::*;

/// Sampled points. Chosen by hand: a share is then known to about a hundredth.
const SAMPLES: usize = 4096;
/// The seed of the points: any number ("gone" in ASCII).
const SEED: u64 = 0x676f_6e65;
/// Points of one parallel task. Chosen by hand; results do not depend on it.
const TASK_POINTS: usize = 256;

/// The share of a surface that is farther than `distance` from another one; triangles count by
/// their weights. 0 if nothing has weight, all if the other surface has no triangle. Too small
/// where [`TriangleTree::may_be_within`] gives up its search.
#[must_use]
pub fn share_beyond(
    surface: &Surface,
    weights: &[f64],
    other: &TriangleTree,
    distance: f64,
) -> f64 {
    let points = over_weights(surface, weights, SAMPLES, SEED);
    // Slices follow the triangles, so the triangle near one point is often near the next.
    let count_far = |run: &[(_, u32)]| {
        let mut hint = NONE;
        let is_far =
            |&&(point, _): &&(_, u32)| !other.may_be_within(point, distance * distance, &mut hint);
        run.iter().filter(is_far).count()
    };
    points.par_chunks(TASK_POINTS).map(count_far).sum::<usize>() as f64 / points.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_a_square_is_far_from_its_other_half() {
        let corner = |i: u16| glam::Vec3::new(f32::from(i & 1), f32::from(i >> 1), 0.0);
        let square = Surface {
            positions: (0..4).map(corner).collect(),
            triangles: vec![[0, 1, 2], [1, 3, 2]],
            ..Surface::default()
        };
        let half = Surface { triangles: vec![[0, 1, 2]], ..square.clone() };
        let share = |weights, other: &Surface| share_beyond(&square, weights, &other.tree(), 1e-6);
        assert!((share(&[1.0, 1.0], &half) - 0.5).abs() < 0.01);
        assert!((share(&[1.0, 3.0], &half) - 0.75).abs() < 0.01);
        assert_eq!(share(&[1.0, 1.0], &square), 0.0);
        assert_eq!(share(&[1.0, 1.0], &Surface::default()), 1.0);
        assert_eq!(share(&[0.0, 0.0], &half), 0.0);
    }
}
