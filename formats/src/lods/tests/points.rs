//! Points come when a split needs them, so that a mesh of many pieces shows something early.

use super::damage::forged;
use super::every_step::check_every_step;
use super::geometry_first::first_triangles;
use super::*;
use crate::testing::Random;
use lodc_fixtures::random_collapse;
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic, Submesh};

/// The faces of the kinds of pieces, by the corners of a tetrahedron: a vertex without a triangle,
/// a triangle, a square, a tetrahedron.
const FACES: [&[[u32; 3]]; 4] =
    [&[], &[[0, 1, 2]], &[[0, 1, 2], [0, 2, 3]], &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]]];

/// Pieces of random kinds, some of them with vertices of their own for each face, in up to five
/// submeshes.
fn pieces(count: usize, random: &mut Random) -> Mesh {
    let submeshes = 1 + random.below(5);
    let mut parts = MeshParts::default();
    let mut triangles = vec![Vec::new(); submeshes];
    for _ in 0..count {
        let (submesh, faces) = (random.below(submeshes), FACES[random.below(4)]);
        let is_split = random.below(3) == 0;
        let at: [f32; 3] = std::array::from_fn(|_| random.below(50) as f32);
        let corner = |c: u32| std::array::from_fn(|i| at[i] + f32::from(i + 1 == c as usize));
        let mut vertex = |c: u32| {
            parts.positions.push(corner(c));
            parts.vertex_submesh.push(submesh as u32);
            parts.positions.len() as u32 - 1
        };
        if is_split {
            triangles[submesh].extend(faces.iter().map(|face| face.map(&mut vertex)));
        } else {
            let corners = [0, 1, 2, 3].map(vertex);
            triangles[submesh].extend(faces.iter().map(|f| f.map(|c| corners[c as usize])));
        }
    }
    let vertices = parts.positions.len();
    let mut attribute = |semantic, component: Component, components: usize| Attribute {
        semantic,
        morph_target: None,
        component,
        components: components as u8,
        normalized: false,
        bytes: match component {
            Component::F32 => {
                (0..vertices * components).flat_map(|_| random.unit().to_le_bytes()).collect()
            }
            _ => (0..vertices * components).map(|_| random.below(3) as u8).collect(),
        },
    };
    let normal = attribute(Semantic::Normal, Component::F32, 3);
    parts.attributes = vec![normal, attribute(Semantic::Joints(0), Component::U8, 4)];
    for triangles in &triangles {
        let (first_triangle, triangle_count) =
            (parts.triangles.len() as u32, triangles.len() as u32);
        let attributes = vec![0, 1];
        parts.submeshes.push(Submesh { first_triangle, triangle_count, attributes });
        parts.triangles.extend(triangles);
    }
    Mesh::try_from(parts).expect("a mesh")
}

#[test]
fn pieces_and_points_are_decoded_at_every_step() {
    for seed in 0..120 {
        let mut random = Random(seed);
        let mesh = pieces(1 + seed as usize / 4, &mut random);
        let problem = format!("pieces {seed}");
        check_every_step(&obj(vec![object("pieces", random_collapse(&mesh, seed))]), &problem);
        let simplified =
            lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {});
        check_every_step(
            &obj(vec![object("pieces", simplified)]),
            &format!("{problem}, simplified"),
        );
    }
}

#[test]
fn forged_streams_of_pieces_do_no_harm() {
    let mut random = Random(3);
    let mut refused = 0;
    for seed in 0..60 {
        let mesh = pieces(2 + seed as usize, &mut random);
        let file = obj(vec![object("pieces", random_collapse(&mesh, seed))]);
        let bytes = stepwise(&file).bytes;
        for _ in 0..40 {
            let mut unpacker = Unpacker::new(Limits::DEFAULT);
            refused += usize::from(unpacker.feed(&forged(&bytes, &mut random)).is_err());
            for object in 0..unpacker.objects() {
                // They may show anything, but must not panic, nor use what has not come.
                let _ = unpacker.mesh(object);
                let decoder = unpacker.decoder(object);
                let _ = unpacker.is_complete().then(|| unpacker.rebuilt(object));
                if unpacker.is_complete() {
                    assert!((0..decoder.vertex_count()).all(|v| decoder.has_come(v)));
                }
                assert!(decoder.triangles().flatten().all(|v| decoder.has_come(v)));
            }
        }
    }
    assert!(refused > 500, "only {refused} were noticed");
}

#[test]
fn a_mesh_of_many_pieces_shows_triangles_within_600_bytes() {
    let mesh = pieces(1500, &mut Random(7));
    let simplified = lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {});
    let file = obj(vec![object("pieces", simplified)]);
    for exact in [false, true] {
        let options = PackOptions { exact, ..PackOptions::default() };
        let bytes = pack(&file, &options).expect("a sound file").bytes;
        let [head, first] = first_triangles(&bytes);
        assert!(first <= head + 600, "{first} bytes before its first triangles");
        assert!(bytes.len() > 20_000, "{} bytes", bytes.len());
        let ordered = if exact { &file } else { &in_stream_order(&file) };
        check(&fed(&bytes), 0, &ordered.objects[0].simplified, "pieces");
    }
}
