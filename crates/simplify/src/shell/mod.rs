//! Before the first step: faces that lie on others are put aside, and follow them.
//!
//! Exporters write capes, leaves and cloth twice, with the back as faces of its own, and some
//! meshes have all their faces, or some, two times. To edges and stars that is a tangle: the rim of
//! a sheet looks like a fold, and every edge inside like a seam of four faces. But it is one
//! surface. So one layer of it, the *shell*, is simplified as if it were alone, and then all faces
//! follow: whatever moves in the shell moves in the whole mesh, where each wedge of each layer gets
//! a target of its own. A doubled mesh thus loses the same positions in the same order as the
//! single one.
//!
//! The input is a mesh; the output is the shell as a mesh (`layers` finds it), and later the
//! log of the shell's collapses carried out on the whole mesh (`follow`).

mod follow;
mod layers;

pub(crate) use follow::{follow, layer_collapses};

use crate::number::{FollowerPlane, Input};
use glam::DVec3;
use lodc_mesh::{Mesh, MeshParts, NONE, PositionIds, Submesh, WedgeGroups};

/// The shell is made anew at most this often because groups of the whole mesh are split in it.
/// Chosen by hand.
const MAX_TRIES: usize = 8;

/// One layer of a mesh whose faces lie on each other in places.
pub(crate) struct Shell {
    /// The faces that lie on no other, and one of each stack of faces that lie on each other.
    pub(crate) mesh: Mesh,
    /// The vertex of the whole mesh that each vertex is.
    pub(crate) vertices: Vec<u32>,
    /// Faces of quadrilaterals that are divided along both diagonals.
    divided_otherwise: Vec<layers::WeightedFace>,
}

impl Shell {
    /// The shell of a mesh; none if no faces lie on each other.
    pub(crate) fn of(mesh: &Mesh, positions: &PositionIds) -> Option<Self> {
        let (mut follows, mut divided_otherwise) = layers::followers(mesh, positions)?;
        let whole = WedgeGroups::new(mesh, positions);
        for _ in 0..MAX_TRIES {
            let mut shell = Self::without(mesh, &follows);
            if !shell.keep_split_groups(mesh, &whole, &mut follows) {
                // Faces that follow no more are in the shell, whose planes count in full.
                divided_otherwise.retain(|&(face, w)| follows[face as usize] == (w > 0.0));
                shell.divided_otherwise = divided_otherwise;
                return Some(shell);
            }
            if !follows.contains(&true) {
                break;
            }
        }
        None
    }

    /// The faces that do not follow others, with their vertices, both in the order of the mesh:
    /// ties are broken by numbers, as in a mesh that has no other faces.
    fn without(mesh: &Mesh, follows: &[bool]) -> Self {
        let mut is_used = vec![false; mesh.vertex_count()];
        let stays = || mesh.triangles().iter().zip(follows).filter(|(_, follows)| !**follows);
        stays().flat_map(|(t, _)| t).for_each(|&v| is_used[v as usize] = true);
        let vertices: Vec<u32> =
            (0..mesh.vertex_count() as u32).filter(|&v| is_used[v as usize]).collect();
        let mut new_index = vec![NONE; mesh.vertex_count()];
        (0..).zip(&vertices).for_each(|(new, &v)| new_index[v as usize] = new);
        let mut triangles = Vec::new();
        let mut submeshes = Vec::with_capacity(mesh.submeshes().len());
        for submesh in mesh.submeshes() {
            let first = triangles.len();
            let own = submesh.triangles().filter(|&t| !follows[t]);
            triangles.extend(own.map(|t| mesh.triangles()[t].map(|v| new_index[v as usize])));
            submeshes.push(Submesh {
                first_triangle: first as u32,
                triangle_count: (triangles.len() - first) as u32,
                attributes: submesh.attributes.clone(),
            });
        }
        let gathered = |a: &lodc_mesh::Attribute| a.gathered(vertices.iter().copied());
        let mesh = Mesh::try_from(MeshParts {
            positions: vertices.iter().map(|&v| mesh.positions()[v as usize]).collect(),
            vertex_submesh: vertices.iter().map(|&v| mesh.vertex_submesh()[v as usize]).collect(),
            attributes: mesh.attributes().iter().map(gathered).collect(),
            triangles,
            submeshes,
        })
        .expect("some of a mesh's triangles, with their vertices, are a mesh");
        Self { mesh, vertices, divided_otherwise: Vec::new() }
    }

    /// Finds groups of the whole mesh that are several groups of the shell, since only following
    /// faces connect them; these faces become part of the next shell. Returns whether there are
    /// such groups.
    fn keep_split_groups(&self, mesh: &Mesh, whole: &WedgeGroups, follows: &mut [bool]) -> bool {
        let groups = WedgeGroups::new(&self.mesh, &self.mesh.position_ids());
        let mut of_whole = vec![NONE; whole.len()];
        let mut split = vec![false; whole.len()];
        let mut any = false;
        for (&group, &vertex) in groups.of_vertex.iter().zip(&self.vertices) {
            let in_whole = whole.of_vertex[vertex as usize] as usize;
            if of_whole[in_whole] == NONE {
                of_whole[in_whole] = group;
            } else if of_whole[in_whole] != group {
                split[in_whole] = true;
                any = true;
            }
        }
        if any {
            for (follows, triangle) in follows.iter_mut().zip(mesh.triangles()) {
                *follows &= !triangle.iter().any(|&v| split[whole.of_vertex[v as usize] as usize]);
            }
        }
        any
    }

    /// The planes of quadrilaterals that are divided along both diagonals, with areas that are
    /// added to those of the shell's faces so that either division counts half: what is flat for
    /// one layer may not be for the other.
    pub(crate) fn planes(
        &self,
        mesh: &Mesh,
        positions: &PositionIds,
        input: &Input<'_>,
    ) -> Vec<FollowerPlane> {
        if self.divided_otherwise.is_empty() {
            return Vec::new();
        }
        let mut group_at = vec![NONE; positions.len()];
        for (&group, &vertex) in input.group_of.iter().zip(&self.vertices) {
            group_at[positions.of_vertex[vertex as usize] as usize] = group;
        }
        let mut planes = Vec::with_capacity(3 * self.divided_otherwise.len());
        for &(face, weight) in &self.divided_otherwise {
            let corners = mesh.triangles()[face as usize];
            let position = |v: u32| DVec3::from(mesh.positions()[v as usize].map(f64::from));
            let [a, b, c] = corners.map(|v| input.scale * position(v));
            let normal = (b - a).cross(c - a);
            planes.extend(corners.map(|v| FollowerPlane {
                group: group_at[positions.of_vertex[v as usize] as usize],
                unit_normal: normal.normalize_or_zero(),
                area: 0.5 * weight * normal.length(),
            }));
        }
        planes.sort_by_key(|plane| plane.group);
        planes
    }

    /// For each vertex of the shell: true if a vertex of its group, in any layer, is locked.
    pub(crate) fn locked(
        &self,
        mesh: &Mesh,
        positions: &PositionIds,
        locked: &[bool],
    ) -> Vec<bool> {
        if !locked.contains(&true) {
            return Vec::new();
        }
        let groups = WedgeGroups::new(mesh, positions);
        let mut is_locked = vec![false; groups.len()];
        for (&group, _) in groups.of_vertex.iter().zip(locked).filter(|(_, locked)| **locked) {
            is_locked[group as usize] = true;
        }
        let is_vertex_locked = |&v: &u32| is_locked[groups.of_vertex[v as usize] as usize];
        self.vertices.iter().map(is_vertex_locked).collect()
    }
}

#[cfg(test)]
mod tests;
