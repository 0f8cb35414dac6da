//! Tables that a cursor reads and never changes: the triangles of each vertex, and the order in
//! which triangles and vertices disappear.

use lodc_mesh::Simplified;

/// Triangles by vertex and by removal LOD, vertices by removal LOD.
#[derive(Clone, Debug)]
pub(super) struct Index {
    /// Start of each vertex's triangles in `incident`, and end of the last one's.
    first: Vec<u32>,
    /// Triangles around each vertex, the longest-lived first.
    incident: Vec<u32>,
    /// All triangles, the first to die first.
    pub(super) triangles: Vec<u32>,
    /// All vertices that triangles use, the first to lose its last triangle first.
    pub(super) vertices: Vec<u32>,
    /// The LOD at which each vertex's last triangle dies, 0 if it has none.
    pub(super) vertex_removal_lods: Vec<u32>,
    /// The vertex as which each of `vertices` is shown when it loses its last triangle.
    pub(super) shown_at_removal: Vec<u32>,
}

impl Index {
    pub(super) fn new(simplified: &Simplified, removal_lods: &[u32]) -> Self {
        let mesh = simplified.mesh();
        let levels = simplified.collapses().records() as usize + 1;
        let triangles = sorted_by(removal_lods.len(), levels, |t| removal_lods[t]);
        let mut first = vec![0; mesh.vertex_count() + 1];
        for &v in mesh.triangles().as_flattened() {
            first[v as usize + 1] += 1;
        }
        for v in 0..mesh.vertex_count() {
            first[v + 1] += first[v];
        }
        let mut next_slot = first.clone();
        let mut incident = vec![0; 3 * removal_lods.len()];
        for &t in triangles.iter().rev() {
            for v in mesh.triangles()[t as usize] {
                incident[next_slot[v as usize] as usize] = t;
                next_slot[v as usize] += 1;
            }
        }
        let mut index = Self {
            first,
            incident,
            triangles,
            vertices: Vec::new(),
            vertex_removal_lods: Vec::new(),
            shown_at_removal: Vec::new(),
        };
        let last = |v| index.incident(v).first().map_or(0, |&t| removal_lods[t as usize]);
        index.vertex_removal_lods = (0..mesh.vertex_count() as u32).map(last).collect();
        // Removal LOD 0 stands for vertices without triangles: they are left out.
        index.vertices = sorted_by(mesh.vertex_count(), levels, |v| index.vertex_removal_lods[v]);
        let unused = index.vertices.partition_point(|&v| index.incident(v).is_empty());
        index.vertices.drain(..unused);
        index.shown_at_removal = index.resolve_at_removal(simplified.collapses().targets());
        index
    }

    /// The vertex as which each of `vertices` is shown at its removal LOD: union-find with path
    /// halving. Removal LODs rise, so every shortcut stays valid.
    fn resolve_at_removal(&self, targets: &[u32]) -> Vec<u32> {
        let mut shortcut = targets.to_vec();
        let resolve = |&vertex: &u32| {
            let (mut v, removal_lod) = (vertex, self.vertex_removal_lods[vertex as usize]);
            while v < removal_lod {
                let next = shortcut[v as usize];
                if next < removal_lod {
                    shortcut[v as usize] = shortcut[next as usize];
                }
                v = next;
            }
            v
        };
        self.vertices.iter().map(resolve).collect()
    }

    /// The triangles of LOD 0 around a vertex, the longest-lived first.
    pub(super) fn incident(&self, vertex: u32) -> &[u32] {
        &self.incident
            [self.first[vertex as usize] as usize..self.first[vertex as usize + 1] as usize]
    }
}

/// `0..count` sorted by a key below `keys`, equal keys in order: counting sort.
fn sorted_by(count: usize, keys: usize, key: impl Fn(usize) -> u32) -> Vec<u32> {
    let mut next_slot = vec![0u32; keys + 1];
    for i in 0..count {
        next_slot[key(i) as usize + 1] += 1;
    }
    for k in 0..keys {
        next_slot[k + 1] += next_slot[k];
    }
    let mut sorted = vec![0; count];
    for i in 0..count {
        let slot = &mut next_slot[key(i) as usize];
        sorted[*slot as usize] = i as u32;
        *slot += 1;
    }
    sorted
}
