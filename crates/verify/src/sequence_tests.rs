//! What is wrong with a sequence is named; what is only unusual passes.

use super::tests::{sphere, verify_all};
use super::*;
use lodc_fixtures as fixtures;
use lodc_lod::Interactive;
use lodc_mesh::{CollapseSequence, SequenceParts, Simplified};
use std::sync::Arc;

/// A sequence with something changed.
fn changed(simplified: &Simplified, change: impl FnOnce(&mut SequenceParts)) -> Simplified {
    let (mesh, collapses) = simplified.clone().into_parts();
    let mut parts = collapses.into_parts();
    change(&mut parts);
    let collapses = CollapseSequence::try_from(parts).expect("still a sequence");
    Simplified::new(mesh, collapses).expect("still fits")
}

fn failures(simplified: &Simplified) -> Vec<Failure> {
    let reference = Reference::new(simplified).expect("a sequence of ordinary length");
    reference.checks().iter().filter_map(|c| c.failure.clone()).collect()
}

#[test]
fn a_wrong_triangle_count_is_named() {
    let wrong = changed(&sphere(), |parts| parts.step_triangles[3] = parts.step_triangles[2]);
    let lod = wrong.collapses().step(3).lod;
    let counted = sphere().collapses().step(3).triangles;
    let stored = wrong.collapses().step(3).triangles;
    assert_eq!(failures(&wrong), [Failure::TriangleCount { lod, stored, counted }]);
}

#[test]
fn a_vertex_that_leaves_its_seam_tears_the_mesh() {
    // A wedge of a seam goes elsewhere than the others: its step's targets are apart, and the mesh
    // tears there.
    let simplified = sphere();
    let positions = simplified.mesh().position_ids();
    let parts = simplified.collapses().parts();
    let step = (1..parts.step_ends.len())
        .find(|&i| {
            parts.step_ends[i] - parts.step_ends[i - 1] > 1
                && parts.step_triangles[i] + 4 < parts.step_triangles[i - 1] + 4
                && parts.step_triangles[i] > 20
        })
        .expect("a step over the seam");
    let (record, lod) = (parts.step_ends[step] - 1, Lod(parts.step_ends[step]));
    let other = (record + 1..simplified.mesh().vertex_count() as u32)
        .find(|&v| {
            positions.of_vertex[v as usize]
                != positions.of_vertex[parts.targets[record as usize] as usize]
                && positions.of_vertex[v as usize] != positions.of_vertex[record as usize]
        })
        .expect("another position");
    let torn = changed(&simplified, |parts| parts.targets[record as usize] = other);
    let found = failures(&torn);
    assert!(found.contains(&Failure::Apart { lod, record }), "{found:?}");
    assert!(
        found.iter().any(|f| matches!(f, Failure::Torn { lod: l, .. } if *l == lod)),
        "{found:?}"
    );
}

#[test]
fn steps_joined_that_do_not_belong_together_are_named() {
    let joined = changed(&sphere(), |parts| {
        parts.step_ends.remove(4);
        parts.step_errors.remove(4);
        parts.step_triangles.remove(4);
    });
    assert!(failures(&joined).iter().any(|f| matches!(f, Failure::Apart { .. })));
}

#[test]
fn a_wrong_target_never_passes() {
    let simplified = sphere();
    let truth = Reference::new(&simplified).expect("a sequence of ordinary length");
    let mut rng = fixtures::Rng::new(11);
    let mut caught = 0;
    for _ in 0..300 {
        let record = rng.below(simplified.collapses().records() as usize);
        let target = record + 1 + rng.below(simplified.collapses().records() as usize - record);
        let wrong = changed(&simplified, |parts| parts.targets[record] = target as u32);
        let reference = Reference::new(&wrong).expect("a sequence of ordinary length");
        let same = (0..=truth.steps()).all(|step| truth.hash(step) == reference.hash(step));
        // What is shown is other than before: a model of the sequence as it was does not pass. (One
        // wedge instead of another of the same position may change nothing that is shown.)
        let model =
            Interactive::build(&Arc::new(simplified.clone())).expect("triangles are in order");
        let checks = verify(&model, &reference, &VerifyOptions::default());
        assert_eq!(
            checks[..2].iter().all(Check::ok),
            same,
            "record {record} to {target}: {checks:?}"
        );
        caught += usize::from(!same);
    }
    assert!(caught > 200, "only {caught} of 300 changes were visible");
}

#[test]
fn the_reference_follows_any_sequence_whatever_comes_apart_in_it() {
    let mut rng = fixtures::Rng::new(12);
    let mut returned = 0;
    for (seed, mesh) in [fixtures::uv_sphere(8, 5), fixtures::machine_part(), fixtures::bow_tie()]
        .iter()
        .enumerate()
    {
        let simplified = fixtures::random_collapse(mesh, seed as u64);
        let (positions, records) =
            (simplified.mesh().position_ids(), simplified.collapses().records() as usize);
        for _ in 0..40 {
            let wrong = changed(&simplified, |parts| {
                for _ in 0..=rng.below(4) {
                    let record = rng.below(records);
                    parts.targets[record] = (record + 1 + rng.below(records - record)) as u32;
                }
            });
            let reference = Reference::new(&wrong).expect("a sequence of ordinary length");
            for step in 0..=reference.steps() {
                let truth: TriangleHash =
                    wrong.triangles_at_with(reference.lod(step), &positions).into_iter().collect();
                assert_eq!(reference.hash(step), truth, "after {step} steps");
            }
            returned += reference
                .checks()
                .iter()
                .filter(|c| matches!(c.failure, Some(Failure::Returned { .. })))
                .count();
        }
    }
    assert!(returned > 5, "only {returned} sequences in which a dead triangle returns");
}

#[test]
fn triangles_out_of_order_are_named() {
    let (mesh, collapses) = sphere().into_parts();
    let mut parts = mesh.into_parts();
    let last = parts.triangles.len() - 1;
    parts.triangles.swap(0, last);
    let mesh = lodc_mesh::Mesh::try_from(parts).expect("still a mesh");
    let swapped = Simplified::new(mesh, collapses).expect("still fits");
    assert!(failures(&swapped).contains(&Failure::TriangleOrder { triangle: 1 }));
}

#[test]
fn a_dead_triangle_that_returns_is_named() {
    // Vertices 0 and 1 come to one position (2 and 3 are at one place), then part again.
    let mesh = lodc_mesh::Mesh::try_from(lodc_mesh::MeshParts {
        positions: [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0]]
            .map(|[x, y]| [x, y, 0.0])
            .to_vec(),
        vertex_submesh: vec![0; 6],
        attributes: Vec::new(),
        triangles: vec![[0, 1, 5]],
        submeshes: vec![lodc_mesh::Submesh {
            first_triangle: 0,
            triangle_count: 1,
            attributes: Vec::new(),
        }],
    });
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: vec![2, 3, 4, 5, 5],
        step_ends: vec![1, 2, 3, 4, 5],
        step_errors: vec![0.0; 5],
        step_triangles: vec![1, 0, 0, 0, 0],
        triangles: 1,
        ..SequenceParts::default()
    });
    let simplified = Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence"))
        .expect("the two fit");
    assert!(failures(&simplified).contains(&Failure::Returned { lod: Lod(3), triangle: 0 }));
}

#[test]
fn a_first_difference_is_one_of_the_two() {
    let t = |a| OrientedTriangle::new(0, [a, a + 1, a + 2]);
    let lod = Lod(0);
    assert_eq!(first_difference(lod, vec![t(1), t(2)], vec![t(2), t(1)]), None);
    let (missing, extra) =
        (Failure::Missing { lod, triangle: t(2) }, Failure::Extra { lod, triangle: t(2) });
    assert_eq!(first_difference(lod, vec![t(1), t(2)], vec![t(1)]), Some(missing.clone()));
    assert_eq!(first_difference(lod, vec![t(1)], vec![t(1), t(2)]), Some(extra.clone()));
    assert_eq!(first_difference(lod, vec![t(2), t(3)], vec![t(3)]), Some(missing.clone()));
    assert_eq!(first_difference(lod, vec![t(3)], vec![t(2), t(3)]), Some(extra));
    assert_eq!(first_difference(lod, vec![t(2), t(2)], vec![t(2)]), Some(missing));
}

#[test]
fn a_sequence_made_to_be_slow_is_given_up() {
    // A fan whose high-valence vertex moves along a chain: all triangles change at every step.
    let n = 30_000u32;
    let mesh = lodc_mesh::Mesh::try_from(lodc_mesh::MeshParts {
        positions: (0..2 * n).map(|i| [i as f32, (i % 7) as f32, (i % 11) as f32]).collect(),
        vertex_submesh: vec![0; 2 * n as usize],
        attributes: Vec::new(),
        triangles: (n..2 * n - 1).map(|i| [0, i, i + 1]).collect(),
        submeshes: vec![lodc_mesh::Submesh {
            first_triangle: 0,
            triangle_count: n - 1,
            attributes: Vec::new(),
        }],
    });
    let last = 2 * n - 1;
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: (1..2 * n).collect(),
        step_ends: (1..=last).collect(),
        step_errors: vec![0.0; last as usize],
        step_triangles: vec![0; last as usize],
        triangles: n - 1,
        ..SequenceParts::default()
    });
    let simplified = Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence"))
        .expect("the two fit");
    assert!(Reference::new(&simplified).is_err());
}

/// `n` shards of two triangles with a seam between them. Each shrinks to a point of two vertices,
/// then all points are joined one after the other: the two vertices that stand for all before them
/// move once for every shard.
///
/// ```text
///      b·e       record          step       what for
///      /|\       a → e           alone      a b c dies with vertices e and b at one position
///    a/ | \d     d → e           alone      e d f dies with two equal corners
///     \ | /      b → c, e → f    together   the shard is a point
///      \|/       c → c, f → f    together   of the next shard
///      c·f
/// ```
fn shards(n: u32) -> Simplified {
    let (a, d, b, c) = (|i| i, |i| n + i, |i| 2 * n + 2 * i, |i| 4 * n + 2 * i);
    let (mut positions, mut targets) = (vec![[0.0; 3]; 6 * n as usize], vec![0; 6 * n as usize]);
    for i in 0..n {
        let at = |x: f32, y: f32| [3.0 * i as f32 + x, y, (i % 5) as f32];
        for (v, p, t) in [
            (a(i), at(0.0, 1.0), b(i) + 1),
            (d(i), at(2.0, 1.0), b(i) + 1),
            (b(i), at(1.0, 2.0), c(i)),
            (b(i) + 1, at(1.0, 2.0), c(i) + 1),
            (c(i), at(1.0, 0.0), if i + 1 < n { c(i + 1) } else { c(i) + 1 }),
            (c(i) + 1, at(1.0, 0.0), c(i) + 3),
        ] {
            (positions[v as usize], targets[v as usize]) = (p, t);
        }
    }
    targets.pop();
    let triangles = 2 * n;
    let mut step_ends: Vec<u32> = (1..=2 * n).chain((1..2 * n).map(|i| 2 * n + 2 * i)).collect();
    step_ends.push(6 * n - 1);
    let steps = step_ends.len() as u32;
    let mesh = lodc_mesh::Mesh::try_from(lodc_mesh::MeshParts {
        positions,
        vertex_submesh: vec![0; 6 * n as usize],
        attributes: Vec::new(),
        // The last to die comes first.
        triangles: (0..n)
            .rev()
            .map(|i| [b(i) + 1, c(i) + 1, d(i)])
            .chain((0..n).rev().map(|i| [a(i), c(i), b(i)]))
            .collect(),
        submeshes: vec![lodc_mesh::Submesh {
            first_triangle: 0,
            triangle_count: triangles,
            attributes: Vec::new(),
        }],
    });
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets,
        step_ends,
        step_errors: vec![0.0; steps as usize],
        step_triangles: (1..=steps).map(|step| triangles.saturating_sub(step)).collect(),
        triangles,
        ..SequenceParts::default()
    });
    Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence")).expect("the two fit")
}

#[test]
fn many_pieces_that_end_on_one_vertex_are_no_work() {
    for n in [1, 2, 7, 5000] {
        let checks = verify_all(&shards(n));
        for check in &checks {
            assert!(check.ok(), "{n} shards: {check:?}");
        }
        if n == 5000 {
            let full: Vec<_> = checks.iter().rev().take(3).rev().map(|c| c.full).collect();
            assert!(
                (100..=101).contains(&full[0]) && full[1] == full[0] && full[2] == 100,
                "{full:?}"
            );
        }
    }
}
