use crate::{Options, simplify};
use lodc_fixtures::{Coincident, coincident};
use lodc_mesh::{Simplified, position_key};

type PositionKey = [u32; 3];

/// Where the first vertex of each legal step was, and where it went.
fn legal_moves(simplified: &Simplified) -> Vec<(PositionKey, PositionKey)> {
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let at = |v: u32| position_key(mesh.positions()[v as usize]);
    let legal = collapses.parts().last_legal_lod;
    let mut first = 0;
    let mut moves = Vec::new();
    for step in (0..collapses.steps()).map(|i| collapses.step(i)) {
        if step.lod > legal {
            break;
        }
        moves.push((at(first), at(collapses.targets()[first as usize])));
        first = step.lod.0;
    }
    moves
}

#[test]
fn a_doubled_surface_loses_the_same_positions_in_the_same_order() {
    let mut compared = 0;
    for (name, shape) in lodc_fixtures::ALL {
        let mesh = shape();
        let single = simplify(&mesh, &Options::DEFAULT, &|_, _| {});
        for kind in [Coincident::TwoSided, Coincident::Doubled, Coincident::HalfDoubled] {
            let doubled = coincident(&mesh, kind);
            let simplified = simplify(&doubled, &Options::DEFAULT, &|_, _| {});
            if let Err(broken) = lodc_fixtures::check_rules(&doubled, &simplified) {
                panic!("{name}, {kind:?}: {broken}");
            }
            // The two sides of a Möbius strip are one: no layer of it is the single strip's.
            if *name == "mobius_strip" && kind != Coincident::Doubled {
                continue;
            }
            let (doubled, single) = (legal_moves(&simplified), legal_moves(&single));
            let differs = doubled.iter().zip(&single).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{name}, {kind:?}: the first collapse that differs");
            assert_eq!(doubled.len(), single.len(), "{name}, {kind:?}");
            compared += single.len();
        }
    }
    assert!(compared > 10_000, "{compared} collapses");
}
