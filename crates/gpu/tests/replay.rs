//! Every fixture on a device: construction and continuous extraction, at every step and in jumps.

use lodc_fixtures as fixtures;
use lodc_gpu::{Device, GpuError, replay};
use lodc_lod::{AnyModel, Model, ModelKind, plan};
use lodc_mesh::Simplified;
use std::sync::Arc;

/// A device, or none said aloud. Where CI is set there must be one.
fn device() -> Option<Device> {
    match Device::open(None) {
        Ok(device) => Some(device),
        Err(GpuError::NoAdapter { why }) if std::env::var_os("CI").is_none() => {
            eprintln!("SKIPPED: no graphics adapter: {why}");
            None
        }
        Err(e) => panic!("{e}"),
    }
}

fn check(device: &Device, name: &str, simplified: Simplified, grid: u32) {
    let simplified = Arc::new(simplified);
    for kind in ModelKind::ALL.into_iter().filter(|kind| kind.available()) {
        let model = AnyModel::build(kind, &simplified).expect("a valid sequence");
        let stops = plan::schedule(simplified.collapses(), grid, 10, 1);
        for plan in model.replays(&stops).expect("a small mesh") {
            let what = plan.name;
            let done = replay(device, plan).unwrap_or_else(|e| panic!("{name}, {}: {e}", model.name()));
            assert_eq!(done.difference, None, "{name}, {}, {what}", model.name());
            assert!(done.lods > 5, "{name}, {what}");
            assert!(done.words > 0 || simplified.mesh().vertex_count() == 0);
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
        check(&device, &format!("random {seed}"), fixtures::random_collapse(&fixtures::random(seed), seed), 20);
    }
}

#[test]
fn an_adapter_that_is_not_there_is_named() {
    if device().is_some() {
        let refused = Device::open(Some("no such adapter")).err().expect("none has that name");
        assert!(refused.to_string().contains("no such adapter"), "{refused}");
    }
}
