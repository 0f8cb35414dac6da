use crate::entropy::coder::Coder;
use crate::entropy::decoder::Decoder;
use crate::entropy::encoder::Encoder;
use crate::mesh_decoder::{MeshDecoder, StepBlock};
use crate::mesh_encoder::{BlockTarget, EncodedSteps, MeshEncoder};
use crate::partial_mesh::mesh::PartialMesh;
use crate::partial_mesh::new_triangle::{NewTriangle, Side};
use crate::partial_mesh::split::{ParentStar, SplitBuffers, SplitEdge};
use crate::source::batches::StepOrder;
use crate::source::coding_parents::StarRule;
use crate::source::encoder_source::EncoderSource;
use crate::source::split_source::{DecoderSource, SplitSource};
use crate::vertex_data::vertex_layout::VertexLayout;
use crate::vertex_split::contexts::Contexts;
use crate::vertex_split::face_list::FaceListContexts;
use crate::vertex_split::neighbourhood::SplitNeighbourhood;
use lodc_fixtures as fixtures;
use lodc_mesh::{
    CollapseSequence, Lod, Mesh, MeshParts, OrientedTriangle, SequenceParts, Simplified, Submesh,
};

/// Encodes with this rule and decodes block by block; after each the mesh is that of the reference.
/// Returns whether a star was named.
fn check(simplified: &Simplified, rule: StarRule, what: &str) -> bool {
    let layout = VertexLayout::choose(simplified);
    let mut encoder = MeshEncoder::with_rule(simplified, layout, StepOrder::Exact, rule);
    let mut decoder = MeshDecoder::new(encoder.header().clone());
    decoder.set_large_star(rule.large_star);
    let (mut encoded, mut decoded) = (Contexts::new(), Contexts::new());
    while !encoder.is_complete() {
        let target = BlockTarget { bytes: 60, bytes_before: 1 << 20, until_triangle: false };
        let EncodedSteps { steps, splits } = encoder.encode(&mut encoded, target);
        let block = StepBlock { steps, splits: &splits, bytes: 1 << 20 };
        decoder.decode(&mut decoded, block).unwrap_or_else(|e| panic!("{what}: {}", e.0));
        let lod = Lod(encoder.header().vertices - decoder.vertex_count());
        let last = decoder.vertex_count() - 1;
        let submesh = |t: [u32; 3]| decoder.vertex_submesh()[t[0] as usize];
        let oriented = |t| OrientedTriangle::new(submesh(t), t.map(|v| lod.0 + last - v));
        let mut decoded_triangles: Vec<_> = decoder.triangles().map(oriented).collect();
        let mut wanted = simplified.triangles_at(lod);
        decoded_triangles.sort_unstable();
        wanted.sort_unstable();
        assert!(decoded_triangles == wanted, "{what} at {lod:?}");
    }
    assert!(decoder.is_complete(), "{what}");
    assert_eq!(decoder.mesh_parts().positions, simplified.mesh().positions(), "{what}");
    let last = simplified.collapses().records();
    let targets = simplified.collapses().targets().iter().rev().map(|t| last - t);
    assert!(targets.eq(decoder.targets().iter().skip(1).copied()), "{what}");
    let layout = &encoder.header().layout;
    let source = EncoderSource::new(simplified, layout, StepOrder::Exact, rule);
    (0..encoder.header().vertices).any(|v| source.face_list(v).is_some())
}

#[test]
fn every_shape_is_decoded_with_any_stars_named() {
    let mut named = [0; 2];
    for (name, make) in fixtures::ALL {
        let mesh = make();
        if mesh.vertex_count() == 0 {
            continue;
        }
        for (seed, (large_star, max_star_ratio)) in (0..).zip([(0, 0), (2, 1), (4, 2), (6, 3)]) {
            let simplified = fixtures::random_collapse(&mesh, seed);
            let rule = StarRule { large_star, max_star_ratio, max_total_ratio: 0 };
            named[usize::from(check(&simplified, rule, &format!("{name}, seed {seed}")))] += 1;
        }
    }
    assert!(named[0] > 0 && named[1] > 2 * named[0], "{named:?}");
}

#[test]
fn hubs_are_decoded_with_and_without_names() {
    for seed in 0..3 {
        let flaps = fixtures::random_collapse(&fixtures::flaps(700), seed);
        let book = fixtures::random_collapse(&fixtures::book(400), seed);
        for (mesh, max_total_ratio) in [(&flaps, 0), (&flaps, 1 << 30), (&book, 0)] {
            let rule = StarRule { max_total_ratio, ..StarRule::DEFAULT };
            let what = format!("seed {seed}, ratio {max_total_ratio}");
            assert_eq!(check(mesh, rule, &what), max_total_ratio == 0);
        }
    }
}

/// `n` flaps of two triangles (high-valence vertex, a, b) and (a, c, b): first every a collapses
/// onto the high-valence vertex, which takes over the other triangle, then every c and b.
fn opened_flaps(n: u32) -> Simplified {
    let submesh = Submesh { first_triangle: 0, triangle_count: 2 * n, ..Submesh::default() };
    let flap = |i: u32| [[3 * n, i, n + 2 * i + 1], [i, n + 2 * i, n + 2 * i + 1]];
    let mesh = Mesh::try_from(MeshParts {
        positions: (0..=3 * n).map(|i| [(i % 89) as f32, (i / 89) as f32, 0.0]).collect(),
        vertex_submesh: vec![0; 3 * n as usize + 1],
        attributes: Vec::new(),
        submeshes: vec![submesh],
        triangles: (0..n).flat_map(flap).collect(),
    });
    let live_triangles = |lod: u32| if lod <= n { 2 * n - lod } else { n - (lod - n).div_ceil(2) };
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: vec![3 * n; 3 * n as usize],
        step_ends: (1..=3 * n).collect(),
        step_errors: vec![0.0; 3 * n as usize],
        step_rms: vec![],
        step_triangles: (1..=3 * n).map(live_triangles).collect(),
        triangles: 2 * n,
        last_legal_lod: Lod(0),
        topology_changes: 0,
        first_topology_change: None,
    });
    Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence")).expect("simplified")
}

#[test]
fn hubs_that_are_named_are_not_walked_around() {
    let n = 5_000;
    let flaps = opened_flaps(n);
    let layout = VertexLayout::choose(&flaps);
    let [named, walked] = [32, 1 << 30].map(|max_total_ratio| {
        let rule = StarRule { max_total_ratio, ..StarRule::DEFAULT };
        let mut encoder = MeshEncoder::with_rule(&flaps, layout.clone(), StepOrder::Exact, rule);
        let target = BlockTarget { bytes: usize::MAX, bytes_before: 0, until_triangle: false };
        encoder.encode(&mut Contexts::new(), target);
        encoder.package_bytes()
    });
    // The thesis's packages have a bit for each triangle of a star.
    let vertices = 3 * u64::from(n);
    assert!(named < 40 * vertices && walked > 200 * vertices, "{named} {walked}");
}

/// A split of 10 off vertex 0, amid vertices 1 to 6; there is a triangle apart.
fn hexagon() -> (PartialMesh, SplitNeighbourhood) {
    let (mut mesh, mut split) = (PartialMesh::default(), SplitNeighbourhood::default());
    for _ in 0..11 {
        mesh.add_vertex(0);
    }
    let star: Vec<_> =
        (1..7).map(|i| NewTriangle::unconnected(i, i % 6 + 1, Side::Detached)).collect();
    let apart = [NewTriangle::unconnected(8, 9, Side::Detached)];
    for (new, triangles) in [(0, &star[..]), (7, &apart)] {
        let empty = ParentStar { faces: &[], transfer: &[], is_part: false };
        let edge = SplitEdge { parent: 10, new };
        mesh.split(edge, empty, triangles, &mut SplitBuffers::default(), &mut Vec::new());
    }
    split.start(10, 0, false);
    (mesh, split)
}

/// Decodes a star of `size` triangles, named by `faces`: their numbers, or the fault.
fn named(size: u32, faces: &[u32]) -> Result<Vec<u32>, &'static str> {
    let (mut coder, mut contexts) = (Encoder::default(), FaceListContexts::NEW);
    coder.bit(&mut contexts.is_named, true);
    contexts.size.code(&mut coder, size);
    for &face in faces {
        coder.uniform(7, face);
    }
    let bytes = coder.finish().into_bytes(0);
    let ((mesh, mut split), mut contexts) = (hexagon(), FaceListContexts::NEW);
    let mut coder = Decoder::new(&bytes);
    let decoded = split.code_star(&mut coder, &DecoderSource, &mut contexts, &mesh, 5);
    decoded.map_err(|e| e.0).map(|()| split.star.iter().map(|f| f.face()).collect())
}

#[test]
fn what_is_named_must_be_different_triangles_of_the_star() {
    assert_eq!(named(0, &[]), Ok(vec![]));
    assert_eq!(named(2, &[4, 1]), Ok(vec![4, 1]));
    assert_eq!(named(6, &[5, 4, 3, 2, 1, 0]), Ok(vec![5, 4, 3, 2, 1, 0]));
    assert_eq!(named(2, &[4, 6]), Err("names a triangle of another star"));
    assert_eq!(named(3, &[4, 1, 4]), Err("names a triangle twice"));
    assert_eq!(named(7, &[0; 7]), Err("names more triangles than a star has"));
    assert_eq!(named(u32::MAX, &[]), Err("names more triangles than a star has"));
}

#[test]
fn a_triangle_that_a_crafted_stream_took_out_of_a_star_cannot_be_named() {
    let (mut mesh, _) = hexagon();
    mesh.corners.exchange(0, &[4 * 2], &[], &[]);
    assert_eq!(mesh.star_face(2, 0), None);
    assert_eq!(mesh.star_face(3, 0).map(|f| (f.corner, f.a, f.b)), Some((12, 4, 5)));
}
