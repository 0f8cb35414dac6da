//! Welding by distance.

use crate::parts;
use lodc_fixtures::Rng;
use lodc_mesh::{Attribute, Component, Semantic, Submesh, weld_positions};

#[test]
fn positions_within_the_tolerance_become_the_first_of_them() {
    let mut p = parts(
        &[[0.0; 3], [0.9, 0.0, 0.0], [1.8, 0.0, 0.0], [2.6, 0.0, 0.0], [-0.5, 0.5, 0.5]],
        &[],
    );
    assert_eq!(weld_positions(&mut p, 1.0), 3);
    // The third is near the second, but that has gone to the first: chains do not drag.
    assert_eq!(p.positions, [[0.0; 3], [0.0; 3], [1.8, 0.0, 0.0], [1.8, 0.0, 0.0], [0.0; 3]]);
}

#[test]
fn no_tolerance_moves_nothing() {
    let mut p = parts(&[[0.0; 3], [-0.0, 0.0, 0.0], [1e-30, 0.0, 0.0]], &[]);
    let before = p.clone();
    for tolerance in [0.0, -1.0, f64::NAN] {
        assert_eq!(weld_positions(&mut p, tolerance), 0);
    }
    // Zeros of both signs are one position already: their bytes stay.
    assert_eq!(weld_positions(&mut p, 1e-40), 0);
    assert!(
        p.positions
            .iter()
            .zip(&before.positions)
            .all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits))
    );
}

#[test]
fn welding_is_what_comparing_all_pairs_finds() {
    let mut rng = Rng::new(3);
    for size in [1.0f32, 100.0, 1e-6] {
        let points: Vec<[f32; 3]> =
            (0..300).map(|_| std::array::from_fn(|_| (rng.unit() - 0.5) * size)).collect();
        let tolerance = 0.1 * f64::from(size);
        let mut wanted: Vec<[f32; 3]> = Vec::new();
        let mut kept: Vec<[f32; 3]> = Vec::new();
        for &p in &points {
            let near = |q: &&[f32; 3]| {
                (0..3).map(|i| (f64::from(p[i]) - f64::from(q[i])).powi(2)).sum::<f64>()
                    <= tolerance * tolerance
            };
            let target = kept.iter().find(near).copied().unwrap_or_else(|| {
                kept.push(p);
                p
            });
            wanted.push(target);
        }
        let mut p = parts(&points, &[]);
        let moved = weld_positions(&mut p, tolerance);
        assert_eq!(p.positions, wanted);
        assert_eq!(moved, points.iter().zip(&wanted).filter(|(a, b)| a != b).count());
        assert!(moved > 50);
        assert_eq!(weld_positions(&mut p, tolerance), 0, "welding twice moves nothing");
    }
}

#[test]
fn raw_positions_follow_where_the_stream_is_shared() {
    let mut p = parts(&[[10.0; 3], [11.0; 3], [11.0; 3], [12.0; 3]], &[]);
    let raw = Attribute {
        semantic: Semantic::Position,
        morph_target: None,
        component: Component::U8,
        components: 1,
        normalized: false,
        bytes: vec![10, 11, 0, 12],
    };
    p.attributes = vec![raw.clone(), Attribute { semantic: Semantic::TexCoord(0), ..raw }];
    p.submeshes = [&[0u32, 1][..], &[1], &[0]]
        .map(|streams| Submesh { attributes: streams.to_vec(), ..Submesh::default() })
        .to_vec();
    p.vertex_submesh = vec![0, 0, 1, 2];
    assert_eq!(weld_positions(&mut p, 4.0), 3);
    assert_eq!(p.positions, [[10.0; 3]; 4]);
    assert_eq!(
        p.attributes[0].bytes,
        [10, 10, 0, 10],
        "followed, not in the stream, followed across submeshes"
    );
    assert_eq!(p.attributes[1].bytes, [10, 11, 0, 12], "other attributes stay");
}

#[test]
fn a_raw_position_that_cannot_follow_keeps_its_vertex_where_it_is() {
    let mut p = parts(&[[10.0; 3], [11.0; 3]], &[]);
    p.attributes = vec![Attribute {
        semantic: Semantic::Position,
        morph_target: None,
        component: Component::U8,
        components: 1,
        normalized: false,
        bytes: vec![0, 11],
    }];
    p.submeshes = vec![Submesh::default(), Submesh { attributes: vec![0], ..Submesh::default() }];
    p.vertex_submesh = vec![0, 1];
    assert_eq!(
        (weld_positions(&mut p, 4.0), p.positions[1], p.attributes[0].bytes[1]),
        (0, [11.0; 3], 11)
    );
}

#[test]
fn huge_coordinates_and_tiny_tolerances_are_no_problem() {
    let mut p = parts(&[[3e38, -3e38, 0.0], [3e38, -3e38, 1e-40], [-3e38, 3e38, 0.0]], &[]);
    assert_eq!(weld_positions(&mut p, 1e-300), 0);
    assert_eq!(weld_positions(&mut p, 1e300), 2);
}
