//! The heart of the tests: what the simplifier makes obeys every rule at every step, and every
//! model shows the reference answer wherever a cursor is sent. On all named shapes and on many
//! random meshes.

use lodc_fixtures::{ALL, Rng, check_rules, random, random_collapse};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Lod, Mesh, OrientedTriangle, Simplified};
use lodc_model::{Changes, Model};
use lodc_simplify::{Options, simplify};
use lodc_strip::{StripOptions, StripPool};
use std::collections::BTreeMap;
use std::sync::Arc;

const OPTIONS: [(&str, Options); 4] = [
    ("default", Options::DEFAULT),
    ("preserve topology", Options { preserve_topology: true, ..Options::DEFAULT }),
    ("lock border", Options { lock_border: true, ..Options::DEFAULT }),
    ("no attributes", Options { attributes: false, ..Options::DEFAULT }),
];

fn made(mesh: &Mesh, options: &Options) -> Simplified {
    simplify(mesh, options, &|_, _| {})
}

fn with_threads(threads: usize, mesh: &Mesh) -> Simplified {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads can be started");
    pool.install(|| made(mesh, &Options::DEFAULT))
}

/// All failures of a family of cases together: one look shows whether they have something in
/// common.
fn none(what: &str, failures: &[String]) {
    let shown = failures.iter().take(20).map(String::as_str).collect::<Vec<_>>().join("\n  ");
    assert!(failures.is_empty(), "{} {what}:\n  {shown}", failures.len());
}

#[test]
fn simplifications_of_named_shapes_obey_every_rule() {
    let mut failures = Vec::new();
    for (name, make) in ALL {
        let mesh = make();
        for (option, options) in &OPTIONS {
            if let Err(e) = check_rules(&mesh, &made(&mesh, options)) {
                failures.push(format!("{name}, {option}: {e}"));
            }
        }
    }
    none("broken rules", &failures);
}

#[test]
fn simplifications_of_random_meshes_obey_every_rule() {
    let mut failures = Vec::new();
    for seed in 0..400 {
        let mesh = random(seed);
        let (option, options) = &OPTIONS[seed as usize % OPTIONS.len()];
        if let Err(e) = check_rules(&mesh, &made(&mesh, options)) {
            failures.push(format!("random mesh {seed}, {option}: {e}"));
        }
    }
    none("broken rules", &failures);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    for (name, make) in ALL {
        let mesh = make();
        let one = with_threads(1, &mesh);
        for threads in [2, 5] {
            assert!(with_threads(threads, &mesh) == one, "{name} with {threads} threads");
        }
    }
    for seed in 0..40 {
        let mesh = random(seed);
        assert!(with_threads(4, &mesh) == with_threads(1, &mesh), "random mesh {seed}");
    }
}

#[test]
fn closed_shapes_lose_next_to_nothing_before_they_must() {
    // Flat sides divided into many triangles go down to the triangles that a cube needs without any
    // error.
    let cube = lodc_fixtures::named("coloured_cube").expect("a shape");
    let s = made(&cube, &Options { attributes: false, ..Options::DEFAULT });
    let lod = s.collapses().lod_for_triangles(12);
    assert_eq!(s.collapses().triangles_at(lod), 12);
    assert!(s.collapses().error_at(lod) < 1e-4, "{}", s.collapses().error_at(lod));
}

/// Counts what a cursor says goes and comes.
struct Books(BTreeMap<OrientedTriangle, i64>);

impl Changes for Books {
    fn removed(&mut self, t: OrientedTriangle) {
        *self.0.entry(t).or_default() -= 1;
    }
    fn added(&mut self, t: OrientedTriangle) {
        *self.0.entry(t).or_default() += 1;
    }
}

/// Sends a cursor of every model to both ends and to random levels, and compares what it shows, and
/// what it said had changed, with the reference.
fn check_models(s: Simplified, seeks: usize, seed: u64) -> Result<(), String> {
    let s = Arc::new(s);
    let mut rng = Rng::new(seed);
    let mut strips = StripPool::new(&s, StripOptions::default());
    for kind in ModelKind::ALL {
        let model =
            AnyModel::build(kind, &mut strips).map_err(|e| format!("{}: {e}", kind.name()))?;
        let mut cursor = model.cursor();
        let mut books = Books(BTreeMap::new());
        model.triangles(&cursor).into_iter().for_each(|t| books.added(t));
        let last = s.collapses().last().0;
        for seek in 0..seeks {
            // Past the last level, too: that is the last level.
            let lod = match seek {
                0 => last,
                1 => 0,
                2 => u32::MAX,
                n if n % 3 == 0 => {
                    model.lod(&cursor).0.saturating_add_signed(rng.below(9) as i32 - 4)
                }
                _ => rng.below(last as usize + 2) as u32,
            };
            model.seek(&mut cursor, Lod(lod), &mut books);
            let shown = s.collapses().floor(Lod(lod));
            let mut want = s.triangles_at(shown);
            let mut got = model.triangles(&cursor);
            want.sort_unstable();
            got.sort_unstable();
            books.0.retain(|_, n| *n != 0);
            let booked: Vec<_> = books
                .0
                .iter()
                .flat_map(|(&t, &n)| std::iter::repeat_n(t, usize::try_from(n).unwrap_or(1 << 20)))
                .collect();
            let place = format!("{}, seek {seek} to {lod} (shown {})", kind.name(), shown.0);
            if model.lod(&cursor) != shown {
                return Err(format!("{place}: stands at {}", model.lod(&cursor).0));
            }
            if got != want {
                return Err(format!(
                    "{place}: {} triangles instead of {}, or others",
                    got.len(),
                    want.len()
                ));
            }
            if booked != want {
                return Err(format!("{place}: what went and came does not add up"));
            }
        }
    }
    Ok(())
}

#[test]
fn every_model_shows_the_reference_on_named_shapes() {
    let mut failures = Vec::new();
    for (name, make) in ALL {
        let mesh = make();
        for (how, s) in [
            ("simplified", made(&mesh, &Options::DEFAULT)),
            ("arbitrary", random_collapse(&mesh, 77)),
        ] {
            if let Err(e) = check_models(s, 40, 1) {
                failures.push(format!("{name}, {how}: {e}"));
            }
        }
    }
    none("differences", &failures);
}

#[test]
fn every_model_shows_the_reference_on_random_meshes_and_arbitrary_sequences() {
    let mut failures = Vec::new();
    for seed in 0..300 {
        let mesh = random(seed);
        let s = if seed % 3 == 0 {
            made(&mesh, &Options::DEFAULT)
        } else {
            random_collapse(&mesh, seed)
        };
        if let Err(e) = check_models(s, 60, seed) {
            failures.push(format!("random mesh {seed}: {e}"));
        }
    }
    none("differences", &failures);
}
