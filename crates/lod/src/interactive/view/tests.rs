//! Views on the CPU: every fixture, whatever its seams, borders and submeshes.

use super::*;
use crate::interactive::replay::lists;
use lodc_fixtures as fixtures;
use lodc_mesh::{Lod, OrientedTriangle};
use std::sync::Arc;

fn views_of(simplified: &Simplified) -> Views<'_> {
    Views::new(simplified, VertexRecords::whole(simplified.mesh()).expect("a small mesh"))
}

fn everything(check: impl Fn(&str, &Simplified)) {
    for &(name, make) in fixtures::ALL {
        let mesh = make();
        if mesh.triangles().len() <= 400 {
            check(name, &fixtures::random_collapse(&mesh, 1));
        }
    }
    for seed in 0..40 {
        check(&format!("random {seed}"), &fixtures::random_collapse(&fixtures::random(seed), seed));
    }
}

#[test]
fn views_show_what_the_sequence_says_and_never_tear() {
    everything(|name, simplified| {
        let mesh = simplified.mesh();
        if mesh.vertex_count() == 0 {
            return;
        }
        let views = views_of(simplified);
        let reference = ViewReference::new(simplified);
        for view in sample(simplified, 8, 3) {
            let shown = views.show(&view);
            let left = filtered(mesh, mesh.triangles(), &shown.vertices, views.records.stride);
            assert_eq!(
                shown.check(&reference, &view, &left.indices, views.records.stride),
                None,
                "{name}: {view:?}"
            );
        }
    });
}

/// A vertex may be shown as one of another submesh while its triangle is still there.
#[test]
fn meshes_of_views_have_their_triangles_in_their_submeshes() {
    let crossings = std::cell::Cell::new(0);
    everything(|name, simplified| {
        let mesh = simplified.mesh();
        if mesh.vertex_count() == 0 {
            return;
        }
        let (views, ids) = (views_of(simplified), mesh.position_ids());
        for view in sample(simplified, 8, 5) {
            let states = views.show(&view).states;
            let live = live_triangles(simplified, &ids, &states);
            let own = view_mesh(simplified, &ids, &states).expect("a mesh");
            let mut expected: Vec<[[u32; 3]; 3]> = Vec::new();
            let mut counts = vec![0; mesh.submeshes().len()];
            for t in &live {
                expected.push(t.corners.map(|v| mesh.positions()[v as usize].map(f32::to_bits)));
                counts[t.submesh as usize] += 1;
                let others = |v: &u32| mesh.vertex_submesh()[*v as usize] != t.submesh;
                crossings.set(crossings.get() + t.corners.iter().filter(|v| others(v)).count());
            }
            let bits = |v: u32| own.positions()[v as usize].map(f32::to_bits);
            let mut shown: Vec<_> = own.triangles().iter().map(|t| t.map(bits)).collect();
            // Corners begin with any of the three.
            let least = |t: &mut [[u32; 3]; 3]| {
                let first = (0..3).min_by_key(|&i| t[i]).expect("three corners");
                t.rotate_left(first);
            };
            shown.iter_mut().chain(&mut expected).for_each(least);
            shown.sort_unstable();
            expected.sort_unstable();
            assert_eq!(shown, expected, "{name}: {view:?}");
            let found: Vec<u32> = own.submeshes().iter().map(|s| s.triangle_count).collect();
            assert_eq!(found, counts, "{name}: {view:?}");
            let states = views.show(&ViewQuery { morph: true, ..view }).states;
            morphed_mesh(simplified, &states).expect("a mesh");
        }
    });
    assert!(crossings.get() > 100, "{} corners", crossings.get());
}

#[test]
fn hardly_a_triangle_of_an_unfolded_view_is_turned_over() {
    let options = lodc_simplify::Options::DEFAULT;
    let simplified = lodc_simplify::simplify(&fixtures::icosphere(4), &options, &|_, _| ());
    let mesh = simplified.mesh();
    let (selector, ids) = (Selector::new(&simplified), mesh.position_ids());
    let range = LodRange {
        fine: Lod(0),
        coarse: simplified.collapses().lod_for_triangles(30),
        last: simplified.collapses().lod_for_triangles(8),
    };
    let (mut before, mut after) = (0, 0);
    for family in [
        Family::Silhouette { eye: [3.0, 2.0, 5.0] },
        Family::Sphere { centre: [1.0, 0.0, 0.0], radius: 0.7 },
        Family::Region { low: [-2.0; 3], high: [0.1, 2.0, 2.0] },
    ] {
        let mut lods = selector.lods_at(&family, family.given_setting(), &range);
        let inward = |lods: &[u32]| {
            let states = selector.states(lods, false);
            let faces_inward = |t: &OrientedTriangle| {
                let [a, b, c] = t.corners.map(|v| mesh.positions()[v as usize]);
                let middle: [f32; 3] = std::array::from_fn(|k| a[k] + b[k] + c[k]);
                let normal = cones::normal(mesh.positions(), t.corners).unwrap_or_default();
                (0..3).map(|k| normal[k] * f64::from(middle[k])).sum::<f64>() < -0.1
            };
            live_triangles(&simplified, &ids, &states).iter().filter(|t| faces_inward(t)).count()
        };
        before += inward(&lods);
        selector.unfold(&mut lods, &ids);
        after += inward(&lods);
    }
    // Corners that have come far around the ball tilt some that face as their references do.
    assert!(before > 50 && after * 10 < before, "{before} before, {after} after");
}

/// A vertex that takes its own LOD instead of its group's tears the mesh, and verification sees it.
#[test]
fn a_wedge_that_goes_its_own_way_is_a_tear() {
    let simplified =
        fixtures::random_collapse(&fixtures::named("faceted_sphere").expect("a named shape"), 1);
    let views = views_of(&simplified);
    let view = ViewQuery { criterion: Criterion::everywhere(Lod(0)), morph: false };
    let mut shown = views.show(&view);
    let wedge = simplified.mesh().triangles()[0][0] as usize;
    let coarse = simplified.collapses().resolve(wedge as u32, simplified.collapses().last());
    shown.vertices[wedge * views.records.stride..][..3]
        .copy_from_slice(&views.records.at(coarse)[..3]);
    let left = filtered(
        simplified.mesh(),
        simplified.mesh().triangles(),
        &shown.vertices,
        views.records.stride,
    );
    let reference = ViewReference::new(&simplified);
    let wrong = shown.check(&reference, &view, &left.indices, views.records.stride);
    assert!(matches!(wrong, Some(Failure::Torn { .. })), "{wrong:?}");
}

#[test]
fn cones_bound_the_normals_of_all_that_collapses_into_a_group() {
    everything(|name, simplified| {
        let mesh = simplified.mesh();
        let cones = Cones::new(mesh, simplified.collapses(), mesh.positions());
        let lists = lists(simplified).expect("a small mesh");
        for &t in mesh.triangles() {
            let Some(normal) = cones::normal(mesh.positions(), t) else { continue };
            for v in t {
                for &entry in lists.list(v) {
                    let group = cones.of_vertex[entry as usize] as usize;
                    if let Some(cone) = cones.cones.get(group) {
                        assert!(
                            cone.contains(normal),
                            "{name}: {t:?} at {entry}: {cone:?} {normal:?}"
                        );
                    }
                }
            }
        }
    });
}

#[test]
fn morphing_shows_the_same_entries_and_triangles_and_goes_the_last_part_of_the_way() {
    let simplified = fixtures::random_collapse(&fixtures::icosphere(2), 1);
    let views = views_of(&simplified);
    let positions = simplified.mesh().position_ids();
    let (lists, vertices) = (lists(&simplified).expect("a small mesh"), views.links().len() as u32);
    for lod in 0..simplified.collapses().records() {
        let view = |morph| ViewQuery { criterion: Criterion::everywhere(Lod(lod)), morph };
        let (still, moving) = (views.show(&view(false)), views.show(&view(true)));
        let count = |shown: &ViewContent| drawn_triangles(&simplified, &positions, &shown.states);
        assert_eq!(count(&moving), count(&still), "LOD {lod}: what has gone stays away");
        for (v, (state, still)) in moving.states.iter().zip(&still.states).enumerate() {
            assert_eq!(state.entry, still.entry);
            let list = lists.list(v as u32);
            let at = list.iter().position(|&e| e == state.entry).expect("an entry of the list");
            assert_eq!(state.next, list.get(at + 1).copied().unwrap_or(state.entry));
            let leaves = views.links()[state.entry as usize][1];
            let length = ((vertices - leaves.min(vertices)) / 8 + 1).min(leaves);
            let share = (f64::from(lod) - f64::from(leaves - length)) / f64::from(length);
            let way = f64::from(state.progress) / 65536.0;
            assert!((way - share.max(0.0)).abs() < 1e-4, "LOD {lod}: {state:?}");
        }
    }
}

/// From one LOD to the next no vertex moves farther than its share of its way: none leaps, not
/// even where it arrives and goes on with one that is under way itself.
#[test]
fn morphing_never_leaps() {
    let simplified = fixtures::random_collapse(&fixtures::icosphere(3), 1);
    let views = Views::new(&simplified, VertexRecords::positions(simplified.mesh()));
    let vertices = views.links().len() as u32;
    let positions_at = |lod| -> Vec<[f32; 3]> {
        let view = ViewQuery { criterion: Criterion::everywhere(Lod(lod)), morph: true };
        let shown = views.show(&view).vertices;
        shown.chunks_exact(3).map(|c| [c[0], c[1], c[2]].map(f32::from_bits)).collect()
    };
    // Steps of this fixture are records, and ways are no longer than the sphere is wide. Before
    // this all set out at LOD 0, which is the input.
    let first = vertices / 7;
    let mut before = positions_at(first);
    let mut under_way = 0;
    for lod in first + 1..vertices * 9 / 10 {
        let now = positions_at(lod);
        let part = 1.0 / f64::from((vertices - lod) / 8);
        for (a, b) in before.iter().zip(&now) {
            let moved = (0..3).map(|i| f64::from(a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
            under_way += usize::from(moved > 0.0);
            assert!(moved <= 4.0 * part, "LOD {lod}: {moved}, {part} of a way");
        }
        before = now;
    }
    assert!(under_way > 10_000, "{under_way}");
}

/// Fig. 5.8: detail inside a region only.
#[test]
fn a_region_is_fine_inside_and_coarse_outside() {
    let simplified = fixtures::random_collapse(&fixtures::icosphere(2), 1);
    let views = views_of(&simplified);
    let coarse = simplified.collapses().floor(Lod(simplified.collapses().records() * 9 / 10));
    let criterion = Criterion::Region {
        low: [-2.0, -2.0, 0.0],
        high: [2.0; 3],
        inside: Lod(0),
        outside: coarse,
    };
    let shown = views.show(&ViewQuery { criterion, morph: false });
    for (v, state) in shown.states.iter().enumerate() {
        let inside = simplified.mesh().positions()[v][2] >= 0.0;
        let lod = if inside { Lod(0) } else { coarse };
        assert_eq!(state.entry, simplified.collapses().resolve(v as u32, lod));
    }
}

#[test]
fn what_is_on_the_screen_is_fine_and_what_is_behind_the_eye_coarse() {
    let simplified = fixtures::random_collapse(&fixtures::icosphere(3), 1);
    let views = views_of(&simplified);
    let coarse = simplified.collapses().floor(Lod(simplified.collapses().records() * 9 / 10));
    // From the middle of the sphere: a screen of 90 by 53 degrees, not turned.
    let (eye, target, tangents) = ([0.0, 0.1, 0.2], [0.0, 0.1, -4.0], [1.0, 0.5]);
    let criterion = Criterion::Frustum { eye, target, tangents, inside: Lod(0), outside: coarse };
    let shown = views.show(&ViewQuery { criterion, morph: false });
    let (mut fine, mut behind) = (0, 0);
    for (v, state) in shown.states.iter().enumerate() {
        let p = simplified.mesh().positions()[v];
        let [x, y, ahead] = [p[0], p[1] - 0.1, 0.2 - p[2]];
        let inside = |by: f32| x.abs() <= ahead * (1.0 + by) && y.abs() <= ahead * (0.5 + by);
        // But for rounding.
        if inside(1e-4) == inside(-1e-4) {
            let lod = if inside(0.0) { Lod(0) } else { coarse };
            assert_eq!(state.entry, simplified.collapses().resolve(v as u32, lod), "{p:?}");
            fine += u32::from(inside(0.0));
            behind += u32::from(ahead < 0.0);
        }
    }
    assert!(fine > 20 && behind > 200, "{fine}, {behind}");
}

#[test]
fn the_outline_is_fine_and_the_middle_coarse() {
    let simplified = fixtures::random_collapse(&fixtures::icosphere(3), 1);
    let views = views_of(&simplified);
    let last = simplified.collapses().last();
    let criterion =
        Criterion::Silhouette { eye: [0.0, 0.0, 100.0], edge: Lod(0), face: last, width: 1.0 };
    let shown = views.show(&ViewQuery { criterion, morph: false });
    for (point, state) in views.points().iter().zip(&shown.states) {
        let length = point.axis.iter().map(|&c| f32::from(c).powi(2)).sum::<f32>().sqrt();
        let cos = f32::from(point.axis[2]).abs() / length;
        if cos < 0.05 {
            assert!(state.lod < last.0 / 5, "{point:?}: {state:?}");
        }
        if point.sine < 45 && cos > 0.99 {
            assert!(state.lod > last.0 * 4 / 5, "{point:?}: {state:?}");
        }
    }
}

#[test]
fn a_few_views_are_checked_on_the_processor_with_and_without_morphing() {
    let simplified = Arc::new(fixtures::random_collapse(&fixtures::icosphere(2), 1));
    let model = crate::Interactive::build(&simplified).expect("a model");
    let check = model.verify_views();
    assert!(check.ok() && check.lods == 20 && check.full == 20, "{check:?}");
}
