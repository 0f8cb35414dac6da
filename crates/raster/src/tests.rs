use crate::{Camera, Fragment, Layers, Point, Window, metric_cameras, scan, spread_cameras};
use glam::DVec3;

/// Small numbers without any pattern (xorshift).
fn random(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}

fn point(state: &mut u64, range: u64) -> Point {
    let mut next = || (random(state) % range) as i32;
    Point { x: next(), y: next(), z: next() }
}

/// Returns whether a pixel centre is inside, by asking every edge with exact arithmetic; none if it
/// is on an edge.
fn contains(corners: [Point; 3], column: i32, row: i32) -> Option<bool> {
    let (x, y) = (i128::from(column) * 256 + 128, i128::from(row) * 256 + 128);
    let mut signs = [0, 1, 2].map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let (ax, ay, bx, by) = (i128::from(a.x), i128::from(a.y), i128::from(b.x), i128::from(b.y));
        ((bx - ax) * (y - ay) - (by - ay) * (x - ax)).signum()
    });
    signs.sort_unstable();
    match signs {
        [-1, -1, -1] | [1, 1, 1] => Some(true),
        [-1, _, 1] => Some(false),
        _ => None,
    }
}

#[test]
fn a_triangle_covers_the_centres_inside_it_and_no_others() {
    let mut state = 1;
    for range in [300, 2000, 4096] {
        for _ in 0..300 {
            let corners = [0; 3].map(|_| point(&mut state, range));
            let mut seen = [[false; 16]; 16];
            scan(corners, Window::whole(16), |x, y, z| {
                assert!(!std::mem::replace(&mut seen[y as usize][x as usize], true), "twice");
                let depths = corners.map(|p| p.z);
                assert!(
                    depths.iter().any(|&d| d <= z + 1) && depths.iter().any(|&d| d >= z - 1),
                    "{z} {depths:?}"
                );
            });
            for (y, row) in (0..).zip(&seen) {
                for (x, &seen) in (0..).zip(row) {
                    if let Some(inside) = contains(corners, x, y) {
                        assert_eq!(seen, inside, "{corners:?} at {x} {y}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_fan_covers_every_centre_once_even_when_edges_run_through_centres() {
    let mut state = 7;
    for round in 0..500 {
        // Every second round all points are pixel centres, so that edges meet many of them.
        let snap = |p: Point| Point { x: p.x / 256 * 256 + 128, y: p.y / 256 * 256 + 128, z: p.z };
        let mut center = point(&mut state, 3000);
        if round % 2 == 0 {
            center = snap(center);
        }
        let link = [
            (-1000, -1000),
            (1700, -1000),
            (5000, -1000),
            (5000, 2000),
            (5000, 5000),
            (-1000, 5000),
            (-1000, 800),
        ];
        let link = link.map(|(x, y)| Point { x, y, z: 0 });
        let mut count = [0; 256];
        for i in 0..link.len() {
            let mut corners = [center, link[i], link[(i + 1) % link.len()]];
            if round % 3 == 0 {
                corners.swap(0, 1);
            }
            scan(corners, Window::whole(16), |x, y, _| count[(y * 16 + x) as usize] += 1);
        }
        assert!(count.iter().all(|&n| n == 1), "center {center:?}: {count:?}");
    }
}

#[test]
fn layers_keep_order_whatever_comes_and_goes() {
    let mut state = 3;
    let mut layers = Layers::new(4);
    let mut naive: Vec<Vec<Fragment>> = vec![Vec::new(); 4];
    for step in 0..4000 {
        let pixel = random(&mut state) as usize % 4;
        if !naive[pixel].is_empty() && random(&mut state).is_multiple_of(2) {
            let gone = random(&mut state) as usize % naive[pixel].len();
            layers.remove(pixel, naive[pixel].remove(gone).item());
        } else {
            let fragment = Fragment::new(step, random(&mut state) as i32 % 20);
            naive[pixel].push(fragment);
            naive[pixel].sort_unstable();
            layers.insert(pixel, fragment);
        }
        assert!(layers.behind(pixel).eq(naive[pixel].iter().skip(1).copied()));
        assert_eq!(layers.front(pixel), naive[pixel].first().copied().unwrap_or(Fragment::NOTHING));
    }
}

#[test]
fn fragments_sort_by_depth_then_item() {
    let sorted = [(9, -5), (1, 0), (2, 0), (0, 7)].map(|(item, depth)| Fragment::new(item, depth));
    assert!(sorted.windows(2).all(|w| w[0] < w[1]) && sorted[3] < Fragment::NOTHING);
}

#[test]
fn cameras_are_spread_evenly_and_see_the_whole_sphere() {
    let center = DVec3::new(3.0, -2.0, 10.0);
    for cameras in [metric_cameras(center, 2.0, 256), spread_cameras(24, center, 2.0, 256)] {
        let sum: DVec3 = cameras.iter().map(|c| c.toward).sum();
        assert!(sum.length() < 0.5, "{sum}");
        for (i, c) in cameras.iter().enumerate() {
            assert!((c.right.cross(c.up) - c.toward).length() < 1e-12);
            let apart = cameras[..i].iter().map(|d| c.toward.dot(d.toward)).fold(-1.0, f64::max);
            assert!(apart < 0.9, "{i}: {apart}");
            for direction in [DVec3::X, DVec3::Y, DVec3::Z, c.right, c.up] {
                let p = c.project(center + direction * 2.0);
                assert!([p.x, p.y].iter().all(|&v| (0..256 * 256).contains(&v)), "{p:?}");
            }
        }
    }
}

#[test]
fn what_is_nearer_to_the_camera_has_less_depth() {
    let camera = Camera::new(DVec3::Z, DVec3::ZERO, 1.0, 64);
    let (near, far) = (camera.project(DVec3::Z), camera.project(-DVec3::Z));
    assert!(near.z < far.z && (near.x, near.y) == (far.x, far.y));
    let wild = camera.project(DVec3::splat(1e300));
    assert!(wild.x > 0 && wild.y < 0, "far outside, but somewhere: {wild:?}");
}
