use crate::adjacency::{code, decode, neighbours};
use crate::anneal::exp_minus;
use crate::{
    CacheKind, CacheModel, CacheStatistics, StripSet, StripSetError, measure, strip_triangles,
};
use lodc_fixtures as fixtures;
use lodc_mesh::{NONE, OrientedTriangle};

fn strips(strips: &[&[u32]]) -> StripSet {
    let indices: Vec<u32> = strips.concat();
    let mut start = 0;
    let ranges: Vec<_> = strips
        .iter()
        .map(|s| {
            start += s.len();
            (0, start - s.len()..start)
        })
        .collect();
    StripSet::new(1, &ranges, &indices)
}

#[test]
fn odd_triangles_are_turned_and_repetitions_draw_nothing() {
    let drawn: Vec<_> = strip_triangles(&[0, 1, 2, 3, 2, 4]).collect();
    // 2 3 2 is nothing; 3 2 4 is the fourth, and turned.
    assert_eq!(drawn, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(strip_triangles(&[0, 1]).count(), 0);
}

#[test]
fn a_check_finds_what_is_missing_turned_or_too_much() {
    // Two triangles about the edge 1 2.
    let mesh = fixtures::quad();
    let good: Vec<Vec<u32>> = mesh.triangles().iter().map(|t| t.to_vec()).collect();
    let (a, b) = (good[0].clone(), good[1].clone());
    let of = |t: &[u32]| OrientedTriangle::new(0, [t[0], t[1], t[2]]);
    assert_eq!(strips(&[&a, &b]).check(&mesh), Ok(()));
    assert_eq!(strips(&[&b, &a]).check(&mesh), Ok(()));
    assert_eq!(strips(&[&a]).check(&mesh), Err(StripSetError::Missing(of(&b).max(of(&a)))));
    assert!(
        matches!(strips(&[&a, &b, &b]).check(&mesh), Err(StripSetError::Extra(t)) if t == of(&b))
    );
    let turned = [a[1], a[0], a[2]];
    assert!(strips(&[&turned, &b]).check(&mesh).is_err());
    assert_eq!(
        StripSet::default().check(&mesh),
        Err(StripSetError::Submeshes { found: 0, wanted: 1 })
    );
}

#[test]
fn strips_are_sorted_by_submesh_and_keep_their_order_there() {
    let set = StripSet::new(3, &[(2, 0..3), (0, 3..6), (2, 6..9)], &[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(
        set.iter().map(<[u32]>::to_vec).collect::<Vec<_>>(),
        [[3, 4, 5], [0, 1, 2], [6, 7, 8]]
    );
    assert_eq!((set.submesh(0), set.submesh(1), set.submesh(2)), (0..1, 1..1, 1..3));
}

#[test]
fn neighbours_are_mutual_and_run_the_other_way() {
    for (name, shape) in fixtures::ALL {
        let mesh = shape();
        let all = neighbours(mesh.triangles(), mesh.vertex_count());
        for (t, slots) in all.iter().enumerate() {
            for (e, &c) in slots.iter().enumerate().filter(|(_, c)| **c != NONE) {
                let (u, f) = decode(c);
                assert_eq!(all[u as usize][f as usize], code(t as u32, e as u32), "{name}");
                let (a, b) = (mesh.triangles()[t], mesh.triangles()[u as usize]);
                let ends = |t: [u32; 3], s: usize| (t[s], t[(s + 1) % 3]);
                let (from, to) = ends(a, e);
                assert_eq!(ends(b, f as usize), (to, from), "{name}");
            }
        }
    }
}

#[test]
fn a_closed_surface_has_three_neighbours_everywhere() {
    let mesh = fixtures::icosphere(2);
    assert!(neighbours(mesh.triangles(), mesh.vertex_count()).iter().flatten().all(|&c| c != NONE));
}

#[test]
fn caches_forget_in_their_own_way() {
    let stream = [0, 1, 2, 0, 3, 0, 1];
    let with = |kind, size| measure(stream, 4, CacheModel { kind, size }).misses;
    // First in, first out: 3 pushes 0 out although it was just used, then 0 pushes 1 out.
    assert_eq!(with(CacheKind::Fifo, 3), 6);
    // Least recently used: 3 pushes 1 out, so only 1 is fetched again.
    assert_eq!(with(CacheKind::Lru, 3), 5);
    assert_eq!((with(CacheKind::Fifo, 4), with(CacheKind::Lru, 4)), (4, 4));
    assert_eq!((with(CacheKind::Fifo, 0), with(CacheKind::Lru, 0)), (7, 7));
}

#[test]
fn ratios_are_per_triangle_and_per_vertex() {
    let s = measure([0, 1, 2, 2, 1, 3], 10, CacheModel::default());
    assert_eq!(s, CacheStatistics { misses: 4, vertices: 4 });
    assert!((s.acmr(2) - 2.0).abs() < 1e-12 && (s.atvr() - 1.0).abs() < 1e-12);
    let none = CacheStatistics::default();
    assert_eq!((none.acmr(0), none.atvr()), (0.0, 0.0));
}

#[test]
fn the_exponential_is_close_to_the_true_one() {
    for i in 0..400 {
        let x = f64::from(i) / 20.0;
        assert!((exp_minus(x) - (-x).exp()).abs() < 1e-3, "{x}");
    }
}
