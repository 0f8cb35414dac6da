//! Promises of a simplification, on shapes small enough to think about.

use crate::{Guidance, MetricKind, Options, Weights, simplify, simplify_guided, simplify_with};
use lodc_fixtures as shapes;
use lodc_mesh::{Attribute, Component, Lod, Mesh, MeshParts, Semantic, Simplified, Submesh};

/// Simplifies in regions of about `region` groups each.
fn simplify_in(
    mesh: &Mesh,
    options: &Options,
    region: usize,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Simplified {
    simplify_with(mesh, options, Guidance::default(), region, progress).0
}

fn run(mesh: &Mesh) -> Simplified {
    run_with(mesh, Options::DEFAULT)
}

fn run_with(mesh: &Mesh, options: Options) -> Simplified {
    simplify(mesh, &options, &|_, _| {})
}

/// A flat grid of `n` × `n` squares, plain positions.
fn grid(n: u32) -> Mesh {
    let row = n + 1;
    let positions: Vec<[f32; 3]> =
        (0..row * row).map(|i| [(i % row) as f32, (i / row) as f32, 0.0]).collect();
    let mut triangles = Vec::new();
    for i in (0..row * n).filter(|i| i % row < n) {
        triangles.push([i, i + 1, i + row]);
        triangles.push([i + 1, i + row + 1, i + row]);
    }
    plain(positions, triangles)
}

fn plain(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let submeshes = vec![Submesh {
        first_triangle: 0,
        triangle_count: triangles.len() as u32,
        attributes: Vec::new(),
    }];
    let vertex_submesh = vec![0; positions.len()];
    Mesh::try_from(MeshParts {
        positions,
        vertex_submesh,
        triangles,
        submeshes,
        attributes: Vec::new(),
    })
    .expect("a mesh made by hand")
}

/// Two floats for each vertex.
fn texture_coordinates(bytes: Vec<u8>) -> Attribute {
    Attribute {
        semantic: Semantic::TexCoord(0),
        morph_target: None,
        component: Component::F32,
        components: 2,
        normalized: false,
        bytes,
    }
}

#[test]
fn every_shape_obeys_the_rules() {
    for (name, shape) in shapes::ALL {
        let mesh = shape();
        if let Err(broken) = shapes::check_rules(&mesh, &run(&mesh)) {
            panic!("{name}: {broken}");
        }
    }
}

#[test]
fn random_meshes_obey_the_rules_whatever_the_options() {
    for seed in 0..200 {
        let mesh = shapes::random(seed);
        let options = Options {
            preserve_topology: seed % 2 == 1,
            lock_border: seed % 3 == 1,
            attributes: seed % 5 != 1,
            ..Options::DEFAULT
        };
        if let Err(broken) = shapes::check_rules(&mesh, &run_with(&mesh, options)) {
            panic!("seed {seed}, {options:?}: {broken}");
        }
    }
}

/// Regions so small that small shapes take many rounds.
const TINY_REGION: usize = 8;

#[test]
fn regions_obey_the_rules_whatever_the_options() {
    for (name, shape) in shapes::ALL {
        let mesh = shape();
        let simplified = simplify_in(&mesh, &Options::DEFAULT, TINY_REGION, &|_, _| {});
        if let Err(broken) = shapes::check_rules(&mesh, &simplified) {
            panic!("{name}: {broken}");
        }
    }
    for seed in 0..200 {
        let mesh = shapes::random(seed);
        let options = Options {
            preserve_topology: seed % 2 == 1,
            lock_border: seed % 3 == 1,
            attributes: seed % 5 != 1,
            ..Options::DEFAULT
        };
        let simplified = simplify_in(&mesh, &options, TINY_REGION, &|_, _| {});
        if let Err(broken) = shapes::check_rules(&mesh, &simplified) {
            panic!("seed {seed}, {options:?}: {broken}");
        }
    }
}

#[test]
fn regions_cost_hardly_more_error_than_the_exact_order() {
    let mesh = shapes::icosphere(4);
    let error = |region| {
        let simplified = simplify_in(&mesh, &Options::DEFAULT, region, &|_, _| {});
        let collapses = simplified.collapses();
        let triangles = mesh.triangles().len() as u32;
        [4, 16, 64].map(|part| {
            f64::from(collapses.error_at(collapses.lod_for_triangles(triangles / part)))
        })
    };
    let (exact, regions) = (error(usize::MAX / 8), error(128));
    // The largest error so far is a coarse measure, and these regions are small.
    for (e, r) in exact.into_iter().zip(regions) {
        assert!(r <= 1.3 * e, "exact {e}, regions {r}");
    }
}

/// Points of a circle, slightly waved.
fn circle(n: u32) -> impl Iterator<Item = [f32; 3]> {
    (0..n).map(move |i| {
        let a = i as f32 / n as f32 * std::f32::consts::TAU;
        [a.cos(), a.sin(), 0.02 * (a * 9.0).sin()]
    })
}

#[test]
fn hubs_obey_the_rules() {
    let n = 300;
    let poles = [[0.0, 0.0, 0.3], [0.0, 0.0, -0.3]];
    let both: Vec<[f32; 3]> = poles.into_iter().chain(circle(n)).collect();
    let one: Vec<[f32; 3]> = poles.into_iter().take(1).chain(circle(n)).collect();
    let fan = |pole: u32, first: u32| move |i: u32| [pole, first + i, first + (i + 1) % n];
    let turned = |[a, b, c]: [u32; 3]| [a, c, b];
    let edge: Vec<[u32; 3]> = (0..n).map(|i| [0, 1, 2 + i]).collect();
    let bipyramid = (0..n).map(fan(0, 2)).chain((0..n).map(fan(1, 2)).map(turned)).collect();
    let fan = (0..n).map(fan(0, 1)).collect();
    let meshes = [
        ("fan", plain(one, fan)),
        ("edge", plain(both.clone(), edge)),
        ("bipyramid", plain(both, bipyramid)),
    ];
    for (name, mesh) in meshes {
        for region in [TINY_REGION, usize::MAX / 8] {
            let simplified = simplify_in(&mesh, &Options::DEFAULT, region, &|_, _| {});
            if let Err(broken) = shapes::check_rules(&mesh, &simplified) {
                panic!("{name}, regions of {region}: {broken}");
            }
        }
    }
}

#[test]
fn a_flat_square_goes_down_to_two_triangles_without_error() {
    let s = run(&grid(12));
    let two = s.collapses().lod_for_triangles(2);
    assert_eq!(s.collapses().triangles_at(two), 2);
    assert!(s.collapses().error_at(two) < 1e-6, "error {}", s.collapses().error_at(two));
    let corners: Vec<[f32; 3]> = s
        .triangles_at(two)
        .iter()
        .flat_map(|t| t.corners)
        .map(|v| s.mesh().positions()[v as usize])
        .collect();
    for corner in [[0.0, 0.0, 0.0], [12.0, 0.0, 0.0], [0.0, 12.0, 0.0], [12.0, 12.0, 0.0]] {
        assert!(corners.contains(&corner), "{corner:?} is gone");
    }
}

#[test]
fn tiles_of_their_own_are_left_everywhere() {
    let n = 32;
    let tile = |i: u32| {
        let [x, y] = [(i % n) as f32, (i / n) as f32];
        let corners = [[0.0, 0.0], [0.9, 0.0], [0.9, 0.9], [0.0, 0.9]];
        corners.map(|[u, v]| [x + u, y + v, (0.3 * x).sin() + (0.2 * y).cos()])
    };
    let positions: Vec<[f32; 3]> = (0..n * n).flat_map(tile).collect();
    let faces = |i: u32| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]];
    let simplified = run(&plain(positions.clone(), (0..n * n).flat_map(faces).collect()));
    // One in ten, then one in twenty of the triangles: a fifth and a tenth of the tiles.
    for (triangles, farthest) in [(n * n / 5, 4.0), (n * n / 10, 6.0)] {
        let left = simplified.triangles_at(simplified.collapses().lod_for_triangles(triangles));
        let at = |v: u32| glam::Vec3::from(simplified.mesh().positions()[v as usize]);
        let left: Vec<glam::Vec3> = left.iter().map(|t| at(t.corners[0])).collect();
        let distance = |p: &[f32; 3]| {
            let to = |q: &glam::Vec3| q.distance(glam::Vec3::from(*p));
            left.iter().map(to).fold(f32::INFINITY, f32::min)
        };
        let most = positions.iter().map(distance).fold(0.0, f32::max);
        assert!(most < farthest, "{triangles} triangles: {most} tiles from the next");
    }
}

#[test]
fn the_inner_of_two_coarse_levels_never_costs_less_error() {
    for (name, shape) in shapes::ALL {
        let s = run(&shape());
        let errors = &s.collapses().parts().step_errors;
        assert!(errors.windows(2).all(|w| w[0] <= w[1]), "{name}");
    }
}

#[test]
fn a_thin_blade_keeps_its_length() {
    // A flat double-sided blade whose sides are almost one plane: memoryless costs alone would eat
    // it from its tip.
    let n = 40;
    let mut positions = Vec::new();
    for i in 0..=n {
        let (x, width) = (i as f32, 1.0 - 0.5 * i as f32 / n as f32);
        positions.extend([[x, -width, 0.0], [x, 0.0, 0.02], [x, width, 0.0], [x, 0.0, -0.02]]);
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        for k in 0..4 {
            let (a, b) = (4 * i + k, 4 * i + (k + 1) % 4);
            triangles.extend([[a, a + 4, b], [b, a + 4, b + 4]]);
        }
    }
    let end = 4 * n;
    triangles.extend([[0, 1, 2], [0, 2, 3], [end, end + 2, end + 1], [end, end + 3, end + 2]]);
    let s = run(&plain(positions, triangles));
    let lod = s.collapses().lod_for_triangles(16);
    let xs: Vec<f32> = s
        .triangles_at(lod)
        .iter()
        .flat_map(|t| t.corners)
        .map(|v| s.mesh().positions()[v as usize][0])
        .collect();
    assert_eq!(xs.iter().copied().fold(f32::MIN, f32::max), n as f32);
    assert_eq!(xs.iter().copied().fold(f32::MAX, f32::min), 0.0);
}

#[test]
fn threads_do_not_change_the_result() {
    let mesh = shapes::machine_part();
    let painted: Vec<f32> = (0..mesh.vertex_count()).map(|v| (v % 3) as f32 / 2.0).collect();
    let with = |threads, region, importance| {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a small pool");
        let guidance = Guidance { importance, ..Guidance::default() };
        pool.install(|| simplify_with(&mesh, &Options::DEFAULT, guidance, region, &|_, _| {}).0)
    };
    for (region, importance) in
        [(TINY_REGION, &[][..]), (TINY_REGION, &painted), (64, &painted), (usize::MAX / 8, &[])]
    {
        let one = with(1, region, importance);
        for threads in [2, 3, 8] {
            let many = with(threads, region, importance);
            assert_eq!(many, one, "{threads} threads, regions of {region}");
        }
    }
}

#[test]
fn scaling_by_a_power_of_two_changes_errors_only() {
    let mesh = shapes::torus();
    let mut parts = mesh.clone().into_parts();
    for p in &mut parts.positions {
        *p = p.map(|c| c * 1024.0);
    }
    let (small, large) = (run(&mesh), run(&Mesh::try_from(parts).expect("a larger torus")));
    assert_eq!(small.collapses().targets(), large.collapses().targets());
    for (s, l) in
        small.collapses().parts().step_errors.iter().zip(&large.collapses().parts().step_errors)
    {
        assert!((s * 1024.0 - l).abs() <= l * 1e-5, "{s} {l}");
    }
}

#[test]
fn locked_borders_stay_until_the_terminal_phase() {
    let s = run_with(&grid(6), Options { lock_border: true, ..Options::DEFAULT });
    let legal = s.collapses().parts().last_legal_lod;
    let border = |p: [f32; 3]| p[0] == 0.0 || p[1] == 0.0 || p[0] == 6.0 || p[1] == 6.0;
    let gone = s.mesh().positions()[..legal.0 as usize].iter().filter(|p| border(**p)).count();
    assert_eq!(gone, 0);
    assert_eq!(legal.0, 25, "all inner vertices went legally");
}

#[test]
fn preserved_topology_keeps_the_hole_of_a_torus() {
    let s = run_with(&shapes::torus(), Options { preserve_topology: true, ..Options::DEFAULT });
    let c = s.collapses();
    assert_eq!(c.parts().topology_changes, 0);
    assert!(c.triangles_at(c.parts().last_legal_lod) >= 14, "no torus has fewer than 14 triangles");
}

#[test]
fn seams_cost_no_fakes_on_a_sphere_and_its_texture_never_turns_over() {
    let mesh = shapes::uv_sphere(24, 12);
    let s = run(&mesh);
    assert_eq!(s.fakes(), 0);
    let texture = mesh
        .attributes()
        .iter()
        .position(|a| a.semantic == Semantic::TexCoord(0))
        .expect("textured");
    let texture = &s.mesh().attributes()[texture];
    let lod = s.collapses().floor(s.collapses().parts().last_legal_lod);
    for step in (0..s.collapses().steps())
        .map(|i| s.collapses().step(i).lod)
        .filter(|&l| l <= lod)
        .chain([Lod(0)])
    {
        for t in s.triangles_at(step) {
            let [a, b, c] = t.corners.map(|v| [texture.value(v, 0), texture.value(v, 1)]);
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(area <= 1e-6, "LOD {}: texture turned over, area {area}", step.0);
        }
    }
}

/// A new vertex where materials meet has the attributes of the vertex that it lies on, not those
/// that it comes from: they go on from one material to the other.
#[test]
fn texture_coordinates_go_on_where_materials_meet() {
    let whole = grid(12);
    let (mut parts, materials) = (MeshParts::default(), 3);
    for s in 0..materials {
        let first_triangle = parts.triangles.len() as u32;
        let of_material = whole.triangles().iter().zip(0u32..).filter(|(_, i)| i * 7 % 5 % 3 == s);
        let mut number = vec![u32::MAX; whole.vertex_count()];
        for (t, _) in of_material {
            parts.triangles.push(t.map(|v| {
                let number = &mut number[v as usize];
                if *number == u32::MAX {
                    *number = parts.positions.len() as u32;
                    parts.positions.push(whole.positions()[v as usize]);
                    parts.vertex_submesh.push(s);
                }
                *number
            }));
        }
        let triangle_count = parts.triangles.len() as u32 - first_triangle;
        parts.submeshes.push(Submesh { first_triangle, triangle_count, attributes: vec![0] });
    }
    let coordinates = parts.positions.iter().flat_map(|p| [p[0] / 12.0, p[1] / 12.0]);
    let coordinates = texture_coordinates(coordinates.flat_map(f32::to_le_bytes).collect());
    parts.attributes.push(coordinates);
    let mesh = Mesh::try_from(parts).expect("a mesh");
    for options in [Options::DEFAULT, Options { metric: MetricKind::Hybrid, ..Options::DEFAULT }] {
        let simplified = run_with(&mesh, options);
        let result = simplified.mesh();
        assert!(result.vertex_count() > mesh.vertex_count(), "no vertex was added");
        for v in 0..result.vertex_count() as u32 {
            let [x, y, _] = result.positions()[v as usize];
            let coordinates = [0, 1].map(|c| result.attributes()[0].value(v, c));
            assert_eq!(coordinates, [x / 12.0, y / 12.0], "vertex {v}");
        }
    }
}

#[test]
fn attributes_that_are_no_numbers_do_no_harm() {
    let mut parts = shapes::uv_sphere(8, 6).into_parts();
    for a in &mut parts.attributes {
        a.bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes());
        a.bytes[4..8].copy_from_slice(&f32::INFINITY.to_le_bytes());
    }
    let mesh = Mesh::try_from(parts).expect("attributes may hold anything");
    shapes::check_rules(&mesh, &run(&mesh)).expect("still a level of detail");
}

#[test]
fn extreme_coordinates_do_no_harm() {
    for scale in [1e-40, 1e-30, 1e18, 1e37] {
        let mut parts = shapes::torus().into_parts();
        for p in &mut parts.positions {
            *p = p.map(|c| c * scale);
        }
        parts.clean();
        let mesh = Mesh::try_from(parts).expect("finite");
        shapes::check_rules(&mesh, &run(&mesh)).unwrap_or_else(|e| panic!("scale {scale}: {e}"));
    }
}

#[test]
fn groups_that_come_to_share_a_position_lose_no_vertex() {
    // Two vertices at one position whose triangles do not hang together there; moving the end of
    // the ring onto one of them gives a triangle with both.
    for seed in 0..300 {
        let mut rng = shapes::Rng::new(seed);
        let positions: Vec<[f32; 3]> = (0..12)
            .map(|_| [rng.below(3) as f32, rng.below(2) as f32, rng.below(2) as f32])
            .collect();
        let triangles: Vec<[u32; 3]> =
            (0..10).map(|_| [0; 3].map(|_| rng.below(12) as u32)).collect();
        let submeshes =
            vec![Submesh { first_triangle: 0, triangle_count: 10, attributes: Vec::new() }];
        let mut parts = MeshParts {
            positions,
            vertex_submesh: vec![0; 12],
            triangles,
            submeshes,
            attributes: Vec::new(),
        };
        parts.clean();
        let mesh = Mesh::try_from(parts).expect("cleaned");
        shapes::check_rules(&mesh, &run(&mesh)).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    }
}

#[test]
fn points_that_are_left_over_join_the_last_one_directly() {
    // Separate triangles: each ends as a point of its own, which nothing but the last step joins.
    let n = 60;
    let corner = |i: u32| [(i / 3) as f32 * 4.0 + (i % 3) as f32, (i % 2) as f32, 0.0];
    let positions = (0..3 * n).map(corner).collect();
    let triangles = (0..n).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let s = run(&plain(positions, triangles));
    let targets = s.collapses().targets();
    let length = |mut v: u32| {
        let mut steps = 0;
        while let Some(&target) = targets.get(v as usize) {
            v = target;
            steps += 1;
        }
        steps
    };
    let longest = (0..3 * n).map(length).max();
    assert!(longest <= Some(3), "two collapses within a triangle, one onto the last: {longest:?}");
}

#[test]
fn colours_of_a_palette_never_run_into_each_other() {
    // Squares of four vertices each; all corners of a square choose the same cell of a palette.
    let n = 12;
    let (mut positions, mut triangles, mut uv) = (Vec::new(), Vec::new(), Vec::<u8>::new());
    for square in 0..n * n {
        let (x, y) = (square % n, square / n);
        let cell = ((x * 7 + y * 13) % 8) as f32 / 8.0 + 0.05;
        let first = positions.len() as u32;
        for (dx, dy) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            positions.push([(x + dx) as f32, (y + dy) as f32, 0.0]);
            uv.extend([cell, 0.5].iter().flat_map(|c: &f32| c.to_le_bytes()));
        }
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let mut parts = plain(positions, triangles).into_parts();
    parts.attributes.push(texture_coordinates(uv));
    parts.submeshes[0].attributes.push(0);
    let s = run(&Mesh::try_from(parts).expect("a mesh made by hand"));
    let cells = &s.mesh().attributes()[0];
    let lod = s.collapses().lod_for_triangles(140);
    for t in s.triangles_at(lod) {
        let [a, b, c] = t.corners.map(|v| cells.value(v, 0));
        assert!(a == b && b == c, "a triangle across cells {a}, {b}, {c} at {lod:?}");
    }
}

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
    let regions = simplify_with(&mesh, &Options::DEFAULT, guidance, 30, &|_, _| {}).0;
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
    let mesh = shapes::skinned_tube(Component::U8);
    let skin = |skin: f64| Weights { skin, ..Weights::DEFAULT };
    let guidance = Guidance { weights: &[skin(100.0)], ..Guidance::default() };
    let own = simplify_guided(&mesh, &Options::DEFAULT, guidance, &|_, _| {});
    assert_eq!(own, run_with(&mesh, Options { weights: skin(100.0), ..Options::DEFAULT }));
    assert_ne!(own, run(&mesh));
}
