//! Index lists of some levels of an object, joined into one array, the coarsest first.

use super::message::{Message, Tag};

/// Triangles in the lists of all levels of an object together: 24 MB of indices. Small objects have
/// fewer, large ones more; see [`factor`]. `listed` in `loader/model.js` has the same numbers.
/// Chosen by hand.
const LISTED_TRIANGLES: f64 = 2e6;

/// The least ratio of a level's triangles to those of the next coarser level, for an object of
/// `all_triangles` at LOD 0: 1.1 up to 180,000, 1.5 from 670,000 on. It bounds what is wasted:
/// where a level in between would do, at most so many times the needed triangles are drawn.
///
/// With ratio *f* all lists together are at most 1 + 1/*f* + 1/*f*² + … = *f* / (*f* − 1) times as
/// long as the finest. That number, `lists`, is what memory allows, but from 3 to 11; hence *f*.
fn factor(all_triangles: u32) -> f64 {
    let lists = (LISTED_TRIANGLES / f64::from(all_triangles)).clamp(3.0, 11.0);
    lists / (lists - 1.0)
}

/// Returns the largest number of triangles that the level after one of `triangles` may have, from
/// finest to coarsest.
#[cfg(feature = "file")]
pub(super) fn max_coarser(triangles: u32, all_triangles: u32) -> u32 {
    (f64::from(triangles) / factor(all_triangles)) as u32
}

/// Returns the smallest number of triangles that the level after one of `triangles` may have, from
/// coarsest to finest.
#[cfg(feature = "stream")]
pub(super) fn min_finer(triangles: u32, all_triangles: u32) -> u32 {
    (f64::from(triangles) * factor(all_triangles)).ceil() as u32
}

/// The indices of a level.
#[derive(Clone, Debug)]
pub(super) struct DecodedLevel {
    /// Upper bound of the distance from the input, in the object's units.
    pub(super) error: f32,
    /// Triangles of each submesh.
    pub(super) triangles: Vec<u32>,
    /// Three indices for each triangle, by submesh: vertices in stream order.
    pub(super) indices: Vec<u32>,
}

impl DecodedLevel {
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
pub(super) fn put(out: &mut Message, object: u32, first: usize, levels: &[DecodedLevel]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_small_and_all_lists_together_are_bounded() {
        for (all, most) in
            [(1, 1.1), (1000, 1.1), (180_000, 1.1), (400_000, 1.26), (9_000_000, 1.5)]
        {
            assert!(factor(all) <= most + 0.01, "{all}");
            let (mut triangles, mut sum) = (all, 0.0);
            while triangles > 0 {
                sum += f64::from(triangles);
                let coarser = max_coarser(triangles, all);
                assert!(coarser < triangles && min_finer(coarser, all) <= triangles, "{triangles}");
                triangles = coarser;
            }
            let lists = (LISTED_TRIANGLES / f64::from(all)).clamp(3.0, 11.0);
            assert!(sum <= lists * f64::from(all), "{all}: {sum}");
        }
    }
}
