//! A chain of levels over one vertex buffer, of which every level uses a prefix.

use crate::{Lod, Mesh, MeshError, MeshParts, Simplified, Submesh};

/// Triangles of a level by submesh.
pub type LevelTriangles = Vec<Vec<[u32; 3]>>;

/// Several levels of one mesh that share their vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The vertices of all levels, last to disappear first, with the triangles of the finest level.
    /// In every submesh the vertices of a level come before those that only finer levels use.
    pub mesh: Mesh,
    /// Triangles of each level by the vertices of `mesh`, in the order of levels.
    pub levels: Vec<LevelTriangles>,
    /// Number of vertices that have not disappeared at each level: it uses none beyond them.
    pub prefixes: Vec<u32>,
}

impl Simplified {
    /// Returns the levels at `lods`, of which the first is the finest.
    ///
    /// Vertices are numbered in the order in which they disappear, so the reverse of that order
    /// makes a prefix of every level.
    ///
    /// # Errors
    /// If there are more vertices or triangles than a mesh may have: never for LODs of this
    /// sequence.
    pub fn chain(&self, lods: &[Lod]) -> Result<Chain, MeshError> {
        let submeshes = self.mesh().submeshes().len();
        let by_submesh = |&lod: &Lod| -> LevelTriangles {
            let mut level = vec![Vec::new(); submeshes];
            for t in self.triangles_at(self.collapses().floor(lod)) {
                level[t.submesh as usize].push(t.corners);
            }
            level
        };
        let mut levels: Vec<LevelTriangles> = lods.iter().map(by_submesh).collect();

        let mut used: Vec<u32> = levels.iter().flatten().flatten().flatten().copied().collect();
        used.sort_unstable_by(|a, b| b.cmp(a));
        used.dedup();
        let number = |v: u32| used.partition_point(|&u| u > v) as u32;
        for corner in levels.iter_mut().flatten().flatten().flatten() {
            *corner = number(*corner);
        }
        let alive = |&lod: &Lod| {
            let lod = self.collapses().floor(lod).0;
            used.partition_point(|&v| v >= lod) as u32
        };
        let prefixes = lods.iter().map(alive).collect();
        let none = vec![Vec::new(); submeshes];
        let mesh = self.gathered(&used, levels.first().unwrap_or(&none))?;
        Ok(Chain { mesh, levels, prefixes })
    }

    /// The mesh of the vertices `sources`, with the given triangles by submesh.
    fn gathered(&self, sources: &[u32], level: &[Vec<[u32; 3]>]) -> Result<Mesh, MeshError> {
        let mesh = self.mesh();
        let mut first_triangle = 0;
        let submesh = |(s, triangles): (&Submesh, &Vec<[u32; 3]>)| {
            let triangle_count = triangles.len() as u32;
            let submesh =
                Submesh { first_triangle, triangle_count, attributes: s.attributes.clone() };
            first_triangle += triangle_count;
            submesh
        };
        let submeshes = mesh.submeshes().iter().zip(level).map(submesh).collect();
        Mesh::try_from(MeshParts {
            positions: sources.iter().map(|&v| mesh.positions()[v as usize]).collect(),
            vertex_submesh: sources.iter().map(|&v| mesh.vertex_submesh()[v as usize]).collect(),
            attributes: mesh
                .attributes()
                .iter()
                .map(|a| a.gathered(sources.iter().copied()))
                .collect(),
            triangles: level.concat(),
            submeshes,
        })
    }
}
