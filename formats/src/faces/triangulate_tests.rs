use super::*;
use crate::testing::Random;

/// The polygon's triangles and twice its and their areas, in the plane z = 0.
fn check(points: &[[f32; 2]]) -> (Triangles, f64, f64) {
    let corners: Vec<[f32; 3]> = points.iter().map(|p| [p[0], p[1], 0.0]).collect();
    let mut triangulator = Triangulator::default();
    let triangles = triangulator.triangulate(&corners).to_vec();
    assert_eq!(triangles.len(), points.len() - 2);
    let area = |t: &[u32]| {
        let p = |i: usize| points[t[i % t.len()] as usize].map(f64::from);
        (0..t.len()).map(|i| p(i)[0] * p(i + 1)[1] - p(i)[1] * p(i + 1)[0]).sum::<f64>()
    };
    let whole: Vec<u32> = (0..points.len() as u32).collect();
    let total = area(&whole).abs();
    let parts = triangles.iter().map(|t| area(t).abs()).sum();
    let mut uses = vec![0; points.len()];
    triangles.as_flattened().iter().for_each(|&i| uses[i as usize] += 1);
    assert!(uses.iter().all(|&u| u > 0), "a corner is in no triangle");
    (triangles, total, parts)
}

#[test]
fn convex_polygons_are_fans() {
    assert_eq!(check(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]).0, [[0, 1, 2], [0, 2, 3]]);
    // The same seen from behind: the order stays.
    assert_eq!(check(&[[0., 0.], [0., 1.], [1., 1.], [1., 0.]]).0, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn a_concave_quad_is_cut_at_its_reflex_corner() {
    let dart = [[0f32, 0.], [4., 0.], [1., 1.], [0., 4.]];
    for turn in 0..4 {
        let points: Vec<_> = (0..4).map(|i| dart[(i + turn) % 4]).collect();
        let (triangles, total, parts) = check(&points);
        assert_eq!(total, parts, "{triangles:?}");
    }
}

#[test]
fn random_stars_combs_and_spirals_are_covered_exactly_once() {
    let mut random = Random(11);
    for round in 0..300 {
        let n = 4 + random.below(60);
        let radius: Vec<f32> = (0..n).map(|_| 0.2 + random.unit()).collect();
        let star: Vec<_> = (0..n)
            .map(|i| {
                let angle = std::f32::consts::TAU * i as f32 / n as f32;
                [radius[i] * angle.cos(), radius[i] * angle.sin()]
            })
            .collect();
        let comb: Vec<_> = (0..n)
            .map(|i| [i as f32, if i % 2 == 0 { random.unit() } else { 2.0 + random.unit() }])
            .chain([[n as f32, 9.0], [-1.0, 9.0]])
            .collect();
        let arm = |i: usize, width: f32| {
            let angle = 0.3 * i as f32;
            let r = 1.0 + angle + width;
            [r * angle.cos(), r * angle.sin()]
        };
        let spiral: Vec<_> =
            (0..n).map(|i| arm(i, 1.0)).chain((0..n).rev().map(|i| arm(i, 0.0))).collect();
        for (kind, mut points) in [("star", star), ("comb", comb), ("spiral", spiral)] {
            if round % 2 == 1 {
                points.reverse();
            }
            let (_, total, parts) = check(&points);
            assert!(
                (total - parts).abs() <= 1e-9 * total,
                "{kind} of {n}, round {round}: {total} {parts}"
            );
        }
    }
}

#[test]
fn corners_on_a_line_give_no_flat_triangle_where_that_can_be_avoided() {
    let points = [[0f32, 0.], [1., 0.], [2., 0.], [2., 2.], [1., 2.], [0., 2.]];
    let (triangles, total, parts) = check(&points);
    assert_eq!(total, parts);
    for t in triangles {
        let [a, b, c] = t.map(|i| points[i as usize]);
        assert!((b[0] - a[0]) * (c[1] - a[1]) != (b[1] - a[1]) * (c[0] - a[0]), "{t:?} is flat");
    }
}

#[test]
fn a_hole_reached_by_a_slit_stays_a_hole() {
    let points = [
        [0f32, 0.],
        [9., 0.],
        [9., 9.],
        [0., 9.],
        [0., 0.],
        [3., 3.],
        [3., 6.],
        [6., 6.],
        [6., 3.],
        [3., 3.],
    ];
    let (_, total, parts) = check(&points);
    assert_eq!((total, parts), (2.0 * 72.0, 2.0 * 72.0));
}

#[test]
fn polygons_without_sense_still_give_their_triangles() {
    let pentagram: Vec<_> =
        (0..5).map(|i| (i as f32 * 2.0 * std::f32::consts::TAU / 5.0).sin_cos().into()).collect();
    check(&pentagram);
    check(&[[1., 1.]; 7]);
    check(&[[0., 0.], [1., 0.], [2., 0.], [3., 0.], [1., 0.]]);
    check(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]]);
    check(&[
        [f32::MAX, 0.],
        [-f32::MAX, f32::MAX],
        [0., -f32::MAX],
        [1., 1.],
        [f32::MIN_POSITIVE, 0.],
    ]);
    let mut random = Random(5);
    for _ in 0..500 {
        let n = 4 + random.below(12);
        check(
            &(0..n).map(|_| [random.below(4) as f32, random.below(4) as f32]).collect::<Vec<_>>(),
        );
    }
}

#[test]
fn polygons_in_any_plane_keep_their_side() {
    // A dart, tilted: all triangles must look the way the whole does.
    let corners = [[0f32, 0., 5.], [4., 0., 1.], [1., 1., 3.], [0., 4., 1.]];
    let whole = newell(&corners);
    let mut triangulator = Triangulator::default();
    for t in triangulator.triangulate(&corners) {
        let side = newell(&t.map(|i| corners[i as usize]));
        assert!((0..3).map(|i| side[i] * whole[i]).sum::<f64>() > 0.0, "{t:?}");
    }
}

#[test]
fn a_malformed_polygon_is_finished_as_a_fan_when_its_budget_is_spent() {
    let n = 200_000;
    let points: Vec<[f32; 3]> = (0..n)
        .map(|i| [i as f32, if i % 2 == 0 { 0.0 } else { 1.0 + (i % 7) as f32 }, 0.0])
        .collect();
    let mut triangulator = Triangulator::default();
    assert_eq!(triangulator.triangulate(&points).len(), n - 2);
    assert_eq!((triangulator.budget, triangulator.imperfect), (0, 1));
}
