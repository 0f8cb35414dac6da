//! Interactive Meshes: examples worked by hand, and everything against the reference.

use super::*;
use lodc_fixtures as fixtures;
use lodc_fixtures::{ChangeLog, check_moves};
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, SequenceParts, Submesh};

/// Two quads side by side, already in collapse order, with triangles in reverse order of their
/// disappearance:
///
/// ```text
///  3---1---5      record  collapse  kills        then left
///  |  /|  /|      0       0 → 2     (2, 0, 1)    (2, 1, 3) (2, 4, 5) (2, 5, 1)
///  | / | / |      1       1 → 3     (2, 1, 3)    (2, 4, 5) (2, 5, 3)
///  |/  |/  |      2       2 → 4     (0, 4, 5)    (4, 5, 3)
///  2---0---4      3       3 → 5     (0, 5, 1)
///                 4       4 → 5
/// ```
fn two_quads(triangles: [[u32; 3]; 4]) -> Arc<Simplified> {
    let mesh = Mesh::try_from(MeshParts {
        positions: [[1, 0], [1, 1], [0, 0], [0, 1], [2, 0], [2, 1]]
            .map(|[x, y]| [x as f32, y as f32, 0.0])
            .to_vec(),
        vertex_submesh: vec![0; 6],
        attributes: Vec::new(),
        triangles: triangles.to_vec(),
        submeshes: vec![Submesh { first_triangle: 0, triangle_count: 4, attributes: Vec::new() }],
    });
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: vec![2, 3, 4, 5, 5],
        step_ends: vec![1, 2, 3, 4, 5],
        step_errors: vec![0.0; 5],
        step_triangles: vec![3, 2, 1, 0, 0],
        triangles: 4,
        ..SequenceParts::default()
    });
    Arc::new(
        Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence"))
            .expect("the two fit"),
    )
}

/// The result of fig. 5.4: vertices in the order in which they go, triangles in the opposite of the
/// order in which they go.
const REORDERED: [[u32; 3]; 4] = [[0, 5, 1], [0, 4, 5], [2, 1, 3], [2, 0, 1]];

fn triangles(list: &[[u32; 3]]) -> Vec<OrientedTriangle> {
    let mut all: Vec<_> = list.iter().map(|&t| OrientedTriangle::new(0, t)).collect();
    all.sort_unstable();
    all
}

/// Follows models.md, section 5, and the thesis's fig. 5.3, in which the list of v18 is 38, 49.
#[test]
fn a_collapse_list_follows_the_hierarchy_and_the_lod_picks_its_entry() {
    let mut collapse_to: Vec<u32> = (0..49).map(|_| 49).collect();
    collapse_to[18] = 38;
    let lists = CollapseLists::new(&collapse_to, Lod(49), 1000).expect("short lists");
    let lengths: Vec<u32> = lists.offsets().windows(2).map(|o| o[1] - o[0]).collect();
    assert_eq!(CollapseLists::lengths(&collapse_to, Lod(49)), lengths);
    assert_eq!(lists.list(18), [18, 38, 49]);
    assert_eq!(lists.list(38), [38, 49]);
    assert_eq!(lists.list(49), [49]);
    let mut extraction = Extraction::new(&lists);
    for (lod, entry) in
        [(0, 18), (18, 18), (19, 38), (38, 38), (39, 49), (49, 49), (30, 38), (49, 49), (5, 18)]
    {
        extraction.seek(&lists, Lod(lod), |_, _| ());
        assert_eq!(extraction.shown(&lists, 18), entry, "LOD {lod}");
    }
}

#[test]
fn lists_cut_at_a_lod_are_shorter_and_good_down_to_it() {
    let simplified = fixtures::random_collapse(&fixtures::icosphere(2), 3);
    let targets = simplified.collapses().targets();
    let coarsest = simplified.collapses().floor(Lod(targets.len() as u32 / 20));
    let whole = CollapseLists::new(targets, simplified.collapses().last(), usize::MAX)
        .expect("a small mesh");
    let cut = CollapseLists::new(targets, coarsest, usize::MAX).expect("a small mesh");
    assert!(cut.entries().len() < whole.entries().len());
    let mut extraction = Extraction::new(&cut);
    extraction.seek(&cut, coarsest, |_, _| ());
    for v in 0..=targets.len() as u32 {
        assert_eq!(extraction.shown(&cut, v), simplified.collapses().resolve(v, coarsest));
    }
}

#[test]
fn lists_that_grow_with_the_square_are_refused_before_they_are_made() {
    let chain: Vec<u32> = (1..=1_000_000).collect();
    let refused =
        CollapseLists::new(&chain, Lod(1_000_000), 100_000_000).expect_err("far too long");
    assert_eq!(refused.entries, 1_000_001 * 1_000_002 / 2);
}

#[test]
fn triangles_die_in_the_order_worked_out_by_hand() {
    let model = Interactive::build(&two_quads(REORDERED)).expect("triangles are in order");
    assert_eq!(model.removal_lods(), [4, 3, 2, 1]);
    assert_eq!((0..=5).map(|lod| model.live(0, Lod(lod))).collect::<Vec<_>>(), [4, 3, 2, 1, 0, 0]);
}

#[test]
fn triangles_out_of_order_are_refused() {
    let swapped = [REORDERED[0], REORDERED[2], REORDERED[1], REORDERED[3]];
    let refused = Interactive::build(&two_quads(swapped)).expect_err("out of order");
    assert_eq!(refused, BuildError::TriangleOrder { submesh: 0, triangle: 2 });
}

/// After the thesis's fig. 5.7: the prefix of the triangles, each corner replaced by its list's
/// entry.
#[test]
fn extraction_shows_the_triangles_worked_out_by_hand() {
    let model = Interactive::build(&two_quads(REORDERED)).expect("triangles are in order");
    let levels: [&[[u32; 3]]; 6] = [
        &[[2, 0, 1], [2, 1, 3], [0, 4, 5], [0, 5, 1]],
        &[[2, 1, 3], [2, 4, 5], [2, 5, 1]],
        &[[2, 4, 5], [2, 5, 3]],
        &[[4, 5, 3]],
        &[],
        &[],
    ];
    let mut cursor = model.cursor();
    for lod in [0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0, 3, 1, 5, 2, 0] {
        model.seek(&mut cursor, Lod(lod), &mut ());
        let mut shown = model.triangles(&cursor);
        shown.sort_unstable();
        assert_eq!(shown, triangles(levels[lod as usize]), "LOD {lod}");
    }
}

#[test]
fn changes_worked_out_by_hand() {
    let model = Interactive::build(&two_quads(REORDERED)).expect("triangles are in order");
    let mut cursor = model.cursor();
    let mut move_to = |lod| {
        let mut log = ChangeLog::default();
        let traffic = model.seek(&mut cursor, Lod(lod), &mut log);
        log.removed.sort_unstable();
        log.added.sort_unstable();
        (log.removed, log.added, traffic.records, traffic.rewritten)
    };
    let (fine, coarse) =
        (triangles(&[[2, 0, 1], [0, 4, 5], [0, 5, 1]]), triangles(&[[2, 4, 5], [2, 5, 1]]));
    assert_eq!(move_to(1), (fine.clone(), coarse.clone(), 1, 1));
    assert_eq!(move_to(0), (coarse, fine, 1, 1));
    // Straight down to one triangle: what came and went in between is not reported.
    let (all, one) = (triangles(&REORDERED), triangles(&[[4, 5, 3]]));
    assert_eq!(move_to(3), (all.clone(), one.clone(), 3, 3));
    assert_eq!(move_to(3), (vec![], vec![], 0, 0));
    assert_eq!(move_to(0), (one, all, 3, 3));
}

/// Every fixture under an arbitrary sequence: every step, both ways, and jumps; triangles, changes,
/// and the list pass.
#[test]
fn everything_shown_and_reported_equals_the_reference() {
    for &(name, make) in fixtures::ALL {
        // The naive sequence is slow on the largest shapes, which `tests/` has with few seeds.
        let mesh = make();
        if mesh.triangles().len() <= 400 {
            check(name, &fixtures::random_collapse(&mesh, 1));
        }
    }
    for seed in 0..40 {
        check(&format!("random {seed}"), &fixtures::random_collapse(&fixtures::random(seed), seed));
    }
}

/// Moves that nobody hears of go near and far, in any order.
#[test]
fn moves_unheard_of_show_the_reference_wherever_they_came_from() {
    let mut random = lodc_mesh::SplitMix64::new(5);
    for mesh in [fixtures::icosphere(4), fixtures::torus()] {
        let simplified = fixtures::random_collapse(&mesh, 3);
        let model = Interactive::build(&Arc::new(simplified.clone())).expect("a valid sequence");
        let records = u64::from(simplified.collapses().records());
        let (mut cursor, mut at) = (model.cursor(), 0);
        for _ in 0..2000 {
            let bits = random.bits();
            at = match bits % 8 {
                0 => (bits >> 8) % (records + 1),
                1..=4 => (at + (bits >> 8) % 12).min(records),
                _ => at.saturating_sub((bits >> 8) % 12),
            };
            model.seek(&mut cursor, Lod(at as u32), &mut ());
            let mut shown = model.triangles(&cursor);
            let mut truth = simplified.triangles_at(model.lod(&cursor));
            shown.sort_unstable();
            truth.sort_unstable();
            assert_eq!(shown, truth, "LOD {at}");
        }
    }
}

fn check(name: &str, simplified: &Simplified) {
    let model = Interactive::build(&Arc::new(simplified.clone())).expect("a valid sequence");
    let collapses = simplified.collapses();
    let lists = CollapseLists::new(collapses.targets(), collapses.last(), usize::MAX)
        .expect("a small mesh");
    let mut extraction = Extraction::new(&lists);
    check_moves(name, &model, |cursor| {
        let lod = model.lod(cursor);
        extraction.seek(&lists, lod, |_, _| ());
        for v in 0..simplified.mesh().vertex_count() as u32 {
            assert_eq!(extraction.shown(&lists, v), collapses.resolve(v, lod), "{name}");
        }
    });
}

#[test]
fn storage_of_a_closed_mesh_is_about_ten_words_per_vertex() {
    let simplified = Arc::new(fixtures::random_collapse(&fixtures::icosphere(2), 1));
    let cost = Interactive::build(&simplified).expect("a valid sequence").storage();
    let v = simplified.mesh().vertex_count() as f64;
    assert!((cost.thesis() - 32.0 * (10.0 * v - 13.0) / v).abs() < 1e-9, "{cost:?}");
    assert!((cost.thesis_normals() - cost.thesis() - 96.0).abs() < 1e-9);
    let plain = StorageCost::of_triangles(&simplified);
    assert!((plain.thesis() - 32.0 * (9.0 * v - 12.0) / v).abs() < 1e-9, "{plain:?}");
}

#[test]
fn a_hierarchy_made_to_be_slow_is_still_built_quickly() {
    // One chain of 200,000 collapses, and triangles whose corners are far apart on it.
    let n = 200_000u32;
    let mesh = Mesh::try_from(MeshParts {
        positions: (0..n).map(|i| [i as f32, (i % 2) as f32, 0.0]).collect(),
        vertex_submesh: vec![0; n as usize],
        attributes: Vec::new(),
        triangles: (0..50_000).rev().map(|i| [i, n / 2 + i, n / 2 + i + 25_000]).collect(),
        submeshes: vec![Submesh {
            first_triangle: 0,
            triangle_count: 50_000,
            attributes: Vec::new(),
        }],
    });
    let removal_lods = |i: u32| n / 2 + i;
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: (1..n).collect(),
        step_ends: (1..n).collect(),
        step_errors: vec![0.0; n as usize - 1],
        step_triangles: vec![0; n as usize - 1],
        triangles: 50_000,
        ..SequenceParts::default()
    });
    let simplified = Simplified::new(mesh.expect("a mesh"), collapses.expect("a sequence"))
        .expect("the two fit");
    let model = Interactive::build(&Arc::new(simplified)).expect("triangles are in order");
    assert_eq!(model.removal_lods()[0], removal_lods(49_999));
    assert_eq!(model.removal_lods()[49_999], removal_lods(0));
}
