//! Levels of detail of a sphere, one after the other: `cargo run -p lodc-lod --example extract`.
//!
//! Speed Strips are the model for a processor; [`ModelKind::Interactive`] is the one for a graphics
//! device.

#![expect(clippy::print_stdout, reason = "an example shows what it does")]

use lodc_lod::{AnyModel, ModelKind};
use lodc_model::Model;
use lodc_simplify::{Options, simplify};
use lodc_strip::{StripOptions, StripPool};
use std::sync::Arc;

fn main() {
    let mesh = lodc_fixtures::icosphere(4);
    let simplified = Arc::new(simplify(&mesh, &Options::DEFAULT, &|_, _| ()));
    let mut strips = StripPool::new(&simplified, StripOptions::default());
    let model = AnyModel::build(ModelKind::Speed, &mut strips)
        .expect("a simplifier's sequence has a model");
    let mut cursor = model.cursor();
    for triangles in [5120, 2560, 512, 51, 512, 5120] {
        let lod = simplified.collapses().lod_for_triangles(triangles);
        let traffic = model.seek(&mut cursor, lod, &mut ());
        let shown = model.triangles(&cursor).len();
        println!("LOD {}: {shown} triangles, {} indices rewritten", lod.0, traffic.rewritten);
        assert!(shown <= triangles as usize);
    }
}

#[test]
fn the_example_runs() {
    main();
}
