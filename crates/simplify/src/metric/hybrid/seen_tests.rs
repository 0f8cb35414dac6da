//! Properties of what is seen: loose pieces, doubled faces, cards, texture coordinates.

use super::energy::{COVERING, geometric_error};
use super::lanes::SampleQuad;
use super::samples::Samples;
use super::vectors::{NearestPoints, Vec3x4};
use super::{Appearance, Checkerboard, SurfaceColours, visibility};
use crate::cut::Region;
use crate::number::Input;
use crate::{MetricKind, Options, simplify, simplify_coloured};
use glam::{Vec3, Vec4};
use lodc_fixtures as shapes;
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic, Simplified, Submesh};

const HYBRID: Options = Options { metric: MetricKind::Hybrid, ..Options::DEFAULT };

fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, attribute: Option<Attribute>) -> Mesh {
    let attributes: Vec<Attribute> = attribute.into_iter().collect();
    let submesh = Submesh {
        first_triangle: 0,
        triangle_count: triangles.len() as u32,
        attributes: (0..attributes.len() as u32).collect(),
    };
    Mesh::try_from(MeshParts {
        vertex_submesh: vec![0; positions.len()],
        positions,
        attributes,
        triangles,
        submeshes: vec![submesh],
    })
    .expect("a valid mesh")
}

/// An attribute of floats.
fn floats<const N: usize>(semantic: Semantic, values: &[[f32; N]]) -> Attribute {
    Attribute {
        semantic,
        morph_target: None,
        component: Component::F32,
        components: N as u8,
        normalized: false,
        bytes: values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect(),
    }
}

/// A grid of `n` by `n` squares over the unit square: positions and triangles.
fn grid(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let at = |i: u32| i as f32 / n as f32;
    let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y), 0.0])).collect();
    let square = |x: u32, y: u32| {
        let a = y * (n + 1) + x;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    (positions, (0..n).flat_map(|y| (0..n).flat_map(move |x| square(x, y))).collect())
}

/// The area of the triangles of a level that satisfy a condition on their corners.
fn area(simplified: &Simplified, triangles: u32, is_counted: impl Fn([Vec3; 3]) -> bool) -> f32 {
    let lod = simplified.collapses().lod_for_triangles(triangles);
    let corners = simplified
        .triangles_at(lod)
        .into_iter()
        .map(|t| t.corners.map(|v| Vec3::from(simplified.mesh().positions()[v as usize])));
    corners.filter(|c| is_counted(*c)).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

#[test]
fn loose_quads_go_one_by_one() {
    let quad = |i: u32| {
        let (x, y) = ((i % 20) as f32, (i / 20) as f32);
        [[x, y, 0.0], [x + 0.5, y, 0.0], [x + 0.5, y + 0.5, 0.0], [x, y + 0.5, 0.0]]
    };
    let positions = (0..300).flat_map(quad).collect();
    let triangles = (0..300).flat_map(|i| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| 4 * i + v)));
    let simplified = simplify(&mesh(positions, triangles.collect(), None), &HYBRID, &|_, _| {});
    let whole = area(&simplified, 600, |_| true);
    for left in [540, 450, 300, 150, 60] {
        let share = area(&simplified, left, |_| true) / whole;
        let fair = left as f32 / 600.0;
        assert!(share > fair - 0.02, "{share} of the area in {left} of 600 triangles");
    }
}

#[test]
fn a_seat_of_doubled_faces_stays_covered() {
    // A square seat, both sides as faces of their own, beside a sphere that takes most triangles.
    let (seat, faces) = grid(6);
    let ball = shapes::icosphere(3);
    let mut positions = seat.clone();
    positions.extend(&seat);
    let mut triangles = faces.clone();
    triangles.extend(faces.iter().map(|t| [t[2] + 49, t[1] + 49, t[0] + 49]));
    let first = positions.len() as u32;
    positions.extend(
        ball.positions().iter().map(|p| [p[0] * 0.3 + 0.5, p[1] * 0.3 + 0.5, p[2] * 0.3 + 1.0]),
    );
    triangles.extend(ball.triangles().iter().map(|t| t.map(|v| v + first)));
    let simplified = simplify(&mesh(positions, triangles, None), &HYBRID, &|_, _| {});
    for left in [400, 100, 40] {
        let seat = area(&simplified, left, |c| c.iter().all(|p| p.z == 0.0));
        assert!(seat > 0.95, "{left} triangles: {seat} of the seat's two sides");
    }
}

#[test]
fn a_card_is_seen_from_both_sides() {
    let (positions, triangles) = grid(8);
    let mesh = mesh(positions, triangles, None);
    let input = Input::new(&mesh);
    let mut region = Region::whole(&input, false);
    region.mesh.keep_facets();
    let colours = Checkerboard::new(&mesh);
    let appearance = Appearance::new(&mesh, &colours);
    let mut samples = Samples::new(&region.mesh, &region.wedges, &appearance, 1e-6, 16_000);
    let before = samples.weight();
    visibility::weigh(&region.mesh, &mut samples, 1.0);
    let after = samples.weight();
    // A closed surface is seen from one side: half of all directions. A card is seen from all.
    assert!(after > 1.8 * before, "{after} of {before}");
}

/// A sharp border between two charts.
struct TwoCharts;

impl SurfaceColours for TwoCharts {
    fn set(&self, _submesh: u32) -> Option<u32> {
        Some(0)
    }
    fn at(&self, _submesh: u32, [u, _]: [f32; 2], _footprint: f32) -> [f32; 3] {
        if u < 0.5 { [1.0, 0.1, 0.1] } else { [0.1, 0.1, 1.0] }
    }
}

/// The share of the unit square that shows the wrong one of two charts.
fn bled(simplified: &Simplified, triangles: u32, texture: &dyn Fn([f32; 3]) -> f32) -> f32 {
    let mesh = simplified.mesh();
    let lod = simplified.collapses().lod_for_triangles(triangles);
    let levels = simplified.triangles_at(lod);
    let (mut wrong, mut all) = (0, 0);
    for i in 0..2500 {
        let p = Vec3::new((i % 50) as f32 / 50.0 + 0.01, (i / 50) as f32 / 50.0 + 0.01, 0.0);
        for t in &levels {
            let [a, b, c] = t.corners.map(|v| Vec3::from(mesh.positions()[v as usize]));
            let whole = (b - a).cross(c - a).z;
            let shares = [(c - b).cross(p - b).z, (a - c).cross(p - c).z, (b - a).cross(p - a).z];
            let shares = shares.map(|s| s / whole);
            if shares.iter().all(|&s| s >= 0.0) {
                let u = |k: usize| mesh.attributes()[0].value(t.corners[k], 0) * shares[k];
                all += 1;
                wrong += u32::from((u(0) + u(1) + u(2) < 0.5) != (texture(p.to_array()) < 0.5));
                break;
            }
        }
    }
    assert!(all > 2400, "only {all} points are covered");
    wrong as f32 / all as f32
}

/// Levels so coarse that one place in a hundred is wrong where colours are not seen.
const COARSE: [u32; 7] = [30, 35, 40, 45, 50, 60, 80];

/// A coordinate across the unit square that is 0.5 along a bent line.
fn bent(p: [f32; 3]) -> f32 {
    let bend = p[1] * (1.0 - p[1]);
    0.5 + 4.0 * (p[0] - 0.3 - bend) * (0.2 + (p[0] - 0.3 - bend).abs())
}

#[test]
fn charts_do_not_bleed() {
    // The square is flat, so nothing but its colours says which vertices matter.
    let (positions, triangles) = grid(24);
    let texture: Vec<[f32; 2]> = positions.iter().map(|&p| [bent(p), p[1]]).collect();
    let mesh = mesh(positions, triangles, Some(floats(Semantic::TexCoord(0), &texture)));
    let seen = simplify_coloured(&mesh, &HYBRID, &TwoCharts, &|_, _| {});
    let blind = simplify(&mesh, &Options { attributes: false, ..Options::DEFAULT }, &|_, _| {});
    let all = |simplified: &Simplified| -> f32 {
        COARSE.map(|count| bled(simplified, count, &bent)).iter().sum()
    };
    let (with, without) = (all(&seen), all(&blind));
    assert!(without > 0.05 && with < 0.6 * without, "{with} with colours, {without} without");
}

#[test]
fn colours_of_vertices_do_not_bleed() {
    let (positions, triangles) = grid(24);
    let side = |p: [f32; 3]| if bent(p) < 0.5 { 0.02 } else { 0.98 };
    let colours: Vec<[f32; 3]> = positions.iter().map(|&p| [side(p), 0.2, 0.2]).collect();
    let mesh = mesh(positions, triangles, Some(floats(Semantic::Color(0), &colours)));
    let seen = simplify(&mesh, &HYBRID, &|_, _| {});
    let blind = simplify(&mesh, &Options { attributes: false, ..Options::DEFAULT }, &|_, _| {});
    let all = |simplified: &Simplified| -> f32 {
        COARSE.map(|count| bled(simplified, count, &side)).iter().sum()
    };
    let (with, without) = (all(&seen), all(&blind));
    assert!(without > 0.05 && with < 0.6 * without, "{with} with colours, {without} without");
}

#[test]
fn water_and_the_bed_below_it_know_of_each_other() {
    let (mut positions, mut triangles) = grid(20);
    let bed = positions.len();
    // Water over the middle, 0.04 above.
    let (water, faces) = grid(10);
    positions.extend(water.iter().map(|p| [0.25 + 0.5 * p[0], 0.25 + 0.5 * p[1], 0.04]));
    triangles.extend(faces.iter().map(|t| t.map(|v| v + bed as u32)));
    let mesh = mesh(positions, triangles, None);
    let mut region = Region::whole(&Input::new(&mesh), false);
    region.mesh.keep_facets();
    let appearance = Appearance::of_shape();
    let mut samples = Samples::new(&region.mesh, &region.wedges, &appearance, 1e-6, 16_000);
    visibility::weigh(&region.mesh, &mut samples, 1.5);
    // The error of a sample whose surface has moved along its normal.
    let moved = |sample: usize, by: f32| {
        let quad = SampleQuad::new(&[sample as u32], &samples);
        let away = Vec3x4::new(&[Vec3::Z * -by; 4]);
        let squared = Vec4::splat(by * by);
        let nearest = NearestPoints { face: [0; 4], at: [Vec4::ZERO; 2], away, squared };
        geometric_error(&quad, &nearest, 0.0).x
    };
    let mut counts = [0; 3];
    for (number, s) in samples.all().iter().enumerate() {
        let middle = [s.position.x, s.position.y].iter().all(|c| (0.35..0.65).contains(c));
        let layer = s.layer;
        match (middle, s.position.z > 0.02) {
            (true, is_water) => {
                let side = if is_water { -1.0 } else { 1.0 };
                assert_eq!(layer.inverse_rest.signum(), side, "{s:?}");
                assert!((layer.free - 0.02).abs() < 0.012, "{s:?}");
                assert!((30.0..140.0).contains(&layer.inverse_rest.abs()), "{s:?}");
                // What passes the other layer costs its area; nothing else costs anything.
                let covered = COVERING * s.extent * s.extent;
                assert!((moved(number, side * 0.06) - covered).abs() < 1e-3 * covered, "{s:?}");
                assert_eq!([moved(number, side * 0.005), moved(number, side * -0.06)], [0.0; 2]);
                counts[usize::from(is_water)] += 1;
            }
            (false, false) if s.position.x < 0.1 => {
                assert_eq!(layer.inverse_rest, 0.0, "{s:?}");
                counts[2] += 1;
            }
            _ => {}
        }
    }
    assert!(counts.iter().all(|&n| n > 100), "{counts:?}");
}

/// The share of points over a pond at which water is what is seen from above.
fn water_seen(simplified: &Simplified, triangles: u32, first_of_water: u32) -> f32 {
    let lod = simplified.collapses().lod_for_triangles(triangles);
    let level = simplified.triangles_at(lod);
    let position = |v: u32| Vec3::from(simplified.mesh().positions()[v as usize]);
    let points = (0..400u32).map(|i| {
        let (turn, r) = (i as f32 * 2.399_963, (i as f32 / 400.0).sqrt() * 0.22);
        (0.5 + r * turn.cos(), 0.5 + r * turn.sin())
    });
    let height = |[a, b, c]: [Vec3; 3], (x, y): (f32, f32)| {
        let area = |p: Vec3, q: Vec3| (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        let [u, v, w] = [area(b, c), area(c, a), area(a, b)];
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let sum = u + v + w;
        (inside && sum != 0.0).then(|| (u * a.z + v * b.z + w * c.z) / sum)
    };
    let is_water = |point: &(f32, f32)| {
        let mut top = (f32::NEG_INFINITY, false);
        for t in &level {
            if let Some(z) = height(t.corners.map(position), *point)
                && z > top.0
            {
                top = (z, t.corners[0] >= first_of_water);
            }
        }
        top.1
    };
    points.filter(is_water).count() as f32 / 400.0
}

#[test]
fn the_bed_of_a_pond_stays_below_its_water() {
    for depth in [0.01, 0.03, 0.1] {
        // Sand with a hollow, ragged at its rim; water over it, reaching under the sand.
        let (mut positions, mut triangles) = grid(40);
        for p in &mut positions {
            let (x, y) = (p[0] - 0.5, p[1] - 0.5);
            let rim = 0.3 + 0.03 * (y.atan2(x) * 9.0).sin();
            p[2] = if x.hypot(y) < rim { -depth } else { 0.004 * (x * 40.0).sin() };
        }
        let first = positions.len() as u32;
        let (water, faces) = grid(6);
        let wide = water.iter().map(|p| [0.1 + 0.8 * p[0], 0.1 + 0.8 * p[1], -0.5 * depth]);
        positions.extend(wide);
        triangles.extend(faces.iter().map(|t| t.map(|v| v + first)));
        // What takes most triangles.
        let ball = shapes::icosphere(4);
        let from = positions.len() as u32;
        positions.extend(
            ball.positions().iter().map(|p| [p[0] * 0.2 + 0.5, p[1] * 0.2 + 1.5, p[2] * 0.2]),
        );
        triangles.extend(ball.triangles().iter().map(|t| t.map(|v| v + from)));
        let all = triangles.len() as u32;
        let up = vec![[0.0, 0.0, 1.0]; positions.len()];
        let normals = Some(floats(Semantic::Normal, &up));
        let mesh = mesh(positions, triangles, normals);
        let colours = Checkerboard::new(&mesh);
        let simplified = simplify_coloured(&mesh, &HYBRID, &colours, &|_, _| {});
        for part in [4, 10, 20, 40] {
            let share = water_seen(&simplified, all / part, first);
            assert!(share > 0.9, "{depth} deep, 1/{part}: {share} of the pond is water");
        }
    }
}
