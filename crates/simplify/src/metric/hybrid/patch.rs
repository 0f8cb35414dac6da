//! The faces whose look a collapse changes: those that move, and those that share a corner with
//! them and are shaded together.

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

/// A face with the normals and texture coordinates of its corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchFace {
    pub(super) face: u32,
    /// Its corners, as vertices of the patch; `NONE` for those that are none.
    corners: [u32; 3],
    pub(super) normal: Vec3,
    /// The normals that its corners are shaded with.
    pub(super) shading: [Vec3; 3],
    pub(super) submesh: u32,
    /// Texture coordinates of the corners.
    pub(super) texture: [[f32; 2]; 3],
    /// The place where its samples begin: in [`Patch::samples`] if it moves, else in
    /// [`Patch::shaded`].
    pub(super) first: u32,
}

/// The state that a patch is cut from.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) mesh: &'a WorkingMesh,
    pub(super) wedges: &'a Wedges,
    pub(super) appearance: &'a Appearance<'a>,
    pub(super) samples: &'a Samples,
    /// The error of each face's samples.
    pub(super) energy: &'a [f64],
}

/// Buffers of one thread, and the patch that they hold.
#[derive(Default)]
pub(crate) struct Patch {
    /// For each group: the epoch in which it was a vertex of the patch, and its number there.
    vertex_of: Vec<(u32, u32)>,
    /// For each face: the epoch in which it was in the patch.
    marks: Vec<u32>,
    epoch: u32,
    /// The groups next to the one that moves.
    ring: Vec<u32>,
    /// For each of them, the start of its range in `fixed`.
    fixed_start: Vec<u32>,
    /// Normals of the faces around the ring that stay.
    fixed: Vec<Vec3>,
    /// Faces around the star. Their shading holds the part that stays, not yet of unit length.
    pub(super) surrounding: Vec<PatchFace>,
    /// Faces of the star that move, and their new places.
    pub(super) moved: Vec<PatchFace>,
    pub(super) triangles: Vec<PreparedTriangle>,
    /// For the samples, four at a time, their nearest points of the moved faces.
    pub(super) nearest: Vec<NearestPoints>,
    /// Wedges of the group that moves, and those at the target that they share a face with.
    targets: Vec<(u32, u32)>,
    /// Samples of the star, in the order of its faces.
    pub(super) samples: Vec<SampleQuad>,
    /// For each corner of the star, where the samples of its face begin in `samples`.
    first_samples: Vec<u32>,
    /// Samples of the faces around the star, in their order.
    pub(super) shaded: Vec<ShadedQuad>,
    /// Samples of the star, as they are gathered.
    ids: Vec<u32>,
    /// The energy of the whole patch before the move.
    pub(super) current_energy: f64,
    /// The visible share of the star: 1 for a closed surface with nothing in front of it.
    pub(super) visible: f64,
}

impl Patch {
    /// Gathers the star of a group and, where shading is that of faces, the faces around it.
    pub(super) fn gather(&mut self, source: &Source<'_>, from: u32) {
        let Source { mesh, samples, energy, .. } = *source;
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
            self.first_samples.push(self.ids.len() as u32 / 4);
            self.ids.extend(samples.of(face));
            for g in mesh.others(corner) {
                if self.vertex_of[g as usize].0 != self.epoch {
                    self.vertex_of[g as usize] = (self.epoch, self.ring.len() as u32);
                    self.ring.push(g);
                }
            }
        }
        self.samples.extend(self.ids.chunks(4).map(|four| SampleQuad::new(four, samples)));
        self.visible = if area > visible { visible / area } else { 1.0 };
        if !source.appearance.has_normals() {
            self.gather_surrounding(source, from);
        }
    }

    /// Gathers the normals that stay around the ring, and the faces that are shaded with them.
    fn gather_surrounding(&mut self, source: &Source<'_>, from: u32) {
        let Source { mesh, energy, samples, .. } = *source;
        for i in 0..self.ring.len() {
            self.fixed_start.push(self.fixed.len() as u32);
            for &corner in mesh.star(self.ring[i]).iter().take(MAX_AVERAGED) {
                let f = &mesh.faces[corner.face() as usize];
                if !f.groups.contains(&from) {
                    self.fixed.push(mesh.normal(corner.face()));
                }
            }
        }
        self.fixed_start.push(self.fixed.len() as u32);
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
            self.vertex_of.resize(mesh.places.len(), (0, 0));
        }
        self.epoch = self.epoch.checked_add(1).unwrap_or_else(|| {
            self.marks.fill(0);
            self.vertex_of.fill((0, 0));
            1
        });
        self.ring.clear();
        self.fixed_start.clear();
        self.fixed.clear();
        self.surrounding.clear();
        self.samples.clear();
        self.first_samples.clear();
        self.shaded.clear();
        self.ids.clear();
    }

    /// The number of a group among the vertices of the patch; `NONE` if it is none.
    fn vertex(&self, group: u32) -> u32 {
        let (epoch, vertex) = self.vertex_of[group as usize];
        if epoch == self.epoch { vertex } else { NONE }
    }

    fn add_surrounding(&mut self, mesh: &WorkingMesh, face: u32) {
        let (f, normal) = (&mesh.faces[face as usize], mesh.normal(face));
        let corners = f.groups.map(|g| self.vertex(g));
        let shading = [0, 1, 2].map(|c| match corners[c] {
            NONE => {
                let faces = mesh.star(f.groups[c]).iter().take(MAX_AVERAGED);
                smooth(faces.map(|c| mesh.normal(c.face())), normal)
            }
            vertex => smooth(self.fixed_at(vertex).iter().copied(), normal),
        });
        let (submesh, texture, first) = (0, [[0.0; 2]; 3], self.shaded.len() as u32);
        self.surrounding.push(PatchFace {
            face,
            corners,
            normal,
            shading,
            submesh,
            texture,
            first,
        });
    }

    /// The normals around a vertex of the patch that stay.
    fn fixed_at(&self, vertex: u32) -> &[Vec3] {
        let start = &self.fixed_start[vertex as usize..];
        &self.fixed[start[0] as usize..start[1] as usize]
    }

    /// Moves the star to `to` and shades its faces.
    pub(super) fn move_to(&mut self, source: &Source<'_>, from: u32, to: u32) {
        let Source { mesh, wedges, appearance, .. } = *source;
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
            let corners_at = groups.map(|g| mesh.places[g as usize].position);
            let triangle = PreparedTriangle::new(corners_at);
            let normal = triangle.normal;
            let corners = groups.map(|g| self.vertex(g));
            let mut own = mesh.wedges(face);
            let submesh = wedges.submesh(own[0]);
            own[corner.at()] = self.target(wedges, own[corner.at()]);
            let vertices = own.map(|w| attribute_vertex(wedges, w));
            let shading = if appearance.has_normals() {
                vertices.map(|v| appearance.normal(v))
            } else {
                [normal; 3]
            };
            let texture = vertices.map(|v| appearance.coordinates(v));
            self.moved.push(PatchFace { face, corners, normal, shading, submesh, texture, first });
            self.triangles.push(triangle);
        }
        if !appearance.has_normals() {
            self.shade_moved();
        }
    }

    /// Shades the moved faces with the normals of the faces around their corners.
    fn shade_moved(&mut self) {
        for i in 0..self.moved.len() {
            let own = self.moved[i];
            self.moved[i].shading = own.corners.map(|vertex| {
                let fixed = smooth(self.fixed_at(vertex).iter().copied(), own.normal);
                (fixed + self.moving_at(vertex, own.normal)).normalize_or_zero()
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

    /// The wedge whose attributes a wedge has after the move: one that it shares a
    /// face with, the counterpart of a wedge with the same attributes, or, for a fake, itself.
    fn target(&self, wedges: &Wedges, wedge: u32) -> u32 {
        let class = wedges.class(wedge);
        let same = self.targets.iter().find(|t| t.0 == wedge);
        let alike = || self.targets.iter().find(|t| wedges.class(t.0) == class);
        same.or_else(alike).map_or(wedge, |t| t.1)
    }

    /// The sum of the normals of moved faces at a vertex that are shaded together with `own`.
    fn moving_at(&self, vertex: u32, own: Vec3) -> Vec3 {
        smooth(self.moved.iter().filter(|f| f.corners.contains(&vertex)).map(|f| f.normal), own)
    }

    /// The normals that a face around the star is shaded with after the move.
    pub(super) fn surrounding_shading(&self, f: &PatchFace) -> [Vec3; 3] {
        [0, 1, 2].map(|c| match f.corners[c] {
            NONE => f.shading[c].normalize_or_zero(),
            vertex => (f.shading[c] + self.moving_at(vertex, f.normal)).normalize_or_zero(),
        })
    }
}

/// The sum of the normals that are shaded together with `own`.
fn smooth(normals: impl Iterator<Item = Vec3>, own: Vec3) -> Vec3 {
    normals.filter(|n| n.dot(own) > CREASE).sum()
}
