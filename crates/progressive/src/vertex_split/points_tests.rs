use crate::entropy::encoder::Encoder;
use crate::header::MeshHeader;
use crate::mesh_decoder::{MeshDecoder, StepBlock};
use crate::mesh_encoder::{BlockTarget, MeshEncoder};
use crate::source::batches::StepOrder;
use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::vertex_layout::VertexLayout;
use crate::vertex_split::contexts::Contexts;
use lodc_mesh::{CollapseSequence, Lod, Mesh, MeshParts, SequenceParts, Simplified, Submesh};

/// Two triangles and a vertex that none uses. In stream order: the points 0 and 1 of the first
/// triangle, 2 of none, 3 and 4 of the second, then a vertex for each triangle.
fn two_triangles_and_a_point() -> Simplified {
    let submesh = Submesh { first_triangle: 0, triangle_count: 2, ..Submesh::default() };
    let mesh = Mesh::try_from(MeshParts {
        positions: (0..7).map(|i| [i as f32, (i * i) as f32, 0.5]).collect(),
        vertex_submesh: vec![0; 7],
        attributes: Vec::new(),
        submeshes: vec![submesh],
        triangles: vec![[1, 5, 6], [0, 2, 3]],
    });
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: vec![2, 5, 3, 6, 6, 6],
        step_ends: (1..=6).collect(),
        step_errors: vec![0.0, 1.0, 2.0, 2.0, 2.0, 2.0],
        step_rms: vec![],
        step_triangles: vec![1, 0, 0, 0, 0, 0],
        triangles: 2,
        last_legal_lod: Lod(0),
        topology_changes: 0,
        first_topology_change: None,
    });
    Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence")).expect("simplified")
}

#[test]
fn points_come_when_a_split_or_a_triangle_needs_them_and_the_others_last() {
    let simplified = two_triangles_and_a_point();
    let layout = VertexLayout::choose(&simplified);
    let mut encoder = MeshEncoder::new(&simplified, layout, StepOrder::Exact);
    let mut decoder = MeshDecoder::new(encoder.header().clone());
    let (mut encoded, mut decoded) = (Contexts::new(), Contexts::new());
    let mut come = Vec::new();
    while !encoder.is_complete() {
        let target = BlockTarget { bytes: 0, bytes_before: 0, until_triangle: false };
        let block = encoder.encode(&mut encoded, target);
        let steps = StepBlock { steps: 1, splits: &block.splits, bytes: 1000 };
        decoder.decode(&mut decoded, steps).expect("a sound block");
        let vertices = decoder.vertex_count();
        come.push((vertices, (0..vertices).filter(|&v| decoder.has_come(v)).collect::<Vec<_>>()));
        assert!(decoder.triangles().flatten().all(|v| decoder.has_come(v)));
    }
    let wanted = [(6, vec![0, 1, 5]), (7, vec![0, 1, 3, 4, 5, 6]), (7, (0..7).collect())];
    assert_eq!(come, wanted);
    assert!(decoder.is_complete() && decoder.header().steps == 3);
    assert_eq!(decoder.targets(), [0, 0, 0, 0, 3, 1, 4]);
    assert_eq!(decoder.mesh_parts().positions, simplified.mesh().positions());
}

/// Decodes a block that announces `points` points of an object with `vertices` vertices.
fn announced(points: u32, vertices: u32) -> &'static str {
    let (mut coder, mut contexts) = (Encoder::default(), Contexts::new());
    contexts.points.count.code(&mut coder, points - 1);
    let splits = coder.finish().into_bytes(0);
    let header = MeshHeader { vertices, triangles: 1, steps: 1, ..MeshHeader::unknown(1) };
    let mut decoder = MeshDecoder::new(header);
    let block = StepBlock { steps: 1, splits: &splits, bytes: splits.len() };
    decoder.decode(&mut Contexts::new(), block).expect_err("a crafted block").0
}

#[test]
fn a_few_bytes_cannot_announce_many_points() {
    assert_eq!(announced(8, 7), "has more vertices than its header says");
    assert_eq!(announced(u32::MAX, 7), "has more vertices than its header says");
    // Eleven units each: three channels and eight.
    let most = (1 << 20) / 11;
    assert_ne!(announced(most, u32::MAX), "expands more than any real stream");
    assert_eq!(announced(most + 2000, u32::MAX), "expands more than any real stream");
    assert_eq!(announced(u32::MAX, u32::MAX), "expands more than any real stream");
}

#[test]
fn a_position_that_is_not_finite_fails_its_step() {
    let simplified = two_triangles_and_a_point();
    let mut encoder =
        MeshEncoder::new(&simplified, VertexLayout::choose(&simplified), StepOrder::Exact);
    let mut header = encoder.header().clone();
    // What is 2 or more in the steps of the encoder is infinite in these.
    header.layout.systems.fill(NumberSystem::Grid { origin: 0.0, step: f32::MAX });
    let mut decoder = MeshDecoder::new(header);
    let target = BlockTarget { bytes: 0, bytes_before: 0, until_triangle: false };
    let block = encoder.encode(&mut Contexts::new(), target);
    let block = StepBlock { steps: 1, splits: &block.splits, bytes: 1000 };
    let error = decoder.decode(&mut Contexts::new(), block).expect_err("it is infinite");
    assert_eq!(error.0, "has a position that is not a finite number");
    let positions = decoder.mesh_parts().positions;
    assert!(positions.into_flattened().into_iter().all(f32::is_finite));
}
