//! Verification finds every kind of damage, and cries wolf at nothing.
//!
//! The damage is done to what is stored (a mesh and a sequence that are still valid by themselves);
//! the model is that of the damaged file, or the one made before the damage. Damage to what a model
//! shows is in `verify/tests.rs`.

use lodc_fixtures as fixtures;
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, SequenceParts, Simplified};
use lodc_strip::{StripOptions, StripPool};
use lodc_verify::{Check, Failure, Reference, VerifyOptions, verify};
use std::sync::Arc;

/// Checks of the stored facts, then those of the model. None if the model cannot even be built.
fn checks(stored: &Simplified, model_of: &Simplified) -> Option<Vec<Check>> {
    let stored = Arc::new(stored.clone());
    let reference = Reference::new(&stored).expect("a sequence of ordinary length");
    let mut checks = reference.checks().to_vec();
    let model_of = Arc::new(model_of.clone());
    let mut strips = StripPool::new(&model_of, StripOptions::default());
    let model = AnyModel::build(ModelKind::Interactive, &mut strips).ok()?;
    checks.extend(verify(
        &model,
        &reference,
        &VerifyOptions { jumps: 10, ..VerifyOptions::default() },
    ));
    Some(checks)
}

fn sound(checks: Option<&Vec<Check>>) -> bool {
    checks.is_some_and(|all| all.iter().all(Check::ok))
}

/// A mesh and its sequence, to be damaged.
struct Stored {
    mesh: MeshParts,
    sequence: SequenceParts,
}

/// One kind of damage: its name, what it does (false: not possible here), and whether the model was
/// made before it.
type Kind = (&'static str, fn(&mut Stored, &mut fixtures::Rng) -> bool, bool);

/// A triangle of LOD 0.
fn any(s: &Stored, rng: &mut fixtures::Rng) -> usize {
    rng.below(s.mesh.triangles.len())
}

/// A step that is not the last one and has triangles left.
fn visible_step(s: &Stored, rng: &mut fixtures::Rng) -> usize {
    let visible = s.sequence.step_triangles.partition_point(|&t| t > 4);
    1 + rng.below(visible.max(2) - 1)
}

const BEFORE: bool = true;
const AFTER: bool = false;

const KINDS: &[Kind] = &[
    (
        "a vertex of a triangle replaced",
        |s, rng| {
            let (t, corner) = (any(s, rng), rng.below(3));
            let old = s.mesh.triangles[t][corner];
            let new = rng.below(s.mesh.positions.len()) as u32;
            let submesh = |v: u32| s.mesh.vertex_submesh[v as usize];
            let fits = submesh(old) == submesh(new)
                && s.mesh.triangles[t]
                    .iter()
                    .all(|&v| s.mesh.positions[v as usize] != s.mesh.positions[new as usize]);
            s.mesh.triangles[t][corner] = new;
            fits
        },
        BEFORE,
    ),
    (
        "a flipped face",
        |s, rng| {
            let t = any(s, rng);
            s.mesh.triangles[t].swap(1, 2);
            true
        },
        BEFORE,
    ),
    (
        "a face lost and another doubled",
        |s, rng| {
            let (a, b) = (any(s, rng), any(s, rng));
            let part = |t: usize| s.mesh.vertex_submesh[s.mesh.triangles[t][0] as usize];
            let fits = part(a) == part(b) && s.mesh.triangles[a] != s.mesh.triangles[b];
            s.mesh.triangles[a] = s.mesh.triangles[b];
            fits
        },
        BEFORE,
    ),
    (
        "a vertex moved off the others of its position",
        |s, rng| {
            let p = s.mesh.positions.clone();
            let twins: Vec<usize> =
                (0..p.len()).filter(|&v| p.iter().filter(|q| **q == p[v]).count() > 1).collect();
            let Some(&v) = twins.get(rng.below(twins.len().max(1))) else { return false };
            s.mesh.positions[v][0] += 0.37;
            true
        },
        AFTER,
    ),
    (
        "a wrong target",
        |s, rng| {
            let k = rng.below(s.sequence.targets.len() / 2);
            s.sequence.targets[k] = k as u32 + 1 + rng.below(s.sequence.targets.len() - k) as u32;
            true
        },
        BEFORE,
    ),
    (
        "a record dropped: its vertex handed to the next record's",
        |s, rng| {
            let k = rng.below(s.sequence.targets.len() / 2);
            s.sequence.targets[k] = k as u32 + 1;
            true
        },
        BEFORE,
    ),
    (
        "two records swapped",
        |s, rng| {
            let k = rng.below(s.sequence.targets.len() / 2);
            let far = s.sequence.targets[k] as usize > k + 1;
            s.sequence.targets.swap(k, k + 1);
            far && s.sequence.targets[k] as usize > k
        },
        BEFORE,
    ),
    (
        "a step's end shifted",
        |s, rng| {
            let i = visible_step(s, rng);
            let ends = &mut s.sequence.step_ends;
            ends[i] += 1;
            i + 1 < ends.len() && ends[i] < ends[i + 1]
        },
        AFTER,
    ),
    (
        "two steps joined",
        |s, rng| {
            let i = visible_step(s, rng);
            s.sequence.step_ends.remove(i);
            s.sequence.step_errors.remove(i);
            s.sequence.step_triangles.remove(i);
            true
        },
        AFTER,
    ),
    (
        "a step cut in two",
        |s, rng| {
            let ends = s.sequence.step_ends.clone();
            let long: Vec<usize> = (1..ends.len()).filter(|&i| ends[i] - ends[i - 1] > 1).collect();
            let Some(&i) = long.get(rng.below(long.len().max(1))) else { return false };
            // Only where the parts of the step show: not once all its triangles are gone.
            s.sequence.step_ends.insert(i, ends[i] - 1);
            s.sequence.step_errors.insert(i, s.sequence.step_errors[i]);
            s.sequence.step_triangles.insert(i, s.sequence.step_triangles[i]);
            s.sequence.step_triangles[i - 1] > s.sequence.step_triangles[i] + 2
        },
        BEFORE,
    ),
    (
        "a wrong live count",
        |s, rng| {
            let i = visible_step(s, rng);
            let (above, below) = (s.sequence.step_triangles[i - 1], s.sequence.step_triangles[i]);
            s.sequence.step_triangles[i] = above;
            above != below
        },
        AFTER,
    ),
    (
        "a triangle in the wrong place of its submesh",
        |s, rng| {
            let t = any(s, rng);
            let last = s.mesh.triangles.len() - 1;
            let part = |t: usize| s.mesh.vertex_submesh[s.mesh.triangles[t][0] as usize];
            let fits = t + last / 2 < last && part(t) == part(last);
            s.mesh.triangles.swap(t, last);
            fits
        },
        AFTER,
    ),
    (
        "a corner that becomes a vertex of another submesh",
        |s, rng| {
            let k = rng.below(s.sequence.targets.len() / 2);
            let target = s.sequence.targets[k] as usize;
            let p = &s.mesh.positions;
            let other = (k + 1..p.len()).find(|&v| {
                p[v] == p[target] && s.mesh.vertex_submesh[v] != s.mesh.vertex_submesh[target]
            });
            s.sequence.targets[k] = other.unwrap_or(target) as u32;
            other.is_some() && s.mesh.triangles.as_flattened().contains(&(k as u32))
        },
        AFTER,
    ),
    (
        "a crack: one wedge of a group stays behind for a step",
        |s, rng| {
            let ends = s.sequence.step_ends.clone();
            let long: Vec<usize> =
                (1..ends.len() / 2).filter(|&i| ends[i] - ends[i - 1] > 1).collect();
            let Some(&i) = long.get(rng.below(long.len().max(1))) else { return false };
            let k = ends[i - 1] as usize;
            s.sequence.targets[k] = ends[i];
            let p = &s.mesh.positions;
            p[ends[i] as usize] != p[s.sequence.targets[k + 1] as usize]
        },
        AFTER,
    ),
];

fn rebuilt(s: Stored) -> Option<Simplified> {
    let (mesh, sequence) =
        (Mesh::try_from(s.mesh).ok()?, CollapseSequence::try_from(s.sequence).ok()?);
    Simplified::new(mesh, sequence).ok()
}

/// Returns what is shown at every step, to tell damage from a change that changes nothing.
fn shows_the_same(a: &Simplified, b: &Simplified) -> bool {
    let content = |s: &Simplified| {
        let p = s.mesh().positions().to_vec();
        let steps = (0..s.collapses().steps()).map(|i| s.collapses().step(i)).collect::<Vec<_>>();
        let shown: Vec<_> = steps
            .iter()
            .map(|step| {
                let mut t: Vec<_> = s.triangles_at(step.lod).into_iter().collect();
                t.sort_unstable();
                (step.lod, step.triangles, t)
            })
            .collect();
        (p, s.mesh().triangles().to_vec(), shown)
    };
    content(a) == content(b)
}

#[test]
fn every_kind_of_damage_is_found() {
    let shapes = [fixtures::uv_sphere(12, 8), fixtures::machine_part(), fixtures::striped_sphere()];
    let originals: Vec<Simplified> =
        (5..).zip(&shapes).map(|(seed, m)| fixtures::random_collapse(m, seed)).collect();
    assert!(KINDS.len() >= 12);
    let mut missed = Vec::new();
    for &(name, damage, when) in KINDS {
        let (mut tried, mut found) = (0, 0);
        let mut rng = fixtures::Rng::new(3);
        for _ in 0..200 {
            for original in &originals {
                let (mesh, sequence) = original.clone().into_parts();
                let mut stored =
                    Stored { mesh: mesh.into_parts(), sequence: sequence.into_parts() };
                if tried >= 20 || !damage(&mut stored, &mut rng) {
                    continue;
                }
                // Damage that the types themselves refuse is found by the reader.
                let Some(damaged) = rebuilt(stored) else { continue };
                if shows_the_same(original, &damaged) {
                    continue;
                }
                tried += 1;
                let result = checks(&damaged, if when == BEFORE { original } else { &damaged });
                found += usize::from(!sound(result.as_ref()));
            }
        }
        if tried < 5 || found < tried {
            missed.push(format!("{name}: {found} of {tried}"));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn a_thousand_sound_files_pass() {
    for seed in 0..1000 {
        let simplified = fixtures::random_collapse(&fixtures::random(seed), seed);
        let result = checks(&simplified, &simplified).expect("triangles are in order");
        let wrong: Vec<&Failure> = result.iter().filter_map(|c| c.failure.as_ref()).collect();
        assert!(wrong.is_empty(), "seed {seed}: {wrong:?}");
    }
}
