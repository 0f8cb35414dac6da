//! Index lists of some levels of an object, joined into one array, the coarsest first.

use super::message::{Message, Tag};

/// A level has at least this many times the triangles of the one before: all lists together are at
/// most three times as long as that of the finest level, and a third of what is drawn is too much.
const FACTOR: f64 = 1.5;

/// Returns the most triangles of the next coarser level.
#[cfg(feature = "file")]
pub(super) fn coarser(triangles: u32) -> u32 {
    (f64::from(triangles) / FACTOR) as u32
}

/// Returns the least triangles of the next finer level.
#[cfg(feature = "stream")]
pub(super) fn finer(triangles: u32) -> u32 {
    (f64::from(triangles) * FACTOR).ceil() as u32
}

/// The indices of a level.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// Upper bound of the distance from the input, in the object's units.
    pub(super) error: f32,
    /// Triangles of each submesh.
    pub(super) triangles: Vec<u32>,
    /// Three for each of them, by submesh.
    pub(super) indices: Vec<u32>,
}

impl Level {
    /// A level of triangles whose corners are vertices in stream order.
    pub(super) fn new(
        error: f32,
        submeshes: usize,
        triangles: impl Iterator<Item = (u32, [u32; 3])> + Clone,
    ) -> Self {
        let mut counts = vec![0; submeshes];
        for (submesh, _) in triangles.clone() {
            counts[submesh as usize] += 1;
        }
        let mut place = vec![0; submeshes];
        for submesh in 1..submeshes {
            place[submesh] = place[submesh - 1] + 3 * counts[submesh - 1] as usize;
        }
        let mut indices = vec![0; 3 * counts.iter().sum::<u32>() as usize];
        for (submesh, corners) in triangles {
            let at = &mut place[submesh as usize];
            indices[*at..*at + 3].copy_from_slice(&corners);
            *at += 3;
        }
        Self { error, triangles: counts, indices }
    }
}

/// Appends levels of an object, whose indices begin behind `first` others: the object's number, the
/// number of levels, for each its error (f32) and the triangles of each submesh; `first`; all
/// indices. What was there from `first` on is no longer.
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
