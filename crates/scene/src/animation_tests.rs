//! Values at keys and between them.

use super::*;
use crate::Node;

fn channel(property: Property, interpolation: Interpolation, values: &[f64]) -> Channel {
    let times = vec![1.0, 2.0, 4.0];
    Channel { node: 0, property, interpolation, times, values: values.to_vec() }
}

#[test]
fn keys_hold_before_the_first_and_after_the_last() {
    let moves = channel(
        Property::Translation,
        Interpolation::Linear,
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 4.0, 0.0],
    );
    for (seconds, wanted) in [
        (0.0, [0.0, 0.0, 0.0]),
        (1.0, [0.0, 0.0, 0.0]),
        (1.25, [0.25, 0.0, 0.0]),
        (2.0, [1.0, 0.0, 0.0]),
        (3.0, [1.0, 2.0, 0.0]),
        (9.0, [1.0, 4.0, 0.0]),
    ] {
        assert_eq!(moves.at(seconds).as_deref(), Some(&wanted[..]), "{seconds}");
    }
    let steps = Channel { interpolation: Interpolation::Step, ..moves };
    assert_eq!(steps.at(1.99).as_deref(), Some(&[0.0, 0.0, 0.0][..]));
    assert_eq!(steps.at(2.0).as_deref(), Some(&[1.0, 0.0, 0.0][..]));
    let empty = Channel { times: vec![], values: vec![], ..steps };
    assert_eq!(empty.at(1.0), None);
}

#[test]
fn rotations_turn_evenly_along_the_shorter_arc() {
    let about_z = |degrees: f64, length: f64| {
        let (s, c) = (degrees.to_radians() / 2.0).sin_cos();
        [0.0, 0.0, s * length, c * length]
    };
    for (from, to) in [(0.0, 90.0), (0.0, 170.0), (10.0, 10.0), (0.0, 350.0), (-20.0, 100.0)] {
        // The other sign is the same rotation; lengths do not count.
        for length in [1.0, -1.0, 3.0] {
            let shorter = if to - from > 180.0 { to - 360.0 } else { to };
            for t in [0.0, 0.1, 0.5, 0.75, 1.0] {
                let found = slerp(&about_z(from, 1.0), &about_z(to, length), t);
                let wanted = about_z(from + t * (shorter - from), 1.0);
                let dot: f64 = found.iter().zip(wanted).map(|(a, b)| a * b).sum();
                let square: f64 = found.iter().map(|c| c * c).sum();
                assert!((square - 1.0).abs() < 1e-12, "{from} to {to}, {t}: {square}");
                assert!(dot.abs() > 1.0 - 1e-12, "{from} to {to}, {t}: {found:?}");
            }
        }
    }
}

#[test]
fn splines_pass_their_keys_with_their_tangents() {
    // In-tangent, value, out-tangent of each of three keys.
    let values = [[0.0, 1.0, 2.0], [-1.0, 3.0, 0.5], [0.25, 2.0, 0.0]];
    let flat: Vec<f64> = values.iter().flat_map(|k| k.map(|v| [v; 3])).flatten().collect();
    let spline = channel(Property::Scale, Interpolation::CubicSpline, &flat);
    let at = |s: f64| spline.at(s).expect("keys")[0];
    assert_eq!([at(1.0), at(2.0), at(4.0)], [1.0, 3.0, 2.0]);
    let slope = |s: f64, step: f64| (at(s + step) - at(s)) / step;
    for (seconds, step, wanted) in [(1.0, 1e-6, 2.0), (2.0, -1e-6, -1.0), (2.0, 1e-6, 0.5)] {
        assert!(
            (slope(seconds, step) - wanted).abs() < 1e-4,
            "{seconds}: {}",
            slope(seconds, step)
        );
    }
}

#[test]
fn a_pose_is_the_rest_pose_with_what_moves_replaced() {
    let trs = LocalTransform::Trs {
        translation: [5.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [2.0; 3],
    };
    let node = Node { local: trs, weights: vec![0.5, 0.25], ..Node::default() };
    let fixed = Node::default();
    let graph = Graph { nodes: vec![node, fixed], roots: vec![0], skins: vec![] };
    let moves = channel(Property::Scale, Interpolation::Step, &[1.0; 9]);
    let blends = Channel {
        property: Property::Weights,
        interpolation: Interpolation::Linear,
        values: vec![0.0, 1.0, 1.0, 0.0, 1.0, 0.0],
        ..moves.clone()
    };
    // A matrix and a node that is not there stay as they are.
    let others = [1, 7].map(|node| Channel { node, ..moves.clone() });
    let channels = [vec![moves, blends], others.to_vec()].concat();
    let animation = Animation { name: "all".to_owned(), channels };
    assert_eq!(animation.duration(), 4.0);
    let pose = animation.pose(&graph, 1.5);
    let LocalTransform::Trs { translation, scale, .. } = pose.locals[0] else { panic!("a matrix") };
    assert_eq!((translation, scale), ([5.0; 3], [1.0; 3]));
    assert_eq!(pose.weights[0], [0.5, 0.5]);
    assert_eq!(pose.locals[1], graph.rest_pose().locals[1]);
}

#[test]
fn one_weight_leaves_the_others_as_they_are() {
    let node = Node { weights: vec![0.25], ..Node::default() };
    let graph = Graph { nodes: vec![node], roots: vec![0], skins: Vec::new() };
    let channel = Channel {
        node: 0,
        property: Property::Weight(2),
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 1.0],
    };
    let animation = Animation { channels: vec![channel], ..Animation::default() };
    assert_eq!(animation.pose(&graph, 0.5).weights, [[0.25, 0.0, 0.5]]);
}
