//! The surroundings of the vertex split that is being coded: the parent's star and link, and the
//! triangles that are added.

use crate::invalid::InvalidStream;
use crate::partial_mesh::mesh::PartialMesh;
use crate::partial_mesh::new_triangle::{NewTriangle, Side};
use crate::partial_mesh::star::{LinkVertex, StarFace, collect_link, is_closed_fan};

/// The third corner of a new triangle at the split edge, with its index in the parent's link if it
/// is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apex {
    pub(crate) vertex: u32,
    pub(crate) link_index: Option<usize>,
}

/// The surroundings of the present split.
#[derive(Clone, Debug, Default)]
pub(crate) struct SplitNeighbourhood {
    pub(crate) new: u32,
    pub(crate) parent: u32,
    /// True if the step began with an earlier vertex.
    pub(crate) continued: bool,
    /// The sides on which earlier vertices of the step brought triangles: 1 left, 2 right, 3 both.
    pub(crate) sides: usize,
    /// The parent's star; of an explicit face list only the triangles that are transferred.
    pub(crate) star: Vec<StarFace>,
    /// True for an explicit face list: the triangles of the star are named by their numbers.
    pub(crate) is_named: bool,
    /// True if `star` is a single closed fan.
    pub(crate) closed: bool,
    /// The parent's link; unused if the star is closed, whose link follows from it.
    link: Vec<LinkVertex>,
    /// The triangles that the split adds.
    pub(crate) triangles: Vec<NewTriangle>,
    /// The expected transfer of each triangle of the star, see `corner_transfer`.
    pub(crate) expected: Vec<u8>,
    /// For each triangle of the star whether it is transferred.
    pub(crate) transfer: Vec<bool>,
}

impl SplitNeighbourhood {
    /// Starts a split; its star is collected or coded next.
    pub(crate) fn start(&mut self, new: u32, parent: u32, continued: bool) {
        let earlier = if continued { self.sides } else { 0 };
        let side = |t: &NewTriangle| match t.side {
            Side::Left => 1,
            Side::Right => 2,
            Side::Detached => 0,
        };
        let sides = self.triangles.iter().map(side);
        self.sides = if continued { sides.fold(earlier, |all, side| all | side) } else { 0 };
        (self.new, self.parent, self.continued) = (new, parent, continued);
        self.triangles.clear();
    }

    /// Collects the star of the parent and its link.
    pub(crate) fn collect_star(&mut self, mesh: &PartialMesh) {
        self.is_named = false;
        self.closed = mesh.collect_star(self.parent, &mut self.star);
        if !self.closed {
            collect_link(&self.star, &mut self.link);
        }
    }

    /// Collects the link of `self.star`, which holds the triangles of an explicit face list.
    pub(crate) fn finish_named_star(&mut self) {
        (self.is_named, self.closed) = (true, is_closed_fan(&self.star));
        if !self.closed {
            collect_link(&self.star, &mut self.link);
        }
    }

    /// Returns the number of vertices in the parent's link.
    #[inline]
    pub(crate) fn link_len(&self) -> usize {
        if self.closed { self.star.len() } else { self.link.len() }
    }

    /// Returns a vertex of the parent's link by its index.
    #[inline]
    pub(crate) fn link_vertex(&self, link_index: usize) -> LinkVertex {
        if !self.closed {
            return self.link[link_index];
        }
        let incoming = if link_index == 0 { self.star.len() } else { link_index } - 1;
        LinkVertex {
            vertex: self.star[link_index].a,
            outgoing: link_index as u32,
            incoming: incoming as u32,
        }
    }

    /// Returns the first index of a vertex in the parent's link.
    pub(crate) fn link_index_of(&self, vertex: u32) -> Option<usize> {
        (0..self.link_len()).position(|i| self.link_vertex(i).vertex == vertex)
    }

    /// Adds a triangle at the split edge.
    pub(crate) fn add_triangle(&mut self, side: Side, apex: Apex) {
        let (next, previous) = match side {
            Side::Left => (apex.vertex, self.parent),
            _ => (self.parent, apex.vertex),
        };
        let mut triangle = NewTriangle::unconnected(next, previous, side);
        if let Some(link_index) = apex.link_index {
            let link = self.link_vertex(link_index);
            (triangle.outgoing, triangle.incoming) = (link.outgoing, link.incoming);
        }
        self.triangles.push(triangle);
    }

    /// Returns an error if a new triangle, from number `from` on, is degenerate.
    pub(crate) fn check_corners(&self, from: usize) -> Result<(), InvalidStream> {
        let new = self.new;
        let is_degenerate =
            |t: &NewTriangle| t.next == t.previous || t.next == new || t.previous == new;
        if self.triangles[from..].iter().any(is_degenerate) {
            return Err(InvalidStream("has a degenerate triangle"));
        }
        Ok(())
    }

    /// Returns an error if a new triangle spans submeshes, given that of each vertex.
    pub(crate) fn check_submeshes(&self, submesh: &[u32]) -> Result<(), InvalidStream> {
        let is_other = |v: u32| submesh[v as usize] != submesh[self.new as usize];
        if self.triangles.iter().any(|t| is_other(t.next) || is_other(t.previous)) {
            return Err(InvalidStream("has a triangle across submeshes"));
        }
        Ok(())
    }
}
