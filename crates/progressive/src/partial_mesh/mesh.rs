//! The partial mesh that encoder and decoder both hold: vertices in stream order, triangles, and
//! the list of corners of each vertex.

use crate::partial_mesh::corner_lists::CornerLists;
use crate::partial_mesh::star::{NEXT, StarFace};
use lodc_mesh::NONE;
use std::hint::black_box;

/// The connectivity of a mesh that grows from a single vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartialMesh {
    /// The submesh of each vertex.
    pub(crate) submesh: Vec<u32>,
    /// The next vertex of the same step and position (the next wedge), in a circle.
    pub(crate) next_wedge: Vec<u32>,
    /// The corners of each vertex (4 × triangle + 0, 1 or 2), mostly in the order of a fan.
    pub(crate) corners: CornerLists,
    /// The vertices of each triangle; the fourth is unused.
    pub(crate) faces: Vec<[u32; 4]>,
}

impl PartialMesh {
    pub(crate) fn vertex_count(&self) -> u32 {
        self.submesh.len() as u32
    }

    pub(crate) fn face_count(&self) -> u32 {
        self.faces.len() as u32
    }

    /// Reserves memory for this many more vertices.
    pub(crate) fn reserve(&mut self, vertices: usize) {
        self.submesh.reserve_exact(vertices);
        self.next_wedge.reserve_exact(vertices);
        self.corners.reserve(vertices);
    }

    /// Adds a vertex without triangles and returns it.
    pub(crate) fn add_vertex(&mut self, submesh: u32) -> u32 {
        let new = self.vertex_count();
        self.submesh.push(submesh);
        self.next_wedge.push(new);
        self.corners.add_vertex();
        new
    }

    /// Puts a vertex after another one in its circle of wedges.
    pub(crate) fn add_wedge(&mut self, vertex: u32, after: u32) {
        self.next_wedge[vertex as usize] =
            std::mem::replace(&mut self.next_wedge[after as usize], vertex);
    }

    /// Returns the vertices of a triangle.
    pub(crate) fn face(&self, face: u32) -> [u32; 3] {
        let [x, y, z, _] = self.faces[face as usize];
        [x, y, z]
    }

    /// Collects the star of a vertex in the order of its corner list. Returns whether it is a
    /// single closed fan.
    #[inline]
    pub(crate) fn collect_star(&self, vertex: u32, star: &mut Vec<StarFace>) -> bool {
        star.clear();
        let mut is_chain = true;
        let mut end = NONE;
        let mut star_face = |corner: u32| {
            let face = &self.faces[corner as usize >> 2];
            let next = NEXT[corner as usize & 3] as usize & 3;
            let (a, b) = (face[next], face[NEXT[next] as usize & 3]);
            is_chain &= end == a || end == NONE;
            end = b;
            StarFace { corner, a, b }
        };
        match self.corners.inline(vertex) {
            Some(corners) => star.extend(corners.iter().map(|&corner| star_face(corner))),
            None => star.extend(self.corners.long_corners(vertex).map(star_face)),
        }
        is_chain && star.first().is_some_and(|first| first.a == end)
    }

    /// Returns a triangle as seen from a vertex; none if it is not in the star of that vertex.
    pub(crate) fn star_face(&self, face: u32, vertex: u32) -> Option<StarFace> {
        let corners = self.face(face);
        let index = corners.iter().position(|&v| v == vertex)?;
        let corner = 4 * face + index as u32;
        let star_face =
            StarFace { corner, a: corners[(index + 1) % 3], b: corners[(index + 2) % 3] };
        self.corners.contains(vertex, corner).then_some(star_face)
    }

    /// Loads the corner list of a vertex that is needed soon into the caches. Changes nothing.
    pub(crate) fn prefetch_corners(&self, vertex: u32) {
        black_box(self.corners.count(vertex));
    }

    /// Loads what `value` reads of the link of a vertex that is needed soon into the caches.
    /// Changes nothing.
    #[inline]
    pub(crate) fn prefetch_link(&self, vertex: u32, value: impl Fn(u32) -> i32) {
        let link_value =
            |&c: &u32| value(self.faces[c as usize >> 2][NEXT[c as usize & 3] as usize & 3]);
        let corners = self.corners.inline(vertex).unwrap_or_default().iter();
        black_box(corners.fold(0, |all, c| all ^ link_value(c)));
    }
}
