//! Attributes as numbers that can be compared with lengths in space: one row per vertex of the
//! input, with a column for each component.
//!
//! The lengths below were chosen by the image error of `lodc compare` on six models with textures
//! (design-notes/what-was-tried.md): normals at twice the first guess gain up to 15 % and lose at
//! most 2 %, at four times they lose 12 % on Corset; joints, normals and texture coordinates
//! together were lowered until CesiumMan's limbs kept their shape (12 views at 25 %, 9.3 of error
//! to 5.4). Colours were not measured by themselves.

use super::turned::TurnedNormals;
use crate::SeenShapes;
use crate::cut::Facet;
use crate::number::ShapeSet;
use crate::options::Weights;
use glam::{DVec3, Vec3, Vec4};
use lodc_mesh::{Attribute, Mesh, Semantic};

/// A change of the normal by one (60°) counts like a displacement by this share of the mesh's size.
const NORMAL_LENGTH: f64 = 0.01;
/// A change of a colour channel from none to full counts like a displacement by this share of the
/// mesh's size.
const COLOR_LENGTH: f64 = 0.02;
/// A joint's weight that changes from none to full counts like a displacement by this share of the
/// mesh's size.
const JOINT_LENGTH: f64 = 0.01;
/// A texture that shifts along the surface by some length counts like a displacement by this share
/// of it. Between a quarter and four times of this hardly anything changes: the rules about seams
/// and turned charts do the work.
const TEXTURE_SHARE: f64 = 0.1;
/// The length of one unit of texture space where no triangle covers any of it, as a multiple of the
/// mesh's size. Such coordinates choose colours from a palette, whose neighbours have nothing in
/// common: with this length, a step of 1/512 already counts as a change. Chosen by hand.
const PALETTE_LENGTH: f64 = 10.0;

/// The non-spatial attributes of every vertex, scaled to working units.
pub(crate) struct Attributes {
    /// Numbers per vertex.
    pub(super) width: usize,
    /// The rows, each filled up with zeros to a multiple of four.
    rows: Vec<f32>,
    /// Column of the first texture coordinates in a row.
    pub(crate) texture: Option<usize>,
    /// Up to four joints of each vertex and their weights, if the mesh is skinned.
    joints: Vec<[(u32, f32); 4]>,
    /// The factor of each vertex's joints; empty without them.
    joint_scales: Vec<f64>,
    /// Normals in motion.
    turned: TurnedNormals,
}

/// One number of every vertex.
struct Column<'a> {
    attribute: &'a Attribute,
    component: usize,
    /// The weight of its kind.
    weight: fn(&Weights) -> f64,
    /// A change by one counts, with weight 1, like a displacement by this share of a length.
    share: f64,
    length: f64,
}

impl<'a> Column<'a> {
    /// The columns of an attribute's components.
    fn of(
        attribute: &'a Attribute,
        weight: fn(&Weights) -> f64,
        share: f64,
        length: f64,
    ) -> impl Fn(usize) -> Self {
        move |component| Self { attribute, component, weight, share, length }
    }

    /// The number of a vertex in working units.
    fn at(&self, vertex: u32, weights: &Weights) -> f32 {
        let scale = (self.weight)(weights) * self.share * self.length;
        let value = f64::from(self.attribute.value(vertex, self.component)) * scale;
        if value.is_finite() { value as f32 } else { 0.0 }
    }
}

impl Attributes {
    /// Reads what takes part in the cost. `weights` are those of each submesh; `scale` turns mesh
    /// units into working units; `size` is the mesh's diagonal in those.
    pub(crate) fn new(
        mesh: &Mesh,
        seen: &SeenShapes,
        weights: impl Fn(u32) -> Weights,
        scale: f64,
        size: f64,
    ) -> Self {
        let by_submesh: Vec<Weights> = (0..mesh.submeshes().len() as u32).map(weights).collect();
        let counts = |weight: fn(&Weights) -> f64| by_submesh.iter().any(|w| weight(w) > 0.0);
        let mut columns: Vec<Column<'_>> = Vec::new();
        let mut texture = None;
        // Streams of normals with their first columns.
        let mut normals: Vec<(&Attribute, usize)> = Vec::new();
        for a in mesh.attributes().iter().filter(|a| a.morph_target.is_none()) {
            let components = usize::from(a.components);
            match a.semantic {
                Semantic::Normal if counts(|w| w.normal) => {
                    normals.extend((components >= 3).then_some((a, columns.len())));
                    let column = Column::of(a, |w| w.normal, NORMAL_LENGTH, size);
                    columns.extend((0..components.min(3)).map(column));
                }
                Semantic::Color(_) if counts(|w| w.color) => {
                    let column = Column::of(a, |w| w.color, COLOR_LENGTH, size);
                    columns.extend((0..components.min(4)).map(column));
                }
                Semantic::TexCoord(set) if components >= 2 && counts(|w| w.uv) => {
                    if set == 0 && texture.is_none() {
                        texture = Some(columns.len());
                    }
                    let length = texture_length(a, mesh, scale, size);
                    columns.extend((0..2).map(Column::of(a, |w| w.uv, TEXTURE_SHARE, length)));
                }
                _ => {}
            }
        }
        let stride = columns.len().next_multiple_of(4);
        let mut rows = Vec::with_capacity(stride * mesh.vertex_count());
        for (v, &submesh) in (0u32..).zip(mesh.vertex_submesh()) {
            let weights = &by_submesh[submesh as usize];
            rows.extend(columns.iter().map(|column| column.at(v, weights)));
            rows.resize(stride * (v as usize + 1), 0.0);
        }
        let normal_column = |submesh: u32| {
            let used = mesh.submeshes()[submesh as usize].attributes.iter();
            let mut used = used.map(|&a| &mesh.attributes()[a as usize]);
            used.find_map(|a| normals.iter().find(|(n, _)| std::ptr::eq(*n, a)).map(|(_, c)| *c))
        };
        let normal_columns: Vec<Option<usize>> =
            (0..by_submesh.len() as u32).map(normal_column).collect();
        let column = |v: u32| normal_columns[mesh.vertex_submesh()[v as usize] as usize];
        let length = |v: u32| {
            let weights = &by_submesh[mesh.vertex_submesh()[v as usize] as usize];
            (weights.normal * NORMAL_LENGTH * size) as f32
        };
        for (v, normal) in (0..).zip(&seen.normals_at_rest) {
            if let Some(column) = column(v) {
                let scaled = Vec3::from(*normal) * length(v);
                scaled.write_to_slice(&mut rows[v as usize * stride + column..]);
            }
        }
        let turned = TurnedNormals::new(seen, mesh.vertex_count() as u32, |v, normal| {
            let column = column(v)?;
            let at_rest = Vec3::from_slice(&rows[v as usize * stride + column..]);
            let delta = Vec3::from(normal) * length(v) - at_rest;
            delta.is_finite().then_some((column, delta))
        });
        let joints = if counts(|w| w.skin) { joints(mesh) } else { Vec::new() };
        let submeshes = mesh.vertex_submesh()[..joints.len()].iter();
        let joint_scale = |s: &u32| by_submesh[*s as usize].skin * JOINT_LENGTH * size;
        let joint_scales = submeshes.map(joint_scale).collect();
        Self { width: columns.len(), rows, texture, joints, joint_scales, turned }
    }

    /// No attributes: every vertex is like every other.
    pub(crate) fn none() -> Self {
        let (rows, joints, joint_scales) = (Vec::new(), Vec::new(), Vec::new());
        let turned = TurnedNormals::default();
        Self { width: 0, rows, texture: None, joints, joint_scales, turned }
    }

    /// Returns whether there is nothing to compare.
    pub(crate) fn is_empty(&self) -> bool {
        self.width == 0 && self.joints.is_empty()
    }

    /// The numbers of a vertex.
    #[inline]
    pub(crate) fn row(&self, vertex: u32) -> &[f32] {
        &self.padded(vertex)[..self.width]
    }

    /// The numbers of a vertex, and zeros up to a multiple of four.
    #[inline]
    pub(super) fn padded(&self, vertex: u32) -> &[f32] {
        let stride = self.width.next_multiple_of(4);
        &self.rows[vertex as usize * stride..][..stride]
    }

    /// Four numbers of a vertex, from the number `first` on, a multiple of four.
    #[inline]
    pub(super) fn four(&self, vertex: u32, first: usize) -> Vec4 {
        Vec4::from_slice(&self.padded(vertex)[first..first + 4])
    }

    /// The same in a shape in motion.
    pub(super) fn four_in(&self, vertex: u32, first: usize, shape: u32) -> Vec4 {
        self.four(vertex, first) + self.turned.four(vertex, first, shape)
    }

    /// The shapes in which a vertex has another normal than at rest.
    #[inline]
    pub(super) fn turned(&self, vertex: u32) -> ShapeSet {
        self.turned.set(vertex)
    }

    /// Returns whether any vertex has another normal in any shape.
    #[inline]
    pub(super) fn has_turned(&self) -> bool {
        !self.turned.is_empty()
    }

    /// Returns whether the mesh is skinned.
    #[inline]
    pub(super) fn has_joints(&self) -> bool {
        !self.joints.is_empty()
    }

    /// Squared difference of two vertices, in squared working units.
    pub(crate) fn distance_squared(&self, a: u32, b: u32) -> f64 {
        self.row(a)
            .iter()
            .zip(self.row(b))
            .map(|(x, y)| (f64::from(*x) - f64::from(*y)).powi(2))
            .sum()
    }

    /// Squared difference of two vertices' skinning weights, in squared working units of the first.
    pub(super) fn joint_distance_squared(&self, a: u32, b: u32) -> f64 {
        if self.joints.is_empty() || a == b {
            return 0.0;
        }
        let scale = self.joint_scales[a as usize];
        let (a, b) = (&self.joints[a as usize], &self.joints[b as usize]);
        let weight = |list: &[(u32, f32); 4], joint: u32| -> f32 {
            list.iter().filter(|(j, _)| *j == joint).map(|(_, w)| w).sum()
        };
        let mut sum = 0.0;
        for (i, &(joint, _)) in a.iter().enumerate() {
            if !a[..i].iter().any(|(j, _)| *j == joint) {
                sum += f64::from(weight(a, joint) - weight(b, joint)).powi(2);
            }
        }
        for (i, &(joint, _)) in b.iter().enumerate() {
            if !b[..i].iter().any(|(j, _)| *j == joint) && !a.iter().any(|(j, _)| *j == joint) {
                sum += f64::from(weight(b, joint)).powi(2);
            }
        }
        sum * scale * scale
    }
}

/// The length on the surface of one unit of texture space, on average over the triangles that cover
/// some of it.
fn texture_length(a: &Attribute, mesh: &Mesh, scale: f64, size: f64) -> f64 {
    let (mut surface, mut texture) = (0.0, 0.0);
    for triangle in mesh.triangles() {
        let [p, q, r] = triangle.map(|v| [f64::from(a.value(v, 0)), f64::from(a.value(v, 1))]);
        let area = 0.5 * ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).abs();
        if area.is_finite() && area > 0.0 {
            let corners =
                triangle.map(|v| DVec3::from(mesh.positions()[v as usize].map(f64::from)) * scale);
            texture += area;
            surface += f64::from(Facet::new(corners).area);
        }
    }
    if texture > 0.0 { (surface / texture).sqrt() } else { PALETTE_LENGTH * size }
}

/// Up to four joints of each vertex with their weights, from the first set; empty if the mesh has
/// none.
fn joints(mesh: &Mesh) -> Vec<[(u32, f32); 4]> {
    let find = |semantic: &Semantic| {
        mesh.attributes().iter().filter(|a| a.semantic == *semantic).collect::<Vec<_>>()
    };
    let (joints, weights) = (find(&Semantic::Joints(0)), find(&Semantic::Weights(0)));
    if joints.is_empty() || weights.is_empty() {
        return Vec::new();
    }
    (0..mesh.vertex_count() as u32)
        .map(|v| {
            let mut list = [(0, 0.0); 4];
            for (j, w) in joints.iter().zip(&weights) {
                for (c, slot) in list
                    .iter_mut()
                    .enumerate()
                    .take(usize::from(j.components.min(w.components)).min(4))
                {
                    let weight = w.value(v, c);
                    if weight > 0.0 && weight.is_finite() {
                        *slot = (j.value(v, c) as u32, weight);
                    }
                }
            }
            list
        })
        .collect()
}
