//! Triangles as a multiset: orientation, order and multiplicity.

use lodc_fixtures::Rng;
use lodc_mesh::{OrientedTriangle, TriangleHash};
use std::collections::BTreeSet;

fn hash(triangles: &[OrientedTriangle]) -> TriangleHash {
    triangles.iter().copied().collect()
}

fn some(n: usize, seed: u64) -> Vec<OrientedTriangle> {
    let mut rng = Rng::new(seed);
    (0..n)
        .map(|_| {
            let first = rng.below(1000) as u32;
            OrientedTriangle::new(
                rng.below(3) as u32,
                [first, first + 1 + rng.below(5) as u32, first + 9],
            )
        })
        .collect()
}

#[test]
fn turning_a_triangle_changes_nothing_and_reversing_it_does() {
    let t = OrientedTriangle::new(1, [7, 3, 5]);
    assert_eq!(t.corners, [3, 5, 7]);
    assert_eq!((t, t), (OrientedTriangle::new(1, [3, 5, 7]), OrientedTriangle::new(1, [5, 7, 3])));
    for other in [OrientedTriangle::new(1, [7, 5, 3]), OrientedTriangle::new(2, [7, 3, 5])] {
        assert_ne!(other, t);
        assert_ne!(hash(&[other]), hash(&[t]));
    }
}

#[test]
fn order_does_not_matter_and_multiplicity_does() {
    let mut triangles = some(500, 1);
    let before = hash(&triangles);
    Rng::new(2).shuffle(&mut triangles);
    assert_eq!(hash(&triangles), before);
    assert_ne!(hash(&triangles[1..]), before);
    triangles.push(triangles[0]);
    assert_ne!(hash(&triangles), before);
    assert_ne!(hash(&[triangles[0]; 2]), TriangleHash::default(), "a pair must not cancel");
}

#[test]
fn taking_away_undoes_adding_in_any_order() {
    let (base, mut extra) = (some(100, 3), some(200, 4));
    let mut sum = hash(&base);
    extra.iter().for_each(|&t| sum.add(t));
    Rng::new(5).shuffle(&mut extra);
    extra.iter().for_each(|&t| sum.remove(t));
    assert_eq!(sum, hash(&base));
    // Taking away before adding passes through states that are no multiset; the end is the same.
    extra.iter().for_each(|&t| sum.remove(t));
    extra.iter().for_each(|&t| sum.add(t));
    assert_eq!(sum, hash(&base));
}

#[test]
fn neighbouring_triangles_and_exchanged_corners_do_not_collide() {
    let mut seen = BTreeSet::new();
    for submesh in 0..4 {
        for a in 0..12 {
            for b in a + 1..14 {
                for c in a + 1..14 {
                    if b != c {
                        let sum = hash(&[OrientedTriangle::new(submesh, [a, b, c])]);
                        assert!(seen.insert(format!("{sum:?}")), "{submesh}: {a} {b} {c}");
                    }
                }
            }
        }
    }
    // Two pairs with the same edges, differently combined.
    let t = |corners| OrientedTriangle::new(0, corners);
    assert_ne!(hash(&[t([0, 1, 2]), t([3, 4, 5])]), hash(&[t([0, 1, 5]), t([3, 4, 2])]));
}
