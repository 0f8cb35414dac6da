//! The shape that a scene gives an object, in the object's own units.

use crate::placement::{Arrangement, Placement};
use crate::posed::posed;
use crate::scale::representative;
use glam::{DMat3, DVec3};
use lodc_mesh::{Mesh, Semantic};
use std::borrow::Cow;

/// Deviation from a similarity, relative to its scale, that is taken for rounding.
const ROUNDING: f64 = 1e-6;

/// Returns the surface of an object at the placement that shows it largest, in mesh units: world
/// positions divided by that placement's scale, up to a motion. Those of the mesh where the scene
/// moves, turns, mirrors and scales it as a whole; else, bent by joints or morph targets or
/// stretched, around their middle. All finite if those of the mesh are.
#[must_use]
pub fn shape_in_scene<'a>(
    mesh: &'a Mesh,
    object: usize,
    scene: &Arrangement,
) -> Cow<'a, [[f32; 3]]> {
    let as_modelled = Cow::Borrowed(mesh.positions());
    let (Some(placement), scale) = representative(mesh, object, scene) else { return as_modelled };
    if !bends(mesh, placement) && is_similarity(&placement.transform.matrix3, scale) {
        return as_modelled;
    }
    let posed = posed(mesh, placement).positions;
    let (low, high) = posed
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let middle = low.midpoint(high);
    let place = |p: &DVec3| ((*p - middle) / scale).as_vec3();
    let places: Vec<[f32; 3]> = posed.iter().map(|p| place(p).to_array()).collect();
    if places.as_flattened().iter().all(|x| x.is_finite()) {
        Cow::Owned(places)
    } else {
        as_modelled
    }
}

/// Returns whether a placement moves vertices by more than one transform.
fn bends(mesh: &Mesh, placement: &Placement) -> bool {
    let moves = |semantic: &Semantic, target: Option<u32>| {
        let weight = |t: u32| placement.weights.get(t as usize).is_some_and(|&w| w != 0.0);
        *semantic == Semantic::Position && target.is_some_and(weight)
    };
    !placement.joints.is_empty()
        || mesh.attributes().iter().any(|a| moves(&a.semantic, a.morph_target))
}

/// Returns whether a matrix scales all directions alike.
fn is_similarity(m: &DMat3, scale: f64) -> bool {
    let gram = (m.transpose() * *m) * (1.0 / (scale * scale));
    (gram - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() <= ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, LocalTransform, Node};

    fn shown(scale: [f64; 3]) -> (Mesh, Arrangement) {
        let local = LocalTransform::Trs {
            translation: [1000.0, 0.0, 0.0],
            rotation: [0.6, 0.0, 0.0, 0.8],
            scale,
        };
        let node = Node { local, objects: vec![0], ..Node::default() };
        let graph = Graph { nodes: vec![node], roots: vec![0], skins: Vec::new() };
        let scene = Arrangement::new(&graph, &graph.rest_pose(), 1);
        (lodc_fixtures::named("cube").expect("a shape"), scene)
    }

    #[test]
    fn what_is_moved_as_a_whole_keeps_its_positions() {
        let (mesh, scene) = shown([-3.0, 3.0, 3.0]);
        assert!(matches!(shape_in_scene(&mesh, 0, &scene), Cow::Borrowed(_)));
        assert_eq!(*shape_in_scene(&mesh, 0, &scene), *mesh.positions());
    }

    #[test]
    fn what_is_stretched_is_as_large_as_the_mesh_along_its_longest_stretch() {
        let (mesh, scene) = shown([4.0, 2.0, 2.0]);
        let extent = |places: &[[f32; 3]], axis: usize| {
            let along = places.iter().map(|p| p[axis]);
            along.clone().fold(f32::MIN, f32::max) - along.fold(f32::MAX, f32::min)
        };
        let length = |places: &[[f32; 3]]| (0..3).map(|k| extent(places, k).powi(2)).sum::<f32>();
        let shape = shape_in_scene(&mesh, 0, &scene);
        assert!((extent(&shape, 0) - extent(mesh.positions(), 0)).abs() < 1e-4);
        assert!(length(&shape) < length(mesh.positions()));
    }
}
