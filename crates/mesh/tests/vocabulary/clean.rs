//! Cleaning: what is dropped, what is kept, what is counted.

use crate::{CORNERS, parts};
use lodc_mesh::{Attribute, Cleaning, Component, Mesh, Semantic, Submesh};

#[test]
fn degenerate_triangles_go_by_position_not_by_index() {
    let mut p = parts(
        &[CORNERS[0], CORNERS[1], CORNERS[2], [1.0, -0.0, 0.0]],
        &[[0, 1, 2], [1, 3, 2], [0, 0, 2]],
    );
    assert_eq!(p.clean(), Cleaning { degenerate_triangles: 2, unreferenced_vertices: 1 });
    assert_eq!(p.triangles, [[0, 1, 2]]);
    assert_eq!(p.positions.len(), 3);
}

#[test]
fn duplicates_of_faces_and_vertices_and_faces_without_area_are_kept() {
    let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let mut p = parts(&line, &[[0, 1, 2], [0, 1, 2], [0, 1, 3]]);
    let before = p.clone();
    assert_eq!(p.clean(), Cleaning::default());
    assert_eq!(p, before);
}

#[test]
fn the_rest_moves_up_with_its_submesh_and_attributes() {
    let mut p = parts(&[CORNERS, CORNERS].concat(), &[[0, 0, 1], [1, 2, 3], [5, 5, 6], [7, 6, 5]]);
    p.vertex_submesh = vec![0, 0, 0, 0, 1, 1, 1, 1];
    p.submeshes = [(0, 2), (2, 2)]
        .map(|(first_triangle, triangle_count)| Submesh {
            first_triangle,
            triangle_count,
            attributes: vec![0],
        })
        .to_vec();
    p.attributes.push(Attribute {
        semantic: Semantic::Color(0),
        morph_target: None,
        component: Component::U8,
        components: 2,
        normalized: true,
        bytes: (0..16).collect(),
    });
    assert_eq!(p.clean(), Cleaning { degenerate_triangles: 2, unreferenced_vertices: 2 });
    assert_eq!(p.triangles, [[0, 1, 2], [5, 4, 3]]);
    assert_eq!(p.vertex_submesh, [0, 0, 0, 1, 1, 1]);
    assert_eq!(p.attributes[0].bytes, [2, 3, 4, 5, 6, 7, 10, 11, 12, 13, 14, 15]);
    assert_eq!((p.submeshes[1].first_triangle, p.submeshes[1].triangle_count), (1, 1));
    Mesh::try_from(p).expect("what was cleaned is a mesh");
}

#[test]
fn a_mesh_of_nothing_but_waste_becomes_empty() {
    let mut p = parts(&CORNERS, &[[0, 0, 1], [2, 3, 2]]);
    assert_eq!(p.clean(), Cleaning { degenerate_triangles: 2, unreferenced_vertices: 4 });
    let mesh = Mesh::try_from(p).expect("an empty mesh is a mesh");
    assert_eq!((mesh.vertex_count(), mesh.submeshes().len()), (0, 1));
}

#[test]
fn cleaning_twice_changes_nothing() {
    for seed in 0..50 {
        let mut p = lodc_fixtures::random(seed).into_parts();
        // Every third triangle loses a corner.
        p.triangles.iter_mut().step_by(3).for_each(|t| t[1] = t[0]);
        assert!(p.triangles.is_empty() || p.clean().degenerate_triangles > 0);
        let once = p.clone();
        assert_eq!((p.clean(), p == once), (Cleaning::default(), true), "seed {seed}");
    }
}
