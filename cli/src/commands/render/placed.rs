//! The vertices of an object where a scene shows it: moved by a node, or by joints, and by morph
//! targets before.

use lodc_formats::appearance::Placement;
use lodc_mesh::{Attribute, Mesh, Semantic};
use rayon::prelude::*;

/// An affine transformation: three rows.
type Affine = [[f64; 4]; 3];

/// Vertices in the space of the scene.
pub(super) struct Placed {
    /// One per vertex.
    pub(super) positions: Vec<[f64; 3]>,
    /// Normals of the file, of any length; zero where a vertex has none.
    pub(super) normals: Vec<[f32; 3]>,
    /// Whether the surface is turned inside out, so that corners must be taken the other way round.
    pub(super) mirrored: bool,
}

/// Places all vertices of a mesh. With `normals`, those of the file too.
pub(super) fn placed(mesh: &Mesh, placement: &Placement, normals: bool) -> Placed {
    let streams = Streams::of(mesh, placement);
    let node = rows(&placement.matrix);
    let joints: Vec<Affine> = placement.joints.iter().map(rows).collect();
    let vertices = 0..mesh.vertex_count() as u32;
    let place = |v: u32| {
        let matrix = if joints.is_empty() {
            node
        } else {
            streams.blended(mesh, v, &joints).unwrap_or(node)
        };
        let position = apply(&matrix, streams.position(mesh, v), 1.0);
        let normal = match streams.normal(mesh, v) {
            Some(n) if normals => turned(&matrix, n).map(|c| c as f32),
            _ => [0.0; 3],
        };
        (position, normal)
    };
    let (positions, normals) = vertices.into_par_iter().map(place).unzip();
    Placed { positions, normals, mirrored: joints.is_empty() && determinant(&node) < 0.0 }
}

/// Where in a mesh things are.
struct Streams<'a> {
    /// For each submesh, its normals.
    normals: Vec<Option<&'a Attribute>>,
    /// For each submesh, joints and weights of every set.
    joints: Vec<Vec<[&'a Attribute; 2]>>,
    /// For each submesh, moves of positions and of normals by morph targets, with how much of them
    /// counts.
    moves: Vec<[Vec<(f64, &'a Attribute)>; 2]>,
}

impl<'a> Streams<'a> {
    fn of(mesh: &'a Mesh, placement: &Placement) -> Self {
        let submeshes = 0..mesh.submeshes().len();
        let find = |s: usize, semantic: Semantic| stream(mesh, s, &semantic);
        let sets = |s: usize| {
            (0..)
                .map_while(|set| {
                    Some([find(s, Semantic::Joints(set))?, find(s, Semantic::Weights(set))?])
                })
                .collect()
        };
        let moves = |s: usize| {
            [Semantic::Position, Semantic::Normal].map(|semantic| {
                let weight =
                    |a: &Attribute| placement.weights.get(a.morph_target? as usize).copied();
                let all = attributes(mesh, s).filter(|a| a.semantic == semantic);
                all.filter_map(|a| Some((weight(a)?, a))).filter(|(w, _)| *w != 0.0).collect()
            })
        };
        Self {
            normals: submeshes.clone().map(|s| find(s, Semantic::Normal)).collect(),
            joints: submeshes.clone().map(sets).collect(),
            moves: submeshes.map(moves).collect(),
        }
    }

    fn position(&self, mesh: &Mesh, v: u32) -> [f64; 3] {
        let p = mesh.positions()[v as usize].map(f64::from);
        moved(p, &self.moves[submesh(mesh, v)][0], v)
    }

    fn normal(&self, mesh: &Mesh, v: u32) -> Option<[f64; 3]> {
        let stream = self.normals[submesh(mesh, v)]?;
        Some(moved(vector(stream, v), &self.moves[submesh(mesh, v)][1], v))
    }

    /// The joints' matrices by the vertex's weights; none if it has no weight at all.
    fn blended(&self, mesh: &Mesh, v: u32, joints: &[Affine]) -> Option<Affine> {
        let mut sum = [[0.0; 4]; 3];
        let mut whole = 0.0;
        for [joint, weight] in &self.joints[submesh(mesh, v)] {
            for i in 0..usize::from(joint.components.min(weight.components)) {
                let w = f64::from(weight.value(v, i));
                // A joint that is not there moves nothing.
                let Some(matrix) = joints.get(joint.value(v, i) as usize).filter(|_| w != 0.0)
                else {
                    continue;
                };
                whole += w;
                for (row, add) in sum.iter_mut().zip(matrix) {
                    row.iter_mut().zip(add).for_each(|(s, a)| *s += w * a);
                }
            }
        }
        (whole > 0.0).then(|| sum.map(|row| row.map(|c| c / whole)))
    }
}

fn submesh(mesh: &Mesh, v: u32) -> usize {
    mesh.vertex_submesh()[v as usize] as usize
}

fn attributes(mesh: &Mesh, submesh: usize) -> impl Iterator<Item = &Attribute> {
    mesh.submeshes()[submesh].attributes.iter().map(|&a| &mesh.attributes()[a as usize])
}

/// The stream of a submesh with this meaning, at rest.
pub(super) fn stream<'a>(
    mesh: &'a Mesh,
    submesh: usize,
    semantic: &Semantic,
) -> Option<&'a Attribute> {
    attributes(mesh, submesh).find(|a| a.semantic == *semantic && a.morph_target.is_none())
}

fn vector(stream: &Attribute, v: u32) -> [f64; 3] {
    std::array::from_fn(|i| {
        if i < usize::from(stream.components) { f64::from(stream.value(v, i)) } else { 0.0 }
    })
}

fn moved(p: [f64; 3], moves: &[(f64, &Attribute)], v: u32) -> [f64; 3] {
    moves.iter().fold(p, |p, (weight, stream)| {
        let by = vector(stream, v);
        std::array::from_fn(|i| p[i] + weight * by[i])
    })
}

/// Three rows of a matrix that is stored column by column.
fn rows(m: &[f64; 16]) -> Affine {
    std::array::from_fn(|row| std::array::from_fn(|column| m[4 * column + row]))
}

fn apply(m: &Affine, p: [f64; 3], w: f64) -> [f64; 3] {
    m.map(|[a, b, c, d]| {
        let v = a * p[0] + b * p[1] + c * p[2] + d * w;
        // What has no place is drawn nowhere in particular, but must not spoil the camera.
        if v.is_finite() { v } else { 0.0 }
    })
}

/// A normal by the inverse transpose, up to its length: by cofactors, which need no division.
fn turned(m: &Affine, n: [f64; 3]) -> [f64; 3] {
    let at = |r: usize, c: usize| m[r % 3][c % 3];
    let cofactor = |r: usize, c: usize| {
        at(r + 1, c + 1) * at(r + 2, c + 2) - at(r + 1, c + 2) * at(r + 2, c + 1)
    };
    let sign = if determinant(m) < 0.0 { -1.0 } else { 1.0 };
    let v: [f64; 3] =
        std::array::from_fn(|r| sign * (0..3).map(|c| cofactor(r, c) * n[c]).sum::<f64>());
    let size = v.iter().fold(0.0f64, |s, c| s.max(c.abs()));
    if size > 0.0 && size.is_finite() { v.map(|c| c / size) } else { n }
}

fn determinant(m: &Affine) -> f64 {
    let [a, b, c] = [m[0], m[1], m[2]];
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_stay_upright_under_any_scale() {
        // A plane x + y = 0 stretched along x: its normal turns towards y.
        let m = [[4.0, 0.0, 0.0, 9.0], [0.0, 1.0, 0.0, 9.0], [0.0, 0.0, 1.0, 9.0]];
        let n = turned(&m, [1.0, 1.0, 0.0]);
        let along = apply(&m, [1.0, -1.0, 0.0], 0.0);
        assert!((0..3).map(|i| n[i] * along[i]).sum::<f64>().abs() < 1e-12 && n[0] > 0.0);
        let mirror = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        assert_eq!(turned(&mirror, [1.0, 0.0, 0.0]), [-1.0, 0.0, 0.0]);
        assert!(determinant(&mirror) < 0.0 && determinant(&m) > 0.0);
    }

    #[test]
    fn joints_and_morph_targets_move_vertices() {
        let mesh = lodc_fixtures::named("skinned_tube_u8").expect("a shape");
        let node = |shift: f64| {
            std::array::from_fn(|i| {
                if i % 5 == 0 {
                    1.0
                } else if i == 12 {
                    shift
                } else {
                    0.0
                }
            })
        };
        let joints = vec![node(3.0); 8];
        let there = Placement { object: 0, matrix: node(100.0), joints, weights: Vec::new() };
        let positions = placed(&mesh, &there, true).positions;
        // All joints move alike, so that weights do not matter; the node does not count.
        for (p, q) in mesh.positions().iter().zip(&positions) {
            assert!(
                (f64::from(p[0]) + 3.0 - q[0]).abs() < 1e-9
                    && (f64::from(p[1]) - q[1]).abs() < 1e-9
            );
        }
        let mesh = lodc_fixtures::named("morphing_sphere").expect("a shape");
        let at = |weights: Vec<f64>| {
            placed(
                &mesh,
                &Placement { object: 0, matrix: node(0.0), joints: Vec::new(), weights },
                false,
            )
            .positions
        };
        let (rest, half, full) = (at(vec![0.0; 4]), at(vec![0.5]), at(vec![1.0]));
        assert_ne!(rest, full);
        for ((a, b), c) in rest.iter().zip(&half).zip(&full) {
            assert!((0..3).all(|i| ((a[i] + c[i]) / 2.0 - b[i]).abs() < 1e-9));
        }
    }
}
