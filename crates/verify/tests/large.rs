//! A mesh too large for full comparisons everywhere: simplified for real, then verified at every
//! step.

use lodc_lod::{AnyModel, ModelKind};
use lodc_simplify::{Options, simplify};
use lodc_strip::{StripOptions, StripPool};
use lodc_verify::{Check, Reference, VerifyOptions, verify};
use std::sync::Arc;

#[expect(clippy::print_stdout, reason = "what the large test is for is its time")]
fn simplify_and_verify(subdivisions: u32) {
    let simplified =
        Arc::new(simplify(&lodc_fixtures::icosphere(subdivisions), &Options::DEFAULT, &|_, _| ()));
    let start = std::time::Instant::now();
    let reference = Reference::new(&simplified).expect("a real sequence");
    let followed = start.elapsed();
    let model = AnyModel::build(
        ModelKind::Interactive,
        &mut StripPool::new(&simplified, StripOptions::default()),
    )
    .expect("triangles are in order");
    let checks = verify(&model, &reference, &VerifyOptions::default());
    println!(
        "{} triangles, {} steps: reference {followed:.2?}, in all {:.2?}",
        simplified.mesh().triangles().len(),
        reference.steps(),
        start.elapsed()
    );
    for check in reference.checks().iter().chain(&checks) {
        assert!(check.ok(), "{check:?}");
    }
    assert_eq!(checks.iter().filter(|c| c.lods > reference.steps() as u64).count(), 2);
    assert!(reference.checks().iter().all(Check::ok));
}

#[test]
fn twenty_thousand_triangles_verify_at_every_step() {
    simplify_and_verify(5);
}

#[test]
#[ignore = "takes a minute: 1.3 million triangles, to be run with --release"]
fn a_million_triangles_verify_at_every_step() {
    simplify_and_verify(8);
}
