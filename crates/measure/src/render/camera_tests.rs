//! Everything fits into a picture, from every side and with every lens.

use super::*;

fn seen(camera: &Camera, p: [f64; 3]) -> [f64; 3] {
    let m = camera.matrix();
    let p: [f64; 3] = std::array::from_fn(|i| p[i] - camera.centre[i]);
    let at = |r: usize| (0..3).map(|c| f64::from(m[c][r]) * p[c]).sum::<f64>() + f64::from(m[3][r]);
    [at(0) / at(3), at(1) / at(3), at(2) / at(3)]
}

fn every(check: impl Fn(&Framing)) {
    for lens in [Lens::Perspective(30.0), Lens::Perspective(90.0), Lens::Orthographic] {
        for up in [Up::Y, Up::Z] {
            for (azimuth, elevation) in
                [(0.0, 0.0), (35.0, 20.0), (200.0, -70.0), (0.0, 90.0), (90.0, -90.0)]
            {
                check(&Framing { up, azimuth, elevation, lens, zoom: 1.0 });
            }
        }
    }
}

#[test]
fn everything_fits_and_touches_the_margin() {
    let points: Vec<[f64; 3]> = (0..8)
        .map(|i| {
            [f64::from(i & 1) * 7.0 + 100.0, f64::from(i >> 1 & 1) * 2.0, f64::from(i >> 2) * 3.0]
        })
        .collect();
    every(|framing| {
        for aspect in [0.5, 1.0, 2.5] {
            let camera = Camera::around(&points, framing, aspect);
            let edge = points.iter().map(|&p| seen(&camera, p)).fold(0.0f64, |edge, [x, y, z]| {
                assert!((0.0..=1.0).contains(&z), "{framing:?}: depth {z}");
                edge.max(x.abs()).max(y.abs())
            });
            assert!((edge - (1.0 - 2.0 * MARGIN)).abs() < 1e-4, "{framing:?}, {aspect}: {edge}");
        }
    });
}

#[test]
fn nearer_points_have_less_depth_and_up_is_up() {
    let points = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]];
    let framing = Framing {
        up: Up::Y,
        azimuth: 0.0,
        elevation: 0.0,
        lens: Lens::Perspective(40.0),
        zoom: 1.0,
    };
    let camera = Camera::around(&points, &framing, 1.0);
    assert!(seen(&camera, [0.0, 0.0, 1.0])[2] < seen(&camera, [0.0, 0.0, 0.0])[2]);
    assert!(seen(&camera, [1.0, 0.0, 0.0])[0] > 0.0 && seen(&camera, [0.0, 1.0, 0.0])[1] > 0.0);
    // From the side of +x, the front is to the left.
    let side = Camera::around(&points, &Framing { azimuth: 90.0, ..framing }, 1.0);
    assert!(seen(&side, [0.0, 0.0, 1.0])[0] < 0.0);
    let cad = Camera::around(&points, &Framing { up: Up::Z, ..framing }, 1.0);
    assert!(
        seen(&cad, [0.0, 0.0, 1.0])[1] > 0.0
            && seen(&cad, [0.0, 0.0, 0.0])[2] < seen(&cad, [0.0, 1.0, 0.0])[2]
    );
}

#[test]
fn nothing_and_a_point_have_a_camera_too() {
    every(|framing| {
        for points in [&[][..], &[[3.0, 4.0, 5.0]]] {
            let camera = Camera::around(points, framing, 1.5);
            assert!(camera.matrix().as_flattened().iter().all(|v| v.is_finite()), "{framing:?}");
        }
    });
}

#[test]
fn an_eye_sees_its_target_in_the_middle_and_what_is_up_above_it() {
    let points: Vec<[f64; 3]> = (0..8)
        .map(|i| [f64::from(i & 1) * 3.0, f64::from(i >> 1 & 1), f64::from(i >> 2) * 2.0])
        .collect();
    for up in [Up::Y, Up::Z] {
        for eye in [[9.0, 2.0, 5.0], [-4.0, 0.5, 1.0], [1.5, 8.0, 1.0], [1.5, 0.5, -7.0]] {
            let target = [1.5, 0.5, 1.0];
            let view = Viewpoint { eye, target, up, degrees: 60.0, zoom: 1.0 };
            let camera = Camera::at(&points, &view, 1.5);
            let [x, y, z] = seen(&camera, target);
            assert!(x.abs() < 1e-4 && y.abs() < 1e-4 && (0.0..1.0).contains(&z), "{eye:?}: {z}");
            let mut above = target;
            above[if up == Up::Y { 1 } else { 2 }] += 0.25;
            assert!(seen(&camera, above)[1] > -1e-5, "{eye:?} {up:?}");
            for p in &points {
                assert!((0.0..=1.0).contains(&seen(&camera, *p)[2]), "{eye:?}: depth of {p:?}");
            }
        }
    }
}
