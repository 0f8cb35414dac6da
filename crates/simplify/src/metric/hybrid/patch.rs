//! A patch: the faces whose look the collapse of a group changes. These are the faces of its star,
//! which move, and, where normals are those of faces, the faces around them, whose shading changes.
//! The groups next to the moving one are its *ring*. [`Patch::gather`] comes once, then for each
//! target [`Patch::move_to`] and [`Patch::surrounding_shading`].

use super::appearance::{Appearance, attribute_vertex};
use super::lanes::{SampleQuad, ShadedQuad};
use super::samples::{CREASE, MAX_AVERAGED, Samples};
use super::triangle::PreparedTriangle;
use super::vectors::NearestPoints;
use crate::cut::{Wedges, WorkingMesh};
use glam::Vec3;
use lodc_mesh::NONE;

/// Stars with more faces than this are priced without the faces around them, whose number would
/// make the time quadratic. Chosen by hand; legal collapses make no such stars.
pub(super) const MAX_STAR: usize = 32;

/// A face of the star after the move, with the normals and texture coordinates of its corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovedFace {
    pub(super) face: u32,
    /// Its corners, as indices into [`Patch::ring`]: none is `NONE`, since the target is in it.
    corners: [u32; 3],
    pub(super) normal: Vec3,
    /// The normals that its corners are shaded with.
    pub(super) shading: [Vec3; 3],
    pub(super) submesh: u32,
    /// The vertices whose attributes the corners have.
    pub(super) vertices: [u32; 3],
    /// Texture coordinates of the corners.
    pub(super) texture: [[f32; 2]; 3],
    /// The index in [`Patch::samples`] of the four with its first sample; they may begin with
    /// samples of the face before it.
    pub(super) first: u32,
}

/// A face around the star, which does not move but is shaded anew.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurroundingFace {
    pub(super) face: u32,
    /// Its corners, as indices into [`Patch::ring`]; `NONE` for corners at other groups.
    corners: [u32; 3],
    normal: Vec3,
    /// For each corner the sum of the normals that it is shaded with and that do not change.
    fixed_sum: [Vec3; 3],
    /// The index in [`Patch::shaded`] of its first four samples, which are of this face alone.
    pub(super) first: u32,
}

/// The state that a patch is cut from.
#[derive(Clone, Copy)]
pub(super) struct PatchInput<'a> {
    pub(super) mesh: &'a WorkingMesh,
    pub(super) wedges: &'a Wedges,
    pub(super) appearance: &'a Appearance<'a>,
    pub(super) samples: &'a Samples,
    /// The energy of each face: the weighted errors of its samples.
    pub(super) energy: &'a [f64],
}

/// Buffers of one thread, and the patch that they hold.
#[derive(Default)]
pub(crate) struct Patch {
    /// For each group: the last epoch in which it was in `ring`, and its index there. An epoch is
    /// the number of the present patch, so that nothing has to be cleared between two.
    ring_index_of: Vec<(u32, u32)>,
    /// For each face: the last epoch in which it was in the patch.
    marks: Vec<u32>,
    epoch: u32,
    /// The groups next to the one that moves.
    ring: Vec<u32>,
    /// For each of them, the start of its range in `fixed_normals`; and the end of the last.
    fixed_start: Vec<u32>,
    /// For each group of the ring, the normals of its faces that do not move.
    fixed_normals: Vec<Vec3>,
    /// Faces around the star.
    pub(super) surrounding: Vec<SurroundingFace>,
    /// Faces of the star that outlive the move.
    pub(super) moved: Vec<MovedFace>,
    /// The same after the move.
    pub(super) triangles: Vec<PreparedTriangle>,
    /// For each entry of `samples` its nearest points of the moved faces.
    pub(super) nearest: Vec<NearestPoints>,
    /// Wedges of the group that moves, and those at the target that they share a face with.
    targets: Vec<(u32, u32)>,
    /// Samples of the star, in the order of its faces.
    pub(super) samples: Vec<SampleQuad>,
    /// For each corner of the star, the index in `samples` of the first four of its face.
    first_samples: Vec<u32>,
    /// Samples of the faces around the star, in their order.
    pub(super) shaded: Vec<ShadedQuad>,
    /// Numbers of the star's samples, from which `samples` is made.
    sample_ids: Vec<u32>,
    /// The energy of the whole patch before the move.
    pub(super) current_energy: f64,
    /// The visible share of the star: 1 for a closed surface with nothing in front of it.
    pub(super) visible: f64,
}

impl Patch {
    /// Gathers the star of a group and, where shading is that of faces, the faces around it.
    pub(super) fn gather(&mut self, input: &PatchInput<'_>, from: u32) {
        let PatchInput { mesh, samples, energy, .. } = *input;
        self.start(mesh);
        self.current_energy = 0.0;
        let (mut visible, mut area) = (0.0, 0.0);
        for &corner in mesh.star(from) {
            let face = corner.face();
            for s in samples.of(face).map(|s| samples.get(s)) {
                area += f64::from(s.extent * s.extent);
                visible += f64::from(s.weight);
            }
            self.marks[face as usize] = self.epoch;
            self.current_energy += energy[face as usize];
            self.first_samples.push(self.sample_ids.len() as u32 / 4);
            self.sample_ids.extend(samples.of(face));
            for g in mesh.others(corner) {
                if self.ring_index_of[g as usize].0 != self.epoch {
                    self.ring_index_of[g as usize] = (self.epoch, self.ring.len() as u32);
                    self.ring.push(g);
                }
            }
        }
        self.samples.extend(self.sample_ids.chunks(4).map(|four| SampleQuad::new(four, samples)));
        self.visible = if area > visible { visible / area } else { 1.0 };
        if !input.appearance.has_normals() {
            self.gather_surrounding(input, from);
        }
    }

    /// Gathers the normals around the ring that do not change, and the faces shaded with them.
    fn gather_surrounding(&mut self, input: &PatchInput<'_>, from: u32) {
        let PatchInput { mesh, energy, samples, .. } = *input;
        for i in 0..self.ring.len() {
            self.fixed_start.push(self.fixed_normals.len() as u32);
            for &corner in mesh.star(self.ring[i]).iter().take(MAX_AVERAGED) {
                let f = &mesh.faces[corner.face() as usize];
                if !f.groups.contains(&from) {
                    self.fixed_normals.push(mesh.normal(corner.face()));
                }
            }
        }
        self.fixed_start.push(self.fixed_normals.len() as u32);
        if mesh.star(from).len() > MAX_STAR {
            return;
        }
        for i in 0..self.ring.len() {
            for &corner in mesh.star(self.ring[i]).iter().take(MAX_AVERAGED) {
                let face = corner.face();
                if self.marks[face as usize] != self.epoch {
                    self.marks[face as usize] = self.epoch;
                    self.current_energy += energy[face as usize];
                    self.add_surrounding(mesh, face);
                    ShadedQuad::gather(face, samples, &mut self.shaded);
                }
            }
        }
    }

    /// Empties the buffers and begins an epoch.
    fn start(&mut self, mesh: &WorkingMesh) {
        if self.marks.len() < mesh.faces.len() {
            self.marks.resize(mesh.faces.len(), 0);
            self.ring_index_of.resize(mesh.group_positions.len(), (0, 0));
        }
        self.epoch = self.epoch.checked_add(1).unwrap_or_else(|| {
            self.marks.fill(0);
            self.ring_index_of.fill((0, 0));
            1
        });
        self.ring.clear();
        self.fixed_start.clear();
        self.fixed_normals.clear();
        self.surrounding.clear();
        self.samples.clear();
        self.first_samples.clear();
        self.shaded.clear();
        self.sample_ids.clear();
    }

    /// The index of a group in the ring; `NONE` if it is not in it.
    fn ring_index(&self, group: u32) -> u32 {
        let (epoch, index) = self.ring_index_of[group as usize];
        if epoch == self.epoch { index } else { NONE }
    }

    fn add_surrounding(&mut self, mesh: &WorkingMesh, face: u32) {
        let (f, normal) = (&mesh.faces[face as usize], mesh.normal(face));
        let corners = f.groups.map(|g| self.ring_index(g));
        let fixed_sum = [0, 1, 2].map(|c| match corners[c] {
            NONE => {
                let faces = mesh.star(f.groups[c]).iter().take(MAX_AVERAGED);
                sum_within_crease(faces.map(|c| mesh.normal(c.face())), normal)
            }
            ring_index => sum_within_crease(self.fixed_at(ring_index).iter().copied(), normal),
        });
        let first = self.shaded.len() as u32;
        self.surrounding.push(SurroundingFace { face, corners, normal, fixed_sum, first });
    }

    /// The normals around a group of the ring that do not change.
    fn fixed_at(&self, ring_index: u32) -> &[Vec3] {
        let start = &self.fixed_start[ring_index as usize..];
        &self.fixed_normals[start[0] as usize..start[1] as usize]
    }

    /// Moves the star to `to` and shades its faces.
    pub(super) fn move_to(&mut self, input: &PatchInput<'_>, from: u32, to: u32) {
        let PatchInput { mesh, wedges, appearance, .. } = *input;
        self.moved.clear();
        self.triangles.clear();
        self.find_targets(mesh, from, to);
        for (&corner, &first) in mesh.star(from).iter().zip(&self.first_samples) {
            let face = corner.face();
            let groups = mesh.faces[face as usize].groups;
            if groups.contains(&to) {
                continue;
            }
            let groups = groups.map(|g| if g == from { to } else { g });
            let positions = groups.map(|g| mesh.group_positions[g as usize].position);
            let triangle = PreparedTriangle::new(positions);
            let normal = triangle.normal;
            let corners = groups.map(|g| self.ring_index(g));
            let mut face_wedges = mesh.wedges(face);
            let submesh = wedges.submesh(face_wedges[0]);
            let moving = &mut face_wedges[corner.at()];
            *moving = self.target(input, *moving);
            let vertices = face_wedges.map(|w| attribute_vertex(wedges, w));
            let shading = if appearance.has_normals() {
                vertices.map(|v| appearance.normal(v))
            } else {
                [normal; 3]
            };
            let texture = vertices.map(|v| appearance.coordinates(v));
            self.moved.push(MovedFace {
                face,
                corners,
                normal,
                shading,
                submesh,
                vertices,
                texture,
                first,
            });
            self.triangles.push(triangle);
        }
        if !appearance.has_normals() {
            self.shade_moved();
        }
    }

    /// Shades the moved faces with the normals of the faces around their corners.
    fn shade_moved(&mut self) {
        for i in 0..self.moved.len() {
            let moved = self.moved[i];
            self.moved[i].shading = moved.corners.map(|ring_index| {
                let fixed_normals = self.fixed_at(ring_index).iter().copied();
                let fixed_sum = sum_within_crease(fixed_normals, moved.normal);
                (fixed_sum + self.moving_at(ring_index, moved.normal)).normalize_or_zero()
            });
        }
    }

    /// Finds the wedges that lose a face between `from` and `to`, and their counterparts.
    fn find_targets(&mut self, mesh: &WorkingMesh, from: u32, to: u32) {
        self.targets.clear();
        if mesh.one_wedge_each() {
            self.targets.push((from, to));
            return;
        }
        for &corner in mesh.star(from) {
            let face = corner.face();
            let groups = mesh.faces[face as usize].groups;
            if let Some(end) = groups.iter().position(|&g| g == to) {
                let wedges = mesh.wedges(face);
                self.targets.push((wedges[corner.at()], wedges[end]));
            }
        }
    }

    /// The wedge whose attributes a wedge of the moving group has after the move: one at the target
    /// that it shares a face with, else the counterpart of a wedge with the same attributes, if
    /// need be of another submesh. Else it becomes a fake and keeps its own.
    fn target(&self, &PatchInput { wedges, appearance, .. }: &PatchInput<'_>, wedge: u32) -> u32 {
        let class = wedges.class(wedge);
        let look = |w: u32| {
            let vertex = attribute_vertex(wedges, w);
            let normal = appearance.has_normals().then(|| appearance.normal(vertex));
            (normal, appearance.coordinates(vertex), appearance.vertex_colour(vertex))
        };
        let same = self.targets.iter().find(|t| t.0 == wedge);
        let alike = || self.targets.iter().find(|t| wedges.class(t.0) == class);
        let across = || self.targets.iter().find(|t| look(t.0) == look(wedge));
        same.or_else(alike).or_else(across).map_or(wedge, |t| t.1)
    }

    /// The sum of the normals of moved faces at a group of the ring that are shaded together with a
    /// face of this normal.
    fn moving_at(&self, ring_index: u32, normal: Vec3) -> Vec3 {
        let faces = self.moved.iter().filter(|f| f.corners.contains(&ring_index));
        sum_within_crease(faces.map(|f| f.normal), normal)
    }

    /// The normals that a face around the star is shaded with after the move.
    pub(super) fn surrounding_shading(&self, f: &SurroundingFace) -> [Vec3; 3] {
        [0, 1, 2].map(|c| match f.corners[c] {
            NONE => f.fixed_sum[c].normalize_or_zero(),
            ring_index => {
                (f.fixed_sum[c] + self.moving_at(ring_index, f.normal)).normalize_or_zero()
            }
        })
    }
}

/// The sum of those normals that are shaded together with a face of the normal `around`: within 60°
/// of it.
fn sum_within_crease(normals: impl Iterator<Item = Vec3>, around: Vec3) -> Vec3 {
    normals.filter(|n| n.dot(around) > CREASE).sum()
}
