//! The shape of an object in one pose of the scene, in the object's own units: what errors are
//! measured on.

use crate::placement::Placement;
use crate::posed::posed_positions;
use glam::{DMat3, DVec3};
use lodc_mesh::{Mesh, Semantic};
use std::borrow::Cow;

/// Largest deviation from a similarity, relative to its scale, that counts as rounding. Chosen by
/// hand, between the rounding of floats in files and any stretch that is meant.
const MAX_ROUNDING: f64 = 1e-6;

/// The shape that a placement gives an object. It maps the positions of the object, or of a level
/// of it, to mesh units: world positions relative to the middle of the object's box, divided by the
/// world scale of the object.
#[derive(Clone, Debug)]
pub struct Shape {
    /// None for an object that keeps its positions.
    placement: Option<Placement>,
    /// World units per unit of the shape.
    scale: f64,
    /// The middle of the object's bounding box, in world units.
    middle: DVec3,
}

impl Shape {
    /// The positions of the mesh as they are.
    pub const AS_MODELLED: Self = Self { placement: None, scale: 1.0, middle: DVec3::ZERO };

    /// The shape of an object in a placement, `scale` world units being one unit. The object keeps
    /// its positions if the placement only moves, turns, mirrors and scales it as a whole by
    /// `scale`. None if coordinates are not finite.
    pub(crate) fn shown(mesh: &Mesh, placement: &Placement, scale: f64) -> Option<Self> {
        if !bends(mesh, placement) && is_similarity(&placement.transform.matrix3, scale) {
            return Some(Self::AS_MODELLED);
        }
        Self::placed(mesh, placement.clone(), scale)
    }

    /// As [`Self::shown`], with the positions of the placement in any case.
    pub(crate) fn placed(mesh: &Mesh, placement: Placement, scale: f64) -> Option<Self> {
        let posed = posed_positions(mesh, &placement);
        let (low, high) = posed
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let shape = Self { placement: Some(placement), scale, middle: low.midpoint(high) };
        let is_finite = |p| shape.to_mesh_units(p).iter().all(|x| x.is_finite());
        ([low, high].into_iter().all(is_finite) || posed.is_empty()).then_some(shape)
    }

    /// Returns whether the object keeps its positions.
    #[must_use]
    pub fn is_as_modelled(&self) -> bool {
        self.placement.is_none()
    }

    /// Returns the positions of the vertices of the object, or of another mesh with its attributes.
    #[must_use]
    pub fn of<'a>(&self, mesh: &'a Mesh) -> Cow<'a, [[f32; 3]]> {
        let Some(placement) = &self.placement else { return Cow::Borrowed(mesh.positions()) };
        let posed = posed_positions(mesh, placement);
        Cow::Owned(posed.into_iter().map(|p| self.to_mesh_units(p)).collect())
    }

    fn to_mesh_units(&self, p: DVec3) -> [f32; 3] {
        ((p - self.middle) / self.scale).as_vec3().to_array()
    }
}

/// Returns whether a placement may move vertices by more than one transform: by joints or morph
/// targets.
fn bends(mesh: &Mesh, placement: &Placement) -> bool {
    let moves = |semantic: &Semantic, target: Option<u32>| {
        let weight = |t: u32| placement.weights.get(t as usize).is_some_and(|&w| w != 0.0);
        *semantic == Semantic::Position && target.is_some_and(weight)
    };
    !placement.joints.is_empty()
        || mesh.attributes().iter().any(|a| moves(&a.semantic, a.morph_target))
}

/// Returns whether a matrix scales all directions by `scale`.
fn is_similarity(m: &DMat3, scale: f64) -> bool {
    let gram = (m.transpose() * *m) * (1.0 / (scale * scale));
    (gram - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() <= MAX_ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LocalTransform, Transform};

    fn shown(scale: [f64; 3]) -> (Mesh, Placement) {
        let local = LocalTransform::Trs {
            translation: [1000.0, 0.0, 0.0],
            rotation: [0.6, 0.0, 0.0, 0.8],
            scale,
        };
        let transform: Transform = local.matrix();
        let placement = Placement { transform, ..Placement::as_modelled(0) };
        (lodc_fixtures::named("cube").expect("a shape"), placement)
    }

    #[test]
    fn what_is_moved_as_a_whole_keeps_its_positions() {
        let (mesh, placement) = shown([-3.0, 3.0, 3.0]);
        let shape = Shape::shown(&mesh, &placement, 3.0).expect("finite");
        assert!(matches!(shape.of(&mesh), Cow::Borrowed(p) if p == mesh.positions()));
        // In other units it does not.
        let shape = Shape::shown(&mesh, &placement, 2.0).expect("finite");
        assert!(matches!(shape.of(&mesh), Cow::Owned(_)));
    }

    #[test]
    fn what_is_stretched_is_as_large_as_the_mesh_along_its_longest_stretch() {
        let (mesh, placement) = shown([4.0, 2.0, 2.0]);
        let extent = |positions: &[[f32; 3]], axis: usize| {
            let along = positions.iter().map(|p| p[axis]);
            along.clone().fold(f32::MIN, f32::max) - along.fold(f32::MAX, f32::min)
        };
        let length =
            |positions: &[[f32; 3]]| (0..3).map(|k| extent(positions, k).powi(2)).sum::<f32>();
        let shape = Shape::shown(&mesh, &placement, 4.0).expect("finite");
        let shape = shape.of(&mesh);
        assert!((extent(&shape, 0) - extent(mesh.positions(), 0)).abs() < 1e-4);
        assert!(length(&shape) < length(mesh.positions()));
    }
}
