//! The reference answer, worked by hand on a strip of four triangles with a seam.

use crate::parts;
use lodc_mesh::{
    CollapseSequence, Lod, Mesh, OrientedTriangle, SequenceParts, Simplified, SimplifiedError,
};

/// Five points in a row of squares cut in half; the point in the middle of the bottom has two
/// wedges (0 and 1).
///
/// ```text
///   2 --- 5 --- 6        triangles 2: (0 5 2)  1: (3 0 2)
///   | \   | \   |                  0: (4 6 1)  3: (6 5 1)
///   3 --- 01 -- 4
/// ```
fn strip() -> (Mesh, SequenceParts) {
    let at = |x: f32, y: f32| [x, y, 0.0];
    let positions = [
        at(1.0, 0.0),
        at(1.0, 0.0),
        at(0.0, 1.0),
        at(0.0, 0.0),
        at(2.0, 0.0),
        at(1.0, 1.0),
        at(2.0, 1.0),
    ];
    let mesh = Mesh::try_from(parts(&positions, &[[4, 6, 1], [6, 5, 1], [0, 5, 2], [3, 0, 2]]))
        .expect("a valid mesh");
    let sequence = SequenceParts {
        // Both wedges go to the left end: wedge 0 along its edge, wedge 1 with it; then the rest,
        // one by one.
        targets: vec![3, 3, 5, 5, 6, 6],
        step_ends: vec![2, 3, 4, 5, 6],
        step_errors: vec![0.0; 5],
        step_triangles: vec![3, 2, 1, 0, 0],
        triangles: 4,
        ..SequenceParts::default()
    };
    (mesh, sequence)
}

fn simplified() -> Simplified {
    let (mesh, sequence) = strip();
    Simplified::new(mesh, CollapseSequence::try_from(sequence).expect("a valid sequence"))
        .expect("they fit")
}

#[test]
fn the_reference_is_what_a_hand_finds() {
    let s = simplified();
    let at = |lod: u32| {
        let mut t: Vec<[u32; 3]> = s.triangles_at(Lod(lod)).iter().map(|t| t.corners).collect();
        t.sort_unstable();
        t
    };
    assert_eq!(at(0), [[0, 2, 3], [0, 5, 2], [1, 4, 6], [1, 6, 5]]);
    // Inside a step: wedge 0 has gone, wedge 1 has not. Taken as it is, not rounded.
    assert_eq!(at(1), [[1, 4, 6], [1, 6, 5], [2, 3, 5]]);
    assert_eq!(at(2), [[2, 3, 5], [3, 4, 6], [3, 6, 5]]);
    assert_eq!(at(3), [[3, 4, 6], [3, 6, 5]]);
    assert_eq!(at(4), [[4, 6, 5]]);
    assert_eq!((at(5), at(6), at(7)), (vec![], vec![], vec![]));
    for i in 0..s.collapses().steps() {
        let step = s.collapses().step(i);
        assert_eq!(at(step.lod.0).len(), step.triangles as usize);
    }
}

#[test]
fn a_triangle_between_wedges_of_one_position_is_dead() {
    // Vertices 1 and 2 share a position but no index; once 0 has gone to 1, a triangle has corners
    // 1, 2, 3.
    let positions = [[0.0, 1.0, 0.0], [0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]];
    let mesh = Mesh::try_from(parts(&positions, &[[0, 2, 3]])).expect("a valid mesh");
    let sequence = SequenceParts {
        targets: vec![1, 2, 3],
        step_ends: vec![1, 2, 3],
        step_errors: vec![0.0; 3],
        step_triangles: vec![0; 3],
        triangles: 1,
        ..SequenceParts::default()
    };
    let s =
        Simplified::new(mesh, sequence.try_into().expect("a valid sequence")).expect("they fit");
    assert_eq!(s.triangles_at(Lod(0)), [OrientedTriangle::new(0, [0, 2, 3])]);
    assert!(s.triangles_at(Lod(1)).is_empty());
    assert_eq!(s.fakes(), 1);
}

#[test]
fn sizes_that_do_not_match_are_refused() {
    let (mesh, sequence) = strip();
    let refused = |p: SequenceParts| {
        Simplified::new(mesh.clone(), CollapseSequence::try_from(p).expect("a valid sequence"))
            .expect_err("no match")
    };
    let other = SequenceParts { triangles: 5, ..sequence.clone() };
    assert_eq!(refused(other), SimplifiedError::Triangles { mesh: 4, sequence: 5 });
    let mut longer = sequence;
    longer.targets.push(7);
    *longer.step_ends.last_mut().expect("five steps") = 7;
    assert_eq!(refused(longer), SimplifiedError::Records { vertices: 7, records: 7 });
}

#[test]
fn nothing_simplifies_to_nothing() {
    let none =
        CollapseSequence::try_from(SequenceParts::default()).expect("nothing breaks no rule");
    let s = Simplified::new(lodc_fixtures::empty(), none).expect("they fit");
    assert!(s.triangles_at(Lod(0)).is_empty() && s.triangles_at(Lod(9)).is_empty());
    assert_eq!(s.fakes(), 0);
}

#[test]
fn live_triangles_come_first_in_arbitrary_sequences() {
    for seed in 0..30 {
        let s = lodc_fixtures::random_collapse(&lodc_fixtures::random(seed), seed);
        let positions = s.mesh().position_ids();
        for i in (0..s.collapses().steps()).step_by(7) {
            let step = s.collapses().step(i);
            assert_eq!(s.triangles_at_with(step.lod, &positions), s.triangles_at(step.lod));
            assert_eq!(
                s.triangles_at(step.lod).len(),
                step.triangles as usize,
                "seed {seed}, step {i}"
            );
        }
    }
}
