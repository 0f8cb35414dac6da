//! What the codec of triangle lists remembers, on both sides.

/// The 16 latest edges and vertices.
pub(crate) struct Recent {
    edges: [[u32; 2]; 16],
    vertices: [u32; 16],
    edge_at: usize,
    vertex_at: usize,
}

impl Default for Recent {
    fn default() -> Self {
        Self { edges: [[u32::MAX; 2]; 16], vertices: [u32::MAX; 16], edge_at: 0, vertex_at: 0 }
    }
}

impl Recent {
    /// Returns an edge by its age: 0 is the latest.
    pub(crate) fn edge(&self, back: usize) -> [u32; 2] {
        self.edges[(self.edge_at + 31 - back) & 15]
    }
    /// Returns a vertex by its age: 0 is the latest.
    pub(crate) fn vertex(&self, back: usize) -> u32 {
        self.vertices[(self.vertex_at + 31 - back) & 15]
    }
    pub(crate) fn push_edge(&mut self, edge: [u32; 2]) {
        self.edges[self.edge_at & 15] = edge;
        self.edge_at = (self.edge_at + 1) & 15;
    }
    pub(crate) fn push_vertex(&mut self, vertex: u32) {
        self.vertices[self.vertex_at & 15] = vertex;
        self.vertex_at = (self.vertex_at + 1) & 15;
    }
    pub(crate) fn forget_vertices(&mut self) {
        self.vertices = [u32::MAX; 16];
    }
}
