//! Speed Strips: examples worked by hand, and everything against the reference.

use super::*;
use lodc_fixtures as fixtures;
use lodc_fixtures::{ChangeLog, check_moves, first_difference};
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, SequenceParts, Submesh};
use lodc_strip::{Effort, StripSet};
use lodc_strip::{StripKind, Strips};

fn model(simplified: &Simplified, kind: StripKind) -> Speed {
    let strips = Strips::generate(simplified, kind, Effort::Fast);
    Speed::build(&Arc::new(simplified.clone()), Arc::new(strips)).expect("strips of the mesh")
}

fn any(set: StripSet) -> Arc<Strips> {
    Arc::new(Strips { kind: StripKind::Stripe, set })
}

/// A strip of one vertex after another, with a sequence whose every record is a step.
fn strip_of(points: &[[i32; 2]], strip: &[u32], targets: &[u32]) -> Speed {
    let triangles: Vec<[u32; 3]> = lodc_strip::strip_triangles(strip).collect();
    let count = triangles.len() as u32;
    let mesh = Mesh::try_from(MeshParts {
        positions: points.iter().map(|[x, y]| [*x as f32, *y as f32, 0.0]).collect(),
        vertex_submesh: vec![0; points.len()],
        attributes: Vec::new(),
        triangles,
        submeshes: vec![Submesh {
            first_triangle: 0,
            triangle_count: count,
            attributes: Vec::new(),
        }],
    });
    let records = targets.len();
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: targets.to_vec(),
        step_ends: (1..=records as u32).collect(),
        step_errors: vec![0.0; records],
        step_triangles: vec![0; records],
        triangles: count,
        ..SequenceParts::default()
    });
    let simplified = Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence"))
        .expect("the two fit");
    let strips =
        StripSet::from_parts(strip.to_vec(), vec![strip.len() as u32], vec![1]).expect("one strip");
    Speed::build(&Arc::new(simplified), any(strips)).expect("a strip of the mesh")
}

/// After fig. 2.5: the strip a b c d e f of the thesis, drawn by vertices that go in the order 0,
/// 1, …
///
/// ```text
///  5---1---3---7
///  |  /|  /|  /|     strip 4 5 0 1 2 3 6 7
///  | / | / | / |
///  4---0---2---6
/// ```
#[test]
fn a_strip_and_its_operations_worked_out_by_hand() {
    let points = [[1, 0], [1, 1], [2, 0], [2, 1], [0, 0], [0, 1], [3, 0], [3, 1]];
    let model = strip_of(&points, &[4, 5, 0, 1, 2, 3, 6, 7], &[2, 3, 4, 5, 5, 6, 7]);
    let mut cursor = model.cursor();
    let mut shown = vec![cursor.strip(0).to_vec()];
    for lod in 1..=7 {
        model.seek(&mut cursor, Lod(lod), &mut ());
        shown.push(cursor.strip(0).to_vec());
    }
    let expected: [&[u32]; 8] = [
        &[4, 5, 0, 1, 2, 3, 6, 7],
        // 0 → 2: place 2 changes.
        &[4, 5, 2, 1, 2, 3, 6, 7],
        // 1 → 3: place 3 changes, and 2 3 2 3 is an edge repetition.
        &[4, 5, 2, 3, 6, 7],
        // 2 → 4, 3 → 5: 4 5 4 5 is another, but taking it out costs more than the one change that
        // is to come.
        &[4, 5, 4, 3, 6, 7],
        &[4, 5, 4, 5, 6, 7],
        // 4 → 5: 5 5 5 5 6 7 still draws 5 6 7.
        &[5, 5, 5, 5, 6, 7],
        // 5 → 6 kills the last triangle, and the strip.
        &[],
        &[],
    ];
    assert_eq!(shown, expected);
    let remove = |at, count, kind| Operation::Remove(Removal { offset: at, count, kind });
    let change = Operation::Change;
    let strip = |operations: &[Operation]| vec![(0, operations.to_vec())];
    let arrays = model.run_time(Lod(7));
    let operations = [
        strip(&[change(2)]),
        strip(&[change(3), remove(4, 2, RemovalKind::Edge)]),
        strip(&[change(2)]),
        strip(&[change(3)]),
        strip(&[change(0), change(2)]),
        strip(&[]),
        vec![],
    ];
    assert_eq!(arrays.records(), operations);
    assert_eq!(arrays.updates, [2, 3, !4, -2, 2, 3, 0, 2]);
    assert_eq!(arrays.bytes(), 5 * (7 + 6) + 4 * 8);
    assert_eq!(model.removal_lods(), [6]);
    let never = u32::MAX;
    assert_eq!(model.index_removal_lods(), [never, never, never, never, 2, 2, never, never]);
    for lod in (0..7).rev() {
        model.seek(&mut cursor, Lod(lod), &mut ());
        assert_eq!(cursor.strip(0), expected[lod as usize], "back to {lod}");
    }
}

/// Odd repetitions turn the rest of a strip over, so they go by twos or stay.
#[test]
fn a_vertex_repetition_goes_only_with_a_partner() {
    for seed in 0..200 {
        let model =
            model(&fixtures::random_collapse(&fixtures::random(seed), seed), StripKind::Stripe);
        let mut cursor = model.cursor();
        for lod in 0..=model.simplified().collapses().records() {
            model.seek(&mut cursor, Lod(lod), &mut ());
            let mut shown = model.triangles(&cursor);
            let mut truth = model.simplified().triangles_at(model.lod(&cursor));
            shown.sort_unstable();
            truth.sort_unstable();
            assert!(shown == truth, "seed {seed}, LOD {lod}: {}", first_difference(&shown, &truth));
        }
    }
}

/// A pole of valence 1,000: its record changes more strips, or one strip at more places, than a
/// byte can count.
#[test]
fn counts_that_overflow_a_byte_are_spelled_out() {
    let simplified = fixtures::random_collapse(&fixtures::pole(1000), 3);
    let (mut many_strips, mut many_operations) = (false, false);
    let fan = |strips: &mut dyn FnMut() -> StripSet| {
        let model =
            Speed::build(&Arc::new(simplified.clone()), any(strips())).expect("strips of the mesh");
        let arrays = model.run_time(simplified.collapses().last());
        let records = arrays.records();
        assert_eq!(records.len(), simplified.collapses().records() as usize);
        let mut many = (false, false);
        for (record, strips) in records.iter().enumerate() {
            many.0 |= strips.len() >= 255;
            let affected = model.edits.affected(&(record as u32..record as u32 + 1));
            let expected: Vec<_> = affected.zip(model.operations(record as u32)).collect();
            many.1 |= strips.iter().any(|(_, operations)| operations.len() >= 255);
            assert_eq!(*strips, expected);
        }
        check_moves("pole", &model, |_| ());
        many
    };
    // Each triangle a strip of its own, then all in one.
    let triangles = simplified.mesh().triangles();
    let ends: Vec<u32> = (1..=triangles.len() as u32).map(|i| 3 * i).collect();
    let count = ends.len() as u32;
    let single = StripSet::from_parts(triangles.as_flattened().to_vec(), ends, vec![count])
        .expect("triangles");
    many_strips |= fan(&mut || single.clone()).0;
    let mut long: Vec<u32> = Vec::new();
    for &[a, b, c] in triangles {
        if let Some(&last) = long.last() {
            long.extend([last, a]);
        }
        if long.len() % 2 == 1 {
            long.push(a);
        }
        long.extend([a, b, c]);
    }
    let length = long.len() as u32;
    let one = StripSet::from_parts(long, vec![length], vec![1]).expect("one strip");
    assert_eq!(one.check(simplified.mesh()), Ok(()));
    many_operations |= fan(&mut || one.clone()).1;
    assert!(many_strips && many_operations);
}

/// Every fixture under an arbitrary sequence and both kinds of strips.
#[test]
fn everything_shown_and_reported_equals_the_reference() {
    for &(name, make) in fixtures::ALL {
        let mesh = make();
        if mesh.triangles().len() <= 400 {
            check_moves(
                name,
                &model(&fixtures::random_collapse(&mesh, 1), StripKind::Stripe),
                |_| (),
            );
        }
    }
    for seed in 0..60 {
        let simplified = fixtures::random_collapse(&fixtures::random(seed), seed);
        for kind in [StripKind::Stripe, StripKind::Cache] {
            check_moves(
                &format!("random {seed}, {}", kind.name()),
                &model(&simplified, kind),
                |_| (),
            );
        }
    }
}

#[test]
fn arrays_come_back_and_damage_is_refused_or_harmless() {
    for (seed, layout) in (0..12).zip(Layout::ALL.into_iter().cycle()) {
        let simplified = Arc::new(fixtures::random_collapse(&fixtures::random(seed), seed));
        let built = model(&simplified, StripKind::Stripe);
        let arrays = built.arrays(layout);
        let loaded = Speed::load(&simplified, &arrays).expect("what was given out");
        let last = simplified.collapses().last();
        assert_eq!(loaded.arrays(layout), arrays);
        assert_eq!(loaded.run_time(last), built.run_time(last));
        assert_eq!(
            (loaded.index_removal_lods(), loaded.removal_lods()),
            (built.index_removal_lods(), built.removal_lods())
        );
        for which in 0..2 {
            let damaged = |bytes: Vec<u8>| {
                let mut arrays = arrays.clone();
                arrays[which].bytes = bytes;
                Speed::load(&simplified, &arrays)
            };
            let bytes = &arrays[which].bytes;
            for cut in 0..bytes.len() {
                assert!(
                    damaged(bytes[..cut].to_vec()).is_err(),
                    "random {seed}: {cut} bytes of array {which}"
                );
            }
            assert!(damaged([&bytes[..], &[0]].concat()).is_err());
            for bit in 0..8 * bytes.len() {
                let mut flipped = bytes.clone();
                flipped[bit / 8] ^= 1 << (bit % 8);
                // What is accepted may be a wrong picture, which is for verification to find; it
                // can be walked.
                if let Ok(model) = damaged(flipped) {
                    let mut cursor = model.cursor();
                    for lod in [
                        last,
                        Lod(0),
                        Lod(last.0 / 2),
                        last,
                        Lod(last.0 / 3),
                        Lod(last.0 / 2),
                        Lod(0),
                    ] {
                        model.seek(&mut cursor, lod, &mut ChangeLog::default());
                    }
                    (1..=last.0).for_each(|lod| _ = model.seek(&mut cursor, Lod(lod), &mut ()));
                    (0..last.0)
                        .rev()
                        .for_each(|lod| _ = model.seek(&mut cursor, Lod(lod), &mut ()));
                    assert_eq!(model.arrays(layout).len(), 2);
                }
            }
        }
        assert!(Speed::load(&simplified, &arrays[..1]).is_err());
    }
}

#[test]
fn long_strips_are_cut_and_draw_the_same() {
    let n = 5 * Speed::LONGEST_STRIP as u32;
    let points: Vec<[i32; 2]> = (0..n as i32).map(|i| [i, i % 2]).collect();
    let strip: Vec<u32> = (0..n).collect();
    let targets: Vec<u32> = (1..n).collect();
    let model = strip_of(&points, &strip, &targets);
    assert_eq!(model.strips().len(), 6);
    assert!(model.strips().iter().all(|strip| strip.len() <= Speed::LONGEST_STRIP));
    let drawn: Vec<_> = model.strips().triangles().map(|t| t.corners).collect();
    let whole = lodc_strip::strip_triangles(&strip).map(|t| OrientedTriangle::new(0, t).corners);
    assert!(drawn.into_iter().eq(whole));
}

#[test]
fn threads_do_not_matter() {
    let simplified = fixtures::random_collapse(&fixtures::uv_sphere(24, 16), 2);
    let arrays = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| model(&simplified, StripKind::Stripe)).arrays(Layout::Packed)
    };
    assert_eq!(arrays(1), arrays(4));
}

#[test]
fn storage_counts_words_and_bytes_of_the_arrays() {
    let simplified = fixtures::random_collapse(&fixtures::icosphere(2), 1);
    let model = model(&simplified, StripKind::Stripe);
    let (cost, half) =
        (model.storage(), model.storage_to(Lod(simplified.collapses().records() / 2)));
    assert_eq!(cost.primitives, 4 * model.strips().separate_indices());
    assert_eq!(cost.positions, 12 * simplified.mesh().vertex_count() as u64);
    assert!(half.structures < cost.structures && half.structures > 0);
    assert_eq!(model.storage_to(Lod(0)).structures, 0);
}

#[test]
fn the_share_of_degenerates_removed_is_that_of_a_plain_count() {
    for seed in 0..10 {
        let simplified = Arc::new(fixtures::random_collapse(&fixtures::icosphere(2), seed));
        let strips = Arc::new(Strips::generate(&simplified, StripKind::Stripe, Effort::Fast));
        let model = Speed::build(&simplified, strips).expect("few changes");
        let (mut cursor, mut whole, mut left) = (model.cursor(), 0, 0);
        for lod in 0..=simplified.collapses().records() {
            model.seek(&mut cursor, Lod(lod), &mut ());
            let live = simplified.triangles_at(Lod(lod)).len();
            let strips = (0..model.strips.len()).filter(|&s| !cursor.strip(s).is_empty());
            let triangles =
                strips.map(|s| (model.strips.strip(s).len() - 2, cursor.strip(s).len() - 2));
            let [all, drawn] = triangles.fold([0, 0], |[a, b], (x, y)| [a + x, b + y]);
            whole += all - live;
            left += drawn - live;
        }
        let share = 1.0 - left as f64 / whole as f64;
        assert!(share > 0.1 && (model.degenerates_removed() - share).abs() < 1e-12, "{share}");
    }
}

#[test]
fn the_share_of_changes_of_length_is_that_of_a_plain_count() {
    for seed in 0..10 {
        let simplified = Arc::new(fixtures::random_collapse(&fixtures::icosphere(2), seed));
        let strips = Arc::new(Strips::generate(&simplified, StripKind::Stripe, Effort::Fast));
        let model = Speed::build(&simplified, strips).expect("few changes");
        let (mut cursor, mut changed) = (model.cursor(), 0);
        let at = |cursor: &<Speed as Model>::Cursor| -> Vec<Vec<u32>> {
            (0..model.strips.len()).map(|s| cursor.strip(s).to_vec()).collect()
        };
        let mut before = at(&cursor);
        for record in 1..=simplified.collapses().records() {
            model.seek(&mut cursor, Lod(record), &mut ());
            let now = at(&cursor);
            changed += u32::from(before.iter().zip(&now).any(|(a, b)| a.len() != b.len()));
            before = now;
        }
        let share = f64::from(changed) / f64::from(simplified.collapses().records());
        assert!(share > 0.05 && (model.length_changes() - share).abs() < 1e-12, "{share}");
    }
}
