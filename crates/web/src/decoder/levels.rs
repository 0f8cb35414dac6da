//! Index lists of some levels of an object, joined into one array, the coarsest first.

use super::message::{Message, Tag};

/// A level has at least this many times the triangles of the one before, so all lists together are
/// at most three times as long as that of the finest level. Where a level in between would do, up
/// to a third of the triangles drawn are too many.
const TRIANGLE_FACTOR: f64 = 1.5;

/// Returns the largest number of triangles of the next coarser level.
#[cfg(feature = "file")]
pub(super) fn max_coarser(triangles: u32) -> u32 {
    (f64::from(triangles) / TRIANGLE_FACTOR) as u32
}

/// Returns the smallest number of triangles of the next finer level.
#[cfg(feature = "stream")]
pub(super) fn min_finer(triangles: u32) -> u32 {
    (f64::from(triangles) * TRIANGLE_FACTOR).ceil() as u32
}

/// The indices of a level.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// Upper bound of the distance from the input, in the object's units.
    pub(super) error: f32,
    /// Triangles of each submesh.
    pub(super) triangles: Vec<u32>,
    /// Three indices for each triangle, by submesh: vertices in stream order.
    pub(super) indices: Vec<u32>,
}

impl Level {
    /// A level of triangles: each its submesh and its corners, vertices in stream order.
    pub(super) fn new(
        error: f32,
        submeshes: usize,
        triangles: impl Iterator<Item = (u32, [u32; 3])> + Clone,
    ) -> Self {
        let mut counts = vec![0; submeshes];
        for (submesh, _) in triangles.clone() {
            counts[submesh as usize] += 1;
        }
        let mut next_index = vec![0; submeshes];
        for submesh in 1..submeshes {
            next_index[submesh] = next_index[submesh - 1] + 3 * counts[submesh - 1] as usize;
        }
        let mut indices = vec![0; 3 * counts.iter().sum::<u32>() as usize];
        for (submesh, corners) in triangles {
            let next = &mut next_index[submesh as usize];
            indices[*next..*next + 3].copy_from_slice(&corners);
            *next += 3;
        }
        Self { error, triangles: counts, indices }
    }
}

/// Appends a chunk with levels of an object: the object's number, the number of levels, for each
/// its error (f32) and the triangles of each submesh; `first`; all indices. They replace the
/// indices of the object from the index `first` on.
pub(super) fn put(out: &mut Message, object: u32, first: usize, levels: &[Level]) {
    out.chunk(Tag::Levels, |m| {
        m.words([object, levels.len() as u32]);
        for level in levels {
            m.word(level.error.to_bits());
            m.words(level.triangles.iter().copied());
        }
        m.word(first as u32);
        levels.iter().for_each(|level| m.words(level.indices.iter().copied()));
    });
}
