//! A model on a graphics device, compared with the CPU at some levels of detail:
//! `cargo run -p lodc-gpu --example engine`.

#![expect(clippy::print_stdout, reason = "an example shows what it does")]

use lodc_gpu::{Device, GpuError, replay};
use lodc_lod::Interactive;
use lodc_plan::schedule;
use lodc_simplify::{Options, simplify};
use lodc_verify::Reference;
use std::sync::Arc;

fn main() {
    let device = match Device::open(None) {
        Ok(device) => device,
        Err(GpuError::NoAdapter { why }) => return println!("no graphics device: {why}"),
        Err(error) => panic!("{error}"),
    };
    let mesh = lodc_fixtures::icosphere(4);
    let simplified = Arc::new(simplify(&mesh, &Options::DEFAULT, &|_, _| ()));
    let model = Interactive::build(&simplified).expect("a simplifier's sequence has a model");
    let stops = schedule(simplified.collapses(), 10, 3, 1);
    let reference = Reference::new(&simplified).expect("a small sequence");
    for plan in model.replays(&stops, &reference).expect("a small mesh") {
        let name = plan.name;
        let done = replay(&device, plan).expect("a small mesh fits on any device");
        println!("{}: {name}, {} levels", device.adapter(), done.lods);
        assert_eq!(done.difference, None);
    }
}

#[test]
fn the_example_runs() {
    main();
}
