//! Refitted levels: closer, whole, upright, and the same for any number of threads.

use super::*;
use lodc_fixtures::{named, random};
use lodc_measure::{Sampling, Surface, distances};
use lodc_mesh::{Attribute, Component, MeshParts, Semantic, Submesh};
use lodc_simplify::{Guidance, simplify, simplify_guided};
use std::sync::atomic::{AtomicU32, Ordering};

fn simplified(mesh: &Mesh) -> Simplified {
    simplify(mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {})
}

fn surface(mesh: &Mesh) -> Surface {
    Surface {
        positions: mesh.positions().iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
}

fn rms(a: &Mesh, b: &Mesh) -> f64 {
    let found = distances(&surface(a), &surface(b), &Sampling::DEFAULT);
    found.rms[0].max(found.rms[1])
}

fn level(s: &Simplified, share: f64) -> Lod {
    s.collapses().lod_for_triangles((share * s.mesh().triangles().len() as f64) as u32)
}

fn unrefitted(s: &Simplified, lod: Lod) -> Mesh {
    s.mesh().extract(&s.triangles_at(lod)).expect("a level")
}

#[test]
fn levels_of_curved_surfaces_come_closer() {
    for name in ["torus", "icosphere", "morphing_sphere"] {
        let mesh = named(name).expect("a fixture");
        let s = simplified(&mesh);
        for share in [0.5, 0.25, 0.1] {
            let lod = level(&s, share);
            let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
            let [before, after] = [before, after].map(|m| rms(s.mesh(), &m));
            assert!(after < 0.9 * before, "{name} {share}: {after} {before}");
        }
    }
}

#[test]
fn fine_levels_of_scans_come_closer() {
    // Within some 10⁻⁵ of the diagonal; and a level of which the most is as it was.
    let s = simplified(&lodc_fixtures::icosphere(5));
    for share in [0.8, 0.5] {
        let lod = level(&s, share);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        let [before, after] = [before, after].map(|m| rms(s.mesh(), &m));
        assert!(after < 0.85 * before, "{share}: {after} {before}");
    }
}

/// The mean angle, in degrees, between shading normals at the corners and centres of a mesh's
/// triangles and those of another where it is nearest.
fn mean_angle(a: &Mesh, b: &Mesh) -> f64 {
    let normal = |m: &Mesh, t: [u32; 3], at: [f64; 3]| {
        let is_normal = |s: &&Attribute| s.semantic == Semantic::Normal && s.morph_target.is_none();
        let stream = m.attributes().iter().find(is_normal).expect("normals");
        let value = |v| DVec3::from_array([0, 1, 2].map(|k| f64::from(stream.value(v, k))));
        lodc_nearest::point_at(t.map(value), at).normalize()
    };
    let tree = surface(b).tree();
    let (mut sum, mut count) = (0.0, 0.0);
    for (t, &corners) in a.triangles().iter().enumerate() {
        for at in [[1.0 / 3.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let point = lodc_nearest::point_at(surface(a).corners(t), at);
            let near = tree.nearest(point, lodc_mesh::NONE).expect("triangles");
            let near_corners = b.triangles()[near.triangle as usize];
            let cosine = normal(a, corners, at).dot(normal(b, near_corners, near.barycentric));
            sum += cosine.clamp(-1.0, 1.0).acos().to_degrees();
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn normals_are_nearer_than_those_that_are_looked_up() {
    for name in ["uv_sphere", "morphing_sphere"] {
        let s = simplified(&named(name).expect("a fixture"));
        for share in [0.25, 0.1] {
            let found = Refit::new(&s, level(&s, share), &Options::DEFAULT, &|| ());
            let (Fitted { input, positions, .. }, _) = found.fitted.as_ref().expect("positions");
            let looked_up = attributes::resample(s.mesh(), input, &found.level, positions);
            let looked_up = Mesh::try_from(looked_up).expect("a mesh");
            let [before, after] =
                [looked_up, found.mesh(1.0)].map(|level| mean_angle(s.mesh(), &level));
            assert!(after < before, "{name} {share}: {after} {before}");
        }
    }
}

/// The root mean square distance between texture coordinates at points of a level's triangles and
/// those of a mesh where it is nearest, seams left out.
fn slide(level: &Mesh, mesh: &Mesh) -> f64 {
    let at = |m: &Mesh, t: [u32; 3], barycentric| {
        let is_set = |a: &&Attribute| a.semantic == Semantic::TexCoord(0);
        let set = m.attributes().iter().find(is_set).expect("texture coordinates");
        let value = |v| DVec3::new(set.value(v, 0).into(), set.value(v, 1).into(), 0.0);
        lodc_nearest::point_at(t.map(value), barycentric)
    };
    let (surface, tree) = (surface(level), surface(mesh).tree());
    let inside = [[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6], [1.0 / 3.0; 3]];
    let mut squared = Vec::new();
    for (number, &t) in level.triangles().iter().enumerate() {
        for barycentric in inside {
            let point = lodc_nearest::point_at(surface.corners(number), barycentric);
            let near = tree.nearest(point, lodc_mesh::NONE).expect("triangles");
            let corners = mesh.triangles()[near.triangle as usize];
            let far = at(level, t, barycentric).distance(at(mesh, corners, near.barycentric));
            squared.extend((far < 0.25).then_some(far * far));
        }
    }
    (squared.iter().sum::<f64>() / squared.len() as f64).sqrt()
}

#[test]
fn textures_slide_less_than_those_that_are_looked_up() {
    let s = simplified(&named("uv_sphere").expect("a fixture"));
    let (mut all_before, mut all_after) = (0.0, 0.0);
    for share in [0.5, 0.25, 0.1] {
        let found = Refit::new(&s, level(&s, share), &Options::DEFAULT, &|| ());
        let (Fitted { input, positions, .. }, _) = found.fitted.as_ref().expect("positions");
        let looked_up = attributes::resample(s.mesh(), input, &found.level, positions);
        let looked_up = Mesh::try_from(looked_up).expect("a mesh");
        let [before, after] = [looked_up, found.mesh(1.0)].map(|level| slide(&level, s.mesh()));
        assert!(after < before, "{share}: {after} {before}");
        all_before += before;
        all_after += after;
    }
    assert!(all_after < 0.99 * all_before, "{all_after} {all_before}");
}

#[test]
fn textures_stay_in_their_charts() {
    let s = simplified(&named("uv_sphere").expect("a fixture"));
    let range = |mesh: &Mesh| {
        let is_set = |a: &&Attribute| a.semantic == Semantic::TexCoord(0);
        let set = mesh.attributes().iter().find(is_set).expect("texture coordinates");
        let all = |k| (0..mesh.vertex_count() as u32).map(move |v| f64::from(set.value(v, k)));
        let ends = |k| all(k).fold([1.0f64, 0.0], |[a, b], x| [a.min(x), b.max(x)]);
        [ends(0), ends(1)]
    };
    let [u, v] = range(s.mesh());
    for share in [0.5, 0.25, 0.1] {
        let [now_u, now_v] = range(&refit(&s, level(&s, share), &Options::DEFAULT));
        for (now, before) in [(now_u, u), (now_v, v)] {
            let stays = now[0] >= before[0] - 1e-6 && now[1] <= before[1] + 1e-6;
            assert!(stays, "{share}: {now:?} {before:?}");
        }
    }
}

#[test]
fn locked_vertices_keep_what_they_have_beside_quantised_positions() {
    let mesh = named("quantised_torus").expect("a fixture");
    let locked: Vec<bool> = mesh.positions().iter().map(|p| p[0] > 30_000.0).collect();
    let guidance = Guidance { locked: &locked, ..Guidance::default() };
    let s = simplify_guided(&mesh, &lodc_simplify::Options::DEFAULT, guidance, &|_, _| {});
    let lod = level(&s, 0.7);
    let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
    let coordinates = |m: &Mesh| m.attributes().last().expect("texture coordinates").clone();
    let (was, is) = (coordinates(&before), coordinates(&after));
    let kept = (0..).zip(before.positions()).filter(|(_, p)| p[0] > 30_000.0);
    assert!(kept.clone().count() > 10 && is.semantic == Semantic::TexCoord(0));
    for (v, _) in kept {
        assert_eq!(was.at(v), is.at(v), "vertex {v}");
    }
}

#[test]
fn tangents_are_perpendicular_to_normals() {
    let s = simplified(&tangential(&named("uv_sphere").expect("a fixture")));
    let after = refit(&s, level(&s, 0.25), &Options::DEFAULT);
    let stream = |semantic| after.attributes().iter().find(|a| a.semantic == semantic);
    let [normals, tangents] =
        [Semantic::Normal, Semantic::Tangent].map(|s| stream(s).expect("one"));
    for v in 0..after.vertex_count() as u32 {
        let dot: f32 = (0..3).map(|k| normals.value(v, k) * tangents.value(v, k)).sum();
        assert!(dot.abs() < 1e-5 && tangents.value(v, 3) == -1.0, "vertex {v}: {dot}");
    }
}

/// A mesh with tangents besides, level and round the z axis, left-handed.
fn tangential(mesh: &Mesh) -> Mesh {
    let mut parts = mesh.clone().into_parts();
    let number = parts.attributes.len() as u32;
    let along = |p: &[f32; 3]| {
        let round = glam::Vec3::new(-p[1], p[0], 0.0).try_normalize();
        let [x, y, z] = round.unwrap_or(glam::Vec3::X).to_array();
        [x, y, z, -1.0].map(f32::to_le_bytes)
    };
    parts.attributes.push(Attribute {
        semantic: Semantic::Tangent,
        morph_target: None,
        component: Component::F32,
        components: 4,
        normalized: false,
        bytes: parts.positions.iter().flat_map(along).flatten().collect(),
    });
    parts.submeshes.iter_mut().for_each(|s| s.attributes.push(number));
    Mesh::try_from(parts).expect("a mesh")
}

#[test]
fn part_of_the_way_is_between_both_ends() {
    let s = simplified(&named("torus").expect("a fixture"));
    let lod = level(&s, 0.25);
    let found = Refit::new(&s, lod, &Options::DEFAULT, &|| ());
    assert_eq!(found.unmoved(), unrefitted(&s, lod));
    assert_eq!(found.mesh(0.0).positions(), found.unmoved().positions());
    assert_eq!(found.mesh(1.0), refit(&s, lod, &Options::DEFAULT));
    let [none, half, all] = [0.0, 0.5, 1.0].map(|share| rms(s.mesh(), &found.mesh(share)));
    assert!(all < half && half < none, "{none} {half} {all}");
}

#[test]
fn vertices_at_one_position_stay_at_one_position() {
    for seed in 0..40 {
        let s = simplified(&random(seed));
        let lod = level(&s, 0.4);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        assert_eq!(before.triangles(), after.triangles(), "seed {seed}");
        let ids = before.position_ids();
        let mut point = vec![None; ids.len()];
        for (&id, &p) in ids.of_vertex.iter().zip(after.positions()) {
            assert_eq!(*point[id as usize].get_or_insert(p), p, "seed {seed}");
        }
    }
}

#[test]
fn no_face_turns_over() {
    let normal = |m: &Mesh, t: [u32; 3]| {
        let [a, b, c] = t.map(|v| DVec3::from_array(m.positions()[v as usize].map(f64::from)));
        (b - a).cross(c - a).normalize_or_zero()
    };
    for seed in 0..40 {
        let s = simplified(&random(seed));
        let lod = level(&s, 0.4);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        for &t in before.triangles() {
            let cosine = normal(&before, t).dot(normal(&after, t));
            assert!(cosine > 0.24, "seed {seed}: {cosine}");
        }
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    for name in ["machine_part", "uv_sphere"] {
        let s = simplified(&named(name).expect("a fixture"));
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(|| refit(&s, level(&s, 0.3), &Options::DEFAULT))
        };
        let one = with(1);
        assert!([2, 3, 8].into_iter().all(|threads| with(threads) == one), "{name}");
    }
}

#[test]
fn flat_ground_stays_flat_and_keeps_its_border() {
    let mesh = named("terrain").expect("a fixture");
    let s = simplified(&mesh);
    let (lo, hi) = mesh.bounds();
    let diagonal = mesh.diagonal() as f32;
    let after = refit(&s, level(&s, 0.2), &Options::DEFAULT).bounds();
    for k in 0..3 {
        let slack = 0.03 * diagonal;
        let kept = |a: f32, b: f32| (a - b).abs() < slack;
        assert!(kept(lo[k], after.0[k]) && kept(hi[k], after.1[k]), "{lo:?} {hi:?} {after:?}");
    }
}

#[test]
fn weights_sum_up_to_one_and_directions_are_units() {
    let s = simplified(&named("skinned_tube_u16").expect("a fixture"));
    let after = refit(&s, level(&s, 0.3), &Options::DEFAULT);
    for stream in after.attributes() {
        for v in 0..after.vertex_count() as u32 {
            let n = usize::from(stream.components);
            let values: Vec<f32> = (0..n).map(|k| stream.value(v, k)).collect();
            match stream.semantic {
                Semantic::Weights(0) => {
                    assert!((values.iter().sum::<f32>() - 1.0).abs() < 1e-4, "{values:?}");
                }
                Semantic::Normal => {
                    let length = values.iter().map(|x| x * x).sum::<f32>().sqrt();
                    assert!((length - 1.0).abs() < 0.02, "{values:?}");
                }
                _ => {}
            }
        }
    }
}

/// A tube whose influences bend with the angle, so that both sides of its seam would take others.
fn twisted_tube() -> Mesh {
    let mut parts = named("skinned_tube_u16").expect("a fixture").into_parts();
    let positions = parts.positions.clone();
    for (v, [x, y, z]) in positions.into_iter().enumerate() {
        let first = (0.5 + 0.3 * (x + 2.0 * y * y).sin() * (1.7 * z).cos()).clamp(0.0, 1.0);
        let weights = parts.attributes.iter_mut().find(|a| a.semantic == Semantic::Weights(0));
        let first = f64::from((first * 65535.0).round() / 65535.0);
        blend::store(weights.expect("weights"), v, &[first, 1.0 - first, 0.0, 0.0]);
    }
    Mesh::try_from(parts).expect("the same mesh otherwise")
}

#[test]
fn seams_stay_closed_in_motion() {
    let s = simplified(&twisted_tube());
    for share in [0.7, 0.5, 0.3, 0.15] {
        let lod = level(&s, share);
        let after = refit(&s, lod, &Options::DEFAULT).position_ids();
        // What was one place in every shape is one still.
        let before = unrefitted(&s, lod).position_ids();
        let mut place = vec![None; before.len()];
        for (&id, &now) in before.of_vertex.iter().zip(&after.of_vertex) {
            assert_eq!(*place[id as usize].get_or_insert(now), now, "{share}");
        }
    }
}

#[test]
fn the_input_and_levels_without_triangles_stay_as_they_are() {
    let s = simplified(&named("cube").expect("a fixture"));
    assert_eq!(refit(&s, Lod(0), &Options::DEFAULT), unrefitted(&s, Lod(0)));
    assert!(refit(&s, s.collapses().last(), &Options::DEFAULT).triangles().is_empty());
}

/// A pillow: two sheets of `SIDE` by `SIDE` vertices, a hair apart and joined at the border, whose
/// normals point up, down and outward: one chart.
fn pillow() -> Mesh {
    const SIDE: usize = 6;
    let border = |x: usize, y: usize| [x, y].iter().any(|c| c.is_multiple_of(SIDE - 1));
    let (mut number, mut positions, mut normals) = ([[[0; SIDE]; SIDE]; 2], vec![], vec![]);
    for (sheet, z) in [(0, 0.01f32), (1, -0.01)] {
        for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
            number[sheet][y][x] = positions.len() as u32;
            if border(x, y) && sheet == 1 {
                number[sheet][y][x] = number[0][y][x];
                continue;
            }
            positions.push([x as f32, y as f32, if border(x, y) { 0.0 } else { z }]);
            normals.extend(if border(x, y) { [1.0, 0.0, 0.0] } else { [0.0, 0.0, z * 100.0] });
        }
    }
    let mut triangles = Vec::new();
    for (y, x) in (0..SIDE - 1).flat_map(|y| (0..SIDE - 1).map(move |x| (y, x))) {
        for (sheet, [p, q]) in number.iter().zip([[0, 1], [1, 0]]) {
            let corner = |dx: usize, dy: usize| sheet[y + dy][x + dx];
            let across = [corner(1, 0), corner(0, 1)];
            triangles.push([corner(0, 0), across[p], across[q]]);
            triangles.push([corner(1, 1), across[q], across[p]]);
        }
    }
    let bytes = normals.iter().flat_map(|n: &f32| n.to_le_bytes()).collect();
    let normals = Attribute {
        semantic: Semantic::Normal,
        morph_target: None,
        component: Component::F32,
        components: 3,
        normalized: false,
        bytes,
    };
    let all =
        Submesh { first_triangle: 0, triangle_count: triangles.len() as u32, attributes: vec![0] };
    let vertex_submesh = vec![0; positions.len()];
    let (attributes, submeshes) = (vec![normals], vec![all]);
    let parts = MeshParts { positions, vertex_submesh, attributes, triangles, submeshes };
    Mesh::try_from(parts).expect("a mesh")
}

#[test]
fn a_vertex_takes_nothing_from_the_other_side_of_a_sheet() {
    let s = simplified(&pillow());
    let level = CoarseMesh::new(&s, Lod(0));
    let input = Input::new(s.mesh(), level.faces.len());
    let up = |m: &Mesh, v: u32| m.attributes()[0].value(v, 2);
    let above: Vec<u32> =
        (0..level.mesh.vertex_count() as u32).filter(|&v| up(&level.mesh, v) > 0.5).collect();
    assert_eq!(above.len(), 16);
    for v in above {
        // Nearer to the lower sheet than to its own.
        let mut positions = level.points.clone();
        positions[level.point_of_vertex[v as usize] as usize].z = -0.006;
        let moved = attributes::resample(s.mesh(), &input, &level, &positions);
        let moved = Mesh::try_from(moved).expect("a mesh");
        assert!(up(&moved, v) > 0.5, "vertex {v}: {}", up(&moved, v));
    }
}

#[test]
fn texture_coordinates_stay_on_their_side_of_a_seam() {
    // Once round: texture coordinates go from 0 to 1 and meet at a seam of one chart.
    let s = simplified(&named("uv_sphere").expect("a fixture"));
    for share in [0.5, 0.25, 0.1] {
        let lod = level(&s, share);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        let is_set = |a: &&Attribute| a.semantic == Semantic::TexCoord(0);
        let span = |m: &Mesh, t: [u32; 3]| {
            let set = m.attributes().iter().find(is_set).expect("texture coordinates");
            let u = t.map(|v| set.value(v, 0));
            u.iter().copied().fold(0.0, f32::max) - u.iter().copied().fold(1.0, f32::min)
        };
        for &t in before.triangles() {
            let [was, is] = [span(&before, t), span(&after, t)];
            assert!(is < was + 0.25, "{share}: {t:?} spans {was} and then {is}");
        }
    }
}

/// A slice of a cake: a wedge, and a thin candle on it that hangs together with it.
fn slice() -> Mesh {
    let wedge = [[0.0f32, 0.0], [3.2, -1.6], [3.2, 1.6]];
    let candle = [[0.8f32, -0.1], [1.0, -0.1], [1.0, 0.1], [0.8, 0.1]];
    let mut positions: Vec<[f32; 3]> = Vec::new();
    for z in [0.0, 0.8] {
        positions.extend(wedge.map(|[x, y]| [x, y, z]));
    }
    for z in [0.8, 1.1] {
        positions.extend(candle.map(|[x, y]| [x, y, z]));
    }
    // The bottom and the top around the candle; the sides of both.
    let mut triangles = vec![[0, 2, 1]];
    triangles.extend([[3, 4, 6], [4, 7, 6], [4, 5, 7], [5, 8, 7], [5, 9, 8], [5, 3, 9], [3, 6, 9]]);
    let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    [(0, 1), (1, 2), (2, 0)].into_iter().for_each(|(a, b)| quad([a, b, b + 3, a + 3]));
    [(6, 7), (7, 8), (8, 9), (9, 6)].into_iter().for_each(|(a, b)| quad([a, b, b + 4, a + 4]));
    quad([10, 11, 12, 13]);
    let triangle_count = triangles.len() as u32;
    let all = Submesh { first_triangle: 0, triangle_count, attributes: vec![] };
    let vertex_submesh = vec![0; positions.len()];
    let (attributes, submeshes) = (vec![], vec![all]);
    let parts = MeshParts { positions, vertex_submesh, attributes, triangles, submeshes };
    Mesh::try_from(parts).expect("a mesh")
}

#[test]
fn what_a_level_lacks_does_not_pull_a_spike_out_of_it() {
    let s = simplified(&slice());
    let lod = s.collapses().lod_for_triangles(8);
    let level = unrefitted(&s, lod);
    // The wedge as it was: its top could only be pulled out to where the candle stood.
    assert!(level.triangles().len() == 8 && level.bounds().1[2] == 0.8, "{:?}", level.bounds());
    assert_eq!(refit(&s, lod, &Options::DEFAULT), level);
}

/// A mesh without attributes, one submesh for each part.
fn parts_mesh(parts: &[(Vec<DVec3>, Vec<[u32; 3]>)]) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let (mut vertex_submesh, mut submeshes) = (Vec::new(), Vec::new());
    for (number, (points, faces)) in (0..).zip(parts) {
        let (first, first_triangle) = (positions.len() as u32, triangles.len() as u32);
        positions.extend(points.iter().map(|p| p.as_vec3().to_array()));
        triangles.extend(faces.iter().map(|f| f.map(|v| first + v)));
        vertex_submesh.extend(points.iter().map(|_| number));
        let triangle_count = faces.len() as u32;
        submeshes.push(Submesh { first_triangle, triangle_count, attributes: vec![] });
    }
    let attributes = vec![];
    let parts = MeshParts { positions, vertex_submesh, attributes, triangles, submeshes };
    Mesh::try_from(parts).expect("a mesh")
}

fn corner_points(mesh: &Mesh, t: [u32; 3]) -> [DVec3; 3] {
    t.map(|v| DVec3::from_array(mesh.positions()[v as usize].map(f64::from)))
}

#[test]
fn a_core_does_not_come_through_its_shell() {
    // A lump, and another inside it, 2 % smaller.
    let sphere = lodc_fixtures::icosphere(4);
    let lump = |scale: f64| {
        let bump = |p: DVec3| p * scale * (1.0 + 0.08 * (5.0 * p.x).sin() * (4.0 * p.y).cos());
        let point = |p: &[f32; 3]| bump(DVec3::from_array(p.map(f64::from)));
        (sphere.positions().iter().map(point).collect(), sphere.triangles().to_vec())
    };
    let s = simplified(&parts_mesh(&[lump(1.0), lump(0.98)]));
    for share in [0.5, 0.25, 0.1, 0.07] {
        let lod = level(&s, share);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        // Seen from the middle: how much farther out the shell is than corners and centres of the
        // core.
        let clearance = |mesh: &Mesh| {
            let range =
                |submesh: usize| mesh.triangles()[mesh.submeshes()[submesh].triangles()].to_vec();
            let core = range(1).into_iter().flat_map(|t| {
                let t = corner_points(mesh, t);
                [t[0], t[1], t[2], (t[0] + t[1] + t[2]) / 3.0]
            });
            let shell: Vec<[DVec3; 3]> =
                range(0).into_iter().map(|t| corner_points(mesh, t)).collect();
            let beyond = |p: DVec3| {
                let hits = shell.iter().filter_map(|&[a, b, c]| {
                    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|n| n.dot(p));
                    let normal = cross([a, b, c]);
                    let is_hit = sides.iter().all(|s| *s >= 0.0);
                    is_hit.then(|| p.length() * (a.dot(normal) / p.dot(normal) - 1.0))
                });
                hits.fold(f64::INFINITY, f64::min)
            };
            core.map(beyond).fold(f64::INFINITY, f64::min)
        };
        let [was, is] = [&before, &after].map(clearance);
        assert!(was <= 0.0 || is > 0.0, "{share}: {was} before, {is} after");
        assert!(rms(s.mesh(), &after) < 0.9 * rms(s.mesh(), &before), "{share}");
    }
}

/// A bent plate, closed, as thick as 1 % of its length.
fn plate() -> Mesh {
    const COLUMNS: usize = 60;
    const ROWS: usize = 30;
    let middle = |x: f64, y: f64| DVec3::new(x, y, 0.25 * (2.0 * x).cos() + 0.1 * (4.0 * y).sin());
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for side in [0.01, -0.01] {
        for (i, j) in (0..COLUMNS).flat_map(|i| (0..ROWS).map(move |j| (i, j))) {
            let x = 2.0 * i as f64 / (COLUMNS - 1) as f64 - 1.0;
            let y = j as f64 / (ROWS - 1) as f64 - 0.5;
            let normal = DVec3::new(0.5 * (2.0 * x).sin(), -0.4 * (4.0 * y).cos(), 1.0).normalize();
            points.push(middle(x, y) + normal * side);
        }
    }
    let number = |side: usize, i: usize, j: usize| (side * COLUMNS * ROWS + i * ROWS + j) as u32;
    for (i, j) in (0..COLUMNS - 1).flat_map(|i| (0..ROWS - 1).map(move |j| (i, j))) {
        for side in [0, 1] {
            let at = |di: usize, dj: usize| number(side, i + di, j + dj);
            let (b, d) = if side == 0 { (at(1, 0), at(0, 1)) } else { (at(0, 1), at(1, 0)) };
            faces.extend([[at(0, 0), b, at(1, 1)], [at(0, 0), at(1, 1), d]]);
        }
    }
    let along_x = |j: usize| (0..COLUMNS).map(move |i| (i, j));
    let along_y = |i: usize| (0..ROWS).map(move |j| (i, j));
    let rim: Vec<(usize, usize)> = (along_x(0).chain(along_y(COLUMNS - 1).skip(1)))
        .chain(along_x(ROWS - 1).rev().skip(1))
        .chain(along_y(0).rev().skip(1).take(ROWS - 2))
        .collect();
    for (k, &(i, j)) in rim.iter().enumerate() {
        let (m, n) = rim[(k + 1) % rim.len()];
        let (top, bottom) =
            ([number(0, i, j), number(0, m, n)], [number(1, i, j), number(1, m, n)]);
        faces.extend([[top[0], bottom[0], bottom[1]], [top[0], bottom[1], top[1]]]);
    }
    parts_mesh(&[(points, faces)])
}

#[test]
fn thin_plates_keep_both_sides() {
    let s = simplified(&plate());
    let volume = |mesh: &Mesh| -> f64 {
        let six = mesh.triangles().iter().map(|&t| {
            let [a, b, c] = corner_points(mesh, t);
            a.dot(b.cross(c))
        });
        six.sum::<f64>() / 6.0
    };
    let whole = volume(s.mesh());
    for share in [0.25, 0.1, 0.05] {
        let lod = level(&s, share);
        let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
        let kept = volume(&after) / whole;
        assert!((0.9..1.1).contains(&kept), "{share}: {kept} of the volume");
        assert!(rms(s.mesh(), &after) < 0.9 * rms(s.mesh(), &before), "{share}");
        // The upper side stays above the lower one: a point of it is nearest to its own side.
        let tree = surface(s.mesh()).tree();
        for (number, &t) in after.triangles().iter().enumerate() {
            let corners = corner_points(&after, t);
            let near = tree.nearest(corners.iter().sum::<DVec3>() / 3.0, lodc_mesh::NONE);
            let near = near.expect("triangles").triangle as usize;
            let own = cross(corner_points(s.mesh(), s.mesh().triangles()[near])).normalize();
            let cosine = cross(corners).normalize().dot(own);
            assert!(cosine > -0.5, "{share}: triangle {number} is on the other side, {cosine}");
        }
    }
}

#[test]
fn no_normal_faces_away_from_its_face() {
    let normal = |m: &Mesh, v: u32| {
        let is_normal = |a: &&Attribute| a.semantic == Semantic::Normal && a.morph_target.is_none();
        let stream = m.attributes().iter().find(is_normal).expect("normals");
        DVec3::from_array([0, 1, 2].map(|k| f64::from(stream.value(v, k))))
    };
    let mut tried = 0;
    for (name, make) in lodc_fixtures::ALL {
        let mesh = make();
        let has_normals = mesh.submeshes().iter().all(|s| {
            s.attributes.iter().any(|&a| mesh.attributes()[a as usize].semantic == Semantic::Normal)
        });
        let is_one =
            mesh.attributes().iter().filter(|a| a.semantic == Semantic::Normal).count() == 1;
        if !(has_normals && is_one && mesh.triangles().len() >= 100) {
            continue;
        }
        let s = simplified(&mesh);
        for share in [0.25, 0.1, 0.05] {
            let lod = level(&s, share);
            let (before, after) = (unrefitted(&s, lod), refit(&s, lod, &Options::DEFAULT));
            let faces_away = |m: &Mesh, t: [u32; 3], v: u32| {
                normal(m, v).dot(cross(corner_points(m, t)).normalize_or_zero()) < -2e-3
            };
            for &t in after.triangles() {
                for v in t {
                    let was = faces_away(&before, t, v);
                    let cosine =
                        normal(&after, v).dot(cross(corner_points(&after, t)).normalize_or_zero());
                    let first = normal(&before, v)
                        .dot(cross(corner_points(&before, t)).normalize_or_zero());
                    assert!(
                        was || !faces_away(&after, t, v),
                        "{name} {share}: vertex {v}, {cosine}, {first} before"
                    );
                }
            }
            tried += 1;
        }
    }
    assert!(tried > 10, "{tried} levels");
}

#[test]
fn work_is_left_where_a_tick_unwinds() {
    let s = simplified(&named("uv_sphere").expect("a fixture"));
    let lod = level(&s, 0.25);
    let ticks = AtomicU32::new(0);
    let count = || {
        ticks.fetch_add(1, Ordering::Relaxed);
    };
    let _ = Refit::new(&s, lod, &Options::DEFAULT, &count);
    assert!(ticks.load(Ordering::Relaxed) > 1);
    let late = || std::panic::resume_unwind(Box::new("late"));
    let left = std::panic::catch_unwind(|| Refit::new(&s, lod, &Options::DEFAULT, &late).mesh(1.0));
    assert_eq!(left.err().and_then(|e| e.downcast_ref().copied()), Some("late"));
}
