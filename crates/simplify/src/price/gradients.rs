//! The price of attributes: every wedge's gradients, and what moving along an edge would cost
//! them. A *number* is one component of an attribute; four are computed at a time. A *spoke* is the
//! vector from the group to a neighbour.
//!
//! Let `gᵢ` be the gradient of a number on face `i` of area `aᵢ` around a wedge, `W` the area of
//! all its faces and `ḡ` the mean gradient. The wedge moves by `δ` to where the number differs by
//! `c`. How far off a straight continuation of each face it would be (a vertex-centred quadric over
//! position and attributes together, Hoppe 1999, refitted to the current faces) is
//!
//! ```text
//! Σ aᵢ(gᵢ·δ − c)²  =  W(ḡ·δ − c)² + Σ aᵢ((gᵢ − ḡ)·δ)²
//! ```
//!
//! of which the right side cancels nothing, so that single precision is enough.

use super::attributes::Attributes;
use super::one_ring::OneRing;
use crate::cut::{Entry, Wedges, WorkingMesh, target};
use crate::number::ShapeSet;
use glam::{Vec3, Vec4};

/// A gradient of four numbers: one coordinate of each for each vector.
pub(super) type FourGradients = [Vec4; 3];

/// The attributes of the wedges of one region.
#[derive(Clone, Copy)]
pub(super) struct WedgeAttributes<'a> {
    pub(super) mesh: &'a WorkingMesh,
    pub(super) wedges: &'a Wedges,
    pub(super) attributes: &'a Attributes,
    /// The shape in motion; none at rest.
    pub(super) shape: Option<u32>,
}

impl WedgeAttributes<'_> {
    /// The same in a shape in motion.
    pub(super) fn in_shape(self, shape: u32) -> Self {
        Self { shape: Some(shape), ..self }
    }

    /// Four numbers of a vertex of the input, from the number `first` on, a multiple of four.
    #[inline]
    pub(super) fn four(&self, vertex: u32, first: usize) -> Vec4 {
        match self.shape {
            None => self.attributes.four(vertex, first),
            Some(shape) => self.attributes.four_in(vertex, first, shape),
        }
    }

    /// The shapes in which the normal of a wedge is another than at rest.
    #[inline]
    pub(super) fn turned(&self, wedge: u32) -> ShapeSet {
        self.attributes.turned(self.wedges.attribute_source[wedge as usize])
    }

    /// The wedge at the other end of an edge with these faces that one of another submesh becomes
    /// whose attributes are the same as `wedge`'s.
    fn across(&self, faces: &[Entry], wedge: u32) -> Option<u32> {
        let Self { wedges, attributes, .. } = *self;
        if wedges.is_bare() {
            return None;
        }
        let row = |w: u32| attributes.row(wedges.attribute_source[w as usize]);
        let is_alike = |e: &&Entry| {
            wedges.submesh(e.wedge) != wedges.submesh(wedge) && row(e.wedge) == row(wedge)
        };
        // Bounded as in `target`.
        faces.iter().take(64).find(is_alike).map(|e| e.neighbour_wedge)
    }
}

/// The dual basis of a face's plane, by which differences along its two spokes become gradients,
/// and the face's area.
#[derive(Clone, Copy, Default)]
pub(super) struct Dual {
    along: [Vec3; 2],
    pub(super) area: f32,
}

impl Dual {
    /// The dual basis of two spokes with their cross product; zero if the face has no area.
    #[inline]
    pub(super) fn new([spoke, following]: [Vec3; 2], normal: Vec3) -> Self {
        let squared = normal.length_squared();
        if squared <= 0.0 {
            return Self::default();
        }
        let along = [following.cross(normal) / squared, normal.cross(spoke) / squared];
        Self { along, area: 0.5 * squared.sqrt() }
    }

    /// The gradient of four numbers, given their changes along the two spokes.
    #[inline]
    pub(super) fn gradient(&self, [first, second]: [Vec4; 2]) -> FourGradients {
        let [d, e] = self.along;
        [first * d.x + second * e.x, first * d.y + second * e.y, first * d.z + second * e.z]
    }
}

/// The scatter of gradients about their means: the sum of `weight · v vᵀ`, for four numbers at a
/// time, in the order of [`Symmetric`](crate::cut::Symmetric).
#[derive(Clone, Copy, Default)]
pub(super) struct Scatter([Vec4; 6]);

impl Scatter {
    /// Adds the gradients on one face.
    #[inline]
    pub(super) fn add(&mut self, gradient: &FourGradients, mean: &FourGradients, area: f32) {
        let [x, y, z] = [gradient[0] - mean[0], gradient[1] - mean[1], gradient[2] - mean[2]];
        let weighted = [x * area, y * area, z * area];
        let outer = &mut self.0;
        outer[0] += weighted[0] * x;
        outer[1] += weighted[0] * y;
        outer[2] += weighted[0] * z;
        outer[3] += weighted[1] * y;
        outer[4] += weighted[1] * z;
        outer[5] += weighted[2] * z;
    }

    /// The quadratic form of all numbers.
    #[inline]
    pub(super) fn form(&self) -> [f32; 6] {
        self.0.map(sum)
    }
}

/// A continuation of four numbers by `delta`.
#[inline]
pub(super) fn continued(mean: &FourGradients, delta: Vec3) -> Vec4 {
    mean[0] * delta.x + mean[1] * delta.y + mean[2] * delta.z
}

#[inline]
pub(super) fn sum(v: Vec4) -> f32 {
    (v.x + v.y) + (v.z + v.w)
}

/// A face around one of the wedges.
struct WedgeFace {
    /// The wedge's index in [`Gradients::wedges`].
    wedge: usize,
    dual: Dual,
    /// The input vertices whose attributes its corners have, from the wedge's on.
    rows: [u32; 3],
}

/// The gradients around the wedges of one group; used again for the next.
#[derive(Default)]
pub(super) struct Gradients {
    /// Each wedge and the area of its faces.
    wedges: Vec<(u32, f32)>,
    /// The mean gradients of each wedge, of the first four numbers, of the next four, and so on.
    means: Vec<FourGradients>,
    /// The quadratic form of the scatter of all gradients.
    form: [f32; 6],
    faces: Vec<WedgeFace>,
    /// The gradients of the present four numbers on each face.
    on_faces: Vec<FourGradients>,
}

impl Gradients {
    /// Fits the attributes around every wedge of a group, given the positions of groups.
    pub(super) fn fit(
        &mut self,
        view: WedgeAttributes<'_>,
        from: u32,
        position: impl Fn(u32) -> Vec3,
    ) {
        self.clear();
        for &corner in view.mesh.star(from) {
            let spokes = view.mesh.others(corner).map(|g| position(g) - position(from));
            let dual = Dual::new(spokes, spokes[0].cross(spokes[1]));
            self.add_face(view, dual, view.mesh.wedges_from(corner));
        }
        self.fit_all(view);
    }

    /// Fits the attributes around every wedge of a group with a closed fan, given the wedges at the
    /// corners of its faces.
    pub(super) fn fit_ring<const N: usize>(
        &mut self,
        view: WedgeAttributes<'_>,
        ring: &OneRing<N>,
        corners: &[[u32; 3]],
    ) {
        self.clear();
        let (spokes, normals) = (ring.spokes(), ring.normals());
        for (i, &corners) in corners[..ring.len].iter().enumerate() {
            let dual = Dual::new([spokes[i], spokes[i + 1]], normals[i]);
            self.add_face(view, dual, corners);
        }
        self.fit_all(view);
    }

    fn clear(&mut self) {
        self.wedges.clear();
        self.faces.clear();
        self.means.clear();
    }

    fn fit_all(&mut self, view: WedgeAttributes<'_>) {
        let mut scatter = Scatter::default();
        for first in (0..view.attributes.width).step_by(4) {
            self.fit_four(view, first, &mut scatter);
        }
        self.form = scatter.form();
    }

    /// Adds a face with the wedges at its corners, the group's first.
    #[inline]
    fn add_face(&mut self, view: WedgeAttributes<'_>, dual: Dual, corners: [u32; 3]) {
        let wedge = corners[0];
        let index = self.wedges.iter().rposition(|w| w.0 == wedge).unwrap_or_else(|| {
            self.wedges.push((wedge, 0.0));
            self.wedges.len() - 1
        });
        self.wedges[index].1 += dual.area;
        let rows = corners.map(|w| view.wedges.attribute_source[w as usize]);
        self.faces.push(WedgeFace { wedge: index, dual, rows });
    }

    /// Fits four numbers, from `first` on.
    fn fit_four(&mut self, view: WedgeAttributes<'_>, first: usize, scatter: &mut Scatter) {
        let start = self.means.len();
        self.means.resize(start + self.wedges.len(), [Vec4::ZERO; 3]);
        let means = &mut self.means[start..];
        self.on_faces.clear();
        for face in &self.faces {
            let [value, next_value, previous_value] = face.rows.map(|row| view.four(row, first));
            let gradient = face.dual.gradient([next_value - value, previous_value - value]);
            for (mean, gradient) in means[face.wedge].iter_mut().zip(gradient) {
                *mean += gradient * face.dual.area;
            }
            self.on_faces.push(gradient);
        }
        for (mean, &(_, area)) in means.iter_mut().zip(&self.wedges) {
            let share = if area > 0.0 { 1.0 / area } else { 0.0 };
            *mean = mean.map(|sum| sum * share);
        }
        for (face, gradient) in self.faces.iter().zip(&self.on_faces) {
            scatter.add(gradient, &means[face.wedge], face.dual.area);
        }
    }

    /// Error of the attributes around a group if it moved by `delta`, along an edge with these
    /// faces, which are sorted. In working units to the fourth power.
    pub(super) fn cost(&self, view: WedgeAttributes<'_>, delta: Vec3, faces: &[Entry]) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.form;
        let (x, y, z) = (delta.x, delta.y, delta.z);
        let scattered =
            x * (xx * x + 2.0 * (xy * y + xz * z)) + y * (yy * y + 2.0 * (yz * z)) + z * (zz * z);
        let mut cost = f64::from(scattered.max(0.0));
        for (i, &(wedge, area)) in self.wedges.iter().enumerate() {
            let target = target(view.wedges, faces, wedge)
                .or_else(|| view.across(faces, wedge))
                .unwrap_or(wedge);
            let rows = [wedge, target].map(|w| view.wedges.attribute_source[w as usize]);
            let mut squared = Vec4::ZERO;
            let means = self.means.iter().skip(i).step_by(self.wedges.len());
            for (first, mean) in (0..view.attributes.width).step_by(4).zip(means) {
                let [value, target_value] = rows.map(|row| view.four(row, first));
                let residual = target_value - value - continued(mean, delta);
                squared += residual * residual;
            }
            cost += f64::from(area * sum(squared));
            let [source, target_source] =
                [wedge, target].map(|w| view.wedges.position_source[w as usize]);
            cost += f64::from(area) * view.attributes.joint_distance_squared(source, target_source);
        }
        cost
    }
}
