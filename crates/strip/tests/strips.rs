//! Every generator draws exactly the mesh, whatever the mesh, the effort and the number of threads.

use lodc_fixtures as fixtures;
use lodc_mesh::{Mesh, MeshParts, OrientedTriangle, Submesh};
use lodc_strip::{CacheModel, CacheOptions, Effort, StripSet, cache, measure, order, stripe};

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Default, Effort::Thorough];

type Generator = (String, Box<dyn Fn(&Mesh) -> StripSet>);

fn generators() -> Vec<Generator> {
    let mut all: Vec<Generator> = Vec::new();
    for effort in EFFORTS {
        all.push((format!("stripe {effort:?}"), Box::new(move |mesh| stripe(mesh, effort))));
        let options = CacheOptions { effort, ..CacheOptions::default() };
        all.push((format!("cache {effort:?}"), Box::new(move |mesh| cache(mesh, &options))));
    }
    all
}

/// A mesh of one submesh; where vertices lie does not matter, as long as they differ.
fn mesh(triangles: Vec<[u32; 3]>) -> Mesh {
    let vertices = triangles.iter().flatten().max().map_or(0, |v| v + 1);
    let submesh = Submesh { triangle_count: triangles.len() as u32, ..Submesh::default() };
    let parts = MeshParts {
        positions: (0..vertices).map(|v| [v as f32, 0.0, 0.0]).collect(),
        vertex_submesh: vec![0; vertices as usize],
        triangles,
        submeshes: vec![submesh],
        ..MeshParts::default()
    };
    Mesh::try_from(parts).expect("a valid mesh")
}

fn grid(n: u32) -> Mesh {
    let at = |x: u32, y: u32| y * (n + 1) + x;
    let cells = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
    mesh(
        cells
            .flat_map(|(x, y)| {
                [
                    [at(x, y), at(x + 1, y), at(x, y + 1)],
                    [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)],
                ]
            })
            .collect(),
    )
}

fn check(name: &str, mesh: &Mesh) {
    for (generator, make) in generators() {
        let strips = make(mesh);
        strips.check(mesh).unwrap_or_else(|e| panic!("{name}, {generator}: {e}"));
        assert!(
            strips.iter().all(|s| s.len() >= 3),
            "{name}, {generator}: a strip without a triangle"
        );
        let most = mesh.triangles().len() as u64 * 3;
        assert!(
            strips.separate_indices() <= most,
            "{name}, {generator}: more indices than a list has"
        );
    }
    let sorted = |triangles: &[[u32; 3]]| {
        let mut all: Vec<_> = Vec::new();
        for (i, s) in mesh.submeshes().iter().enumerate() {
            all.extend(
                triangles[s.triangles()].iter().map(|&t| OrientedTriangle::new(i as u32, t)),
            );
        }
        all.sort_unstable();
        all
    };
    assert!(
        sorted(&order(mesh, 16)) == sorted(mesh.triangles()),
        "{name}: order changed the triangles"
    );
}

#[test]
fn every_shape_is_drawn_exactly() {
    for (name, shape) in fixtures::ALL {
        check(name, &shape());
    }
}

#[test]
fn random_meshes_are_drawn_exactly() {
    for seed in 0..300 {
        check(&format!("random {seed}"), &fixtures::random(seed));
    }
}

#[test]
fn random_triangles_over_few_vertices_are_drawn_exactly() {
    // Every edge has many triangles, with both windings, and many triangles are there several
    // times.
    for seed in 0..60 {
        let mut rng = fixtures::Rng::new(seed);
        let vertices = 4 + rng.below(12);
        let mut triangles = Vec::new();
        for _ in 0..rng.below(200) {
            let t = [(); 3].map(|()| rng.below(vertices) as u32);
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                triangles.push(t);
            }
        }
        check(&format!("soup {seed}"), &mesh(triangles));
    }
}

#[test]
fn a_band_is_one_strip_without_repetitions() {
    for n in [1u32, 2, 3, 4, 50, 51] {
        let band = (0..n)
            .map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] })
            .collect();
        let band = mesh(band);
        let strips = stripe(&band, Effort::Default);
        strips.check(&band).expect("exact");
        // An even number of triangles can be wound so that the strip must begin at its other end;
        // it never needs more.
        assert_eq!(
            (strips.len(), strips.separate_indices()),
            (1, u64::from(n) + 2),
            "{n} triangles"
        );
    }
}

#[test]
fn a_fan_turns_by_repetitions() {
    // Six triangles about one vertex, closed: 5 links, between the 4 inner triangles 3 swaps.
    let fan = mesh((0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect());
    let strips = stripe(&fan, Effort::Default);
    strips.check(&fan).expect("exact");
    assert!(strips.separate_indices() <= 11, "{strips:?}");
}

#[test]
fn counts_are_those_of_separate_calls_and_of_restarts() {
    let two = mesh(vec![[0, 1, 2], [3, 4, 5]]);
    let strips = stripe(&two, Effort::Fast);
    assert_eq!((strips.len(), strips.separate_indices(), strips.restart_indices()), (2, 6, 7));
    let none = stripe(&mesh(vec![]), Effort::Thorough);
    assert_eq!((none.len(), none.separate_indices(), none.restart_indices()), (0, 0, 0));
}

#[test]
fn strips_do_not_depend_on_the_number_of_threads() {
    // Large enough for many regions.
    let mesh = grid(160);
    let with = |threads: usize, effort: Effort| {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
        let options = CacheOptions { effort, ..CacheOptions::default() };
        pool.install(|| (stripe(&mesh, effort), cache(&mesh, &options)))
    };
    for effort in [Effort::Fast, Effort::Default] {
        let one = with(1, effort);
        for threads in [2, 3, 8] {
            assert!(with(threads, effort) == one, "{threads} threads, {effort:?}");
        }
    }
}

#[test]
fn a_vertex_of_every_triangle_takes_no_longer() {
    let n = 200_000;
    let fan = mesh((0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect());
    for strips in [
        stripe(&fan, Effort::Fast),
        cache(&fan, &CacheOptions { effort: Effort::Fast, ..Default::default() }),
    ] {
        strips.check(&fan).expect("exact");
    }
    assert_eq!(order(&fan, 16).len(), n as usize);
}

#[test]
fn an_edge_of_every_triangle_takes_no_longer() {
    let n = 200_000u32;
    let book =
        mesh((0..n).map(|i| if i % 3 == 0 { [0, 1, 2 + i] } else { [1, 0, 2 + i] }).collect());
    stripe(&book, Effort::Fast).check(&book).expect("exact");
    cache(&book, &CacheOptions { effort: Effort::Fast, ..Default::default() })
        .check(&book)
        .expect("exact");
}

#[test]
fn strips_are_short_and_misses_few_on_a_smooth_surface() {
    let sphere = fixtures::icosphere(5);
    let triangles = sphere.triangles().len();
    let per = |n: u64| n as f64 / triangles as f64;
    let misses = |indices: &[u32]| {
        measure(indices.iter().copied(), sphere.vertex_count(), CacheModel::default())
            .acmr(triangles)
    };
    let long = |effort| per(stripe(&sphere, effort).separate_indices());
    assert!(long(Effort::Fast) < 1.16 && long(Effort::Default) < 1.12);
    let short = |effort| cache(&sphere, &CacheOptions { effort, ..CacheOptions::default() });
    for (effort, most_indices, most_misses) in
        [(Effort::Fast, 1.42, 0.66), (Effort::Default, 1.36, 0.66)]
    {
        let strips = short(effort);
        let (indices, misses) = (per(strips.separate_indices()), misses(strips.indices()));
        assert!(
            indices < most_indices && misses < most_misses,
            "{effort:?}: {indices} indices, {misses} misses"
        );
    }
    let list = misses(order(&sphere, 16).as_flattened());
    assert!(list < 0.62, "list: {list} misses");
}
