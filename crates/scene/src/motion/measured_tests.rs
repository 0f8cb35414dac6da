//! Placements that stand for others: alike, unlike, many, animated, with joints.

use super::*;
use crate::{Animation, Channel, Graph, Interpolation, LocalTransform, Node, Property, Skin};
use glam::DVec3;
use lodc_mesh::SplitMix64;

fn cube() -> Mesh {
    lodc_fixtures::named("cube").expect("a shape")
}

fn trs(rotation: [f64; 4], scale: [f64; 3]) -> LocalTransform {
    LocalTransform::Trs { translation: [1.0, 2.0, 3.0], rotation, scale }
}

const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// A scene of nodes that each show object 0.
fn showing(locals: impl IntoIterator<Item = LocalTransform>) -> Graph {
    let node = |local| Node { local, objects: vec![0], ..Node::default() };
    let nodes: Vec<Node> = locals.into_iter().map(node).collect();
    Graph { roots: (0..nodes.len() as u32).collect(), nodes, skins: Vec::new() }
}

fn measured(graph: Graph, animations: Vec<Animation>) -> MeasuredPlacements {
    Motion::new(graph, animations, 1).measured_placements(&cube(), 0)
}

fn scaled(node: u32, interpolation: Interpolation, keys: &[(f64, &[[f64; 3]])]) -> Channel {
    let times = keys.iter().map(|key| key.0).collect();
    let values = keys.iter().flat_map(|key| key.1.as_flattened()).copied().collect();
    Channel { node, property: Property::Scale, interpolation, times, values }
}

fn animation(channels: Vec<Channel>) -> Vec<Animation> {
    vec![Animation { channels, ..Animation::default() }]
}

#[test]
fn one_placement_stands_for_turned_mirrored_and_smaller_ones() {
    let all = measured(
        showing([
            trs(UPRIGHT, [2.0; 3]),
            trs([0.5; 4], [-7.0, 7.0, 7.0]),
            trs([0.6, 0.0, 0.0, 0.8], [7.0, 7.0, -7.0]),
            trs([0.1, 0.5, 0.2, 0.3], [6.0, 0.01, 5.0]),
            trs(UPRIGHT, [0.0, 1.0, 1.0]),
        ]),
        vec![],
    );
    assert!((all.scale - 7.0).abs() < 1e-12);
    assert!(all.unevenness - 1.0 < 1e-9 && all.looseness == 1.0, "{all:?}");
    let [one] = &all.placements[..] else { panic!("{all:?}") };
    assert_eq!((one.placement.node, one.growth), (Some(1), 1.0));
}

#[test]
fn what_a_flat_placement_hides_is_measured_in_another() {
    let shadow = trs(UPRIGHT, [1.0, 0.001, 1.0]);
    let all = measured(showing([shadow, trs([0.5; 4], [0.25; 3])]), vec![]);
    let nodes: Vec<Option<u32>> = all.placements.iter().map(|at| at.placement.node).collect();
    assert_eq!(nodes, [Some(0), Some(1)]);
    assert_eq!(all.scale, 1.0);
    // The small one may err by as much as is stated, four times its scale.
    assert!((all.unevenness - 4.0).abs() < 1e-9, "{all:?}");
}

#[test]
fn few_of_many_placements_bound_all() {
    let mut random = SplitMix64::new(9);
    let mut number = |low: f64, high: f64| low + (high - low) * f64::from(random.unit());
    for lowest in [0.8, 0.05] {
        let locals: Vec<LocalTransform> = (0..300)
            .map(|_| {
                let rotation = [0; 4].map(|_| number(-1.0, 1.0));
                trs(rotation, [0; 3].map(|_| number(lowest, 1.2)))
            })
            .collect();
        // Two nodes above each other shear.
        let mut graph = showing(locals);
        for child in 1..150 {
            graph.nodes[child - 1].children.push(150 + child as u32);
        }
        graph.roots = graph.topmost();
        let motion = Motion::new(graph, vec![], 1);
        let all = motion.measured_placements(&cube(), 0);
        assert!(all.placements.len() <= MAX_PLACEMENTS && all.looseness >= 1.0);
        for placement in motion.rest().of(0) {
            let of = |at: &MeasuredPlacement| {
                let map = placement.transform.matrix3 * at.placement.transform.matrix3.inverse();
                largest_stretch(&map) / at.growth
            };
            let bound = all.placements.iter().map(of).fold(f64::INFINITY, f64::min);
            assert!(bound <= 1.0 + 1e-5, "{bound}");
            // A bound of its own, from its own stretch.
            let stretch = largest_stretch(&placement.transform.matrix3);
            assert!(bound * all.scale <= stretch * all.unevenness * (1.0 + 1e-5));
        }
        assert!(all.looseness < if lowest > 0.5 { 1.3 } else { 4.0 }, "{}", all.looseness);
    }
}

#[test]
fn an_object_is_measured_at_the_moment_when_it_is_largest() {
    for rest in [0.001, 0.0] {
        let graph = showing([trs(UPRIGHT, [rest; 3])]);
        let grows = scaled(
            0,
            Interpolation::Linear,
            &[(0.0, &[[rest; 3]]), (0.47, &[[3.0; 3]]), (9.0, &[[rest; 3]])],
        );
        let motion = Motion::new(graph, animation(vec![grows]), 1);
        let all = motion.measured_placements(&cube(), 0);
        let [one] = &all.placements[..] else { panic!("{all:?}") };
        let moment = PoseKey::Moment { animation: 0, seconds: 0.47 };
        assert_eq!((one.stretch, all.scale), (Stretch::At(moment), 3.0));
        let shapes = motion.shapes(&cube(), 0, &[]);
        assert_eq!(shapes.all().len(), 1);
        assert_eq!(*shapes.all()[0].of(&cube()), *cube().positions(), "as modelled");
        let largest = motion.largest();
        assert_eq!(
            largest.placements()[0].transform.matrix3,
            DMat3::from_diagonal(DVec3::splat(3.0))
        );
    }
}

#[test]
fn scales_along_a_chain_are_multiplied_between_their_keys_too() {
    // One shrinks while the other grows: the product is largest halfway.
    let mut graph = showing([LocalTransform::default(), trs(UPRIGHT, [1.0; 3])]);
    graph.nodes[0] = Node { local: trs(UPRIGHT, [1.0; 3]), children: vec![1], ..Node::default() };
    graph.roots = vec![0];
    let ramp = |node, from: f64, to: f64| {
        scaled(node, Interpolation::Linear, &[(0.0, &[[from; 3]]), (2.0, &[[to; 3]])])
    };
    let all = measured(graph, animation(vec![ramp(0, 1.0, 9.0), ramp(1, 9.0, 1.0)]));
    assert!((all.scale - 25.0).abs() < 1e-9, "{all:?}");
}

#[test]
fn a_spline_counts_where_it_goes_beyond_its_keys() {
    let (none, one, steep) = ([0.0; 3], [1.0; 3], [8.0; 3]);
    let keys: [(f64, &[[f64; 3]]); 2] =
        [(0.0, &[none, one, steep]), (1.0, &[[-8.0; 3], one, none])];
    let all = measured(
        showing([trs(UPRIGHT, [1.0; 3])]),
        animation(vec![scaled(0, Interpolation::CubicSpline, &keys)]),
    );
    assert!((all.scale - 3.0).abs() < 1e-9, "{all:?}");
}

#[test]
fn instances_are_stretched_with_their_node() {
    let mut graph = showing([trs(UPRIGHT, [1.0; 3])]);
    let instance = |s: f64| Transform::from_scale(DVec3::new(s, 1.0, 1.0));
    graph.nodes[0].instances = Some(vec![instance(0.5), instance(2.0)]);
    let squash: &[(f64, &[[f64; 3]])] = &[(0.0, &[[1.0; 3]]), (1.0, &[[1.0, 6.0, 1.0]])];
    let all = measured(graph, animation(vec![scaled(0, Interpolation::Linear, squash)]));
    assert!((all.scale - 6.0).abs() < 1e-9, "{all:?}");
    let [one] = &all.placements[..] else { panic!("{all:?}") };
    assert_eq!((one.placement.instance, one.stretch != Stretch::AtRest), (1, true));
}

/// A tube at two nodes with skins of their own, the joints of the second changed.
fn two_rigs(change: impl Fn(usize) -> Transform) -> MeasuredPlacements {
    let mesh = lodc_fixtures::named("skinned_tube_u8").expect("a shape");
    let joint = |local| Node { local: LocalTransform::Matrix(local), ..Node::default() };
    let at = |i: usize| Transform::from_translation(DVec3::new(0.0, 0.0, 2.0 * i as f64));
    let shows = |skin| Node { objects: vec![0], skin: Some(skin), ..Node::default() };
    let nodes = [shows(0), shows(1)].into_iter();
    let nodes = nodes.chain((0..4).map(|i| joint(at(i))));
    let nodes = nodes.chain((0..4).map(|i| joint(change(i) * at(i))));
    let inverse_bind: Vec<Transform> = (0..4).map(|i| at(i).inverse()).collect();
    let skin = |joints: std::ops::Range<u32>| Skin {
        joints: joints.collect(),
        inverse_bind: inverse_bind.clone(),
    };
    let skins = vec![skin(2..6), skin(6..10)];
    let graph = Graph { nodes: nodes.collect(), roots: vec![0, 1], skins };
    Motion::new(graph, vec![], 1).measured_placements(&mesh, 0)
}

#[test]
fn rigs_are_alike_if_one_map_takes_each_joint_to_the_others() {
    let turn = trs([0.5; 4], [100.0; 3]).matrix();
    let alike = two_rigs(|_| turn);
    let [one] = &alike.placements[..] else { panic!("{alike:?}") };
    assert_eq!(one.placement.node, Some(1));
    assert!((alike.scale - 100.0).abs() < 1e-9);
    // One that is bent as well is another shape, and so is what it is bent from.
    let bent =
        two_rigs(
            |i| if i < 2 { turn } else { turn * trs([0.6, 0.0, 0.0, 0.8], [1.0; 3]).matrix() },
        );
    assert_eq!(bent.placements.len(), 2, "{bent:?}");
    assert!((bent.unevenness - 100.0).abs() < 1e-6);
}

fn turned(node: u32, interpolation: Interpolation, keys: &[[f64; 4]]) -> Channel {
    let per_key = interpolation.values_per_key();
    let times = (0..keys.len() / per_key).map(|key| key as f64).collect();
    let values = keys.as_flattened().to_vec();
    Channel { node, property: Property::Rotation, interpolation, times, values }
}

/// A chain of nodes, the last of which shows object 0.
fn chain(scales: &[[f64; 3]]) -> Graph {
    let mut graph = showing(scales.iter().map(|&scale| trs(UPRIGHT, scale)));
    let last = graph.nodes.len() - 1;
    for (n, node) in graph.nodes[..last].iter_mut().enumerate() {
        (node.objects, node.children) = (vec![], vec![n as u32 + 1]);
    }
    graph.roots = vec![0];
    graph
}

/// The largest factor by which any vector is longer at some moment than what is measured.
fn excess(motion: &Motion, animations: u32) -> f64 {
    let all = motion.measured_placements(&cube(), 0);
    assert!(all.is_whole && all.placements.len() <= MAX_PLACEMENTS, "{all:?}");
    let rest = motion.rest().of(0).next().expect("a placement");
    let mut most = 0.0f64;
    for animation in 0..animations {
        for seconds in (0..=1500).map(|i| f64::from(i) / 499.0) {
            let moment = PoseKey::Moment { animation, seconds };
            let shown = motion.shown_at(rest, moment).expect("a moment").transform.matrix3;
            let of = |at: &MeasuredPlacement| {
                largest_stretch(&(shown * at.placement.transform.matrix3.inverse())) / at.growth
            };
            most = most.max(all.placements.iter().map(of).fold(f64::INFINITY, f64::min));
        }
    }
    most
}

#[test]
fn what_turns_below_an_uneven_scale_is_bounded_at_every_moment() {
    const HALF_TURN: [f64; 4] = [0.0, 0.0, 1.0, 0.0];
    for (scale, shapes) in [([10.0, 0.1, 1.0], 1), ([3.0, 1.0, 1.0], 1), ([1.02, 1.0, 1.0], 1)] {
        let turn = turned(1, Interpolation::Linear, &[UPRIGHT, HALF_TURN]);
        let motion = Motion::new(chain(&[scale, [1.0; 3]]), animation(vec![turn]), 1);
        let all = motion.measured_placements(&cube(), 0);
        assert!(excess(&motion, 1) <= 1.0 + 1e-6, "{all:?}");
        // A disc as large as the longest stretch is all that it ever fills.
        assert_eq!(all.placements.len(), shapes, "{all:?}");
        assert!(all.scale <= 1.03 * scale[0], "{all:?}");
        let linear = all.placements[0].placement.transform.matrix3;
        assert!((linear * DVec3::Z).length() <= 1.05, "{all:?}");
    }
}

#[test]
fn every_moment_of_a_chain_is_bounded_whatever_moves_in_it() {
    let mut random = SplitMix64::new(3);
    let mut number = |low: f64, high: f64| low + (high - low) * f64::from(random.unit());
    let kinds = [Interpolation::Linear, Interpolation::Step, Interpolation::CubicSpline];
    for round in 0..24 {
        let scales = [0; 4].map(|_| [0; 3].map(|_| number(0.3, 2.0)));
        let mut animations = Vec::new();
        for which in 0..1 + round % 2 {
            let mut channels = Vec::new();
            for node in 0..4 {
                let interpolation = kinds[(round + node + which) % 3];
                let values = 4 * interpolation.values_per_key();
                if number(0.0, 1.0) < 0.6 {
                    let keys: Vec<[f64; 4]> =
                        (0..values).map(|_| [0; 4].map(|_| number(-1.0, 1.0))).collect();
                    channels.push(turned(node as u32, interpolation, &keys));
                }
                if number(0.0, 1.0) < 0.3 {
                    let keys = (0..values).flat_map(|_| [0; 3].map(|_| number(0.2, 2.0)));
                    channels.push(Channel {
                        node: node as u32,
                        property: Property::Scale,
                        interpolation,
                        times: (0..4).map(f64::from).collect(),
                        values: keys.collect(),
                    });
                }
            }
            animations.push(Animation { channels, ..Animation::default() });
        }
        let count = animations.len() as u32;
        let motion = Motion::new(chain(&scales), animations, 1);
        let excess = excess(&motion, count);
        assert!(excess <= 1.0 + 2e-3, "round {round}: {excess}");
    }
}

#[test]
fn a_scale_that_goes_from_one_axis_to_another_counts_between() {
    // Both keys hide what is halfway.
    let keys: [(f64, &[[f64; 3]]); 2] = [(0.0, &[[1.0, 0.01, 1.0]]), (1.0, &[[0.01, 1.0, 1.0]])];
    let swap = scaled(0, Interpolation::Linear, &keys);
    let motion = Motion::new(showing([trs(UPRIGHT, keys[0].1[0])]), animation(vec![swap]), 1);
    assert!(excess(&motion, 1) <= 1.0 + 1e-3);
    assert!(motion.measured_placements(&cube(), 0).scale < 1.1);
}

#[test]
fn too_many_moments_are_said() {
    let keys: Vec<[f64; 4]> =
        (0..40_000).map(|i| if i % 2 == 0 { UPRIGHT } else { [0.0, 0.0, 1.0, 0.0] }).collect();
    let turn = turned(1, Interpolation::Linear, &keys);
    let all = measured(chain(&[[2.0, 1.0, 1.0], [1.0; 3]]), animation(vec![turn]));
    assert!(!all.is_whole);
}
