//! Locks and weights: what is locked stays, what is weighted changes the order.

use crate::tests::{grid, run, run_with};
use crate::{Guidance, Options, Weights, simplify_guided, simplify_with};
use lodc_fixtures as shapes;
use lodc_mesh::Simplified;

#[test]
fn locked_vertices_stay_until_the_terminal_phase() {
    let mesh = grid(20);
    // A patch in the middle, far from the border.
    let inside = |p: [f32; 3]| p[..2].iter().all(|c| (8.0..=12.0).contains(c));
    let locked: Vec<bool> = mesh.positions().iter().map(|&p| inside(p)).collect();
    let guidance = Guidance { locked: &locked, ..Guidance::default() };
    let s = simplify_guided(&mesh, &Options::DEFAULT, guidance, &|_, _| {});
    let gone = |s: &Simplified| {
        let legal = s.collapses().parts().last_legal_lod;
        s.mesh().positions()[..legal.0 as usize].iter().filter(|p| inside(**p)).count()
    };
    assert_eq!(gone(&s), 0, "every locked vertex is left");
    assert!(gone(&run(&mesh)) > 20, "without locks they go");
    let regions = simplify_with(&mesh, &Options::DEFAULT, guidance, 30, &|_, _| {});
    assert_eq!(gone(&regions), 0, "in small regions, too");
}

#[test]
fn weights_change_what_goes_first() {
    let mesh = shapes::uv_sphere(24, 12);
    let order = |uv: f64| {
        let weights = Weights { uv, ..Weights::DEFAULT };
        let s = run_with(&mesh, Options { weights, ..Options::DEFAULT });
        s.collapses().parts().targets.clone()
    };
    assert_eq!(order(1.0), run(&mesh).collapses().parts().targets);
    assert_ne!(order(1.0), order(100.0));
}

#[test]
fn weights_of_submeshes_are_those_of_the_options_unless_they_differ() {
    let mesh = shapes::machine_part();
    let with = |weights: &[Weights]| {
        let guidance = Guidance { weights, ..Guidance::default() };
        simplify_guided(&mesh, &Options::DEFAULT, guidance, &|_, _| {})
    };
    let weights = Weights { normal: 30.0, uv: 50.0, ..Weights::DEFAULT };
    let all = |w: Weights| vec![w; mesh.submeshes().len()];
    assert!(mesh.submeshes().len() > 1 && !mesh.attributes().is_empty());
    assert_eq!(with(&all(Weights::DEFAULT)), run(&mesh));
    let weighted = run_with(&mesh, Options { weights, ..Options::DEFAULT });
    assert_eq!(with(&all(weights)), weighted);
    let mut one = all(Weights::DEFAULT);
    one[0] = weights;
    let differs = with(&one);
    assert!(differs != weighted && differs != run(&mesh));
}

#[test]
fn joints_weigh_by_submesh() {
    let mesh = shapes::skinned_tube(lodc_mesh::Component::U8);
    let skin = |skin: f64| Weights { skin, ..Weights::DEFAULT };
    let guidance = Guidance { weights: &[skin(100.0)], ..Guidance::default() };
    let own = simplify_guided(&mesh, &Options::DEFAULT, guidance, &|_, _| {});
    assert_eq!(own, run_with(&mesh, Options { weights: skin(100.0), ..Options::DEFAULT }));
    assert_ne!(own, run(&mesh));
}
