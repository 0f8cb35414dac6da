use crate::mesh_decoder::{MeshDecoder, StepBlock};
use crate::mesh_encoder::{BlockTarget, EncodedSteps, MeshEncoder};
use crate::source::batches::StepOrder;
use crate::source::coding_parents::StarRule;
use crate::source::encoder_source::EncoderSource;
use crate::source::first_appearance::first_appearances;
use crate::source::split_source::SplitSource;
use crate::vertex_data::vertex_layout::VertexLayout;
use crate::vertex_split::contexts::Contexts;
use lodc_mesh::{
    CollapseSequence, Lod, Mesh, MeshParts, NONE, SequenceParts, Simplified, Submesh,
    is_degenerate, removal_lods,
};

fn simplified(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, targets: Vec<u32>) -> Simplified {
    let vertices = positions.len() as u32;
    let submesh =
        Submesh { first_triangle: 0, triangle_count: triangles.len() as u32, ..Submesh::default() };
    let mesh = Mesh::try_from(MeshParts {
        positions,
        vertex_submesh: vec![0; vertices as usize],
        attributes: Vec::new(),
        submeshes: vec![submesh],
        triangles,
    });
    let (records, faces) = (vertices - 1, vertices - 2);
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets,
        step_ends: (1..=records).collect(),
        step_errors: vec![0.0; records as usize],
        step_rms: vec![],
        step_triangles: (1..=records).map(|lod| faces - lod.min(faces)).collect(),
        triangles: faces,
        last_legal_lod: Lod(0),
        topology_changes: 0,
        first_topology_change: None,
    });
    Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence"))
        .expect("a simplified mesh")
}

/// A fan of triangles in which each vertex collapses onto the next: paths of collapses as long as
/// the mesh.
fn chain(n: u32) -> Simplified {
    let positions = (0..n).map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
    let triangles = (0..n - 2).map(|i| [i, i + 1, n - 1]).collect();
    simplified(positions, triangles, (1..n).collect())
}

/// A fan in which every vertex collapses onto the high-valence vertex.
fn center(n: u32) -> Simplified {
    let positions = (0..n).map(|i| [i as f32, (i % 89 * (i % 97)) as f32, 0.0]).collect();
    let triangles = (0..n - 2).map(|i| [i, i + 1, n - 1]).collect();
    simplified(positions, triangles, vec![n - 1; n as usize - 1])
}

/// First appearances by definition: the corners resolved one by one at the step before the removal.
fn check_first_appearances(simplified: &Simplified) {
    let collapses = simplified.collapses();
    let positions = simplified.mesh().position_ids();
    let removal = removal_lods(simplified, &positions);
    let starts: Vec<u32> =
        std::iter::once(0).chain(collapses.parts().step_ends.iter().copied()).collect();
    for (i, (appearance, &triangle)) in
        first_appearances(simplified).iter().zip(simplified.mesh().triangles()).enumerate()
    {
        let step = collapses.parts().step_ends.partition_point(|&end| end < removal[i]);
        let resolve = |mut v: u32| {
            while v < starts[step] {
                v = collapses.targets()[v as usize];
            }
            v
        };
        let corners: [u32; 3] =
            std::array::from_fn(|c| resolve(triangle[(appearance.rotation + c) % 3]));
        assert!(!is_degenerate(corners), "triangle {i}");
        assert!(corners[0] < corners[1] && corners[0] < corners[2], "triangle {i}");
        assert_eq!(appearance.vertices, corners.map(|v| collapses.records() - v), "triangle {i}");
    }
}

#[test]
fn first_appearances_are_the_corners_before_the_removal() {
    for (_, make) in lodc_fixtures::ALL {
        for seed in 0..3 {
            check_first_appearances(&lodc_fixtures::random_collapse(&make(), seed));
        }
    }
    check_first_appearances(&chain(500));
    check_first_appearances(&center(500));
}

#[test]
fn chains_and_hubs_take_near_linear_time() {
    // Following each collapse one by one would take 10^10 operations.
    let n = 100_000;
    for simplified in [chain(n), center(n)] {
        let layout = VertexLayout::choose(&simplified);
        let source = EncoderSource::new(&simplified, &layout, StepOrder::Exact, StarRule::DEFAULT);
        let triangles: usize = (0..n).map(|v| source.new_triangles(v).len()).sum();
        assert_eq!(triangles, n as usize - 2);
        assert!((1..n).all(|v| source.parent(v) < v && source.indices(v).len() == 3));
        assert_ne!(source.parent(n - 1), NONE);
    }
}

#[test]
fn vertices_that_take_nothing_from_a_large_star_are_coded_as_split_off_one_another() {
    // Triangles around one edge, like the pages of a book. The last one is the first in the stream:
    // each vertex brings one, and takes over none.
    let n = 5_000;
    let positions = (0..n).map(|i| [i as f32, (i % 89 * (i % 97)) as f32, 0.0]).collect();
    let triangles = (0..n - 2).map(|i| [i, n - 2, n - 1]).collect();
    let target_of = |v: u32| if v.is_multiple_of(2) || v == n - 2 { n - 1 } else { n - 2 };
    let book = simplified(positions, triangles, (0..n - 1).map(target_of).collect());
    let layout = VertexLayout::choose(&book);
    let source = EncoderSource::new(&book, &layout, StepOrder::Exact, StarRule::DEFAULT);
    let target = |new: u32| n - 1 - target_of(n - 1 - new);
    for new in 2..n {
        // Each of the first 256 triangles leaves the stars of both high-valence vertices small
        // enough.
        let wanted = if new < 2 + 257 { target(new) } else { new - 2 };
        assert_eq!(source.parent(new), wanted, "{new}");
        assert_eq!(source.repeats_target(new), new >= 2 + 257, "{new}");
    }
    // The thesis's packages have a bit for each triangle of a star.
    let mut encoder = MeshEncoder::new(&book, layout, StepOrder::Exact);
    let (mut contexts, mut decoded) = (Contexts::new(), Contexts::new());
    let mut decoder = MeshDecoder::new(encoder.header().clone());
    while !encoder.is_complete() {
        let target = BlockTarget { bytes: 1000, bytes_before: 1 << 20, until_triangle: false };
        let EncodedSteps { steps, splits } = encoder.encode(&mut contexts, target);
        let block = StepBlock { steps, splits: &splits, bytes: 1 << 20 };
        decoder.decode(&mut decoded, block).expect("a sound block");
    }
    assert!(encoder.package_bytes() < 40 * u64::from(n), "{}", encoder.package_bytes());
    assert!(decoder.is_complete());
    assert!((2..n).all(|new| decoder.targets()[new as usize] == target(new)));
}
