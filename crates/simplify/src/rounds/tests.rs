//! Rounds where only one region can go on.

use crate::{Guidance, Options, simplify_with};
use lodc_fixtures as shapes;

#[test]
fn no_vertex_runs_round_the_border_of_a_fan() {
    // All faces meet in one vertex, so only its region can go on.
    let mesh = shapes::fan(8000);
    let simplified = simplify_with(&mesh, &Options::DEFAULT, Guidance::default(), 1000, &|_, _| {});
    let collapses = simplified.collapses();
    let mut depth = vec![0u32; collapses.records() as usize + 1];
    for record in (0..mesh.vertex_count() / 2).rev() {
        depth[record] = 1 + depth[collapses.targets()[record] as usize];
    }
    let longest = depth.into_iter().max();
    assert!(longest.is_some_and(|most| most < 40), "{longest:?} collapses, one after the other");
}
