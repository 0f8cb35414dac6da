//! A mesh too large for full comparisons everywhere: simplified for real, then verified at every
//! step.

use lodc_lod::{AnyModel, ModelKind};
use lodc_simplify::{Options, simplify};
use lodc_strip::{StripOptions, StripPool};
use lodc_verify::{Reference, VerifyOptions, verify};
use std::sync::Arc;

fn simplify_and_verify(subdivisions: u32) {
    let simplified =
        Arc::new(simplify(&lodc_fixtures::icosphere(subdivisions), &Options::DEFAULT, &|_, _| ()));
    let reference = Reference::new(&simplified).expect("a real sequence");
    let model = AnyModel::build(
        ModelKind::Interactive,
        &mut StripPool::new(&simplified, StripOptions::default()),
    )
    .expect("triangles are in order");
    let checks = verify(&model, &reference, &VerifyOptions::default());
    for check in reference.checks().iter().chain(&checks) {
        assert!(check.ok(), "{check:?}");
    }
    assert_eq!(checks.iter().filter(|c| c.lods > reference.steps() as u64).count(), 2);
}

#[test]
fn twenty_thousand_triangles_verify_at_every_step() {
    simplify_and_verify(5);
}

#[test]
fn a_million_triangles_verify_at_every_step() {
    if lodc_fixtures::all_asked() {
        simplify_and_verify(8);
    }
}
