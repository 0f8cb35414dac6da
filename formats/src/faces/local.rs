//! Positions that stand too far from the origin for single precision, as an offset and a local
//! mesh.

use crate::far::{Extent, MAX_ROUNDING, single};

/// The positions of corners; all positions without any. What no face uses may lie anywhere, and is
/// dropped.
fn shown<'a, T: Copy>(positions: &'a [T], corners: &'a [u32]) -> impl Iterator<Item = T> + Clone {
    let unused = if corners.is_empty() { positions } else { &[] };
    let of_corners = corners.iter().filter_map(|&corner| positions.get(corner as usize));
    of_corners.chain(unused).copied()
}

/// Returns whether single precision may round positions by more than a mesh should be off: those of
/// these corners, or all, of which loose points and lines have some.
pub(crate) fn may_be_far(positions: &[[f32; 3]], corners: &[u32]) -> bool {
    let is_far = |corners| {
        let shown = shown(positions, corners).map(|p| p.map(f64::from));
        Extent::of(shown).is_some_and(|e| e.is_far())
    };
    is_far(corners) || is_far(&[])
}

/// Returns an offset and the positions without it in single precision; none if those of the
/// corners, and all of them, are as exact without an offset.
pub(crate) fn local(positions: &[[f64; 3]], corners: &[u32]) -> Option<([f64; 3], Vec<[f32; 3]>)> {
    let rounding = |c: f64| (c - f64::from(single(c))).abs();
    let is_exact = |corners: &[u32], diagonal: f64| {
        let largest = shown(positions, corners).flatten().map(rounding).fold(0.0, f64::max);
        largest <= MAX_ROUNDING * diagonal
    };
    let extent = Extent::of(shown(positions, corners))?;
    let (Extent { low, high }, diagonal) = (extent, extent.diagonal());
    if is_exact(corners, diagonal) && is_exact(&[], Extent::of(shown(positions, &[]))?.diagonal()) {
        return None;
    }
    // A multiple of a power of two between an eighth and a quarter of the size: few digits, and the
    // same for most levels of an object.
    let step = (diagonal.log2().floor() - 2.0).exp2();
    let offset = std::array::from_fn(|k| (f64::midpoint(low[k], high[k]) / step).round() * step);
    if !offset.iter().all(|c: &f64| c.is_finite()) {
        return None;
    }
    let moved = |p: &[f64; 3]| std::array::from_fn(|k| single(p[k] - offset[k]));
    Some((offset, positions.iter().map(moved).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_mesh_is_exact_to_a_ten_millionth_of_its_size() {
        for (far, size) in [(4_649_776.123, 3.7), (1e9, 1e-3), (-3e5, 10.0), (1e15, 1.0)] {
            let at = |i: u32, k: f64| far * k + size * f64::from(i * 7919 % 1000) / 1000.0;
            let exact: Vec<[f64; 3]> =
                (0..500).map(|i| [at(i, 1.0), at(i * 3, 0.5), at(i * 7, -0.25)]).collect();
            let (offset, local) = local(&exact, &[]).expect("far from the origin");
            for (exact, local) in exact.iter().zip(&local) {
                for k in 0..3 {
                    let off = (exact[k] - (offset[k] + f64::from(local[k]))).abs();
                    assert!(off <= 1e-7 * size + far.abs() * f64::EPSILON, "{far}: {off}");
                }
            }
        }
    }

    #[test]
    fn what_single_precision_holds_stays_as_it_is() {
        let near = [[1.5, 2.25, -8.0], [3.0, 2.5, -7.0], [1e6, 0.0, 0.25]];
        assert_eq!(local(&near, &[]), None);
        // Far, but exact.
        assert_eq!(local(&[[1e6, 0.0, 0.0], [1e6 + 1.0, 1.0, 0.0]], &[]), None);
        assert_eq!(local(&[], &[]), None);
    }

    #[test]
    fn vertices_that_no_face_uses_do_not_count() {
        let site = |k: f64| [500_000.1 + k, 5_550_123.2 + 2.0 * k, 0.3 * k];
        let exact = [[0.0; 3], site(0.0), site(1.7), [1e9, 0.0, 0.0], site(-2.9)];
        let (offset, moved) = local(&exact, &[1, 2, 4]).expect("far from the origin");
        for v in [1, 2, 4] {
            for k in 0..3 {
                let off = (exact[v][k] - (offset[k] + f64::from(moved[v][k]))).abs();
                assert!(off < 1e-6, "{off}");
            }
        }
        let single = exact.map(|p| p.map(single));
        assert!(may_be_far(&single, &[1, 2, 4]) && !may_be_far(&single, &[]));
    }
}
