//! What other shapes than that at rest do to a simplification.

use crate::{Guidance, Options, SeenShape, SeenShapes, simplify, simplify_guided, simplify_with};
use lodc_fixtures::terrain;
use lodc_mesh::{Mesh, Simplified};

fn guided(mesh: &Mesh, shapes: &SeenShapes) -> Simplified {
    let guidance = Guidance { shapes: Some(shapes), ..Guidance::default() };
    simplify_guided(mesh, &Options::DEFAULT, guidance, &|_, _| {})
}

/// The shapes of a mesh with bumps of some places, one shape for each.
fn raised(mesh: &Mesh, places: &[[f32; 2]], weight: f64) -> SeenShapes {
    let (lo, hi) = mesh.bounds();
    let size = hi[0] - lo[0];
    let shape = |place: &[f32; 2]| {
        let raise = |p: &[f32; 3]| {
            let offset = |k: usize| (p[k] - lo[k]) / size - place[k];
            let squared = offset(0).powi(2) + offset(1).powi(2);
            let height =
                if squared < 0.02 { 0.3 * size * (1.0 - squared / 0.02).powi(2) } else { 0.0 };
            [p[0], p[1], p[2] + height]
        };
        SeenShape { positions: mesh.positions().iter().map(raise).collect(), weight }
    };
    SeenShapes { others: places.iter().map(shape).collect(), ..SeenShapes::default() }
}

/// The vertices near a place that a quarter of the triangles use.
fn vertices_near(simplified: &Simplified, [x, y]: [f32; 2]) -> usize {
    let mesh = simplified.mesh();
    let triangles = mesh.triangles().len() as u32;
    let lod = simplified.collapses().lod_for_triangles(triangles / 4);
    let mut used: Vec<u32> = simplified.triangles_at(lod).iter().flat_map(|t| t.corners).collect();
    used.sort_unstable();
    used.dedup();
    let (lo, hi) = mesh.bounds();
    let size = hi[0] - lo[0];
    let is_near = |v: &&u32| {
        let p = mesh.positions()[**v as usize];
        ((p[0] - lo[0]) / size - x).hypot((p[1] - lo[1]) / size - y) < 0.14
    };
    used.iter().filter(is_near).count()
}

#[test]
fn vertices_stay_where_a_shape_needs_them() {
    let mesh = terrain();
    let place = [0.4, 0.6];
    let at = |shapes: &SeenShapes| vertices_near(&guided(&mesh, shapes), place);
    let rest = at(&SeenShapes::default());
    let raised_there = at(&raised(&mesh, &[place], 1.0));
    assert!(raised_there as f64 > 1.4 * rest as f64, "{raised_there} {rest}");
    // Another shape elsewhere takes some of them, but not all.
    let both = at(&raised(&mesh, &[place, [0.75, 0.25]], 1.0));
    assert!(both > rest && both <= raised_there, "{both}");
    assert!(at(&raised(&mesh, &[place], 1e-6)) < raised_there, "a weight counts");
}

#[test]
fn shapes_that_are_those_at_rest_change_nothing() {
    let mesh = terrain();
    let shape = SeenShape { positions: mesh.positions().to_vec(), weight: 1.0 };
    let same = SeenShapes { others: vec![shape; 3], ..SeenShapes::default() };
    let plain = simplify(&mesh, &Options::DEFAULT, &|_, _| {});
    assert_eq!(guided(&mesh, &same), plain);
    assert_eq!(guided(&mesh, &SeenShapes::default()), plain);
}

#[test]
fn shapes_go_along_from_region_to_region() {
    let mesh = terrain();
    let shapes = raised(&mesh, &[[0.3, 0.3], [0.4, 0.35], [0.7, 0.7]], 1.0);
    let guidance = Guidance { shapes: Some(&shapes), ..Guidance::default() };
    for region in [40, 200] {
        let run = || simplify_with(&mesh, &Options::DEFAULT, guidance, region, &|_, _| {}).0;
        let simplified = run();
        if let Err(broken) = lodc_fixtures::check_rules(&mesh, &simplified) {
            panic!("regions of {region}: {broken}");
        }
        let near = vertices_near(&simplified, [0.7, 0.7]);
        let rest = simplify_with(&mesh, &Options::DEFAULT, Guidance::default(), region, &|_, _| {});
        let rest = vertices_near(&rest.0, [0.7, 0.7]);
        assert!(near > rest, "regions of {region}: {near} {rest}");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        assert_eq!(pool.install(run), simplified, "one thread");
    }
}
