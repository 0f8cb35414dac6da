//! A chain: several levels of one mesh over one vertex buffer, of which every level uses a prefix.
//! A morphing chain also says where each vertex moves when the next level replaces its own
//! (geomorphing).

use crate::{Attribute, Lod, Mesh, MeshError, MeshParts, NONE, Semantic, Simplified, Submesh};

/// Triangles of a level by submesh.
pub type LevelTriangles = Vec<Vec<[u32; 3]>>;

/// Several levels of one mesh that share their vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The vertices of all levels by the last level that uses them, the coarsest first, with the
    /// triangles of the finest level. In every submesh the vertices of a level come before those
    /// that only finer levels use.
    pub mesh: Mesh,
    /// Triangles of each level by the vertices of `mesh`, in the order of levels.
    pub levels: Vec<LevelTriangles>,
    /// Number of vertices that each level or a coarser one uses: it uses none beyond them.
    pub prefixes: Vec<u32>,
}

/// A chain with what moves each level into the next one (geomorphing).
#[derive(Clone, Debug, PartialEq)]
pub struct MorphingChain {
    /// The levels; the mesh also has the vertices that others become without having a triangle.
    pub chain: Chain,
    /// For each vertex of the mesh the vertex that it becomes at the first level that does not use
    /// it; itself, if the last level does. If the vertices of level *k* are moved there, its
    /// triangles are those of level *k* + 1, at the same indices, and triangles without area.
    pub becomes: Vec<u32>,
}

impl MorphingChain {
    /// Returns the mesh with every vertex moved to what it becomes, without triangles. A vertex
    /// that becomes one of another submesh takes its position alone, and its normal if both have
    /// the same streams: its other values stay.
    #[must_use]
    pub fn next(&self) -> Mesh {
        let mesh = &self.chain.mesh;
        let submesh = |v: u32| mesh.vertex_submesh()[v as usize];
        let streams = |v: u32| &mesh.submeshes()[submesh(v) as usize].attributes;
        let sources = |is_taken: &dyn Fn(u32, u32) -> bool| -> Vec<u32> {
            let source = |(v, &to): (u32, &u32)| if is_taken(v, to) { to } else { v };
            (0..).zip(&self.becomes).map(source).collect()
        };
        let value_sources = sources(&|v, to| submesh(v) == submesh(to));
        let normal_sources = sources(&|v, to| streams(v) == streams(to));
        let attribute = |a: &Attribute| match a.semantic {
            _ if a.is_spatial() => a.gathered(self.becomes.iter().copied()),
            Semantic::Normal => a.gathered(normal_sources.iter().copied()),
            _ => a.gathered(value_sources.iter().copied()),
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

/// The last level of a chain that uses a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct LastUse {
    level: usize,
    vertex: u32,
}

impl Simplified {
    /// Returns the levels at `lods`, of which the first is the finest.
    ///
    /// # Errors
    /// If there are more vertices or triangles than a mesh may have: never for LODs of this
    /// sequence.
    pub fn chain(&self, lods: &[Lod]) -> Result<Chain, MeshError> {
        let (levels, used) = self.used(lods);
        self.chain_of(levels, &used, used.len())
    }

    /// Returns the levels at `lods`, which do not fall, and what each vertex becomes between
    /// one and the next.
    ///
    /// # Errors
    /// As [`Self::chain`].
    pub fn morphing_chain(&self, lods: &[Lod]) -> Result<MorphingChain, MeshError> {
        let (levels, mut used) = self.used(lods);
        let floors: Vec<Lod> = lods.iter().map(|&lod| self.collapses().floor(lod)).collect();
        // For each vertex of the input the vertex that it becomes, where it is removed.
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
        // One that the next level has, but without triangles, stays where it is.
        for &LastUse { level, vertex } in &used {
            let is_there = |floor: &Lod| vertex >= floor.0;
            if floors.get(level + 1).is_some_and(is_there) {
                becomes[vertex as usize] = vertex;
            }
        }
        // Vertices of the input by number, with those that no level uses, but that others become.
        let mut number = vec![NONE; self.mesh().vertex_count()];
        for (new, last_use) in (0..).zip(&used) {
            number[last_use.vertex as usize] = new;
        }
        let count = used.len();
        for i in 0..count {
            let to = becomes[used[i].vertex as usize];
            let slot = &mut number[to as usize];
            if *slot == NONE {
                *slot = used.len() as u32;
                // No level uses it: its level is not read.
                used.push(LastUse { level: 0, vertex: to });
            }
        }
        let becomes = (0..)
            .zip(&used)
            .map(|(own, last_use)| match own < count as u32 {
                true => number[becomes[last_use.vertex as usize] as usize],
                false => own,
            })
            .collect();
        Ok(MorphingChain { chain: self.chain_of(levels, &used, count)?, becomes })
    }

    /// Returns the triangles of the levels at `lods` by the vertices of this mesh, and the vertices
    /// that they use, by the last level that does: the coarsest first, and in each those first that
    /// disappear last.
    fn used(&self, lods: &[Lod]) -> (Vec<LevelTriangles>, Vec<LastUse>) {
        let by_submesh = |&lod: &Lod| -> LevelTriangles {
            let mut level = vec![Vec::new(); self.mesh().submeshes().len()];
            for t in self.triangles_at(self.collapses().floor(lod)) {
                level[t.submesh as usize].push(t.corners);
            }
            level
        };
        let levels: Vec<LevelTriangles> = lods.iter().map(by_submesh).collect();
        let mut last_level = vec![NONE; self.mesh().vertex_count()];
        for (number, level) in (0..).zip(&levels) {
            for &v in level.iter().flatten().flatten() {
                last_level[v as usize] = number;
            }
        }
        let last_uses = (0..).zip(last_level).filter(|&(_, level)| level != NONE);
        let mut used: Vec<LastUse> =
            last_uses.map(|(vertex, level)| LastUse { level: level as usize, vertex }).collect();
        used.sort_unstable_by(|a, b| b.cmp(a));
        (levels, used)
    }

    /// Returns the chain of levels by the vertices of this mesh. `vertices` are those of its own
    /// mesh in their order, of which levels use the first `used`.
    fn chain_of(
        &self,
        mut levels: Vec<LevelTriangles>,
        vertices: &[LastUse],
        used: usize,
    ) -> Result<Chain, MeshError> {
        let mut number = vec![NONE; self.mesh().vertex_count()];
        for (new, last_use) in (0..).zip(vertices) {
            number[last_use.vertex as usize] = new;
        }
        for corner in levels.iter_mut().flatten().flatten().flatten() {
            *corner = number[*corner as usize];
        }
        let prefix = |k| vertices[..used].partition_point(|last_use| last_use.level >= k) as u32;
        let prefixes = (0..levels.len()).map(prefix).collect();
        let sources: Vec<u32> = vertices.iter().map(|last_use| last_use.vertex).collect();
        let no_triangles = vec![Vec::new(); self.mesh().submeshes().len()];
        let mesh = self.gathered(&sources, levels.first().unwrap_or(&no_triangles))?;
        Ok(Chain { mesh, levels, prefixes })
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
        Mesh::try_from(mesh.with_vertices(sources, level.concat(), submeshes))
    }
}
