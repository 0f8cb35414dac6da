//! Quadrature rules for triangles: fixed sample points with their shares of the area (Dunavant
//! 1985).

/// A rule: barycentric coordinates and the share of the triangle's area of each point.
pub(crate) type Rule = &'static [([f64; 3], f64)];

// Barycentric coordinates and weights of the rule of six points.
const A: f64 = 0.445_948_490_915_965;
const B: f64 = 0.091_576_213_509_771;
const WEIGHT_A: f64 = 0.223_381_589_678_011;
const WEIGHT_B: f64 = 0.109_951_743_655_322;

/// The centroid: exact for linear functions.
const ONE_POINT: Rule = &[([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], 1.0)];

/// Three points: exact for quadratic functions.
const THREE_POINTS: Rule = &[
    ([2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], 1.0 / 3.0),
    ([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], 1.0 / 3.0),
    ([1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0], 1.0 / 3.0),
];

/// Six points: exact for polynomials of degree 4.
const SIX_POINTS: Rule = &[
    ([1.0 - 2.0 * A, A, A], WEIGHT_A),
    ([A, 1.0 - 2.0 * A, A], WEIGHT_A),
    ([A, A, 1.0 - 2.0 * A], WEIGHT_A),
    ([1.0 - 2.0 * B, B, B], WEIGHT_B),
    ([B, 1.0 - 2.0 * B, B], WEIGHT_B),
    ([B, B, 1.0 - 2.0 * B], WEIGHT_B),
];

/// The most points of any rule.
pub(crate) const MAX_POINTS: usize = SIX_POINTS.len();

/// Returns the rules for the input's triangles and for the level's: the more of the input's there
/// are for each of the level, the fewer points each of them needs, and the less do more points on
/// the level cost. The limits are chosen by hand.
pub(crate) fn rules_for_ratio(input_triangles: usize, level_triangles: usize) -> [Rule; 2] {
    match input_triangles / level_triangles.max(1) {
        0..3 => [THREE_POINTS, THREE_POINTS],
        3..8 => [ONE_POINT, THREE_POINTS],
        _ => [ONE_POINT, SIX_POINTS],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_moments_are_exact() {
        for (rule, degree) in [(ONE_POINT, 1), (THREE_POINTS, 2), (SIX_POINTS, 4)] {
            assert!((rule.iter().map(|r| r.1).sum::<f64>() - 1.0).abs() < 1e-12);
            for n in 1..=degree {
                // The mean of the n-th power of one barycentric coordinate is 2 / ((n + 1)(n + 2)).
                let mean: f64 = rule.iter().map(|(b, share)| share * b[0].powi(n)).sum();
                let exact = 2.0 / f64::from((n + 1) * (n + 2));
                assert!((mean - exact).abs() < 1e-12, "degree {n} of {}", rule.len());
            }
        }
    }
}
