//! Vertices that are at one position at rest and part in motion.

use crate::parts;
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic, weld_positions};

fn floats(semantic: Semantic, target: Option<u32>, rows: &[&[f32]]) -> Attribute {
    Attribute {
        semantic,
        morph_target: target,
        component: Component::F32,
        components: rows[0].len() as u8,
        normalized: false,
        bytes: rows.iter().flat_map(|row| row.iter().flat_map(|x| x.to_le_bytes())).collect(),
    }
}

/// Two triangles on one another but for the corner of the second that `streams` move.
fn with_streams(streams: Vec<Attribute>) -> MeshParts {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut p = parts(&[corners, corners].concat(), &[[0, 1, 2], [3, 4, 5]]);
    p.submeshes[0].attributes = (0..streams.len() as u32).collect();
    p.attributes = streams;
    p
}

fn delta(of_last: [f32; 3]) -> Attribute {
    let zero: &[f32] = &[0.0, -0.0, 0.0];
    floats(Semantic::Position, Some(2), &[zero, zero, zero, zero, zero, &of_last])
}

fn skin(joints: [[f32; 2]; 2], weights: [[f32; 2]; 2]) -> Vec<Attribute> {
    let rows = |[a, b]: &[[f32; 2]; 2]| -> Vec<Vec<f32>> {
        [a, a, a, a, a, b].map(|row| row.to_vec()).into()
    };
    let stream = |semantic, values: &[[f32; 2]; 2]| {
        let rows = rows(values);
        floats(semantic, None, &rows.iter().map(Vec::as_slice).collect::<Vec<_>>())
    };
    vec![stream(Semantic::Joints(0), &joints), stream(Semantic::Weights(0), &weights)]
}

#[test]
fn what_parts_in_motion_is_at_several_positions() {
    let cases = [
        (vec![], 3),
        (vec![delta([0.0; 3])], 3),
        (vec![delta([0.0, 0.0, 1.0])], 4),
        (skin([[1.0, 2.0]; 2], [[0.5; 2]; 2]), 3),
        // The order of joints, and those of no weight, do not count.
        (skin([[1.0, 2.0], [2.0, 1.0]], [[0.25, 0.75], [0.75, 0.25]]), 3),
        (skin([[1.0, 2.0], [1.0, 7.0]], [[1.0, 0.0]; 2]), 3),
        (skin([[1.0, 2.0], [1.0, 7.0]], [[0.5; 2]; 2]), 4),
        (skin([[1.0, 2.0]; 2], [[0.5, 0.5], [0.25, 0.75]]), 4),
    ];
    for (streams, expected) in cases {
        let mesh = Mesh::try_from(with_streams(streams.clone())).expect("a mesh");
        let ids = mesh.position_ids();
        assert_eq!(ids.len(), expected, "{streams:?}");
        assert_eq!(ids.of_vertex[..5], [0, 1, 2, 0, 1]);
    }
}

#[test]
fn a_triangle_that_is_a_point_at_rest_alone_stays() {
    for (moved, dropped) in [([0.0, 0.0, 2.0], 0), ([0.0; 3], 1)] {
        let mut p = with_streams(vec![delta(moved)]);
        p.positions[5] = p.positions[4];
        let is_mesh = Mesh::try_from(p.clone()).is_ok();
        assert_eq!((is_mesh, p.clean().degenerate_triangles), (dropped == 0, dropped));
    }
}

#[test]
fn submeshes_that_store_motion_otherwise_are_not_joined() {
    let mut p = with_streams(vec![delta([0.0; 3]), delta([0.0; 3])]);
    p.vertex_submesh = vec![0, 0, 0, 1, 1, 1];
    p.submeshes = vec![p.submeshes[0].clone(); 2];
    for (number, submesh) in p.submeshes.iter_mut().enumerate() {
        (submesh.first_triangle, submesh.triangle_count) = (number as u32, 1);
        submesh.attributes = vec![0];
    }
    let positions = |p: &MeshParts| Mesh::try_from(p.clone()).expect("a mesh").position_ids().len();
    assert_eq!(positions(&p), 3);
    p.submeshes[1].attributes = vec![1];
    assert_eq!(positions(&p), 6);
}

#[test]
fn welding_joins_what_stays_together_in_motion() {
    for (moved, welded) in [([0.0, 0.0, 0.05], true), ([0.0, 0.0, 0.5], false)] {
        let mut p = with_streams(vec![delta(moved)]);
        p.positions[5] = [0.0, 1.01, 0.0];
        assert_eq!(weld_positions(&mut p, 0.1), usize::from(welded), "{moved:?}");
        let mesh = Mesh::try_from(p).expect("a mesh");
        assert_eq!(mesh.position_ids().len(), if welded { 3 } else { 4 });
    }
}
