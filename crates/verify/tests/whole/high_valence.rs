//! Shapes with vertices and edges of thousands of triangles: followed with few moves for each
//! corner. The reference counts its moves and gives up where they are many.

use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Mesh;
use lodc_simplify::{Options, simplify};
use lodc_strip::{StripOptions, StripPool};
use lodc_verify::{Reference, VerifyOptions, verify};
use std::sync::Arc;

fn follow(mesh: &Mesh) {
    let simplified = Arc::new(simplify(mesh, &Options::DEFAULT, &|_, _| ()));
    let reference = Reference::new(&simplified).expect("few moves");
    let mut strips = StripPool::new(&simplified, StripOptions::default());
    let checks = ModelKind::ALL.into_iter().flat_map(|kind| {
        let model = AnyModel::build(kind, &mut strips).expect("a valid sequence");
        verify(&model, &reference, &VerifyOptions::default())
    });
    for check in reference.checks().iter().cloned().chain(checks) {
        assert!(check.ok(), "{check:?}");
    }
}

#[test]
fn hubs_of_thousands_of_triangles_are_followed_with_few_moves() {
    let n = 8_000;
    for make in [lodc_fixtures::fan, lodc_fixtures::book, lodc_fixtures::pinwheel] {
        follow(&make(n));
    }
    follow(&lodc_fixtures::soup(n));
}
