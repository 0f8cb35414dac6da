//! Every fixture on a device, in every replay that a model has.

use crate::support::{device, models, reference};
use lodc_fixtures as fixtures;
use lodc_gpu::{Device, replay};
use lodc_mesh::Simplified;
use lodc_model::Model;
use lodc_plan as plan;

fn check(device: &Device, name: &str, simplified: Simplified, grid: u32) {
    for model in models(simplified) {
        let stops = plan::schedule(model.simplified().collapses(), grid, 10, 1);
        let reference = reference(model.simplified());
        for plan in model.replays(&stops, &reference).expect("a small mesh") {
            let what = format!("{name}, {}, {}", model.name(), plan.name);
            let done = replay(device, plan).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(done.difference, None, "{what}");
            assert!(done.lods > 5 && done.words > 0, "{what}");
        }
    }
}

#[test]
fn every_shape_is_the_same_on_a_device() {
    let Some(device) = device() else { return };
    for &(name, make) in fixtures::ALL {
        let mesh = make();
        if mesh.triangles().len() <= 400 {
            check(&device, name, fixtures::random_collapse(&mesh, 1), 40);
        }
    }
    for seed in 0..20 {
        check(
            &device,
            &format!("random {seed}"),
            fixtures::random_collapse(&fixtures::random(seed), seed),
            20,
        );
    }
}

/// Large enough for prefix sums of prefix sums, and for several workgroups in everything.
#[test]
fn a_large_mesh_is_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let mesh = fixtures::icosphere(6);
    let simplified = lodc_simplify::simplify(&mesh, &lodc_simplify::Options::default(), &|_, _| {});
    check(&device, "icosphere 6", simplified, 3);
}

#[test]
fn an_adapter_that_is_not_there_is_named() {
    if device().is_some() {
        let refused = Device::open(Some("no such adapter")).err().expect("none has that name");
        assert!(refused.to_string().contains("no such adapter"), "{refused}");
    }
}
