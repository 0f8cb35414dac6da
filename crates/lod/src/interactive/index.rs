//! Tables that a cursor reads and never changes: the triangles of each vertex, and the order in
//! which triangles and vertices disappear.

use lodc_mesh::Simplified;

/// Triangles by vertex and by removal LOD, vertices by removal LOD.
#[derive(Clone, Debug)]
pub(super) struct Index {
    /// Start of each vertex's triangles in `incident`, and end of the last one's.
    incident_starts: Vec<u32>,
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
        let lod_count = simplified.collapses().records() as usize + 1;
        let triangles = sorted_by(removal_lods.len(), lod_count, |t| removal_lods[t]);
        let mut incident_starts = vec![0; mesh.vertex_count() + 1];
        for &v in mesh.triangles().as_flattened() {
            incident_starts[v as usize + 1] += 1;
        }
        for v in 0..mesh.vertex_count() {
            incident_starts[v + 1] += incident_starts[v];
        }
        let mut next_slot = incident_starts.clone();
        let mut incident = vec![0; 3 * removal_lods.len()];
        for &t in triangles.iter().rev() {
            for v in mesh.triangles()[t as usize] {
                incident[next_slot[v as usize] as usize] = t;
                next_slot[v as usize] += 1;
            }
        }
        let mut index = Self {
            incident_starts,
            incident,
            triangles,
            vertices: Vec::new(),
            vertex_removal_lods: Vec::new(),
            shown_at_removal: Vec::new(),
        };
        let last_removal_lod =
            |v| index.incident(v).first().map_or(0, |&t| removal_lods[t as usize]);
        index.vertex_removal_lods = (0..mesh.vertex_count() as u32).map(last_removal_lod).collect();
        // Removal LOD 0 stands for vertices without triangles: they are left out.
        index.vertices =
            sorted_by(mesh.vertex_count(), lod_count, |v| index.vertex_removal_lods[v]);
        let unused = index.vertices.partition_point(|&v| index.incident(v).is_empty());
        index.vertices.drain(..unused);
        index.shown_at_removal = index.resolve_at_removal(simplified.collapses().targets());
        index
    }

    /// Returns the vertex as which each of `vertices` is shown at its removal LOD: union-find with
    /// path halving. Removal LODs rise, so every shortcut stays valid.
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
        let [start, end] = [0, 1].map(|i| self.incident_starts[vertex as usize + i] as usize);
        &self.incident[start..end]
    }
}

/// Returns `0..count` sorted by a key below `key_count`, equal keys in order: counting sort.
fn sorted_by(count: usize, key_count: usize, key: impl Fn(usize) -> u32) -> Vec<u32> {
    let mut next_slot = vec![0u32; key_count + 1];
    for i in 0..count {
        next_slot[key(i) as usize + 1] += 1;
    }
    for k in 0..key_count {
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
