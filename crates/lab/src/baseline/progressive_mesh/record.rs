//! Records of a Progressive Mesh: for each edge collapse the fans that it rewrites and the edges
//! that triangles lose.

/// Some consecutive corners around a vertex: those that one side of a vertex split takes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fan {
    /// The corner where the fan begins.
    pub(super) corner: u32,
    /// Number of corners it has; the others follow counter-clockwise through the neighbour
    /// pointers.
    pub(super) corners: u32,
}

/// The records, which never change.
#[derive(Clone, Debug)]
pub(super) struct Records {
    /// The half-edge across each half-edge at LOD 0.
    pub(super) opposite: Vec<u32>,
    /// Start of each record's fans in `fans`, and end of the last one's. On a surface a
    /// record has one fan, or none if all its triangles die.
    pub(super) first_fan: Vec<u32>,
    pub(super) fans: Vec<Fan>,
    /// The half-edge that each triangle loses when it dies, in the order of removal LODs.
    pub(super) lost_edges: Vec<u32>,
    /// Where the edges of each step (all records of one collapse) end in `lost_edges`.
    pub(super) lost_ends: Vec<u32>,
    /// For each triangle the LOD from which on it is not drawn.
    pub(super) removal_lods: Vec<u32>,
}

impl Records {
    /// The fans that a record rewrites.
    pub(super) fn fans_of(&self, record: u32) -> &[Fan] {
        let ends = &self.first_fan[record as usize..=record as usize + 1];
        &self.fans[ends[0] as usize..ends[1] as usize]
    }

    /// The edges that triangles lose in a step, counted from 0.
    pub(super) fn lost_in(&self, step: usize) -> &[u32] {
        let start = if step == 0 { 0 } else { self.lost_ends[step - 1] };
        &self.lost_edges[start as usize..self.lost_ends[step] as usize]
    }
}
