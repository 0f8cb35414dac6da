//! Extracts triangles of a mesh, such as a level of detail, as a mesh of its own.

use crate::{Mesh, MeshError, MeshParts, OrientedTriangle, Submesh};

impl Mesh {
    /// The mesh that `triangles` make: only the vertices they use, in the order of this mesh, with
    /// their attributes bit for bit. Every submesh is kept, also one without triangles; within a
    /// submesh triangles keep their order.
    ///
    /// # Errors
    /// If a triangle names a submesh or vertex that this mesh does not have, mixes submeshes or is
    /// degenerate.
    pub fn extract(&self, triangles: &[OrientedTriangle]) -> Result<Self, MeshError> {
        let mut new_index = vec![u32::MAX; self.vertex_count()];
        let mut counts = vec![0u32; self.submeshes().len()];
        for (triangle, t) in triangles.iter().enumerate() {
            let count = counts
                .get_mut(t.submesh as usize)
                .ok_or(MeshError::SubmeshRange { submesh: t.submesh as usize })?;
            *count += 1;
            for v in t.corners {
                *new_index.get_mut(v as usize).ok_or(MeshError::IndexOutOfRange { triangle })? = 0;
            }
        }
        let sources: Vec<u32> =
            (0..new_index.len() as u32).filter(|&v| new_index[v as usize] == 0).collect();
        for (new, &old) in sources.iter().enumerate() {
            new_index[old as usize] = new as u32;
        }

        let mut first_triangle = 0;
        let submeshes: Vec<Submesh> = (self.submeshes().iter().zip(&counts))
            .map(|(s, &triangle_count)| {
                let submesh =
                    Submesh { first_triangle, triangle_count, attributes: s.attributes.clone() };
                first_triangle += triangle_count;
                submesh
            })
            .collect();
        let mut next_slot: Vec<usize> =
            submeshes.iter().map(|s| s.first_triangle as usize).collect();
        let mut sorted = vec![[0; 3]; triangles.len()];
        for t in triangles {
            let slot = &mut next_slot[t.submesh as usize];
            sorted[*slot] = t.corners.map(|v| new_index[v as usize]);
            *slot += 1;
        }
        Self::try_from(self.with_vertices(&sources, sorted, submeshes))
    }

    /// The parts of a mesh of some of these vertices, in the order of `sources`, with triangles and
    /// submeshes that are numbered for it.
    pub(crate) fn with_vertices(
        &self,
        sources: &[u32],
        triangles: Vec<[u32; 3]>,
        submeshes: Vec<Submesh>,
    ) -> MeshParts {
        MeshParts {
            positions: sources.iter().map(|&v| self.positions()[v as usize]).collect(),
            vertex_submesh: sources.iter().map(|&v| self.vertex_submesh()[v as usize]).collect(),
            attributes: self
                .attributes()
                .iter()
                .map(|a| a.gathered(sources.iter().copied()))
                .collect(),
            triangles,
            submeshes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Attribute, Component, Semantic};

    fn two_submeshes() -> Mesh {
        let square =
            |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]];
        Mesh::try_from(MeshParts {
            positions: [square(0.0), square(2.0)].concat(),
            vertex_submesh: vec![0, 0, 0, 0, 1, 1, 1, 1],
            attributes: vec![Attribute {
                semantic: Semantic::Custom("_ID".to_owned()),
                morph_target: None,
                component: Component::U8,
                components: 1,
                normalized: false,
                bytes: (10..18).collect(),
            }],
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            submeshes: vec![
                Submesh { first_triangle: 0, triangle_count: 2, attributes: vec![0] },
                Submesh { first_triangle: 2, triangle_count: 2, attributes: vec![0] },
            ],
        })
        .expect("a valid mesh")
    }

    #[test]
    fn extraction_keeps_used_vertices_in_order_and_empty_submeshes() {
        let level = two_submeshes()
            .extract(&[OrientedTriangle::new(1, [6, 7, 4])])
            .expect("triangles of the mesh");
        assert_eq!(level.positions(), [[2.0, 0.0, 0.0], [3.0, 1.0, 0.0], [2.0, 1.0, 0.0]]);
        assert_eq!(level.triangles(), [[0, 1, 2]]);
        assert_eq!(level.attributes()[0].bytes, [14, 16, 17]);
        assert_eq!(level.vertex_submesh(), [1, 1, 1]);
        assert_eq!(level.submeshes().iter().map(|s| s.triangle_count).collect::<Vec<_>>(), [0, 1]);
    }

    #[test]
    fn extraction_groups_triangles_by_submesh() {
        let wanted = [(1, [4, 5, 6]), (0, [0, 2, 3]), (1, [4, 6, 7]), (0, [0, 1, 2])];
        let mesh = two_submeshes();
        let level = mesh
            .extract(&wanted.map(|(s, t)| OrientedTriangle::new(s, t)))
            .expect("triangles of the mesh");
        assert_eq!(level.triangles(), [[0, 2, 3], [0, 1, 2], [4, 5, 6], [4, 6, 7]]);
        assert_eq!(level.positions(), mesh.positions());
    }

    #[test]
    fn extraction_of_other_triangles_is_refused() {
        let mesh = two_submeshes();
        let refused = |submesh, corners| {
            mesh.extract(&[OrientedTriangle { submesh, corners }])
                .expect_err("triangles of another mesh")
        };
        assert_eq!(refused(2, [0, 1, 2]), MeshError::SubmeshRange { submesh: 2 });
        assert_eq!(refused(0, [0, 1, 8]), MeshError::IndexOutOfRange { triangle: 0 });
        assert_eq!(refused(0, [0, 1, 6]), MeshError::SharedVertex { triangle: 0 });
        assert_eq!(refused(0, [1, 1, 2]), MeshError::Degenerate { triangle: 0 });
    }
}
