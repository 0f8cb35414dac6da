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

/// Losses that are stored errors in world units.
fn losses(objects: &[Candidate<'_>]) -> Vec<Vec<f64>> {
    let world = |o: &Candidate<'_>| -> Vec<f64> {
        o.collapses.parts().step_errors.iter().map(|&e| f64::from(e) * o.scale).collect()
    };
    objects.iter().map(world).collect()
}

fn chosen(objects: &[Candidate<'_>], target: Target) -> Selection {
    select(objects, target, false, || losses(objects)).expect("a target that fits")
}

fn lods(objects: &[Candidate<'_>], target: Target) -> Vec<u32> {
    chosen(objects, target).lods.iter().map(|l| l.0).collect()
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
    assert_eq!(lods(&o, Target::Error(0.61)), [3], "world units: three for each of the mesh");
    let own = select(&o, Target::Error(0.2), true, || losses(&o)).expect("a target that fits");
    assert_eq!(own.lods, [Lod(3)], "its own units");
    assert!((own.error - 0.6).abs() < 1e-9, "world units");
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
        let chosen = chosen(&o, target);
        assert_eq!(chosen.lods, [Lod(2)], "{target:?}");
        assert_eq!(chosen.warnings.len(), 1, "{target:?}");
    }
    assert_eq!(lods(&o, Target::Lod(3)), [3]);
}

#[test]
fn a_scene_gives_up_triangles_where_least_is_lost() {
    // The second object is shown ten times as large: its steps cost ten times as much.
    let c = sequence(12, &[(0.1, 10), (0.2, 8), (0.3, 6), (0.4, 4), (0.5, 2), (0.6, 0)]);
    let o = [object(&c, 1.0), object(&c, 10.0)];
    assert_eq!(lods(&o, Target::Triangles(24)), [0, 0]);
    assert_eq!(lods(&o, Target::Triangles(17)), [4, 0]);
    assert_eq!(lods(&o, Target::Triangles(15)), [4, 1]);
    assert_eq!(lods(&o, Target::Error(2.0)), [5, 2]);
    // The last four triangles of both go after everything else.
    assert_eq!(lods(&o, Target::Triangles(8)), [4, 4]);
    assert_eq!(lods(&o, Target::Triangles(6)), [5, 4]);
    assert_eq!(lods(&o, Target::Triangles(4)), [5, 5]);
    let short = chosen(&o, Target::Triangles(3));
    assert_eq!((short.lods, short.warnings.len()), (vec![Lod(5), Lod(5)], 1));
}

#[test]
fn a_costly_step_is_shared_out_over_the_triangles_that_follow_it() {
    // One step at a high price spares nothing by itself but lets a hundred triangles go for free;
    // the other object loses a little with every triangle.
    let a = sequence(110, &[(5.0, 109), (5.0, 10), (5.0, 4), (9.0, 1)]);
    let steps: Vec<(f32, u32)> = (1..=106).map(|i| (i as f32 * 0.2, 110 - i)).collect();
    let b = sequence(110, &steps);
    let o = [object(&a, 1.0), object(&b, 1.0)];
    assert_eq!(lods(&o, Target::Triangles(120)), [2, 0]);
}

#[test]
fn smaller_budgets_only_remove_and_every_budget_is_met() {
    let a = sequence(29, &[(0.0, 27), (0.5, 20), (0.5, 16), (2.0, 11), (3.0, 6), (4.0, 1)]);
    let b = sequence(26, &[(0.0, 24), (1.0, 14), (1.5, 12), (9.0, 3), (9.5, 2)]);
    let o = [object(&a, 1.0), object(&b, 0.5)];
    let mut last = vec![u32::MAX; 2];
    for budget in 3..=55 {
        let got = chosen(&o, Target::Triangles(budget));
        let live: u64 =
            got.lods.iter().zip([&a, &b]).map(|(&lod, c)| u64::from(c.triangles_at(lod))).sum();
        assert!(live <= budget, "{budget}: {live}");
        let lods: Vec<u32> = got.lods.iter().map(|l| l.0).collect();
        assert!(lods.iter().zip(&last).all(|(now, before)| now <= before), "{budget}: {lods:?}");
        last = lods;
    }
    assert_eq!(last, [0, 0]);
}

#[test]
fn warnings_name_the_objects_that_stopped() {
    let (a, b) = (sequence(8, &[(1.0, 5), (2.0, 0)]), sequence(90, &[(1.0, 80), (5.0, 10)]));
    let named = |name, c| Candidate { name, ..object(c, 1.0) };
    let o = [named("wheel", &a), named("body", &b)];
    let warnings = chosen(&o, Target::Error(2.0)).warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("1 of 2") && warnings[0].ends_with(": wheel"), "{warnings:?}");
}

#[test]
fn a_record_number_needs_per_object_in_a_scene() {
    let c = sequence(10, &[(0.1, 8), (0.2, 6)]);
    let o = [object(&c, 1.0), object(&c, 1.0)];
    let at =
        |per_object| select(&o, Target::Lod(1), per_object, Vec::<Vec<f64>>::new).map(|s| s.lods);
    assert_eq!(at(false), Err(RecordOfScene { objects: 2 }));
    assert_eq!(at(true), Ok(vec![Lod(1), Lod(1)]));
}

#[test]
fn a_printed_error_typed_again_gives_the_same_lod() {
    for error in [0.1_f32, 0.012_3, 1e-7, 3.333_333_3, 7.0e9] {
        let c = sequence(4, &[(error, 2)]);
        let typed = error.to_string().parse().expect("a printed error is a number");
        assert_eq!(lods(&[object(&c, 1.0)], Target::Error(typed)), [1], "{error}");
    }
}

#[test]
fn an_object_without_triangles_stays_as_it_is() {
    let c = sequence(0, &[(0.0, 0)]);
    assert_eq!(lods(&[object(&c, 1.0)], Target::Ratio(0.5)), [0]);
}
