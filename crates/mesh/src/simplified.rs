//! A mesh in collapse order with its collapse sequence, and the reference: which triangles a LOD
//! has.

use crate::{
    CollapseSequence, Lod, Mesh, OrientedTriangle, PositionIds, SequenceError, is_degenerate,
    position_key,
};

/// Result of a simplifier: the mesh, with its vertices in the order in which they disappear, and
/// the sequence. Fake vertices, which the simplifier made and no triangle of LOD 0 uses, are among
/// them. Within each submesh the triangle that is removed first comes last, so the live triangles
/// of a submesh are always the first ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Simplified {
    mesh: Mesh,
    collapses: CollapseSequence,
    /// By vertex: whether it is locked. Empty if none is.
    locked: Vec<bool>,
    /// The coarsest level that keeps what is locked.
    coarsest: Lod,
}

impl Simplified {
    /// Joins a mesh in collapse order and its sequence.
    ///
    /// # Errors
    /// If their sizes do not match.
    pub fn new(mesh: Mesh, collapses: CollapseSequence) -> Result<Self, SimplifiedError> {
        let (vertices, records) = (mesh.vertex_count(), collapses.records() as usize);
        if vertices != records + 1 && !(vertices == 0 && records == 0) {
            return Err(SimplifiedError::Records { vertices, records });
        }
        let (mesh_triangles, sequence_triangles) =
            (mesh.triangles().len(), collapses.parts().triangles as usize);
        if mesh_triangles != sequence_triangles {
            return Err(SimplifiedError::Triangles {
                mesh: mesh_triangles,
                sequence: sequence_triangles,
            });
        }
        let coarsest = collapses.last();
        Ok(Self { mesh, collapses, locked: Vec::new(), coarsest })
    }
    /// Locks vertices: whoever takes out levels takes none that lacks one of them, nor moves one.
    /// `locked` has an entry for each vertex, or none.
    ///
    /// # Panics
    /// If it has another number of entries.
    #[must_use]
    pub fn with_locked(self, locked: Vec<bool>) -> Self {
        if !locked.contains(&true) {
            let coarsest = self.collapses.last();
            return Self { locked: Vec::new(), coarsest, ..self };
        }
        assert_eq!(locked.len(), self.mesh.vertex_count(), "an entry for each vertex");
        // A position is kept while one of its vertices is: up to the LOD of the last one's number.
        let ids = self.mesh.position_ids();
        let mut last_vertex = vec![0; ids.len()];
        for (v, &id) in (0..).zip(&ids.of_vertex) {
            last_vertex[id as usize] = v;
        }
        let mut first_loss = self.collapses.last();
        for (&id, _) in ids.of_vertex.iter().zip(&locked).filter(|(_, locked)| **locked) {
            first_loss = first_loss.min(Lod(last_vertex[id as usize]));
        }
        let coarsest = self.collapses.floor(first_loss);
        Self { locked, coarsest, ..self }
    }
    /// Locks all vertices at some positions, as [`Self::with_locked`] does.
    #[must_use]
    pub fn with_locked_positions(self, positions: impl Iterator<Item = [f32; 3]>) -> Self {
        let mut keys: Vec<[u32; 3]> = positions.map(position_key).collect();
        if keys.is_empty() {
            return self.with_locked(Vec::new());
        }
        keys.sort_unstable();
        let is_locked = |&p: &[f32; 3]| keys.binary_search(&position_key(p)).is_ok();
        let locked = self.mesh.positions().iter().map(is_locked).collect();
        self.with_locked(locked)
    }
    /// By vertex: whether it is locked. Empty if none is.
    #[must_use]
    pub fn locked(&self) -> &[bool] {
        &self.locked
    }
    /// The positions of locked vertices, some more than once.
    pub fn locked_positions(&self) -> impl Iterator<Item = [f32; 3]> {
        let all = self.locked.iter().zip(self.mesh.positions());
        all.filter(|(locked, _)| **locked).map(|(_, &p)| p)
    }
    /// The coarsest level that keeps what is locked; the last one if nothing is.
    #[must_use]
    pub fn coarsest(&self) -> Lod {
        self.coarsest
    }
    /// Replaces the sequence's errors by measured distances in the mesh's units: the largest and
    /// the root mean square distance after each step.
    ///
    /// # Errors
    /// If there is not one of each for each step, or if they fall.
    pub fn with_distances(self, largest: Vec<f32>, rms: Vec<f32>) -> Result<Self, SequenceError> {
        let Self { mesh, collapses, locked, coarsest } = self;
        let mut parts = collapses.into_parts();
        (parts.step_errors, parts.step_rms) = (largest, rms);
        Ok(Self { mesh, collapses: CollapseSequence::try_from(parts)?, locked, coarsest })
    }
    /// The mesh in collapse order.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }
    /// The sequence.
    #[must_use]
    pub fn collapses(&self) -> &CollapseSequence {
        &self.collapses
    }
    /// The mesh and the sequence.
    #[must_use]
    pub fn into_parts(self) -> (Mesh, CollapseSequence) {
        (self.mesh, self.collapses)
    }
    /// Counts the vertices that the simplifier made: those that no triangle of LOD 0 uses.
    #[must_use]
    pub fn fakes(&self) -> usize {
        let mut used = vec![false; self.mesh.vertex_count()];
        for &v in self.mesh.triangles().as_flattened() {
            used[v as usize] = true;
        }
        used.iter().filter(|&&u| !u).count()
    }
    /// The reference: the input triangles with every vertex resolved, without those that have two
    /// corners at one position. Naive on purpose: everything else is judged by it. `lod` is not
    /// rounded to the end of a step.
    #[must_use]
    pub fn triangles_at(&self, lod: Lod) -> Vec<OrientedTriangle> {
        self.triangles_at_with(lod, &self.mesh.position_ids())
    }
    /// [`Self::triangles_at`] with the numbers of positions given, which saves time over many
    /// calls.
    #[must_use]
    pub fn triangles_at_with(&self, lod: Lod, positions: &PositionIds) -> Vec<OrientedTriangle> {
        let map = self.collapses.resolve_all(lod);
        let mut live = Vec::new();
        for (submesh, s) in self.mesh.submeshes().iter().enumerate() {
            for t in &self.mesh.triangles()[s.triangles()] {
                let corners = t.map(|v| map[v as usize]);
                if !is_degenerate(corners.map(|v| positions.of_vertex[v as usize])) {
                    live.push(OrientedTriangle::new(submesh as u32, corners));
                }
            }
        }
        live
    }
}

/// Why a mesh and a sequence do not belong together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplifiedError {
    /// A sequence has one record fewer than the mesh has vertices.
    #[error("{records} records do not fit {vertices} vertices")]
    Records {
        /// Vertices of the mesh.
        vertices: usize,
        /// Records of the sequence.
        records: usize,
    },
    /// The two disagree on the triangles of LOD 0.
    #[error("the mesh has {mesh} triangles, the sequence starts with {sequence}")]
    Triangles {
        /// Triangles of the mesh.
        mesh: usize,
        /// Triangles that the sequence starts with.
        sequence: usize,
    },
}
