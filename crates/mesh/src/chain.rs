//! A chain: several levels of one mesh over one vertex buffer, of which every level uses a prefix.
//! A gliding chain also says where each vertex moves when the next level replaces its own
//! (geomorphing).

use crate::{Attribute, Lod, Mesh, MeshError, MeshParts, Simplified, Submesh};

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

/// A chain with what moves each level into the next one (geomorphing).
#[derive(Clone, Debug, PartialEq)]
pub struct GlidingChain {
    /// The levels; the mesh also has the vertices that others become without having a triangle.
    pub chain: Chain,
    /// For each vertex of the mesh the vertex that it becomes at the first level without it;
    /// itself, if the last level has it. If the vertices of level *k* are moved there, its
    /// triangles are those of level *k* + 1, at the same indices, and triangles without area.
    pub becomes: Vec<u32>,
}

impl GlidingChain {
    /// Returns the mesh with every vertex moved to what it becomes, without triangles. A vertex
    /// that becomes one of another submesh takes its position alone: its other values stay.
    #[must_use]
    pub fn next(&self) -> Mesh {
        let mesh = &self.chain.mesh;
        let submesh = |v: u32| mesh.vertex_submesh()[v as usize];
        let value_source = |(v, &to): (u32, &u32)| if submesh(v) == submesh(to) { to } else { v };
        let value_sources: Vec<u32> = (0..).zip(&self.becomes).map(value_source).collect();
        let attribute = |a: &Attribute| match a.is_spatial() {
            true => a.gathered(self.becomes.iter().copied()),
            false => a.gathered(value_sources.iter().copied()),
        };
        let parts = MeshParts {
            positions: self.becomes.iter().map(|&v| mesh.positions()[v as usize]).collect(),
            vertex_submesh: mesh.vertex_submesh().to_vec(),
            attributes: mesh.attributes().iter().map(attribute).collect(),
            triangles: Vec::new(),
            submeshes: mesh.submeshes().iter().map(without_triangles).collect(),
        };
        Mesh::try_from(parts).expect("values of vertices of a mesh")
    }
}

fn without_triangles(submesh: &Submesh) -> Submesh {
    Submesh { first_triangle: 0, triangle_count: 0, attributes: submesh.attributes.clone() }
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
        self.chain_with(lods, &[]).map(|(chain, _)| chain)
    }

    /// Returns the levels at `lods`, which do not fall, and what each vertex becomes between
    /// one and the next.
    ///
    /// # Errors
    /// As [`Self::chain`].
    pub fn gliding_chain(&self, lods: &[Lod]) -> Result<GlidingChain, MeshError> {
        let floors: Vec<Lod> = lods.iter().map(|&lod| self.collapses().floor(lod)).collect();
        // For each vertex of the input the vertex that it becomes.
        let mut becomes: Vec<u32> = (0..self.mesh().vertex_count() as u32).collect();
        for pair in floors.windows(2) {
            let removed = pair[0].0 as usize..pair[1].0 as usize;
            for v in removed.clone() {
                becomes[v] = self.collapses().targets()[v];
            }
            for v in removed.clone().rev() {
                // Targets have larger numbers: they are resolved already.
                let to = becomes[v] as usize;
                becomes[v] = if removed.contains(&to) { becomes[to] } else { to as u32 };
            }
        }
        let (chain, used) = self.chain_with(lods, &becomes)?;
        // A vertex without triangles may become one that is not in the mesh: it stays where it is.
        let number = |(own_number, &v): (usize, &u32)| {
            let to = becomes[v as usize];
            used.binary_search_by(|u| to.cmp(u)).unwrap_or(own_number) as u32
        };
        let becomes = used.iter().enumerate().map(number).collect();
        Ok(GlidingChain { chain, becomes })
    }

    /// Returns the chain, and the vertices in its mesh, falling: those that levels use, and those
    /// that they become (none if `becomes` is empty).
    fn chain_with(&self, lods: &[Lod], becomes: &[u32]) -> Result<(Chain, Vec<u32>), MeshError> {
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
        if !becomes.is_empty() {
            let mut with_targets: Vec<u32> = used.iter().map(|&v| becomes[v as usize]).collect();
            with_targets.append(&mut used);
            with_targets.sort_unstable_by(|a, b| b.cmp(a));
            with_targets.dedup();
            used = with_targets;
        }
        let number = |v: u32| used.partition_point(|&u| u > v) as u32;
        for corner in levels.iter_mut().flatten().flatten().flatten() {
            *corner = number(*corner);
        }
        let prefix = |&lod: &Lod| {
            let lod = self.collapses().floor(lod).0;
            used.partition_point(|&v| v >= lod) as u32
        };
        let prefixes = lods.iter().map(prefix).collect();
        let no_triangles = vec![Vec::new(); submeshes];
        let mesh = self.gathered(&used, levels.first().unwrap_or(&no_triangles))?;
        Ok((Chain { mesh, levels, prefixes }, used))
    }

    /// Returns the mesh of the vertices `sources`, with the triangles of a level by submesh.
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
