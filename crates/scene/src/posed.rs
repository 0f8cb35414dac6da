//! The vertices of an object in one placement, in world space: blended by morph targets, then moved
//! by joints or by its node (glTF 2.0, 3.7.2 and 3.7.3).

use crate::placement::{Arrangement, Placement};
use crate::transform::{Transform, transform_normal};
use glam::{DMat3, DVec3, Vec3};
use lodc_mesh::{Attribute, Mesh, Semantic};
use rayon::prelude::*;

/// Vertices in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedVertices {
    /// One per vertex; always finite.
    pub positions: Vec<DVec3>,
    /// Normals of the file, of any length; zero where a vertex has none.
    pub normals: Vec<DVec3>,
    /// True if the surface is turned inside out, so that the corners of its triangles must be taken
    /// the other way round.
    pub mirrored: bool,
}

/// Poses all vertices of a mesh.
#[must_use]
pub fn posed(mesh: &Mesh, placement: &Placement) -> PosedVertices {
    let streams = Streams::of(mesh, placement);
    let vertex = |v: u32| {
        let (position, transform) = posed_vertex(&streams, mesh, placement, v);
        let normal = streams.normal(mesh, v).map(|n| transform_normal(&transform.matrix3, n));
        (position, normal.unwrap_or(DVec3::ZERO))
    };
    let vertices = mesh.vertex_count() as u32;
    let (positions, normals) = (0..vertices).into_par_iter().map(vertex).unzip();
    PosedVertices { positions, normals, mirrored: mirrored(mesh, placement, &streams) }
}

/// Poses all vertices of a mesh, without their normals: [`PosedVertices::positions`].
#[must_use]
pub fn posed_positions(mesh: &Mesh, placement: &Placement) -> Vec<DVec3> {
    let streams = Streams::of(mesh, placement);
    let vertices = mesh.vertex_count() as u32;
    (0..vertices).into_par_iter().map(|v| posed_vertex(&streams, mesh, placement, v).0).collect()
}

/// Returns whether every vertex of a mesh follows one of a skin's `joints`: those that have weights
/// for none of them are placed by their node.
#[must_use]
pub fn follows_joints(mesh: &Mesh, joints: usize) -> bool {
    let streams = Streams::of(mesh, &Placement::as_modelled(0));
    (0..mesh.vertex_count() as u32).into_par_iter().all(|v| {
        let mut total = 0.0;
        streams.each_joint(mesh, v, |joint, weight| {
            if joint < joints {
                total += weight;
            }
        });
        total > 0.0
    })
}

/// Returns about which point a scene is to be looked at in single precision: its middle, where
/// coordinates are so large that single precision would round them by more than a ten-millionth of
/// its extent, else the origin. `mesh` returns that of an object.
pub fn centre<'m>(scene: &Arrangement, mesh: impl Fn(usize) -> &'m Mesh) -> [f64; 3] {
    const MAX_ROUNDING: f64 = 1e-7;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut add = |p: DVec3| {
        if p.is_finite() {
            (low, high) = (low.min(p), high.max(p));
        }
    };
    for placement in scene.placements() {
        let mesh = mesh(placement.object);
        if placement.joints.is_empty() {
            let (lowest, highest) = mesh.bounds();
            let end = |k: usize, bit: usize| f64::from([lowest, highest][bit][k]);
            let corner = |i: usize| std::array::from_fn::<f64, 3, _>(|k| end(k, i >> k & 1));
            let placed = |i: usize| placement.transform.transform_point3(corner(i).into());
            (0..8).map(placed).for_each(&mut add);
        } else {
            posed_positions(mesh, placement).into_iter().for_each(&mut add);
        }
    }
    let largest = low.abs().max(high.abs()).max_element();
    let rounding = f64::from(f32::EPSILON) / 2.0 * largest;
    let is_far = rounding.is_finite() && rounding > MAX_ROUNDING * (high - low).length();
    if is_far { (0.5 * (low + high)).to_array() } else { [0.0; 3] }
}

/// Returns the position of a vertex in world space, and its transform.
pub(crate) fn posed_vertex(
    streams: &Streams<'_>,
    mesh: &Mesh,
    placement: &Placement,
    v: u32,
) -> (DVec3, Transform) {
    let transform = streams.transform(mesh, placement, v);
    (transformed(&transform, streams.position(mesh, v)), transform)
}

/// Transforms a position; one that overflows becomes zero.
pub(crate) fn transformed(transform: &Transform, position: DVec3) -> DVec3 {
    let position = transform.transform_point3(position);
    // Where it is drawn does not matter, but it must not spoil cameras and bounds.
    if position.is_finite() { position } else { DVec3::ZERO }
}

/// Returns true if the transforms of most vertices mirror.
fn mirrored(mesh: &Mesh, placement: &Placement, streams: &Streams<'_>) -> bool {
    if placement.joints.is_empty() {
        return placement.transform.matrix3.determinant() < 0.0;
    }
    let vertices = mesh.vertex_count() as u32;
    let mirrors = |&v: &u32| streams.transform(mesh, placement, v).matrix3.determinant() < 0.0;
    2 * (0..vertices).into_par_iter().filter(mirrors).count() > vertices as usize
}

/// The streams of a mesh that posing reads.
pub(crate) struct Streams<'a> {
    /// For each submesh the stream of its normals.
    normals: Vec<Option<&'a Attribute>>,
    /// For each submesh the streams of joints and of weights of every set.
    joints: Vec<Vec<[&'a Attribute; 2]>>,
    /// For each submesh the deltas of positions, and those of normals: the weight and the stream of
    /// each morph target whose weight is not 0.
    deltas: Vec<[Vec<(f64, &'a Attribute)>; 2]>,
}

impl<'a> Streams<'a> {
    pub(crate) fn of(mesh: &'a Mesh, placement: &Placement) -> Self {
        let submeshes = 0..mesh.submeshes().len();
        let find = |s: usize, semantic: Semantic| stream(mesh, s, &semantic);
        let joints = |s: usize| {
            let set =
                |set| Some([find(s, Semantic::Joints(set))?, find(s, Semantic::Weights(set))?]);
            (0..).map_while(set).collect()
        };
        let deltas = |s: usize| {
            [Semantic::Position, Semantic::Normal].map(|semantic| {
                let weight =
                    |a: &Attribute| placement.weights.get(a.morph_target? as usize).copied();
                let all = attributes(mesh, s).filter(|a| a.semantic == semantic);
                all.filter_map(|a| Some((weight(a)?, a))).filter(|(w, _)| *w != 0.0).collect()
            })
        };
        Self {
            normals: submeshes.clone().map(|s| find(s, Semantic::Normal)).collect(),
            joints: submeshes.clone().map(joints).collect(),
            deltas: submeshes.map(deltas).collect(),
        }
    }

    /// Returns the position with morph targets, before joints or the node move it.
    pub(crate) fn position(&self, mesh: &Mesh, v: u32) -> DVec3 {
        let rest = Vec3::from(mesh.positions()[v as usize]).as_dvec3();
        morphed(rest, &self.deltas[submesh(mesh, v)][0], v)
    }

    /// Returns the normal with morph targets, of any length; none of a vertex without one.
    pub(crate) fn normal(&self, mesh: &Mesh, v: u32) -> Option<DVec3> {
        let stream = self.normals[submesh(mesh, v)]?;
        Some(morphed(vector(stream, v), &self.deltas[submesh(mesh, v)][1], v))
    }

    /// Returns the transform of a vertex: the weighted mean of its joints' transforms; the node's
    /// transform without a skin, or if the vertex has no weight at all.
    pub(crate) fn transform(&self, mesh: &Mesh, placement: &Placement, v: u32) -> Transform {
        let mut sum = Transform { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
        let mut total = 0.0;
        if placement.joints.is_empty() {
            return placement.transform;
        }
        self.each_joint(mesh, v, |joint, weight| {
            // A joint that does not exist moves nothing.
            if let Some(joint) = placement.joints.get(joint) {
                total += weight;
                sum.matrix3 += joint.matrix3 * weight;
                sum.translation += joint.translation * weight;
            }
        });
        if total > 0.0 {
            Transform { matrix3: sum.matrix3 * (1.0 / total), translation: sum.translation / total }
        } else {
            placement.transform
        }
    }

    /// Calls `visit` with the joints of a vertex and their weights, which are not zero.
    pub(crate) fn each_joint(&self, mesh: &Mesh, v: u32, mut visit: impl FnMut(usize, f64)) {
        for [joint, weight] in &self.joints[submesh(mesh, v)] {
            for i in 0..usize::from(joint.components.min(weight.components)) {
                let w = f64::from(weight.value(v, i));
                if w != 0.0 {
                    visit(joint.value(v, i) as usize, w);
                }
            }
        }
    }
}

fn submesh(mesh: &Mesh, v: u32) -> usize {
    mesh.vertex_submesh()[v as usize] as usize
}

fn attributes(mesh: &Mesh, submesh: usize) -> impl Iterator<Item = &Attribute> {
    mesh.submeshes()[submesh].attributes.iter().map(|&a| &mesh.attributes()[a as usize])
}

/// Returns the stream of a submesh with a meaning; never one of morph targets' deltas.
#[must_use]
pub fn stream<'a>(mesh: &'a Mesh, submesh: usize, semantic: &Semantic) -> Option<&'a Attribute> {
    attributes(mesh, submesh).find(|a| a.semantic == *semantic && a.morph_target.is_none())
}

pub(crate) fn vector(stream: &Attribute, v: u32) -> DVec3 {
    let component = |i: usize| {
        if i < usize::from(stream.components) { f64::from(stream.value(v, i)) } else { 0.0 }
    };
    DVec3::new(component(0), component(1), component(2))
}

fn morphed(rest: DVec3, deltas: &[(f64, &Attribute)], v: u32) -> DVec3 {
    deltas.iter().fold(rest, |sum, (weight, stream)| sum + *weight * vector(stream, v))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shifted(x: f64) -> Transform {
        Transform::from_translation(DVec3::new(x, 0.0, 0.0))
    }

    #[test]
    fn joints_move_vertices_and_their_node_does_not() {
        let mesh = lodc_fixtures::named("skinned_tube_u8").expect("a shape");
        let placement = Placement {
            transform: shifted(100.0),
            joints: vec![shifted(3.0); 8].into(),
            ..Placement::as_modelled(0)
        };
        let posed = posed(&mesh, &placement);
        // All joints move alike, so that weights do not matter.
        for (p, q) in mesh.positions().iter().zip(&posed.positions) {
            let expected = Vec3::from(*p).as_dvec3() + DVec3::new(3.0, 0.0, 0.0);
            assert!(q.abs_diff_eq(expected, 1e-9), "{q} {expected}");
        }
        assert!(!posed.mirrored);
    }

    #[test]
    fn morph_targets_are_blended_by_weight() {
        let mesh = lodc_fixtures::named("morphing_sphere").expect("a shape");
        let at = |weights: Vec<f64>| {
            let placement = Placement { weights: weights.into(), ..Placement::as_modelled(0) };
            posed(&mesh, &placement).positions
        };
        let (rest, half, full) = (at(vec![0.0; 4]), at(vec![0.5]), at(vec![1.0]));
        assert_ne!(rest, full);
        for ((a, b), c) in rest.iter().zip(&half).zip(&full) {
            assert!(((a + c) / 2.0).abs_diff_eq(*b, 1e-9));
        }
    }

    #[test]
    fn mirrored_joints_turn_the_surface_inside_out() {
        let mesh = lodc_fixtures::named("skinned_tube_u8").expect("a shape");
        let mirror = Transform::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let skinned = Placement { joints: vec![mirror; 8].into(), ..Placement::as_modelled(0) };
        assert!(posed(&mesh, &skinned).mirrored);
        let placed = Placement { transform: mirror, ..Placement::as_modelled(0) };
        assert!(posed(&mesh, &placed).mirrored);
    }
}
