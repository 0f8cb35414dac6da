//! What other shapes than that at rest do to a simplification.

use crate::{
    Guidance, Options, SeenShape, SeenShapes, Weights, simplify, simplify_guided, simplify_with,
};
use lodc_fixtures::terrain;
use lodc_mesh::{Attribute, Component, Mesh, Semantic, Simplified};

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
        let positions = mesh.positions().iter().map(raise).collect();
        SeenShape { positions, normals: Vec::new(), weight }
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

/// A shape that moves nothing, but turns normals near a place.
fn turned(mesh: &Mesh, [x, y]: [f32; 2], normals: bool) -> SeenShapes {
    let (lo, hi) = mesh.bounds();
    let size = hi[0] - lo[0];
    let turn = |p: &[f32; 3]| {
        let (x, y) = ((p[0] - lo[0]) / size - x, (p[1] - lo[1]) / size - y);
        let near = x.hypot(y) < 0.14;
        if near { [(40.0 * x).sin(), (40.0 * y).sin(), 1.0] } else { [0.0, 0.0, 1.0] }
    };
    let positions = mesh.positions().to_vec();
    let normals = if normals { mesh.positions().iter().map(turn).collect() } else { Vec::new() };
    let others = vec![SeenShape { positions, normals, weight: 1.0 }];
    SeenShapes { others, ..SeenShapes::default() }
}

#[test]
fn normals_of_shapes_count_like_normals() {
    let mesh = with_normals(&terrain());
    let place = [0.4, 0.6];
    let at = |normals| vertices_near(&guided(&mesh, &turned(&mesh, place, normals)), place);
    let (rest, turned_there) = (at(false), at(true));
    assert!(turned_there as f64 > 1.4 * rest as f64, "{turned_there} {rest}");
    let weights = Weights { normal: 0.0, ..Weights::DEFAULT };
    let shapes = turned(&mesh, place, true);
    let guidance = Guidance { shapes: Some(&shapes), ..Guidance::default() };
    let options = Options { weights, ..Options::DEFAULT };
    let without = simplify_guided(&mesh, &options, guidance, &|_, _| {});
    assert!(vertices_near(&without, place) < turned_there, "a weight counts");
}

/// A mesh with all its normals upward.
fn with_normals(mesh: &Mesh) -> Mesh {
    let mut parts = mesh.clone().into_parts();
    let up: Vec<u8> = [0.0f32, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let number = parts.attributes.len() as u32;
    parts.attributes.push(Attribute {
        semantic: Semantic::Normal,
        morph_target: None,
        component: Component::F32,
        components: 3,
        normalized: false,
        bytes: up.repeat(parts.positions.len()),
    });
    parts.submeshes.iter_mut().for_each(|s| s.attributes.push(number));
    Mesh::try_from(parts).expect("a mesh")
}

#[test]
fn shapes_that_are_those_at_rest_change_nothing() {
    let mesh = terrain();
    let (positions, normals) = (mesh.positions().to_vec(), Vec::new());
    let shape = SeenShape { positions, normals, weight: 1.0 };
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
