//! Importance that is painted on a mesh: how much of a cost counts where.

use lodc_mesh::PositionIds;

/// Returns for each vertex the largest importance of the vertices at its position, from 0 to 1;
/// empty if it is as usual everywhere.
pub(crate) fn of_positions(painted: &[f32], positions: &PositionIds) -> Vec<f32> {
    let valid = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.5 };
    if painted.iter().all(|&value| valid(value) == 0.5) {
        return Vec::new();
    }
    let mut largest = vec![0.0f32; positions.len()];
    for (&position, &value) in positions.of_vertex.iter().zip(painted) {
        let at = &mut largest[position as usize];
        *at = at.max(valid(value));
    }
    positions.of_vertex.iter().map(|&position| largest[position as usize]).collect()
}

/// By how much a cost is multiplied where the importance is `value`, from 0 to 1. Costs are squares
/// of distances, so it is a hundredth to a hundred times. By roots, which are the same bits on
/// every machine.
pub(crate) fn factor(value: f32) -> f64 {
    /// The value is rounded to so many binary places.
    const BITS: u32 = 12;
    let steps = (f64::from(value) * f64::from(1 << BITS)).round() as u32;
    let (mut factor, mut root) = (0.01, 10_000.0f64);
    for bit in (0..=BITS).rev() {
        if steps >> bit & 1 == 1 {
            factor *= root;
        }
        root = root.sqrt();
    }
    factor
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_changes_nothing_and_the_ends_are_a_hundredth_and_a_hundred_times() {
        assert_eq!((factor(0.0), factor(0.5), factor(1.0)), (0.01, 1.0, 100.0));
        let all: Vec<f64> = (0..=100).map(|i| factor(i as f32 / 100.0)).collect();
        assert!(all.is_sorted());
        assert!((factor(0.75) - 10.0).abs() < 1e-9, "{}", factor(0.75));
    }
}
