//! Meshes are valid by construction: every rule refuses its first offender.

use crate::{CORNERS, parts};
use lodc_mesh::{Attribute, Component, Mesh, MeshError, MeshParts, Semantic, Submesh};

fn square() -> MeshParts {
    parts(&CORNERS, &[[0, 1, 2], [0, 2, 3]])
}

fn refused(spoil: impl Fn(&mut MeshParts)) -> MeshError {
    let mut p = square();
    spoil(&mut p);
    Mesh::try_from(p).expect_err("a broken rule")
}

#[test]
fn every_rule_names_its_first_offender() {
    Mesh::try_from(square()).expect("the unspoilt square is valid");
    assert_eq!(refused(|p| p.positions[2][1] = f32::NAN), MeshError::NotFinite { vertex: 2 });
    assert_eq!(refused(|p| p.positions[3][0] = f32::INFINITY), MeshError::NotFinite { vertex: 3 });
    assert_eq!(refused(|p| p.vertex_submesh.truncate(3)), MeshError::VertexSubmesh { vertex: 3 });
    assert_eq!(refused(|p| p.vertex_submesh.push(0)), MeshError::VertexSubmesh { vertex: 4 });
    assert_eq!(refused(|p| p.vertex_submesh[1] = 1), MeshError::VertexSubmesh { vertex: 1 });
    assert_eq!(refused(|p| p.triangles[1][2] = 4), MeshError::IndexOutOfRange { triangle: 1 });
    assert_eq!(
        refused(|p| p.triangles[1][2] = u32::MAX),
        MeshError::IndexOutOfRange { triangle: 1 }
    );
    assert_eq!(refused(|p| p.triangles[0][2] = 1), MeshError::Degenerate { triangle: 0 });
    assert_eq!(
        refused(|p| p.positions[2] = [1.0, -0.0, 0.0]),
        MeshError::Degenerate { triangle: 0 }
    );
    assert_eq!(
        refused(|p| p.submeshes[0].first_triangle = 1),
        MeshError::SubmeshRange { submesh: 0 }
    );
    assert_eq!(
        refused(|p| p.submeshes[0].triangle_count = 1),
        MeshError::SubmeshRange { submesh: 1 }
    );
    assert_eq!(
        refused(|p| p.submeshes[0].triangle_count = 3),
        MeshError::SubmeshRange { submesh: 0 }
    );
    assert_eq!(
        refused(|p| p.submeshes[0].triangle_count = u32::MAX),
        MeshError::SubmeshRange { submesh: 0 }
    );
    assert_eq!(
        refused(|p| p.submeshes[0].attributes = vec![0]),
        MeshError::SubmeshAttribute { submesh: 0 }
    );
}

#[test]
fn a_vertex_belongs_to_one_submesh() {
    let e = refused(|p| {
        p.submeshes[0].triangle_count = 1;
        p.submeshes.push(Submesh { first_triangle: 1, triangle_count: 1, attributes: Vec::new() });
    });
    assert_eq!(e, MeshError::SharedVertex { triangle: 1 });
}

#[test]
fn streams_cover_every_vertex_with_one_to_sixteen_components() {
    let with = |components: u8, bytes: usize| {
        let mut p = square();
        p.attributes.push(Attribute {
            semantic: Semantic::Weights(0),
            morph_target: None,
            component: Component::U16,
            components,
            normalized: true,
            bytes: vec![0; bytes],
        });
        Mesh::try_from(p)
    };
    assert!(with(1, 8).is_ok() && with(16, 128).is_ok());
    for (components, bytes) in [(1, 7), (1, 9), (0, 0), (17, 136), (255, 2040)] {
        let want = MeshError::AttributeLength { attribute: 0, bytes, vertices: 4 };
        assert_eq!(with(components, bytes), Err(want.clone()));
        assert!(want.to_string().contains(&bytes.to_string()));
    }
}

#[test]
fn an_empty_mesh_and_an_empty_submesh_are_valid() {
    let nothing = Mesh::try_from(MeshParts::default()).expect("nothing is valid");
    assert_eq!((nothing.bounds(), nothing.diagonal()), (([0.0; 3], [0.0; 3]), 0.0));
    let mut p = square();
    p.submeshes.push(Submesh { first_triangle: 2, ..Submesh::default() });
    assert_eq!(Mesh::try_from(p).expect("a valid mesh").submeshes()[1].triangles(), 2..2);
}

#[test]
fn bounds_and_diagonal_survive_the_largest_floats() {
    let p = parts(&[[-3e38, 1.0, 0.0], [3e38, 5.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    let mesh = Mesh::try_from(p).expect("finite positions");
    assert_eq!(mesh.bounds(), ([-3e38, 1.0, 0.0], [3e38, 5.0, 0.0]));
    assert!((mesh.diagonal() / 6e38 - 1.0).abs() < 1e-6);
}

#[test]
fn parts_come_back_as_they_went_in() {
    let p = lodc_fixtures::machine_part().into_parts();
    assert_eq!(Mesh::try_from(p.clone()).expect("a valid mesh").into_parts(), p);
}
