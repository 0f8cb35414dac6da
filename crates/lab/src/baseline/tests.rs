//! Baselines against the reference, and their storage against the thesis's formulae.

use super::*;
use lodc_fixtures as fixtures;
use lodc_mesh::{Mesh, TriangleHash};
use lodc_simplify::{Options, simplify};
use lodc_strip::Effort;
use lodc_strip::{StripKind, Strips};
use lodc_verify::{Reference, VerifyOptions, first_difference, verify};

/// Small shapes and random meshes under sequences that no metric would make, larger ones under real
/// ones.
fn sequences() -> impl Iterator<Item = (String, Arc<Simplified>)> {
    let shapes = fixtures::ALL.iter().map(|&(name, make)| (name.to_owned(), make()));
    let random = (0..60).map(|seed| (format!("random {seed}"), fixtures::random(seed)));
    let arbitrary =
        shapes.chain(random).enumerate().filter(|(_, (_, mesh))| mesh.triangles().len() <= 400);
    let arbitrary =
        arbitrary.map(|(seed, (name, mesh))| (name, fixtures::random_collapse(&mesh, seed as u64)));
    let real = fixtures::ALL.iter().map(|&(name, make)| (name.to_owned(), real(&make())));
    arbitrary.chain(real).map(|(name, simplified)| (name, Arc::new(simplified)))
}

fn real(mesh: &Mesh) -> Simplified {
    simplify(mesh, &Options::DEFAULT, &|_, _| ())
}

fn baselines(simplified: &Arc<Simplified>) -> Vec<Baseline> {
    let strips = Strips::generate(simplified, StripKind::Stripe, Effort::Fast);
    Baseline::all(simplified, &Arc::new(strips)).expect("triangles are in order")
}

#[test]
fn continuous_baselines_equal_the_reference_at_every_step_and_after_jumps() {
    for (name, simplified) in sequences() {
        let reference = Reference::new(&simplified).expect("a sequence of ordinary length");
        for model in baselines(&simplified).iter().filter(|b| b.continuous()) {
            for check in verify(model, &reference, &VerifyOptions::default()) {
                assert!(check.ok(), "{name}: {check:?}");
            }
        }
    }
}

/// A listener to jumps, which are checked apart: verification only listens from step to step.
struct Follow(TriangleHash, u64);

impl Changes for Follow {
    fn removed(&mut self, triangle: OrientedTriangle) {
        self.0.remove(triangle);
        self.1 += 1;
    }
    fn added(&mut self, triangle: OrientedTriangle) {
        self.0.add(triangle);
        self.1 += 1;
    }
}

#[test]
fn jumps_tell_of_exactly_the_triangles_that_go_and_come() {
    for (name, simplified) in sequences() {
        for model in baselines(&simplified) {
            let mut cursor = model.cursor();
            let mut rng = fixtures::Rng::new(3);
            let mut before = model.triangles(&cursor);
            for _ in 0..20 {
                let lod = Lod(rng.below(simplified.collapses().records() as usize + 1) as u32);
                let mut reported = Follow(before.iter().copied().collect(), 0);
                let from = model.lod(&cursor);
                let traffic = model.seek(&mut cursor, lod, &mut reported);
                let sent = model.sent(from, model.lod(&cursor), traffic);
                let after = model.triangles(&cursor);
                assert_eq!(
                    reported.0,
                    after.iter().copied().collect(),
                    "{name}: {} at {lod:?}",
                    model.name()
                );
                assert_eq!(
                    reported.1,
                    differing(&before, &after),
                    "{name}: {} at {lod:?}",
                    model.name()
                );
                if matches!(model, Baseline::LodStrips(_)) {
                    // What a strip draws besides is dead, and nothing is sent for one that dies.
                    assert!(model.drawn(&cursor) >= after.len() as u64);
                } else {
                    assert_eq!(model.drawn(&cursor), 3 * after.len() as u64);
                    assert!(reported.1 == 0 || sent > 0, "{name}: {} at {lod:?}", model.name());
                }
                before = after;
            }
        }
    }
}

/// Returns the number of triangles two multisets do not share.
fn differing(a: &[OrientedTriangle], b: &[OrientedTriangle]) -> u64 {
    let mut all: Vec<(OrientedTriangle, i64)> =
        a.iter().map(|&t| (t, 1)).chain(b.iter().map(|&t| (t, -1))).collect();
    all.sort_unstable();
    let sums = all
        .chunk_by(|x, y| x.0 == y.0)
        .map(|same| same.iter().map(|x| x.1).sum::<i64>().unsigned_abs());
    sums.sum()
}

#[test]
fn discrete_levels_equal_the_reference_at_theirs() {
    for (name, simplified) in sequences() {
        let model = Discrete::build(&simplified);
        let collapses = simplified.collapses();
        let lods: Vec<Lod> = model.lods().collect();
        assert_eq!((lods.len(), lods[0]), (LEVELS, Lod(0)));
        let mut cursor = model.cursor();
        for lod in (0..=collapses.records()).chain((0..collapses.records()).rev()).map(Lod) {
            model.seek(&mut cursor, lod, &mut ());
            let shown = model.lod(&cursor);
            // At most the detail asked for, and no finer level than that would do.
            let asked = collapses.floor(lod);
            assert_eq!(
                shown,
                lods.iter().copied().find(|&l| l >= asked).unwrap_or(lods[LEVELS - 1]),
                "{name}: {lod:?}"
            );
        }
        for &lod in &lods {
            model.seek(&mut cursor, lod, &mut ());
            let difference =
                first_difference(lod, simplified.triangles_at(lod), model.triangles(&cursor));
            assert_eq!(difference, None, "{name}");
        }
    }
}

#[test]
fn each_discrete_level_has_a_quarter_fewer_triangles() {
    let simplified = Arc::new(real(&fixtures::icosphere(4)));
    let levels = Discrete::build(&simplified);
    let counts: Vec<u32> = levels.lods().map(|l| simplified.collapses().triangles_at(l)).collect();
    assert_eq!(counts, [5120, 3840, 2880, 2160, 1620]);
}

#[test]
fn rebuilding_gives_the_reference() {
    for (name, simplified) in sequences() {
        let mut rebuild = Rebuild::new(&simplified);
        let collapses = simplified.collapses();
        let mut rng = fixtures::Rng::new(1);
        for _ in 0..20 {
            let lod = collapses.floor(Lod(rng.below(collapses.records() as usize + 1) as u32));
            let submesh = |v: u32| simplified.mesh().vertex_submesh()[v as usize];
            let triangles = rebuild.indices_at(lod).chunks_exact(3);
            let triangles = triangles
                .map(|t| OrientedTriangle::new(submesh(t[0]), [t[0], t[1], t[2]]))
                .collect();
            assert_eq!(
                first_difference(lod, simplified.triangles_at(lod), triangles),
                None,
                "{name}"
            );
        }
    }
}

/// A closed mesh of sphere type without seams: `f = 2v − 4`, and `v − 1` records.
fn closed() -> (Arc<Simplified>, f64) {
    let simplified = Arc::new(real(&fixtures::icosphere(3)));
    let v = simplified.mesh().vertex_count() as f64;
    assert_eq!(simplified.mesh().triangles().len() as f64, 2.0 * v - 4.0);
    (simplified, v)
}

fn words(cost: &StorageCost) -> (f64, f64) {
    (cost.thesis() / 32.0, cost.thesis_normals() / 32.0)
}

fn near((a, b): (f64, f64), (c, d): (f64, f64)) {
    assert!((a - c).abs() < 1e-9 && (b - d).abs() < 1e-9, "({a}, {b}) is not ({c}, {d})");
}

#[test]
fn progressive_meshes_take_24_words_per_vertex_and_30_with_normals() {
    let (simplified, v) = closed();
    let model = ProgressiveMesh::build(&simplified).expect("triangles are in order");
    // 3v + v + 6f and 8 per record; normals 6 per record.
    let (positions, normals) = (4.0 * v + 6.0 * (2.0 * v - 4.0) + 8.0 * (v - 1.0), 6.0 * (v - 1.0));
    near(words(&model.storage()), (positions / v, (positions + normals) / v));
    let lod = simplified.collapses().floor(Lod(simplified.collapses().records() / 2));
    let cut = model.storage_to(lod);
    assert_eq!(
        model.storage().structures - cut.structures,
        32 * u64::from(simplified.collapses().records() - lod.0)
    );
    // One fan for nearly every record: at the very end there are some without triangles.
    assert!(model.tight_bytes() as f64 / (4.0 * v) < 23.0);
    assert!(model.tight_bytes() as f64 / (4.0 * v) > 22.0);
}

#[test]
fn discrete_levels_take_three_times_the_triangles() {
    let (simplified, v) = closed();
    let plain = StorageCost::of_triangles(&simplified);
    near(words(&plain), ((9.0 * v - 12.0) / v, (12.0 * v - 12.0) / v));
    let discrete = Discrete::build(&simplified).storage();
    let shrinking: f64 = (0..LEVELS as i32).map(|i| 0.75f64.powi(i)).sum();
    assert!(
        (discrete.thesis() / plain.thesis() - shrinking).abs() < 0.01,
        "{}",
        discrete.thesis() / plain.thesis()
    );
}

#[test]
fn plain_strips_take_three_words_per_vertex_and_one_per_index() {
    let (simplified, v) = closed();
    let strips = Strips::generate(&simplified, StripKind::Stripe, Effort::Fast);
    let i = strips.separate_indices() as f64;
    near(
        words(&StorageCost::of_strips(&simplified, strips.separate_indices())),
        ((3.0 * v + i) / v, (6.0 * v + i) / v),
    );
}

#[test]
fn a_record_on_a_closed_surface_has_one_fan_until_nearly_nothing_is_left() {
    let (simplified, _) = closed();
    let collapses = simplified.collapses();
    let model = ProgressiveMesh::build(&simplified).expect("triangles are in order");
    for record in 0..collapses.parts().last_legal_lod.0 {
        let left = collapses.triangles_at(Lod(record + 1));
        assert!(model.fans(record) == 1 || left < 4, "record {record}, {left} triangles left");
    }
}
