//! The pictures of viewpoint metrics stay those of the mesh, and what nobody sees goes first.

use super::view::View;
use super::{Score, VisualMetric, log_area};
use crate::choose::link::{Link, Marks};
use crate::cut::{OPEN, Region, WorkingMesh};
use crate::metric::Reevaluate;
use crate::number::Input;
use crate::{MetricKind, Options, simplify};
use lodc_fixtures as shapes;
use lodc_mesh::{Mesh, Simplified};
use lodc_raster::Camera;

/// Small pictures, so that small shapes take little time.
const SIZE: u32 = 48;

/// Every area of every view equals that of a picture drawn afresh, integer for integer.
fn check(metric: &VisualMetric, mesh: &WorkingMesh, what: &str) {
    for (camera, view) in metric.cameras.iter().zip(&metric.views) {
        let fresh = View::new(mesh, camera);
        assert_eq!(view.areas(), fresh.areas(), "{what}");
        let seen: u32 = view.areas().iter().sum();
        assert_eq!(seen, view.pixels(), "{what}: every pixel shows one thing");
    }
    for (view, &sum) in metric.views.iter().zip(&metric.divergences) {
        let fresh = metric.divergence(mesh, view);
        assert!(
            (sum - fresh).abs() <= 1e-6 * fresh.abs().max(1.0),
            "{what}: {sum}, afresh {fresh}"
        );
    }
    for face in mesh.live().filter(|_| metric.score == Score::Divergence) {
        let fresh = log_area(mesh.area_of(mesh.faces[face as usize].groups));
        assert_eq!(metric.log_areas[face as usize].to_bits(), fresh.to_bits(), "{what}");
    }
}

/// Collapses at random edges, legal or not, and compares now and then.
fn collapse_at_random(mesh: &Mesh, seed: u64, score: Score, what: &str) {
    let Region { mesh: mut working, wedges, .. } = Region::whole(&Input::new(mesh), false);
    if working.faces.is_empty() {
        return;
    }
    let mut metric = VisualMetric::new(&working, score, SIZE);
    metric.start(&working);
    let mut random = shapes::Rng::new(seed);
    let mut marks = Marks::default();
    let mut commits = 0;
    while working.live_faces > 0 && commits < 300 {
        let from = random.below(working.group_positions.len()) as u32;
        let Some(&corner) = working.star(from).first() else { continue };
        let to = working.others(corner)[random.below(2)];
        metric.collapsed(&working, &wedges, from, to);
        // Fans stay closed where the link condition holds, and only there.
        let holds = Link::new(&working, from, to, &mut marks).holds;
        let mut around = vec![to];
        working.each_neighbour(from, |g| around.push(g));
        let inherited = working.flags[from as usize] & OPEN;
        working.merge(from, to, |_| {});
        working.add_flags(to, inherited);
        for g in around.into_iter().filter(|_| !holds) {
            working.add_flags(g, OPEN);
        }
        commits += 1;
        if commits % 16 == 0 || working.live_faces < 8 {
            check(&metric, &working, what);
        }
    }
    check(&metric, &working, what);
}

#[test]
fn areas_stay_those_of_pictures_drawn_afresh() {
    for (i, (name, shape)) in (0..).zip(shapes::ALL) {
        let score = if i % 2 == 0 { Score::Entropy } else { Score::Divergence };
        collapse_at_random(&shape(), i, score, name);
    }
    for seed in 0..24 {
        let score = if seed % 2 == 0 { Score::Entropy } else { Score::Divergence };
        collapse_at_random(&shapes::random(seed), seed, score, &format!("seed {seed}"));
    }
}

/// Score of a view, straight from the definitions.
fn score_of(mesh: &WorkingMesh, camera: &Camera, score: Score) -> f64 {
    let view = View::new(mesh, camera);
    let areas = view.areas();
    let (faces, background) = areas.split_at(areas.len() - 1);
    let all = f64::from(view.pixels());
    let covered = all - f64::from(background[0]);
    if score == Score::Entropy {
        return areas
            .iter()
            .filter(|&&a| a > 0)
            .map(|&a| f64::from(a) / all)
            .map(|p| -p * p.log2())
            .sum();
    }
    let live = mesh.live().filter(|&f| faces[f as usize] > 0);
    live.map(|f| {
        let p = f64::from(faces[f as usize]) / covered;
        p * (p / mesh.area_of(mesh.faces[f as usize].groups).max(1e-30)).log2()
    })
    .sum()
}

#[test]
fn a_look_says_what_a_collapse_changes() {
    let mut looked_at = 0;
    for (name, mesh) in [
        ("terrain", shapes::terrain()),
        ("icosphere", shapes::icosphere(2)),
        ("part", shapes::machine_part()),
    ] {
        for score in [Score::Entropy, Score::Divergence] {
            let whole = || Region::whole(&Input::new(&mesh), false);
            let Region { mesh: working, wedges, .. } = whole();
            let mut metric = VisualMetric::new(&working, score, SIZE);
            metric.start(&working);
            let before: Vec<f64> =
                metric.cameras.iter().map(|c| score_of(&working, c, score)).collect();
            for from in (0..working.group_positions.len() as u32).step_by(17) {
                let Some(&corner) = working.star(from).first() else { continue };
                let mut candidates = working.others(corner).map(|to| (0.0, to));
                metric.reevaluate(
                    &working,
                    &wedges,
                    from,
                    &mut candidates,
                    false,
                    &mut super::ViewScratch::default(),
                );
                for (cost, to) in candidates {
                    let mut later = whole().mesh;
                    later.merge(from, to, |_| {});
                    let after = metric.cameras.iter().map(|c| score_of(&later, c, score));
                    let expected: f64 = before.iter().zip(after).map(|(b, a)| (a - b).abs()).sum();
                    assert!(
                        (cost - expected).abs() < 1e-9 + 1e-7 * expected,
                        "{name} {score:?} {from}: {cost}, {expected}"
                    );
                    looked_at += 1;
                }
            }
        }
    }
    assert!(looked_at > 50);
}

fn run(mesh: &Mesh, metric: MetricKind) -> Simplified {
    simplify(mesh, &Options { metric, picture: SIZE, ..Options::DEFAULT }, &|_, _| {})
}

const VISUAL: [MetricKind; 2] = [MetricKind::Viewpoint, MetricKind::Divergence];

#[test]
fn every_shape_obeys_the_rules() {
    for metric in VISUAL {
        for (name, shape) in shapes::ALL {
            let mesh = shape();
            if let Err(broken) = shapes::check_rules(&mesh, &run(&mesh, metric)) {
                panic!("{name}, {metric:?}: {broken}");
            }
        }
        for seed in 0..12 {
            let mesh = shapes::random(seed);
            if let Err(broken) = shapes::check_rules(&mesh, &run(&mesh, metric)) {
                panic!("seed {seed}, {metric:?}: {broken}");
            }
        }
    }
}

#[test]
fn of_nested_spheres_the_inner_one_goes_first() {
    let mesh = shapes::nested_spheres();
    let radius = |v: u32| mesh.positions()[v as usize].iter().map(|c| c * c).sum::<f32>().sqrt();
    let outermost = (0..mesh.vertex_count() as u32).map(radius).fold(0.0, f32::max);
    let is_inner = |v: &u32| radius(*v) < 0.9 * outermost;
    let inner = mesh.triangles().iter().filter(|t| t.iter().any(is_inner)).count();
    assert!(
        inner > 0 && inner < mesh.triangles().len(),
        "the fixture has an inner and an outer sphere"
    );
    for metric in VISUAL {
        let simplified = run(&mesh, metric);
        let positions = simplified.mesh().positions();
        let length = |v: u32| positions[v as usize].iter().map(|c| c * c).sum::<f32>().sqrt();
        // The inner spheres are gone before the outer one loses a triangle.
        let outer = mesh.triangles().len() - inner;
        let lod = simplified.collapses().lod_for_triangles(outer as u32);
        let left = simplified.triangles_at(lod);
        assert_eq!(left.len(), outer, "{metric:?}");
        assert!(
            left.iter().all(|t| t.corners.iter().all(|&v| length(v) >= 0.9 * outermost)),
            "{metric:?}"
        );
    }
}

#[test]
fn flat_regions_cost_no_divergence() {
    // A cube whose sides are cut into many squares: all that is not an edge may go without a
    // change.
    let simplified = run(&shapes::machine_part(), MetricKind::Divergence);
    let few =
        simplified.collapses().lod_for_triangles(simplified.collapses().parts().triangles / 2);
    let error = f64::from(simplified.collapses().error_at(few)) / simplified.mesh().diagonal();
    assert!(error < 0.05, "{error}");
}

#[test]
fn the_result_does_not_depend_on_threads() {
    for metric in VISUAL {
        let mesh = shapes::machine_part();
        let with = |threads| {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| run(&mesh, metric))
        };
        let one = with(1);
        assert_eq!(one, with(3), "{metric:?}");
    }
}

#[test]
fn small_meshes_have_small_pictures() {
    let sizes = [0, 12, 500, 2_000, u32::MAX].map(|faces| super::picture_size(256, faces));
    assert_eq!(sizes, [48, 48, 128, 256, 256]);
    assert_eq!([0, u32::MAX].map(|faces| super::picture_size(32, faces)), [32; 2]);
}
