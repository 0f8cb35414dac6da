use super::Quadric;
use glam::DVec3;

/// Sum of weighted squared distances of a point to planes given by point and normal.
fn direct(planes: &[(DVec3, DVec3, f64)], x: DVec3) -> f64 {
    planes.iter().map(|&(p, n, w)| w * n.dot(x - p).powi(2)).sum()
}

#[test]
fn transport_and_addition_give_the_sum_of_squared_distances() {
    let (p, q) = (DVec3::new(0.3, -1.0, 2.0), DVec3::new(1.0, 0.5, -0.25));
    let planes = [
        (p, DVec3::new(0.6, 0.8, 0.0), 2.0),
        (p, DVec3::new(0.0, 0.6, -0.8), 0.5),
        (q, DVec3::X, 3.0),
        (q, DVec3::new(0.0, -0.28, 0.96), 1.0),
    ];
    let mut at_p = Quadric::default();
    let mut at_q = Quadric::default();
    planes[..2].iter().for_each(|&(_, n, w)| at_p.add_plane(n, w));
    planes[2..].iter().for_each(|&(_, n, w)| at_q.add_plane(n, w));
    at_q.add(&at_p.transported(q - p));
    for x in [q, p, DVec3::ZERO, DVec3::new(10.0, -3.0, 0.1)] {
        let expected = direct(&planes, x);
        assert!((at_q.at(x - q) - expected).abs() < 1e-9 * expected.max(1.0), "{x}");
    }
    assert!((at_q.weight - 6.5).abs() < 1e-12);
    assert!((at_q.distance() - (direct(&planes, q) / 6.5).sqrt()).abs() < 1e-12);
}

#[test]
fn a_new_quadric_costs_nothing_where_it_is_even_far_from_the_origin() {
    let mut quadric = Quadric::default();
    quadric.add_plane(DVec3::new(1.0, 2.0, 3.0).normalize(), 1e6);
    assert_eq!(quadric.at(DVec3::ZERO), 0.0);
}
