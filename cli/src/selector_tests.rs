//! Selectors on sequences small enough to check by hand.

use super::*;
use lodc_mesh::SequenceParts;

/// Single-record steps with these errors and live triangles.
fn sequence(triangles: u32, steps: &[(f32, u32)]) -> CollapseSequence {
    let records = steps.len() as u32;
    CollapseSequence::try_from(SequenceParts {
        targets: (1..=records).collect(),
        step_ends: (1..=records).collect(),
        step_errors: steps.iter().map(|s| s.0).collect(),
        step_triangles: steps.iter().map(|s| s.1).collect(),
        triangles,
        ..SequenceParts::default()
    })
    .expect("steps in order make a sequence")
}

fn object(collapses: &CollapseSequence, scale: f64) -> Candidate<'_> {
    Candidate { name: "object", collapses, scale, diagonal: 10.0 }
}

fn lods(objects: &[Candidate<'_>], target: Target) -> Vec<u32> {
    select(objects, target, false).expect("a target that fits").lods.iter().map(|l| l.0).collect()
}

#[test]
fn one_object_is_met_as_the_contract_says() {
    let c = sequence(10, &[(0.1, 8), (0.2, 6), (0.2, 4), (0.4, 2), (0.8, 0)]);
    let o = [object(&c, 3.0)];
    assert_eq!(lods(&o, Target::Lod(2)), [2]);
    assert_eq!(lods(&o, Target::Lod(99)), [5]);
    assert_eq!(lods(&o, Target::Ratio(1.0)), [0]);
    assert_eq!(lods(&o, Target::Ratio(0.59)), [3], "floor(5.9) is 5");
    assert_eq!(lods(&o, Target::Triangles(6)), [2]);
    assert_eq!(lods(&o, Target::Error(0.2)), [3], "mesh units, whatever the node's scale");
    assert_eq!(lods(&o, Target::ErrorShare(0.04)), [4]);
    assert_eq!(lods(&o, Target::Error(0.0)), [0]);
}

#[test]
fn an_object_with_triangles_never_comes_back_empty_except_by_record() {
    let c = sequence(10, &[(0.1, 8), (0.4, 2), (0.8, 0)]);
    let o = [object(&c, 1.0)];
    for target in
        [Target::Ratio(0.0), Target::Triangles(0), Target::Triangles(1), Target::Error(9.0)]
    {
        let chosen = select(&o, target, false).expect("a target that fits");
        assert_eq!(chosen.lods, [Lod(2)], "{target:?}");
        assert_eq!(chosen.warnings.len(), 1, "{target:?}");
    }
    assert_eq!(lods(&o, Target::Lod(3)), [3]);
}

#[test]
fn a_scene_spends_its_triangles_where_the_world_error_is() {
    // The second object is shown ten times as large: its steps cost ten times as much.
    let c = sequence(10, &[(0.1, 8), (0.2, 6), (0.3, 4), (0.4, 2), (0.5, 0)]);
    let o = [object(&c, 1.0), object(&c, 10.0)];
    assert_eq!(lods(&o, Target::Triangles(20)), [0, 0]);
    assert_eq!(lods(&o, Target::Triangles(13)), [4, 0]);
    assert_eq!(lods(&o, Target::Triangles(11)), [4, 1]);
    assert_eq!(lods(&o, Target::Error(2.0)), [4, 2]);
    assert_eq!(lods(&o, Target::Triangles(4)), [4, 4]);
    let short = select(&o, Target::Triangles(3), false).expect("a target that fits");
    assert_eq!((short.lods, short.warnings.len()), (vec![Lod(4), Lod(4)], 1));
}

#[test]
fn steps_of_one_error_are_taken_one_by_one_in_order_of_the_objects() {
    let c = sequence(10, &[(0.1, 8), (0.1, 6), (0.1, 4), (0.1, 2)]);
    let o = [object(&c, 1.0), object(&c, 1.0)];
    assert_eq!(lods(&o, Target::Triangles(16)), [2, 0]);
    assert_eq!(lods(&o, Target::Triangles(11)), [4, 1]);
}

#[test]
fn every_budget_is_met_by_the_finest_state_of_the_merged_walk() {
    let a = sequence(9, &[(0.0, 9), (0.5, 7), (0.5, 3), (2.0, 1), (3.0, 0)]);
    let b = sequence(6, &[(0.0, 4), (1.0, 4), (1.5, 2), (9.0, 0)]);
    let o = [object(&a, 1.0), object(&b, 0.5)];
    // The merged walk by hand: (world error, object, triangles of that object after it).
    let walk = [(0, 9), (1, 4), (0, 7), (0, 3), (1, 4), (1, 2), (0, 1)];
    for budget in 3..=15 {
        let mut left = [9, 6];
        for (object, triangles) in walk {
            if left[0] + left[1] <= budget {
                break;
            }
            left[object] = triangles;
        }
        let chosen = select(&o, Target::Triangles(budget), false).expect("a target that fits");
        let got = [a.triangles_at(chosen.lods[0]), b.triangles_at(chosen.lods[1])].map(u64::from);
        assert_eq!(got, left, "budget {budget}");
    }
}

#[test]
fn a_record_number_needs_per_object_in_a_scene() {
    let c = sequence(10, &[(0.1, 8), (0.2, 6)]);
    let o = [object(&c, 1.0), object(&c, 1.0)];
    assert_eq!(select(&o, Target::Lod(1), false).map_err(|f| f.status.code()), Err(2));
    assert_eq!(select(&o, Target::Lod(1), true).map(|s| s.lods), Ok(vec![Lod(1), Lod(1)]));
}

#[test]
fn a_printed_error_typed_again_gives_the_same_lod() {
    for error in [0.1_f32, 0.012_3, 1e-7, 3.333_333_3, 7.0e9] {
        let c = sequence(4, &[(error, 2)]);
        let typed = bound(&error.to_string()).expect("a printed error is a number");
        assert_eq!(lods(&[object(&c, 1.0)], typed), [1], "{error}");
    }
}

#[test]
fn an_object_without_triangles_stays_as_it_is() {
    let c = sequence(0, &[(0.0, 0)]);
    assert_eq!(lods(&[object(&c, 1.0)], Target::Ratio(0.5)), [0]);
}

#[test]
fn wrong_numbers_are_refused() {
    for wrong in ["-1", "NaN", "inf", "", "%", "1%%"] {
        assert!(bound(wrong).is_err(), "{wrong}");
    }
    for wrong in ["1.1", "-0.1", "NaN", "half"] {
        assert!(ratio(wrong).is_err(), "{wrong}");
    }
}
