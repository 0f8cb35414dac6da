//! Selectors on sequences small enough to check by hand.

use super::*;
use lodc_mesh::{CollapseSequence, SequenceParts};

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
    Candidate {
        name: "object",
        collapses,
        scale,
        diagonal: 10.0,
        coarsest: collapses.last(),
        rounding: 0.0,
    }
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
fn a_scene_gives_up_triangles_where_the_error_is_least() {
    // The second object is shown ten times as large: its steps cost ten times as much.
    let c = sequence(12, &[(0.1, 10), (0.2, 8), (0.3, 6), (0.4, 4), (0.5, 2), (0.6, 0)]);
    let o = [object(&c, 1.0), object(&c, 10.0)];
    assert_eq!(lods(&o, Target::Triangles(24)), [0, 0]);
    assert_eq!(lods(&o, Target::Triangles(17)), [4, 0]);
    assert_eq!(lods(&o, Target::Triangles(15)), [5, 0]);
    assert_eq!(lods(&o, Target::Error(2.0)), [5, 2]);
    assert_eq!(lods(&o, Target::Triangles(10)), [5, 2]);
    assert_eq!(lods(&o, Target::Triangles(6)), [5, 4]);
    assert_eq!(lods(&o, Target::Triangles(4)), [5, 5]);
    let short = chosen(&o, Target::Triangles(3));
    assert_eq!((short.lods, short.warnings.len()), (vec![Lod(5), Lod(5)], 1));
}

#[test]
fn of_nearly_equal_errors_the_steps_with_least_loss_go_first() {
    let a = sequence(20, &[(1.0, 18), (1.0, 16), (1.0, 14), (5.0, 1)]);
    let b = sequence(20, &[(1.01, 18), (1.01, 16), (1.01, 14), (5.0, 1)]);
    let o = [object(&a, 1.0), object(&b, 1.0)];
    // What is lost of the first counts ten times as much.
    let losses = || -> Vec<Vec<f64>> {
        [10.0, 1.0].map(|w| (1..=4).map(|i| w * f64::from(i)).collect()).to_vec()
    };
    let lods = |n| select(&o, Target::Triangles(n), false, losses).expect("a target").lods;
    assert_eq!(lods(36), [0, 2].map(Lod));
    assert_eq!(lods(30), [2, 3].map(Lod));
}

/// Curves of unlike objects: how many triangles they have, how fast their errors grow, how large
/// they are, and what is lost with them, which says nothing about errors.
fn unlike(seed: u64) -> (Vec<CollapseSequence>, Vec<f64>, Vec<Vec<f64>>) {
    let mut rng = lodc_mesh::SplitMix64::new(seed);
    let (mut sequences, mut scales, mut losses) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..3 + rng.below(9) {
        let mut left = 50 + rng.below(4000) as u32;
        let (triangles, growth) = (left, 0.2 + rng.below(30) as f64 / 10.0);
        let (mut steps, mut lost, mut loss) = (Vec::new(), 0.0, Vec::new());
        while left > 2 {
            left -= (1 + rng.below(left as usize / 20 + 1) as u32).min(left - 1);
            let share = f64::from(triangles - left) / f64::from(triangles);
            steps.push((((share / (1.02 - share)).powf(growth) * 0.01) as f32, left));
            lost += rng.below(1000) as f64;
            loss.push(lost);
        }
        sequences.push(sequence(triangles, &steps));
        scales.push(10f64.powi(rng.below(5) as i32 - 2));
        losses.push(loss);
    }
    (sequences, scales, losses)
}

#[test]
fn a_share_never_costs_more_error_than_it_could_have_had() {
    for seed in 0..20 {
        let (sequences, scales, losses) = unlike(seed);
        let o: Vec<_> = sequences.iter().zip(&scales).map(|(c, &s)| object(c, s)).collect();
        let all: u32 = sequences.iter().map(|c| c.parts().triangles).sum();
        let world = |(c, s): (&CollapseSequence, &f64)| -> Vec<f64> {
            c.parts().step_errors.iter().map(|&e| f64::from(e) * s).collect()
        };
        let mut errors: Vec<f64> = sequences.iter().zip(&scales).flat_map(world).collect();
        errors.sort_by(f64::total_cmp);
        let triangles = |lods: &[Lod]| -> u32 {
            sequences.iter().zip(lods).map(|(c, &lod)| c.triangles_at(lod)).sum()
        };
        for share in [0.6, 0.5, 0.4, 0.3, 0.1] {
            let budget = (share * f64::from(all)) as u32;
            let fits = |&error: &f64| {
                triangles(&chosen(&o, Target::Error(error * 1.000_001)).lods) > budget
            };
            let best = errors[errors.partition_point(fits)];
            let got = select(&o, Target::Ratio(share), false, || &losses).expect("a target");
            assert!(triangles(&got.lods) <= budget, "seed {seed} at {share}");
            let error = got.error;
            assert!(error <= 1.1 * best, "seed {seed} at {share}: {error} for {best}");
        }
    }
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
    assert_eq!(at(false), Err(RecordError::OfScene { objects: 2 }));
    assert_eq!(at(true), Ok(vec![Lod(1), Lod(1)]));
}

#[test]
fn levels_end_where_locks_do() {
    let c = sequence(12, &[(0.1, 10), (0.2, 8), (0.3, 6), (0.4, 4), (0.5, 2), (0.6, 0)]);
    let locked = Candidate { coarsest: Lod(2), ..object(&c, 1.0) };
    for target in [Target::Ratio(0.1), Target::Triangles(5), Target::Error(9.0)] {
        let alone = chosen(&[locked], target);
        assert_eq!(alone.lods, [Lod(2)], "{target:?}");
        assert!(alone.warnings[0].ends_with("LOD 2, the last that keeps what is locked"));
        let scene = chosen(&[locked, object(&c, 1.0)], target);
        assert_eq!(scene.lods, [2, 5].map(Lod), "{target:?}");
    }
    let beside = chosen(&[locked, object(&c, 1.0)], Target::Triangles(14));
    assert_eq!(beside.lods, [2, 3].map(Lod));
    assert!(beside.warnings[0].contains("1 of 2") && beside.warnings[0].contains("locked"));
    let of_record = |n| {
        select(&[locked], Target::Lod(n), false, Vec::<Vec<f64>>::new).map(|chosen| chosen.lods)
    };
    assert_eq!(of_record(2), Ok(vec![Lod(2)]));
    let refused = RecordError::Unlocks { object: "object".to_owned(), coarsest: Lod(2) };
    assert_eq!(of_record(3), Err(refused));
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

#[test]
fn what_quantising_adds_is_within_what_is_asked() {
    let c = sequence(10, &[(0.1, 8), (0.2, 6), (0.3, 4), (0.4, 2), (0.8, 0)]);
    let rounded = |rounding| [Candidate { rounding, ..object(&c, 2.0) }];
    assert_eq!(lods(&rounded(0.0), Target::Error(0.6)), [3]);
    assert_eq!(lods(&rounded(0.1), Target::Error(0.61)), [2], "0.2 and 0.1, twice as large");
    assert_eq!(lods(&rounded(0.15), Target::ErrorShare(0.03)), [1]);
    assert_eq!(
        lods(&rounded(0.5), Target::Error(0.6)),
        [0],
        "the finest, where the grid is coarse"
    );
    let both = [rounded(0.0)[0], rounded(0.15)[0]];
    assert_eq!(lods(&both, Target::Error(0.6)), [3, 1], "each leaves its own room");
    assert_eq!(lods(&both, Target::Triangles(20)), [0, 0], "triangles need none");
}

#[test]
fn root_mean_squares_leave_room_for_those_of_a_grid() {
    let c = CollapseSequence::try_from(SequenceParts {
        step_rms: vec![0.03, 0.04],
        ..sequence(10, &[(0.1, 8), (0.2, 6)]).parts().clone()
    })
    .expect("steps in order make a sequence");
    let rounded = |rounding| [Candidate { rounding, ..object(&c, 1.0) }];
    // Half the diagonal of a cell of 0.06: a root mean square of 0.03 for each vertex.
    let half_diagonal = 0.03 * 3f64.sqrt();
    assert_eq!(lods(&rounded(half_diagonal), Target::Rms(0.0501)), [2]);
    assert_eq!(lods(&rounded(half_diagonal), Target::Rms(0.0499)), [1]);
    assert_eq!(lods(&rounded(half_diagonal), Target::Rms(0.0301)), [0]);
    assert_eq!(lods(&rounded(half_diagonal), Target::Rms(0.01)), [0]);
}
