//! A simulated vertex cache: counts how often a stream of indices asks for a vertex that it does
//! not hold. The numbers ACMR and ATVR of the literature come from here.

/// The rule by which a full cache gives up a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CacheKind {
    /// The one fetched first.
    Fifo,
    /// The one not used for longest.
    Lru,
}

/// A vertex cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CacheModel {
    /// The replacement rule.
    pub kind: CacheKind,
    /// Number of vertices it holds.
    pub size: u32,
}

impl Default for CacheModel {
    /// The usual model: first in, first out, 16 vertices.
    fn default() -> Self {
        Self { kind: CacheKind::Fifo, size: 16 }
    }
}

/// The cost of a stream of indices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheStatistics {
    /// Vertices that had to be fetched.
    pub misses: u64,
    /// Different vertices in the stream.
    pub vertices: u64,
}

impl CacheStatistics {
    /// Average cache miss ratio: misses per triangle, from 0.5 (ideal, large closed meshes) to 3.
    /// Zero without triangles.
    #[must_use]
    pub fn acmr(&self, triangles: usize) -> f64 {
        if triangles == 0 { 0.0 } else { self.misses as f64 / triangles as f64 }
    }
    /// Average transform to vertex ratio: misses per vertex, 1 or more. Zero without vertices.
    #[must_use]
    pub fn atvr(&self) -> f64 {
        if self.vertices == 0 { 0.0 } else { self.misses as f64 / self.vertices as f64 }
    }
}

/// Sends a stream of indices through a cache that starts empty. `vertex_count` is more than every
/// index.
///
/// # Panics
/// If an index is not below `vertex_count`.
pub fn measure(
    stream: impl IntoIterator<Item = u32>,
    vertex_count: usize,
    model: CacheModel,
) -> CacheStatistics {
    let mut statistics = CacheStatistics::default();
    match model.kind {
        CacheKind::Fifo => {
            // The number of the miss that fetched a vertex, from 1: it is gone once `size` more
            // have followed.
            let mut fetched = vec![0u64; vertex_count];
            for v in stream {
                let v = v as usize;
                statistics.vertices += u64::from(fetched[v] == 0);
                if fetched[v] == 0 || statistics.misses - fetched[v] >= u64::from(model.size) {
                    statistics.misses += 1;
                    fetched[v] = statistics.misses;
                }
            }
        }
        CacheKind::Lru => {
            let mut seen = vec![false; vertex_count];
            let mut cache: Vec<u32> = Vec::new();
            for v in stream {
                statistics.vertices += u64::from(!seen[v as usize]);
                seen[v as usize] = true;
                if let Some(index) = cache.iter().position(|&c| c == v) {
                    cache[..=index].rotate_right(1);
                    continue;
                }
                statistics.misses += 1;
                cache.insert(0, v);
                cache.truncate(model.size as usize);
            }
        }
    }
    statistics
}
