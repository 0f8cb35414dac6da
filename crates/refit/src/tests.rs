//! Refitted levels: closer, whole, upright, and the same for any number of threads.

use super::*;
use lodc_fixtures::{named, random};
use lodc_measure::{Sampling, Surface, distances};
use lodc_mesh::{PositionIds, Semantic};
use lodc_simplify::simplify;

fn simplified(mesh: &Mesh) -> Simplified {
    simplify(mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {})
}

fn surface(mesh: &Mesh) -> Surface {
    Surface {
        positions: mesh.positions().iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
}

fn rms(a: &Mesh, b: &Mesh) -> f64 {
    let found = distances(&surface(a), &surface(b), &Sampling::DEFAULT);
    found.rms[0].max(found.rms[1])
}

fn level(s: &Simplified, share: f64) -> Lod {
    s.collapses().lod_for_triangles((share * s.mesh().triangles().len() as f64) as u32)
}

fn unrefitted(s: &Simplified, lod: Lod) -> Mesh {
    s.mesh().extract(&s.triangles_at(lod)).expect("a level")
}

#[test]
fn levels_of_curved_surfaces_come_closer() {
    for name in ["torus", "icosphere", "morphing_sphere"] {
        let mesh = named(name).expect("a fixture");
        let s = simplified(&mesh);
        for share in [0.5, 0.25, 0.1] {
            let lod = level(&s, share);
            let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
            let [before, after] = [before, after].map(|m| rms(s.mesh(), &m));
            assert!(after < 0.9 * before, "{name} {share}: {after} {before}");
        }
    }
}

#[test]
fn vertices_at_one_position_stay_at_one_position() {
    for seed in 0..40 {
        let s = simplified(&random(seed));
        let lod = level(&s, 0.4);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        assert_eq!(before.triangles(), after.triangles(), "seed {seed}");
        let ids = PositionIds::new(before.positions());
        let mut place = vec![None; ids.len()];
        for (&id, &p) in ids.of_vertex.iter().zip(after.positions()) {
            assert_eq!(*place[id as usize].get_or_insert(p), p, "seed {seed}");
        }
    }
}

#[test]
fn no_face_turns_over() {
    let normal = |m: &Mesh, t: [u32; 3]| {
        let [a, b, c] = t.map(|v| DVec3::from_array(m.positions()[v as usize].map(f64::from)));
        (b - a).cross(c - a).normalize_or_zero()
    };
    for seed in 0..40 {
        let s = simplified(&random(seed));
        let lod = level(&s, 0.4);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        for &t in before.triangles() {
            let cosine = normal(&before, t).dot(normal(&after, t));
            assert!(cosine > 0.49, "seed {seed}: {cosine}");
        }
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let s = simplified(&named("machine_part").expect("a fixture"));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| refit(&s, level(&s, 0.3), &Options::DEFAULT))
    };
    let one = with(1);
    assert!([2, 3, 8].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn flat_ground_stays_flat_and_keeps_its_border() {
    let mesh = named("terrain").expect("a fixture");
    let s = simplified(&mesh);
    let (lo, hi) = mesh.bounds();
    let diagonal = mesh.diagonal() as f32;
    let after = refit(&s, level(&s, 0.2), &Options::DEFAULT).bounds();
    for k in 0..3 {
        let slack = 0.03 * diagonal;
        let kept = |a: f32, b: f32| (a - b).abs() < slack;
        assert!(kept(lo[k], after.0[k]) && kept(hi[k], after.1[k]), "{lo:?} {hi:?} {after:?}");
    }
}

#[test]
fn weights_sum_up_to_one_and_directions_are_units() {
    let s = simplified(&named("skinned_tube_u16").expect("a fixture"));
    let after = refit(&s, level(&s, 0.3), &Options::DEFAULT);
    for stream in after.attributes() {
        for v in 0..after.vertex_count() as u32 {
            let n = usize::from(stream.components);
            let values: Vec<f32> = (0..n).map(|k| stream.value(v, k)).collect();
            match stream.semantic {
                Semantic::Weights(0) => {
                    assert!((values.iter().sum::<f32>() - 1.0).abs() < 1e-4, "{values:?}");
                }
                Semantic::Normal => {
                    let length = values.iter().map(|x| x * x).sum::<f32>().sqrt();
                    assert!((length - 1.0).abs() < 0.02, "{values:?}");
                }
                _ => {}
            }
        }
    }
}

#[test]
fn the_input_and_levels_without_triangles_stay_as_they_are() {
    let s = simplified(&named("cube").expect("a fixture"));
    assert_eq!(refit(&s, Lod(0), &Options::DEFAULT), unrefitted(&s, Lod(0)));
    assert!(refit(&s, s.collapses().last(), &Options::DEFAULT).triangles().is_empty());
}
