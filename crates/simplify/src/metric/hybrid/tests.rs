//! Promises of the hybrid metric: rules hold, hidden things go first, errors it remembers are
//! those it would measure.

use super::{Checkerboard, HybridMetric, Patch};
use crate::cut::Region;
use crate::metric::Reevaluate;
use crate::number::Input;
use crate::{Guidance, MetricKind, Options, Prefix, simplify, simplify_recorded};
use lodc_fixtures as shapes;
use lodc_mesh::{Mesh, Simplified};

fn run(mesh: &Mesh) -> Simplified {
    simplify(mesh, &Options { metric: MetricKind::Hybrid, ..Options::DEFAULT }, &|_, _| {})
}

#[test]
fn every_shape_obeys_the_rules() {
    let mut meshes: Vec<(String, Mesh)> =
        shapes::ALL.iter().map(|(name, shape)| ((*name).to_owned(), shape())).collect();
    meshes.extend((0..40).map(|seed| (format!("seed {seed}"), shapes::random(seed))));
    for (name, mesh) in meshes {
        if let Err(broken) = shapes::check_rules(&mesh, &run(&mesh)) {
            panic!("{name}: {broken}");
        }
    }
}

#[test]
fn of_nested_spheres_the_inner_ones_go_first() {
    let mesh = shapes::nested_spheres();
    let length = |p: [f32; 3]| p.iter().map(|c| c * c).sum::<f32>().sqrt();
    let is_outer = |p: [f32; 3]| length(p) > 0.9;
    let outer = mesh
        .triangles()
        .iter()
        .filter(|t| t.iter().all(|&v| is_outer(mesh.positions()[v as usize])))
        .count();
    assert!(outer > 0 && outer < mesh.triangles().len());
    let simplified = run(&mesh);
    let lod = simplified.collapses().lod_for_triangles(outer as u32);
    let left = simplified.triangles_at(lod);
    let position = |v: u32| simplified.mesh().positions()[v as usize];
    assert_eq!(left.len(), outer);
    assert!(left.iter().all(|t| t.corners.iter().all(|&v| is_outer(position(v)))));
    // Nobody saw them, so no error has come of it: in a scene they go before what is seen of other
    // objects.
    assert!(simplified.collapses().error_at(lod) < 1e-6);
}

#[test]
fn no_web_is_spun_across_a_hoop() {
    let mesh = shapes::hoop();
    let at = |p: [f32; 3]| glam::Vec3::from(p);
    let area = |corners: [[f32; 3]; 3]| {
        let [a, b, c] = corners.map(at);
        0.5 * (b - a).cross(c - a).length()
    };
    let whole: f32 =
        mesh.triangles().iter().map(|t| area(t.map(|v| mesh.positions()[v as usize]))).sum();
    let simplified = run(&mesh);
    let lod = simplified.collapses().lod_for_triangles(48);
    let positions = simplified.mesh().positions();
    let left = simplified.triangles_at(lod);
    assert!(left.len() > 40);
    let area: f32 = left.iter().map(|t| area(t.corners.map(|v| positions[v as usize]))).sum();
    // A few chords are wide; a metric that asks only what becomes of the input's places more than
    // doubles the area.
    assert!(area < 1.6 * whole, "{area} of {whole}");
}

#[test]
fn what_is_flat_is_free() {
    let mesh = shapes::cube();
    assert_eq!(run(&mesh), run(&mesh));
    let part = run(&shapes::machine_part());
    let half = part.collapses().lod_for_triangles(part.collapses().parts().triangles / 2);
    let error = f64::from(part.collapses().error_at(half)) / part.mesh().diagonal();
    assert!(error < 0.05, "{error}");
}

#[test]
fn a_run_that_begins_as_an_earlier_one_ends_as_if_it_had_decided_alone() {
    let options = Options { metric: MetricKind::Hybrid, ..Options::DEFAULT };
    let of = |mesh: &Mesh, guidance: Guidance<'_>| {
        let (simplified, recorded) = simplify_recorded(mesh, &options, guidance, &|_, _| {});
        let parts = simplified.collapses().parts();
        let steps = (parts.targets.clone(), parts.step_errors.clone());
        ((steps, simplified.mesh().positions().to_vec()), recorded)
    };
    for mesh in [shapes::icosphere(3), shapes::terrain(), shapes::machine_part()] {
        let (everywhere, recorded) = of(&mesh, Guidance::default());
        // The quadric decides from 40 to 20 %.
        let hybrid_ranges = Some(&[[1.0, 0.4], [0.2, 0.0]][..]);
        let (alone, _) = of(&mesh, Guidance { hybrid_ranges, ..Guidance::default() });
        assert_ne!(alone.0, everywhere.0);
        let prefix = Some(Prefix { collapses: &recorded, share: 0.4 });
        let (after, _) = of(&mesh, Guidance { hybrid_ranges, prefix, ..Guidance::default() });
        assert_eq!(alone, after);
    }
}

#[test]
fn a_commit_costs_what_the_look_said() {
    let (mut looked_at, mut off) = (0, 0);
    for mesh in [shapes::icosphere(3), shapes::terrain(), shapes::torus(), shapes::machine_part()] {
        let colours = Checkerboard::new(&mesh);
        let (options, known) = (Options::DEFAULT, Guidance::default());
        let input = Input::new(&mesh);
        let mut region = Region::whole(&input, false);
        region.mesh.keep_facets();
        let mut metric =
            HybridMetric::new(&mesh, Some(&colours), &region, input.size, &options, known);
        let Region { mesh: mut working, wedges, .. } = region;
        metric.update_activity(&working, true);
        let mut random = shapes::Rng::new(5);
        for _ in 0..60 {
            let from = random.below(working.group_positions.len()) as u32;
            let Some(&corner) = working.star(from).first() else { continue };
            let to = working.others(corner)[random.below(2)];
            let mut candidates = [(0.0, to)];
            metric.reevaluate(
                &working,
                &wedges,
                from,
                &mut candidates,
                false,
                &mut Patch::default(),
            );
            let before: f64 = metric.energy.iter().sum();
            metric.collapsed(&working, &wedges, from, to);
            let alive_before = working.live_faces;
            let mut gone = Vec::new();
            for c in working.star(from) {
                if working.others(*c).contains(&to) {
                    gone.push(c.face());
                }
            }
            working.merge(from, to, |_| {});
            for face in gone {
                metric.energy[face as usize] = 0.0;
            }
            assert!(working.live_faces < alive_before);
            let added = metric.energy.iter().sum::<f64>() - before;
            let said = candidates[0].0;
            let expected = if added >= 0.0 { added } else { 0.0 };
            // Samples are thinned, and those with two places at one distance may take either: a
            // few collapses may cost something else.
            let close = (said - expected).abs() <= 0.05 * expected.abs() + 1e-5;
            off += usize::from(!close);
            looked_at += 1;
        }
    }
    assert!(looked_at > 100 && 20 * off <= looked_at, "{off} of {looked_at} cost something else");
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let mesh = shapes::machine_part();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&mesh))
    };
    assert_eq!(with(1), with(3));
}
