//! Poses that are chosen, of objects that bend, morph, or move as a whole.

use super::*;
use crate::{Animation, Channel, Interpolation, LocalTransform, Node, Property, Skin, Transform};
use glam::DVec3;

fn trs(translation: [f64; 3]) -> LocalTransform {
    LocalTransform::Trs { translation, rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
}

/// Turns a node about x within two seconds, by a right angle and back.
fn turning(node: u32) -> Animation {
    let half = 0.5f64.sqrt();
    let values = [[0.0, 0.0, 0.0, 1.0], [half, 0.0, 0.0, half], [0.0, 0.0, 0.0, 1.0]].concat();
    let times = vec![0.0, 1.0, 2.0];
    let (property, interpolation) = (Property::Rotation, Interpolation::Linear);
    let channels = vec![Channel { node, property, interpolation, times, values }];
    Animation { channels, ..Animation::default() }
}

/// A tube along z with four joints, at 0, 2, 4 and 6, each the child of the one before; and a node
/// that shows it, with the joints below it.
fn tube(animations: Vec<Animation>) -> (Mesh, Motion) {
    let joint = |i: u32| Node {
        local: trs(if i > 1 { [0.0, 0.0, 2.0] } else { [0.0; 3] }),
        children: if i < 4 { vec![i + 1] } else { vec![] },
        ..Node::default()
    };
    let shows = Node { objects: vec![0], skin: Some(0), children: vec![1], ..Node::default() };
    let bound = |i: u32| Transform::from_translation(DVec3::new(0.0, 0.0, -2.0 * f64::from(i)));
    let graph = Graph {
        nodes: std::iter::once(shows).chain((1..5).map(joint)).collect(),
        roots: vec![0],
        skins: vec![Skin { joints: vec![1, 2, 3, 4], inverse_bind: (0..4).map(bound).collect() }],
    };
    let mesh = lodc_fixtures::named("skinned_tube_u8").expect("a shape");
    (mesh, Motion::new(graph, animations, 1))
}

#[test]
fn the_farthest_pose_comes_first_and_the_others_differ_from_it() {
    let (mesh, motion) = tube(vec![turning(3)]);
    let chosen = motion.choose(&[&mesh], 3).remove(0);
    let seconds = |pose_key: &PoseKey| match pose_key {
        PoseKey::Moment { animation: 0, seconds } => *seconds,
        other => panic!("{other:?}"),
    };
    let times: Vec<f64> = chosen.iter().map(seconds).collect();
    assert_eq!(times[0], 1.0, "where it is bent most");
    // The way back shows the same poses as the way there.
    assert!(times.len() == 3 && times[1..].iter().all(|t| *t < 1.0), "{times:?}");
    assert!(times[1] > 0.2 && times[1] < 0.8, "{times:?}");
    assert_eq!(motion.choose(&[&mesh], 1), [&chosen[..1]]);
    assert!(motion.choose(&[&mesh], 0)[0].is_empty());
}

#[test]
fn what_moves_as_a_whole_keeps_its_shape() {
    for node in [0, 1] {
        let (mesh, motion) = tube(vec![turning(node)]);
        assert!(motion.choose(&[&mesh], 8)[0].is_empty(), "node {node}");
    }
    let cube = lodc_fixtures::named("cube").expect("a shape");
    let node = Node { local: trs([0.0; 3]), objects: vec![0], ..Node::default() };
    let graph = Graph { nodes: vec![node], roots: vec![0], skins: Vec::new() };
    let motion = Motion::new(graph, vec![turning(0)], 1);
    assert!(motion.choose(&[&cube], 8)[0].is_empty());
}

#[test]
fn a_rig_without_animations_is_at_rest() {
    let (mesh, motion) = tube(vec![]);
    assert!(motion.choose(&[&mesh], 8)[0].is_empty());
}

#[test]
fn morph_targets_are_poses_that_need_no_animation() {
    let sphere = lodc_fixtures::named("morphing_sphere").expect("a shape");
    let graph = Graph::of_objects(1);
    let motion = Motion::new(graph, vec![], 1);
    let chosen = motion.choose(&[&sphere], 8).remove(0);
    // The first moves z by itself, the second x by a half.
    assert_eq!(chosen, [PoseKey::Target(0), PoseKey::Target(1)]);
    let shapes = motion.shapes(&sphere, 0, &chosen);
    let shapes = shapes.all();
    let height = |shape: &Shape| {
        let positions = shape.of(&sphere);
        positions.iter().map(|p| p[2]).fold(f32::MIN, f32::max)
    };
    assert_eq!(shapes.len(), 3);
    assert!((height(&shapes[1]) - 2.0 * height(&shapes[0])).abs() < 1e-5);
}

#[test]
fn moments_count_in_every_node_whose_weights_they_change() {
    let sphere = lodc_fixtures::named("morphing_sphere").expect("a shape");
    let node = || Node { objects: vec![0], weights: vec![0.0; 2], ..Node::default() };
    let graph = Graph { nodes: vec![node(), node(), node()], roots: vec![0, 1, 2], skins: vec![] };
    let weights = |node: u32, to: [f64; 2]| Channel {
        node,
        property: Property::Weights,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: [[0.0; 2], to].concat(),
    };
    let motion = |channels| {
        let animation = Animation { channels, ..Animation::default() };
        Motion::new(graph.clone(), vec![animation], 1)
    };
    let end = PoseKey::Moment { animation: 0, seconds: 1.0 };
    let shapes = |motion: &Motion| {
        let shapes = motion.shapes(&sphere, 0, &[end, PoseKey::Target(0), end]);
        let ends: Vec<(usize, usize)> = (0..6).map(|count| shapes.pose_keys_of(count)).collect();
        (shapes.of_placements().len(), shapes.of_pose_keys().len(), ends)
    };
    // The first node is at rest in both; two that move alike have one shape.
    let ends = [(0, 0), (1, 2), (1, 2), (2, 3), (3, 5), (3, 5)];
    let of_one = motion(vec![weights(2, [3.0, 0.0])]);
    assert_eq!(shapes(&of_one), (1, 5, ends.to_vec()));
    let alike = motion(vec![weights(1, [3.0, 0.0]), weights(2, [3.0, 0.0])]);
    assert_eq!(shapes(&alike), (1, 5, ends.to_vec()));
    assert_eq!(of_one.choose(&[&sphere], 1)[0], [end], "farther than either target");
    // The shapes are those of the nodes.
    let height = |shape: &Shape| {
        let positions = shape.of(&sphere);
        positions.iter().map(|p| p[2]).fold(f32::MIN, f32::max)
    };
    let shapes = of_one.shapes(&sphere, 0, &[end]);
    let [still, moved] = shapes.of_pose_keys() else { panic!("{shapes:?}") };
    assert!((height(moved) - 4.0 * height(still)).abs() < 1e-4);
}

#[test]
fn poses_are_as_large_as_at_rest() {
    let (mesh, mut motion) = tube(vec![turning(3)]);
    let chosen = motion.choose(&[&mesh], 1).remove(0);
    let shape = |motion: &Motion| motion.shapes(&mesh, 0, &chosen).all()[1].of(&mesh).into_owned();
    let before = shape(&motion);
    let Motion { mut graph, animations, .. } = motion;
    graph.nodes[0].local = LocalTransform::Matrix(Transform::from_scale(DVec3::splat(0.01)));
    motion = Motion::new(graph, animations, 1);
    for (a, b) in before.as_flattened().iter().zip(shape(&motion).as_flattened()) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
}

#[test]
fn the_number_of_threads_changes_no_choice() {
    let (mesh, motion) = tube(vec![turning(3), turning(2)]);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| motion.choose(&[&mesh], 8))
    };
    let one = with(1);
    assert!(one[0].len() > 4);
    assert!([2, 3, 8].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn shapes_of_targets_have_the_normals_that_these_turn() {
    let mesh = lodc_fixtures::named("morphing_sphere").expect("a shape");
    let node = Node { objects: vec![0], ..Node::default() };
    let graph = Graph { roots: vec![0], nodes: vec![node], skins: Vec::new() };
    let seen = Motion::new(graph, Vec::new(), 1).seen(&mesh, 0, &[]).expect("it has targets");
    assert!(seen.normals_at_rest.is_empty() && seen.targets.len() == 2);
    // The first stretches z by 1 and adds a quarter of it to the normal, the second acts on x.
    for (shape, factors) in seen.targets.iter().zip([[1.0, 1.0, 1.25], [0.875, 1.0, 1.0]]) {
        let is_turned = |(n, p): (&[f32; 3], &[f32; 3])| {
            let wanted = DVec3::from_array(std::array::from_fn(|k| f64::from(p[k]) * factors[k]));
            wanted.normalize().distance(DVec3::from_array(n.map(f64::from))) < 0.02
        };
        assert_eq!(shape.normals.len(), mesh.vertex_count());
        assert!(shape.normals.iter().zip(mesh.positions()).all(is_turned));
    }
}
