//! Every fixture, every step, both ways, and jumps; damaged arrays; sequences made to be slow.

use super::*;
use lodc_fixtures::check_moves;
use lodc_mesh::put_leb128;
use lodc_strip::Effort;
use lodc_strip::StripKind;

#[test]
fn everything_shown_and_reported_equals_the_reference() {
    for &(name, make) in fixtures::ALL {
        let mesh = make();
        // The naive sequence is slow on the largest shapes, which `tests/` has.
        if mesh.triangles().len() <= 400 {
            check(name, fixtures::random_collapse(&mesh, 1));
        }
    }
    for seed in 0..40 {
        check(&format!("random {seed}"), fixtures::random_collapse(&fixtures::random(seed), seed));
    }
}

#[test]
fn a_pole_with_a_thousand_neighbours_is_shown_as_it_is() {
    let simplified = lodc_simplify::simplify(
        &fixtures::pole(1000),
        &lodc_simplify::Options::DEFAULT,
        &|_, _| (),
    );
    check("pole", simplified);
}

fn check(name: &str, simplified: Simplified) {
    let simplified = Arc::new(simplified);
    for kind in [StripKind::Stripe, StripKind::Cache] {
        let strips = Arc::new(Strips::generate(&simplified, kind, Effort::Fast));
        let model = Masking::build(&simplified, strips).expect("few entries");
        check_moves(&format!("{name}, {}", kind.name()), &model, |cursor| {
            let indices: u64 = (0..model.strips.len()).map(|s| cursor.strip(s).len() as u64).sum();
            assert_eq!(cursor.drawn(), indices, "{name}");
        });
        let again =
            Masking::load(&simplified, &model.arrays(Layout::Packed)).expect("nothing is damaged");
        assert_eq!((&again.entries, &again.updates), (&model.entries, &model.updates), "{name}");
        for layout in Layout::ALL {
            let arrays = model.arrays(layout);
            let again = Masking::load(&simplified, &arrays).expect("nothing is damaged");
            assert_eq!(again.arrays(layout), arrays, "{name}");
        }
    }
}

#[test]
fn damaged_arrays_are_refused_or_found_by_verification() {
    let simplified = Arc::new(fixtures::random_collapse(&fixtures::icosphere(1), 1));
    let strips = Arc::new(Strips::generate(&simplified, StripKind::Cache, Effort::Fast));
    let array =
        Masking::build(&simplified, strips).expect("few entries").arrays(Layout::Packed).remove(0);
    let reference = lodc_verify::Reference::new(&simplified).expect("a small sequence");
    let mut loaded = 0;
    // The first byte names the generator, on which nothing depends.
    for bit in 8..8 * array.bytes.len() {
        let mut damaged = array.clone();
        damaged.bytes[bit / 8] ^= 1 << (bit % 8);
        let Ok(model) = Masking::load(&simplified, &[damaged]) else { continue };
        loaded += 1;
        let checks =
            lodc_verify::verify(&model, &reference, &lodc_verify::VerifyOptions::default());
        assert!(checks.iter().any(|check| !check.ok()), "bit {bit}");
    }
    assert!(loaded > 0);
    assert!(Masking::load(&simplified, &[]).is_err());
    assert!(Masking::load(&simplified, &[array.clone(), array.clone()]).is_err());
    let renamed = Array { name: "faces".to_owned(), ..array };
    assert!(Masking::load(&simplified, &[renamed]).is_err());
    // A strip of 17 vertices.
    let mut bytes = Vec::new();
    bytes.push(0);
    put_leb128(&mut bytes, 1);
    put_leb128(&mut bytes, 17);
    bytes.extend([0; 17]);
    let long = Array { name: STRIPS.to_owned(), bytes, wide: false };
    assert!(matches!(Masking::load(&simplified, &[long]), Err(BuildError::Malformed { .. })));
}

#[test]
fn the_model_is_the_same_whatever_the_threads() {
    let simplified = Arc::new(fixtures::random_collapse(&fixtures::torus(), 4));
    let strips = Arc::new(Strips::generate(&simplified, StripKind::Stripe, Effort::Fast));
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| Masking::build(&simplified, Arc::clone(&strips)).expect("few entries"))
    };
    let (one, five) = (build(1), build(5));
    assert_eq!((one.entries, one.updates), (five.entries, five.updates));
}

#[test]
fn a_hierarchy_made_to_be_slow_is_refused_quickly() {
    // One chain of 200,000 collapses, and triangles whose corners are far apart on it.
    let n = 200_000u32;
    let strips: Vec<[u32; 3]> = (0..50_000).map(|i| [i, n / 2 + i, n / 2 + i + 25_000]).collect();
    let triangles: Vec<_> = strips.iter().rev().copied().collect();
    let mesh = Mesh::try_from(MeshParts {
        positions: (0..n).map(|i| [i as f32, (i % 2) as f32, 0.0]).collect(),
        vertex_submesh: vec![0; n as usize],
        attributes: Vec::new(),
        triangles,
        submeshes: vec![Submesh {
            first_triangle: 0,
            triangle_count: 50_000,
            attributes: Vec::new(),
        }],
    });
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: (1..n).collect(),
        step_ends: (1..n).collect(),
        step_errors: vec![0.0; n as usize - 1],
        step_triangles: vec![0; n as usize - 1],
        triangles: 50_000,
        ..SequenceParts::default()
    });
    let simplified = Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence"))
        .expect("the two fit");
    let strips: Vec<&[u32]> = strips.iter().map(|s| &s[..]).collect();
    let refused = Masking::build(&Arc::new(simplified), Arc::new(strip_set(&strips)));
    assert!(matches!(refused, Err(BuildError::Malformed { .. })));
}
