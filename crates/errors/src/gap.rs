//! How far a closed fan of faces is from the one that it becomes when its middle goes.
//!
//! Both have the same border. Where both lie over one plane without folding, the distance along the
//! plane's normal is linear between the places where an edge of one crosses an edge of the other.

use crate::input::Input;
use glam::{DVec2, DVec3};
use lodc_mesh::NONE;

/// Most faces of a fan that is tried: time grows with the square. As many as legal collapses make.
const MOST: usize = 24;

/// Returns how far the faces that a step left are from those before it, both ways, where a closed
/// fan became a smaller one that does not fold. The step moved the point `source`, if it was one,
/// to one of `targets`; `faces` are those that it touched, as they are after it, with whether they
/// are left. `link` is room.
pub(crate) fn gap_of(
    input: &Input,
    (source, targets): (u32, &[u32]),
    faces: impl ExactSizeIterator<Item = (bool, [u32; 3])>,
    link: &mut Vec<DVec3>,
) -> Option<f64> {
    let &[target] = targets else { return None };
    if source == NONE || !(3..=MOST).contains(&faces.len()) {
        return None;
    }
    let mut ends = [NONE; 2];
    let mut dead = 0;
    let mut edges = [[NONE; 2]; MOST];
    let mut live = 0;
    for (is_live, points) in faces {
        let [a, b, c] = points;
        // The border of the face: from one point to the next.
        let edge = match target {
            p if p == a => [b, c],
            p if p == b => [c, a],
            _ => [a, b],
        };
        if is_live {
            edges[live] = edge;
            live += 1;
            continue;
        }
        // One of its other points is the target, too.
        let mut others = points.into_iter().filter(|&p| p != target);
        let (end, None) = (others.next()?, others.next()) else { return None };
        *ends.get_mut(dead)? = end;
        dead += 1;
    }
    if dead != 2 {
        return None;
    }
    let edges = &mut edges[..live];
    let first = usize::from(!edges.iter().any(|e| e[0] == ends[0]));
    let mut at = ends[first];
    link.clear();
    link.extend([input.place(target), input.place(at)]);
    for done in 0..edges.len() {
        let next = (done..edges.len()).find(|&i| edges[i][0] == at)?;
        edges.swap(done, next);
        at = edges[done][1];
        link.push(input.place(at));
    }
    if at != ends[1 - first] {
        return None;
    }
    gap(input.place(source), link)
}

/// Returns an upper bound of the distance between the fan around `middle` and the one around
/// `link[0]` with the same border `link`, given in order, in both directions; nothing if one of
/// them folds or turns away from the plane that fits their border.
fn gap(middle: DVec3, link: &[DVec3]) -> Option<f64> {
    let apex = link[0];
    let ring = |i: usize| link[i % link.len()] - apex;
    let normal: DVec3 = (1..link.len() - 1).map(|i| ring(i).cross(ring(i + 1))).sum();
    let normal = normal.try_normalize()?;
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let flat = |p: DVec3| (DVec2::new(p.dot(x), p.dot(y)), p.dot(normal));
    let (old, old_height) = flat(middle - apex);
    let mut spokes = [(DVec2::ZERO, 0.0); MOST];
    let spokes = &mut spokes[..link.len()];
    for (spoke, &p) in spokes.iter_mut().zip(link) {
        *spoke = flat(p - apex);
    }
    let n = spokes.len();
    let unfolded = (0..n).all(|i| {
        let (a, b) = (spokes[i].0, spokes[(i + 1) % n].0);
        (a - old).perp_dot(b - old) > 0.0 && (i == 0 || i + 1 == n || a.perp_dot(b) > 0.0)
    });
    if !unfolded {
        return None;
    }
    // The face of the new fan below the old middle.
    let is_below =
        |pair: &&[(DVec2, f64)]| pair[0].0.perp_dot(old) >= 0.0 && old.perp_dot(pair[1].0) >= 0.0;
    let below = spokes[1..].windows(2).find(is_below)?;
    let ((a, at_a), (b, at_b)) = (below[0], below[1]);
    let height = (at_a * old.perp_dot(b) + at_b * a.perp_dot(old)) / a.perp_dot(b);
    let mut most = (height - old_height).abs();
    for &(new, new_height) in &spokes[2..n - 1] {
        for &(end, end_height) in spokes.iter() {
            let along = end - old;
            let turn = new.perp_dot(along);
            // Shares of the way along the new edge from the apex, and along the old one.
            let (s, t) = (old.perp_dot(along) / turn, old.perp_dot(new) / turn);
            if (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t) {
                let apart = new_height * s - (old_height + (end_height - old_height) * t);
                most = most.max(apart.abs());
            }
        }
    }
    Some(most)
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
        assert!((gap(top, &base).expect("it does not fold") - 0.5).abs() < 1e-12);
        // Seen from behind it is the same.
        let turned: Vec<DVec3> = base.into_iter().rev().collect();
        assert!((gap(top, &turned).expect("it does not fold") - 0.5).abs() < 1e-12);
    }

    #[test]
    fn fans_that_fold_have_no_gap() {
        let base =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(gap(DVec3::new(3.0, 1.0, 0.1), &base), None);
        // From the first corner, a dent hides a part of the border.
        let dented = [base[0], base[1], DVec3::new(0.3, 0.2, 0.0), base[2], base[3]];
        assert_eq!(gap(DVec3::new(0.2, 0.5, 0.1), &dented), None);
        assert_eq!(gap(DVec3::ZERO, &[DVec3::ZERO; 4]), None);
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
            let Some(gap) = gap(middle, &link) else { continue };
            found += 1;
            let old: Vec<_> = (0..n).map(|i| [middle, link[i], link[(i + 1) % n]]).collect();
            let new: Vec<_> = (1..n - 1).map(|i| [link[0], link[i], link[i + 1]]).collect();
            let mut most = 0.0f64;
            for (from, to) in [(&old, &new), (&new, &old)] {
                for (i, &[a, b, c]) in (0..).zip(from).flat_map(|x: (usize, _)| [x; 60]) {
                    let (s, t) = (unit(), unit());
                    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                    let p = a + (b - a) * s + (c - a) * t;
                    let near = to.iter().map(|&t| distance_squared(p, t)).fold(f64::MAX, f64::min);
                    assert!(near.sqrt() <= gap + 1e-12, "round {round}, face {i}");
                    most = most.max(near.sqrt());
                }
            }
            assert!(most >= 0.3 * gap, "round {round}: {most} of {gap}");
        }
        assert!(found > 100, "{found}");
    }
}
