//! Reorders a mesh: triangles in a given order, identical vertices merged, vertices in the order of
//! their first use.

use crate::{Mesh, NONE};

impl Mesh {
    /// Returns the mesh rearranged. Vertices of one submesh that are the same byte for byte are
    /// merged; then `order` gets the merged mesh and returns its triangles in the new order (each
    /// once, with its corners in their order, submesh by submesh); then vertices are numbered in
    /// the order in which triangles first use them. Vertices that no triangle uses are dropped.
    #[must_use]
    pub fn arranged(&self, order: impl FnOnce(&Self) -> Vec<[u32; 3]>) -> Self {
        let first_identical = self.first_of_identical();
        let mut parts = self.clone().into_parts();
        for corner in parts.triangles.iter_mut().flatten() {
            *corner = first_identical[*corner as usize];
        }
        let merged = Self::try_from(parts).expect("identical vertices are at one position");
        let mut triangles = order(&merged);
        let mut new_numbers = vec![NONE; merged.vertex_count()];
        // The old number of each vertex, by its new one.
        let mut sources = Vec::new();
        for corner in triangles.iter_mut().flatten() {
            let new_number = &mut new_numbers[*corner as usize];
            if *new_number == NONE {
                *new_number = sources.len() as u32;
                sources.push(*corner);
            }
            *corner = *new_number;
        }
        let gathered = self.with_vertices(&sources, triangles, self.submeshes().to_vec());
        Self::try_from(gathered).expect("triangles of this mesh in another order")
    }

    /// Returns for each vertex the first one of its submesh with the same bytes.
    fn first_of_identical(&self) -> Vec<u32> {
        let bits = |v: u32| self.positions()[v as usize].map(f32::to_bits);
        let submesh = |v: u32| self.vertex_submesh()[v as usize];
        let compare = |&a: &u32, &b: &u32| {
            let stored = &self.submeshes()[submesh(a) as usize].attributes;
            let streams = || stored.iter().map(|&s| &self.attributes()[s as usize]);
            let key_order = (submesh(a), bits(a)).cmp(&(submesh(b), bits(b)));
            key_order.then_with(|| streams().map(|s| s.at(a)).cmp(streams().map(|s| s.at(b))))
        };
        let mut sorted: Vec<u32> = (0..self.vertex_count() as u32).collect();
        sorted.sort_unstable_by(|a, b| compare(a, b).then(a.cmp(b)));
        let mut first = vec![0; sorted.len()];
        for same in sorted.chunk_by(|a, b| compare(a, b).is_eq()) {
            same.iter().for_each(|&v| first[v as usize] = same[0]);
        }
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshParts;
    use crate::Submesh;

    #[test]
    fn identical_vertices_become_one_and_all_are_numbered_by_first_use() {
        let corner = |x: f32, y: f32| [x, y, 0.0];
        let mesh = Mesh::try_from(MeshParts {
            positions: vec![
                corner(0.0, 0.0),
                corner(1.0, 0.0),
                corner(1.0, 1.0),
                corner(0.0, 0.0),
                corner(1.0, 1.0),
                corner(0.0, 1.0),
            ],
            vertex_submesh: vec![0; 6],
            attributes: vec![],
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            submeshes: vec![Submesh { first_triangle: 0, triangle_count: 2, attributes: vec![] }],
        })
        .expect("a square of two triangles");
        let reversed = |m: &Mesh| m.triangles().iter().rev().copied().collect();
        let arranged = mesh.arranged(reversed);
        assert_eq!(arranged.triangles(), [[0, 1, 2], [0, 3, 1]]);
        let expected = [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0), corner(1.0, 0.0)];
        assert_eq!(arranged.positions(), expected);
    }
}
