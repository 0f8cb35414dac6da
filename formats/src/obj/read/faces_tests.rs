use super::parse::parse;
use crate::Limits;
use crate::faces::{Assembled, assemble};
use lodc_mesh::{Mesh, Semantic};

fn build(source: &str) -> Assembled {
    let parsed = parse(source.as_bytes(), &Limits::DEFAULT).expect(source);
    let a = assemble(&parsed.faces, 42);
    Mesh::try_from(a.parts.clone()).expect("valid");
    a
}

fn floats(a: &Assembled, semantic: &Semantic) -> Vec<f32> {
    let attribute =
        a.parts.attributes.iter().find(|x| x.semantic == *semantic).expect("the stream");
    attribute.bytes.chunks(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn corners_with_equal_values_share_a_vertex_and_others_do_not() {
    let a = build(&format!(
        "{SQUARE}vt 0 0\nvt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 3/2 4/1\nf 1/3 2/1 4/2\n"
    ));
    assert_eq!(a.parts.positions.len(), 5);
    assert_eq!(a.parts.triangles, [[0, 1, 2], [0, 2, 3], [4, 1, 3]]);
    // Two positions with equal coordinates stay two vertices.
    let a = build("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 4 3 2\n");
    assert_eq!(a.parts.positions.len(), 4);
}

#[test]
fn one_submesh_per_material_in_order_of_first_use() {
    let a = build(&format!(
        "{SQUARE}vn 0 0 1\nusemtl unused\nusemtl red\ng left\nf 1 2 3\nusemtl\ng right\n\
            f 1//1 2//1 3//1 4//1\nusemtl red\ng left\nf 1 3 4\n"
    ));
    let submeshes: Vec<_> = a
        .parts
        .submeshes
        .iter()
        .map(|s| (s.first_triangle, s.triangle_count, s.attributes.len()))
        .collect();
    assert_eq!(submeshes, [(0, 2, 0), (2, 2, 1)]);
    let names: Vec<_> = a
        .submeshes
        .iter()
        .map(|s| (s.name.as_str(), s.material.as_deref(), s.document_primitive))
        .collect();
    assert_eq!(names, [("left", Some("red"), 0), ("right", None, 1)]);
    assert_eq!((a.joined_labels, a.polygons), (0, 1));
    assert_eq!(a.parts.vertex_submesh, [0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(
        floats(&a, &Semantic::Normal)[..12],
        [0.0; 12],
        "vertices of other submeshes hold zeros"
    );
}

#[test]
fn groups_that_share_a_material_keep_their_names() {
    let a = build(&format!("{SQUARE}g one\nf 1 2 3\ng two\nf 1 3 4\ng one\nf 1 2 4\n"));
    assert_eq!(
        (a.submeshes.len(), a.submeshes[0].name.as_str(), a.joined_labels),
        (1, "one two", 2)
    );
    assert_eq!(a.submeshes[0].material, None);
}

#[test]
fn missing_texture_coordinates_and_normals_are_filled_and_counted() {
    let a =
        build(&format!("{SQUARE}vt 5 6\nvn 1 0 0\nf 1/1/1 2/1/1 3/1/1\nf 1 3 4\nf 2/1 3/1/1 4\n"));
    assert_eq!((a.filled_texcoords, a.filled_normals), (4, 2));
    let (uv, normals) = (floats(&a, &Semantic::TexCoord(0)), floats(&a, &Semantic::Normal));
    let corner = |t: usize, c: usize| a.parts.triangles[t][c] as usize;
    assert_eq!(uv[corner(0, 0) * 2..][..2], [5.0, 6.0]);
    assert_eq!(uv[corner(1, 0) * 2..][..2], [0.0, 0.0]);
    assert_eq!(normals[corner(0, 0) * 3..][..3], [1.0, 0.0, 0.0]);
    for c in 0..3 {
        assert_eq!(normals[corner(1, c) * 3..][..3], [0.0, 0.0, 1.0], "the face's own normal");
    }
    assert_eq!(normals[corner(2, 1) * 3..][..3], [1.0, 0.0, 0.0], "what is there stays");
}

#[test]
fn colours_and_third_coordinates_make_wider_streams() {
    let a = build("v 0 0 0 1 0 0\nv 1 0 0 0 1 0 .5\nv 0 1 0\nvt 1 2 3\nf 1/1 2/1 3/1\n");
    assert_eq!(floats(&a, &Semantic::Color(0)), [1., 0., 0., 1., 0., 1., 0., 0.5, 1., 1., 1., 1.]);
    assert_eq!(floats(&a, &Semantic::TexCoord(0)), [1., 2., 3., 1., 2., 3., 1., 2., 3.]);
    assert_eq!(a.parts.submeshes[0].attributes, [0, 1]);
}

#[test]
fn every_bit_of_a_stream_survives() {
    let a = build("v -0 1e-45 3.4028235e38\nv 1 0 0\nv 0 1 0\nvn nan -inf -0\nf 1//1 2//1 3//1\n");
    assert_eq!(a.parts.positions[0].map(f32::to_bits), [0x8000_0000, 1, 0x7f7f_ffff]);
    let normals = floats(&a, &Semantic::Normal);
    assert!(
        normals[0].is_nan()
            && normals[1] == f32::NEG_INFINITY
            && normals[2].to_bits() == 0x8000_0000
    );
}

#[test]
fn the_seed_changes_nothing() {
    let source = format!("{SQUARE}vt 0 0\nvt 1 0\nf 1/1 2/2 3/1 4/2\nf 4/1 3/2 2/1 1/2\n");
    let parsed = parse(source.as_bytes(), &Limits::DEFAULT).expect("valid");
    assert_eq!(assemble(&parsed.faces, 1).parts, assemble(&parsed.faces, u64::MAX).parts);
}
