//! How far a closed fan of faces is from the one that it becomes when its middle vertex collapses.
//!
//! Both have the same border. Where both are above one plane without folding, the distance along
//! the plane's normal is linear between the points where an edge of one crosses an edge of the
//! other: there it is largest.

use crate::input::Input;
use glam::{DVec2, DVec3};
use lodc_mesh::NONE;

/// Most faces of a fan that is tried: time grows with the square. As many as legal collapses make.
const MAX_FACES: usize = 24;

/// The points that a step moved.
pub(crate) struct Moved<'a> {
    /// Where from, if it was one point; [`NONE`] otherwise.
    pub(crate) source: u32,
    pub(crate) targets: &'a [u32],
}

/// Returns an upper bound of how far the faces after a step are from those before it, both ways,
/// where a closed fan became a smaller one and neither folds; `None` otherwise. `faces` are those
/// that the step touched, as they are after it: whether each is live, and its points. `link` is a
/// buffer.
pub(crate) fn fan_gap(
    input: &Input,
    Moved { source, targets }: Moved<'_>,
    faces: impl ExactSizeIterator<Item = (bool, [u32; 3])>,
    link: &mut Vec<DVec3>,
) -> Option<f64> {
    let &[target] = targets else { return None };
    if source == NONE || !(3..=MAX_FACES).contains(&faces.len()) {
        return None;
    }
    // The edges of the fan's border, but for the two at the target, whose faces die.
    let mut border = [[NONE; 2]; MAX_FACES];
    let mut live_count = 0;
    // The points beside the target on the border.
    let mut beside_target = [NONE; 2];
    let mut dead_count = 0;
    for (is_live, points) in faces {
        let [a, b, c] = points;
        let opposite_edge = match target {
            p if p == a => [b, c],
            p if p == b => [c, a],
            _ => [a, b],
        };
        if is_live {
            border[live_count] = opposite_edge;
            live_count += 1;
            continue;
        }
        // Two points of a dead face are the target.
        let mut others = points.into_iter().filter(|&p| p != target);
        let (other, None) = (others.next()?, others.next()) else { return None };
        *beside_target.get_mut(dead_count)? = other;
        dead_count += 1;
    }
    if dead_count != 2 {
        return None;
    }
    // Walk along the border, from the target all around.
    let border = &mut border[..live_count];
    let start = usize::from(!border.iter().any(|edge| edge[0] == beside_target[0]));
    let mut point = beside_target[start];
    link.clear();
    link.extend([input.point(target), input.point(point)]);
    for done in 0..border.len() {
        let next = (done..border.len()).find(|&i| border[i][0] == point)?;
        border.swap(done, next);
        point = border[done][1];
        link.push(input.point(point));
    }
    if point != beside_target[1 - start] {
        return None;
    }
    gap_between_fans(input.point(source), link)
}

/// Returns an upper bound of the distance between the fan around `middle` and the one around
/// `link[0]` with the same border `link`, given in order, in both directions; `None` if one of them
/// folds or turns away from the plane that fits their border.
fn gap_between_fans(middle: DVec3, link: &[DVec3]) -> Option<f64> {
    let apex = link[0];
    let from_apex = |i: usize| link[i % link.len()] - apex;
    let normal: DVec3 = (1..link.len() - 1).map(|i| from_apex(i).cross(from_apex(i + 1))).sum();
    let normal = normal.try_normalize()?;
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    // Coordinates in the plane through the apex, and the height above it.
    let project = |p: DVec3| (DVec2::new(p.dot(x), p.dot(y)), p.dot(normal));
    let (middle, middle_height) = project(middle - apex);
    let mut border = [(DVec2::ZERO, 0.0); MAX_FACES];
    let border = &mut border[..link.len()];
    for (projected, &p) in border.iter_mut().zip(link) {
        *projected = project(p - apex);
    }
    let n = border.len();
    let is_unfolded = (0..n).all(|i| {
        let (a, b) = (border[i].0, border[(i + 1) % n].0);
        (a - middle).perp_dot(b - middle) > 0.0 && (i == 0 || i + 1 == n || a.perp_dot(b) > 0.0)
    });
    if !is_unfolded {
        return None;
    }
    // The face of the new fan below or above the middle.
    let is_across = |pair: &&[(DVec2, f64)]| {
        pair[0].0.perp_dot(middle) >= 0.0 && middle.perp_dot(pair[1].0) >= 0.0
    };
    let across = border[1..].windows(2).find(is_across)?;
    let ((a, a_height), (b, b_height)) = (across[0], across[1]);
    let height = (a_height * middle.perp_dot(b) + b_height * a.perp_dot(middle)) / a.perp_dot(b);
    let mut gap = (height - middle_height).abs();
    // Inner edges of the new fan lead from the apex to `new`, those of the old from the middle to
    // `old`.
    for &(new, new_height) in &border[2..n - 1] {
        for &(old, old_height) in border.iter() {
            let old_edge = old - middle;
            let cross = new.perp_dot(old_edge);
            // Where they cross, as shares of the new edge and of the old one.
            let (s, t) = (middle.perp_dot(old_edge) / cross, middle.perp_dot(new) / cross);
            if (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t) {
                let apart = new_height * s - (middle_height + (old_height - middle_height) * t);
                gap = gap.max(apart.abs());
            }
        }
    }
    Some(gap)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SplitMix64;
    use lodc_nearest::distance_squared;

    #[test]
    fn a_pyramid_is_as_far_from_its_base_as_it_is_high() {
        let base =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let top = DVec3::new(1.2, 0.7, 0.5);
        assert!((gap_between_fans(top, &base).expect("it does not fold") - 0.5).abs() < 1e-12);
        // Seen from behind it is the same.
        let turned: Vec<DVec3> = base.into_iter().rev().collect();
        assert!((gap_between_fans(top, &turned).expect("it does not fold") - 0.5).abs() < 1e-12);
    }

    #[test]
    fn fans_that_fold_have_no_gap() {
        let base =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(gap_between_fans(DVec3::new(3.0, 1.0, 0.1), &base), None);
        // From the first corner, a dent hides a part of the border.
        let dented = [base[0], base[1], DVec3::new(0.3, 0.2, 0.0), base[2], base[3]];
        assert_eq!(gap_between_fans(DVec3::new(0.2, 0.5, 0.1), &dented), None);
        assert_eq!(gap_between_fans(DVec3::ZERO, &[DVec3::ZERO; 4]), None);
    }

    #[test]
    fn no_point_of_either_fan_is_farther_from_the_other() {
        let mut random = SplitMix64::new(11);
        let mut unit = || f64::from(random.unit());
        let mut found = 0;
        for round in 0..400 {
            let n = 3 + round % 8;
            // A border around the origin, uneven in height.
            let link: Vec<DVec3> = (0..n)
                .map(|i| {
                    let turn = (i as f64 + 0.6 * unit()) / n as f64 * 4.0;
                    let (side, t) = (turn as usize, turn.fract());
                    let [x, y] =
                        [[1.0 - t, t], [-t, 1.0 - t], [t - 1.0, -t], [t, t - 1.0]][side.min(3)];
                    DVec3::new(x, y, 0.4 * unit())
                })
                .collect();
            let middle = DVec3::new(0.2 * unit(), 0.2 * unit(), 0.4 * unit());
            let Some(gap) = gap_between_fans(middle, &link) else { continue };
            found += 1;
            let old: Vec<_> = (0..n).map(|i| [middle, link[i], link[(i + 1) % n]]).collect();
            let new: Vec<_> = (1..n - 1).map(|i| [link[0], link[i], link[i + 1]]).collect();
            let mut largest = 0.0f64;
            for (from, to) in [(&old, &new), (&new, &old)] {
                for (i, &[a, b, c]) in (0..).zip(from).flat_map(|x: (usize, _)| [x; 60]) {
                    let (s, t) = (unit(), unit());
                    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                    let p = a + (b - a) * s + (c - a) * t;
                    let near = to.iter().map(|&t| distance_squared(p, t)).fold(f64::MAX, f64::min);
                    assert!(near.sqrt() <= gap + 1e-12, "round {round}, face {i}");
                    largest = largest.max(near.sqrt());
                }
            }
            assert!(largest >= 0.3 * gap, "round {round}: {largest} of {gap}");
        }
        assert!(found > 100, "{found}");
    }
}
