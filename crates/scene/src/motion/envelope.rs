//! The envelope of linear maps: one that makes no vector shorter than any of them does.
//!
//! Eᵀ maps the unit ball to the ellipsoid of least volume that contains its images under all Mᵀ,
//! which are ellipsoids about the origin. It is found by moving weight to the point that is
//! farthest outside (Khachiyan 1996). E makes a vector at most √3 times as long as the longest of
//! its images.

use crate::transform::largest_stretch;
use glam::{DMat3, DVec3};

/// The ellipsoid may be this much larger than the least. Chosen by hand.
const TOLERANCE: f64 = 1.01;
/// Searches of one map for its farthest point, all steps together. Chosen by hand: some
/// milliseconds.
const SEARCHES: usize = 8_000;
/// Fewest steps. Chosen by hand.
const MIN_STEPS: usize = 8;
/// Most steps. Chosen by hand.
const MAX_STEPS: usize = 256;
/// Axes shorter than this share of the ellipsoid's size are lengthened to it. Chosen by hand: small
/// enough for errors, large enough to compute with.
const MIN_STRETCH: f64 = 1e-6;

/// Returns a map E with |E v| ≥ |M v| for every vector v and each of some maps M; none if all are
/// zero, or some are not finite.
pub(super) fn envelope(maps: &[DMat3]) -> Option<DMat3> {
    let entries = maps.iter().flat_map(DMat3::to_cols_array);
    let size = entries.fold(0.0f64, |most, x| most.max(x.abs()));
    if size == 0.0 || !size.is_finite() || !maps.iter().all(DMat3::is_finite) {
        return None;
    }
    let maps: Vec<DMat3> = maps.iter().map(|m| *m * (1.0 / size)).collect();
    let grams = maps.iter().fold(DMat3::ZERO, |sum, m| sum + m.transpose() * *m);
    // The weighted mean of p pᵀ over points p of those ellipsoids. In three dimensions the squared
    // distance of the farthest point is 3 at the optimum.
    let mut spread = grams * (1.0 / (3.0 * maps.len() as f64));
    let steps = (SEARCHES / maps.len()).clamp(MIN_STEPS, MAX_STEPS);
    let mut least: Option<DMat3> = None;
    for _ in 0..steps {
        let inverse = regularised(&spread).inverse();
        let (number, image, squared_distance) = farthest(&maps, &inverse);
        // Any weights give an ellipsoid around all; the smallest of those seen is taken.
        let ellipsoid = regularised(&spread) * squared_distance;
        if least.is_none_or(|least| ellipsoid.determinant() < least.determinant()) {
            least = Some(ellipsoid);
        }
        if squared_distance <= 3.0 * TOLERANCE * TOLERANCE {
            break;
        }
        let point = maps[number].transpose() * top_direction(&image);
        let share = (squared_distance - 3.0) / (3.0 * (squared_distance - 1.0));
        spread = spread * (1.0 - share) + outer(point) * share;
    }
    Some(cholesky(&least?) * size)
}

/// Returns the number of the map with the point that is farthest outside an ellipsoid, that map's
/// image of the ellipsoid's inverse, and the squared distance.
fn farthest(maps: &[DMat3], inverse: &DMat3) -> (usize, DMat3, f64) {
    let mut found = (0, DMat3::ZERO, 0.0);
    for (number, map) in maps.iter().enumerate() {
        let image = *map * *inverse * map.transpose();
        let squared_distance = largest_stretch(&image);
        if squared_distance > found.2 {
            found = (number, image, squared_distance);
        }
    }
    found
}

/// The matrix of an ellipsoid with a least thickness.
fn regularised(spread: &DMat3) -> DMat3 {
    let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    *spread + DMat3::from_diagonal(DVec3::splat(trace * MIN_STRETCH * MIN_STRETCH))
}

fn outer(p: DVec3) -> DMat3 {
    DMat3::from_cols(p * p.x, p * p.y, p * p.z)
}

/// The direction in which a symmetric matrix stretches most, by squaring it: in its 256th power the
/// other directions have vanished.
fn top_direction(symmetric: &DMat3) -> DVec3 {
    let size = |m: &DMat3| m.to_cols_array().iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let mut power = *symmetric;
    for _ in 0..8 {
        power = power * (1.0 / size(&power));
        power = power * power;
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    let longest = columns
        .into_iter()
        .reduce(|a, b| if b.length_squared() > a.length_squared() { b } else { a });
    longest.unwrap_or(DVec3::X).normalize_or_zero()
}

/// Returns the upper triangular matrix U with Uᵀ U = `gram`, which is positive definite.
fn cholesky(gram: &DMat3) -> DMat3 {
    let [x, y, z] = [gram.x_axis, gram.y_axis, gram.z_axis];
    let first = x.x.sqrt();
    let (xy, xz) = (y.x / first, z.x / first);
    let second = (y.y - xy * xy).sqrt();
    let yz = (z.y - xz * xy) / second;
    let third = (z.z - xz * xz - yz * yz).sqrt();
    DMat3::from_cols(
        DVec3::new(first, 0.0, 0.0),
        DVec3::new(xy, second, 0.0),
        DVec3::new(xz, yz, third),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SplitMix64;

    #[test]
    fn no_vector_is_longer_than_its_envelope_nor_much_shorter() {
        let mut random = SplitMix64::new(5);
        let mut number = || 2.0 * f64::from(random.unit()) - 1.0;
        for flatness in [1.0, 1e-3, 0.0] {
            for count in [1, 2, 3, 40] {
                let mut map = || {
                    let m = DMat3::from_cols_array(&[0; 9].map(|_| number()));
                    DMat3::from_diagonal(DVec3::new(7.0, 1.0, flatness)) * m
                };
                let maps: Vec<DMat3> = (0..count).map(|_| map()).collect();
                let envelope = envelope(&maps).expect("finite maps");
                let inverse = envelope.inverse();
                for map in &maps {
                    let most = largest_stretch(&(*map * inverse));
                    assert!(most <= 1.0 + 1e-6, "{flatness} {count} {most}");
                }
                for _ in 0..200 {
                    let v = DVec3::new(number(), number(), number());
                    let longest = maps.iter().map(|m| (*m * v).length()).fold(0.0, f64::max);
                    let allowed = 1.05 * 3f64.sqrt() * longest + 1e-4 * v.length();
                    assert!((envelope * v).length() <= allowed, "{flatness} {count}");
                }
            }
        }
    }

    #[test]
    fn the_envelope_of_one_map_is_as_it_is() {
        let map = DMat3::from_cols_array(&[3.0, 1.0, 0.0, 0.0, 2.0, 1.0, 5.0, 0.0, 1.0]);
        let envelope = envelope(&[map]).expect("finite");
        assert!((largest_stretch(&(envelope * map.inverse())) - 1.0).abs() < 1e-6);
        assert!(super::envelope(&[DMat3::ZERO]).is_none());
        assert!(super::envelope(&[map, map * f64::NAN]).is_none());
    }
}
