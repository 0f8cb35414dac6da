//! Collapse sequences: valid by construction, and their questions answered by hand on a small one.

use lodc_mesh::{CollapseSequence, Lod, SequenceError, SequenceParts, Step};

/// Six records in four steps: (0 1) (2) (3 4) (5).
fn small() -> SequenceParts {
    SequenceParts {
        targets: vec![2, 3, 5, 6, 5, 6],
        step_ends: vec![2, 3, 5, 6],
        step_errors: vec![0.5, 0.5, 1.0, 4.0],
        step_rms: vec![],
        step_triangles: vec![6, 6, 2, 0],
        triangles: 8,
        last_legal_lod: Lod(5),
        topology_changes: 1,
        first_topology_change: Some(Lod(3)),
    }
}

fn sequence() -> CollapseSequence {
    CollapseSequence::try_from(small()).expect("a valid sequence")
}

#[test]
fn a_level_is_shown_at_the_step_before_it() {
    let s = sequence();
    let floors: Vec<u32> = (0..9).map(|l| s.floor(Lod(l)).0).collect();
    assert_eq!(floors, [0, 0, 2, 3, 3, 5, 6, 6, 6]);
    let triangles: Vec<u32> = (0..9).map(|l| s.triangles_at(Lod(l))).collect();
    assert_eq!(triangles, [8, 8, 6, 6, 6, 2, 0, 0, 0]);
    let errors: Vec<f32> = (0..9).map(|l| s.error_at(Lod(l))).collect();
    assert_eq!(errors, [0.0, 0.0, 0.5, 0.5, 0.5, 1.0, 4.0, 4.0, 4.0]);
    let steps: Vec<usize> = (0..9).map(|l| s.steps_at(Lod(l))).collect();
    assert_eq!(steps, [0, 0, 1, 2, 2, 3, 4, 4, 4]);
    assert_eq!(s.step(2), Step { lod: Lod(5), error: 1.0, triangles: 2 });
    assert_eq!((s.records(), s.steps(), s.last()), (6, 4, Lod(6)));
}

/// Steps of one record, of two, of many, and mixtures, at every LOD and beyond the last.
#[test]
fn steps_are_found_as_by_counting_them() {
    let lengths: [fn(u32) -> u32; 6] = [
        |_| 1,
        |_| 2,
        |_| 100,
        |i| 1 + i % 2,
        |i| 1 + u32::from(i % 40 == 39) * 70,
        |i| 1 + i * i % 13,
    ];
    for length in lengths {
        for records in [1, 31, 32, 33, 64, 700] {
            let mut step_ends = Vec::new();
            while step_ends.last().is_none_or(|&end| end < records) {
                let end = step_ends.last().copied().unwrap_or(0) + length(step_ends.len() as u32);
                step_ends.push(end.min(records));
            }
            let steps = step_ends.len();
            let parts = SequenceParts {
                targets: (1..=records).collect(),
                step_ends: step_ends.clone(),
                step_errors: vec![0.0; steps],
                step_triangles: vec![0; steps],
                ..SequenceParts::default()
            };
            let s = CollapseSequence::try_from(parts).expect("a valid sequence");
            for lod in 0..records + 70 {
                let complete = step_ends.iter().filter(|&&end| end <= lod).count();
                assert_eq!(s.steps_at(Lod(lod)), complete, "LOD {lod} of {records}");
                assert_eq!(s.floor(Lod(lod)).0, step_ends[..complete].last().copied().unwrap_or(0));
            }
        }
    }
}

#[test]
fn levels_are_found_by_triangles_and_by_error() {
    let s = sequence();
    let by_triangles: Vec<u32> = (0..10).map(|n| s.lod_for_triangles(n).0).collect();
    assert_eq!(by_triangles, [6, 6, 5, 5, 5, 5, 2, 2, 0, 0]);
    let by_error =
        [0.0, 0.49, 0.5, 0.9, 1.0, 3.9, 4.0, f32::INFINITY].map(|e| s.lod_for_error(e).0);
    assert_eq!(by_error, [0, 0, 3, 3, 5, 5, 6, 6]);
    assert_eq!(s.lod_for_error(f32::NAN), Lod(0));
    assert_eq!(s.last_visible(), Lod(5));
}

#[test]
fn vertices_resolve_through_chains_up_to_the_level() {
    let s = sequence();
    let at = |lod| (0..7).map(|v| s.resolve(v, Lod(lod))).collect::<Vec<_>>();
    assert_eq!(at(0), [0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(at(1), [2, 1, 2, 3, 4, 5, 6]);
    assert_eq!(at(2), [2, 3, 2, 3, 4, 5, 6]);
    assert_eq!(at(3), [5, 3, 5, 3, 4, 5, 6]);
    assert_eq!(at(5), [5, 6, 5, 6, 5, 5, 6]);
    assert_eq!(at(6), [6; 7]);
    for lod in 0..=6 {
        assert_eq!(s.resolve_all(Lod(lod)), at(lod));
        let mut gone = vec![7; 9];
        s.resolve_gone(Lod(lod), &mut gone);
        assert_eq!(gone, at(lod)[..lod as usize]);
    }
}

#[test]
fn a_level_beyond_the_last_is_the_last() {
    let s = sequence();
    assert_eq!(s.resolve(0, Lod(u32::MAX)), 6);
    assert_eq!(s.resolve_all(Lod(u32::MAX)), [6; 7]);
    assert_eq!(s.triangles_at(Lod(u32::MAX)), 0);
}

#[test]
fn every_rule_names_its_first_offender() {
    let refused = |spoil: &dyn Fn(&mut SequenceParts)| {
        let mut p = small();
        spoil(&mut p);
        CollapseSequence::try_from(p).expect_err("a broken rule")
    };
    assert_eq!(refused(&|p| p.targets[1] = 1), SequenceError::Target { record: 1 });
    assert_eq!(refused(&|p| p.targets[4] = 3), SequenceError::Target { record: 4 });
    assert_eq!(refused(&|p| p.targets[0] = 7), SequenceError::Target { record: 0 });
    assert_eq!(refused(&|p| p.targets[0] = u32::MAX), SequenceError::Target { record: 0 });
    assert_eq!(refused(&|p| p.step_errors.truncate(3)), SequenceError::Lengths);
    assert_eq!(refused(&|p| p.step_triangles.push(0)), SequenceError::Lengths);
    assert_eq!(refused(&|p| p.step_ends[1] = 2), SequenceError::Step { step: 1 });
    assert_eq!(refused(&|p| p.step_ends[0] = 0), SequenceError::Step { step: 0 });
    assert_eq!(refused(&|p| p.step_errors[2] = 0.4), SequenceError::Step { step: 2 });
    assert_eq!(refused(&|p| p.step_errors[0] = -1.0), SequenceError::Step { step: 0 });
    assert_eq!(refused(&|p| p.step_errors[3] = f32::NAN), SequenceError::Step { step: 3 });
    assert_eq!(refused(&|p| p.step_errors[2] = f32::INFINITY), SequenceError::Step { step: 2 });
    assert_eq!(refused(&|p| p.step_rms = vec![0.1]), SequenceError::Lengths);
    for (rms, step) in [([0.1, 0.2, 0.1, 1.0], 2), ([0.1, 0.6, 0.6, 1.0], 1)] {
        let refused = refused(&|p| p.step_rms = rms.to_vec());
        assert_eq!(refused, SequenceError::Step { step });
    }
    assert_eq!(refused(&|p| p.step_triangles[0] = 9), SequenceError::Step { step: 0 });
    assert_eq!(refused(&|p| p.step_triangles[3] = 3), SequenceError::Step { step: 3 });
    assert_eq!(refused(&|p| p.step_ends[3] = 7), SequenceError::Step { step: 4 });
    assert_eq!(refused(&|p| p.targets.push(7)), SequenceError::Step { step: 4 });
    assert_eq!(refused(&|p| p.last_legal_lod = Lod(7)), SequenceError::Step { step: 4 });
    assert_eq!(
        refused(&|p| p.first_topology_change = Some(Lod(7))),
        SequenceError::Step { step: 4 }
    );
    assert!(refused(&|p| p.targets[4] = 3).to_string().contains("record 4"));
}

#[test]
fn measured_errors_end_in_infinity_and_are_found_by_either_curve() {
    let estimate = sequence();
    assert!(!estimate.is_measured());
    assert_eq!((estimate.rms_at(Lod(3)), estimate.lod_for_rms(1.0)), (None, None));
    let s = CollapseSequence::try_from(SequenceParts {
        step_errors: vec![0.5, 0.5, 1.0, f32::INFINITY],
        step_rms: vec![0.0, 0.1, 0.2, f32::INFINITY],
        ..small()
    })
    .expect("infinite without a triangle");
    assert!(s.is_measured());
    let at = |lod| s.rms_at(Lod(lod)).expect("it is measured");
    assert_eq!([0, 2, 4, 5].map(at), [0.0, 0.0, 0.1, 0.2]);
    assert_eq!([0.0, 0.15, 9.0].map(|e| s.lod_for_rms(e)), [2, 3, 5].map(|l| Some(Lod(l))));
    assert_eq!(s.lod_for_error(f32::MAX), s.last_visible());
}

#[test]
fn nothing_is_a_sequence() {
    let s = CollapseSequence::try_from(SequenceParts::default()).expect("nothing breaks no rule");
    assert_eq!(
        (s.records(), s.last_visible(), s.lod_for_triangles(0), s.floor(Lod(3))),
        (0, Lod(0), Lod(0), Lod(0))
    );
    assert_eq!(s.resolve_all(Lod(5)), [0]);
}

#[test]
fn parts_come_back_as_they_went_in() {
    assert_eq!(sequence().into_parts(), small());
    assert_eq!(sequence().parts(), &small());
}
