//! Triangle strips as index lists, submesh by submesh, which triangles they draw, and a proof that
//! these are the mesh's.

use lodc_mesh::{Mesh, NONE, OrientedTriangle, PositionIds, is_degenerate};
use std::ops::Range;

/// Triangle strips of a mesh, submesh by submesh; a strip never crosses from one submesh to
/// another.
///
/// A strip `s` draws the triangles `s[k], s[k + 1], s[k + 2]`, every second one (odd `k`) with its
/// first two corners exchanged. One that names a vertex twice is not drawn: repeating a
/// vertex is how a strip turns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StripSet {
    indices: Vec<u32>,
    /// End of each strip.
    ends: Vec<u32>,
    /// Number of strips up to the end of each submesh.
    submesh_ends: Vec<u32>,
}

impl StripSet {
    /// Strips for `submeshes` submeshes from strips in any order, each with its submesh. Within a
    /// submesh the order is kept.
    pub(crate) fn new(submeshes: usize, strips: &[(u32, Range<usize>)], indices: &[u32]) -> Self {
        let mut sorted: Vec<&(u32, Range<usize>)> = strips.iter().collect();
        sorted.sort_by_key(|(submesh, _)| *submesh);
        let mut set = Self { indices: Vec::with_capacity(indices.len()), ..Self::default() };
        let mut next = sorted.into_iter().peekable();
        for submesh in 0..submeshes as u32 {
            while let Some((_, range)) = next.next_if(|(s, _)| *s == submesh) {
                set.indices.extend_from_slice(&indices[range.clone()]);
                set.ends.push(set.indices.len() as u32);
            }
            set.submesh_ends.push(set.ends.len() as u32);
        }
        set
    }
    /// Strips from stored arrays: the indices of all strips, where each strip ends among them, and
    /// where each submesh's strips end among the strips.
    ///
    /// # Errors
    /// If ends fall, or the last ones are not the ends of everything.
    pub fn from_parts(
        indices: Vec<u32>,
        ends: Vec<u32>,
        submesh_ends: Vec<u32>,
    ) -> Result<Self, StripSetError> {
        let rises = |ends: &[u32], all: usize| {
            ends.is_sorted() && ends.last().map_or(0, |&e| e as usize) == all
        };
        if rises(&ends, indices.len()) && rises(&submesh_ends, ends.len()) {
            Ok(Self { indices, ends, submesh_ends })
        } else {
            Err(StripSetError::Ends)
        }
    }
    /// Returns the number of strips.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }
    /// Returns whether there is no strip.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }
    /// The vertices of all strips, one strip after the other.
    #[must_use]
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }
    /// Returns the range of a strip in [`StripSet::indices`].
    ///
    /// # Panics
    /// If there is no such strip.
    #[must_use]
    pub fn range(&self, strip: usize) -> Range<usize> {
        let first = if strip == 0 { 0 } else { self.ends[strip - 1] };
        first as usize..self.ends[strip] as usize
    }
    /// The submesh of each strip.
    pub fn submeshes(&self) -> impl Iterator<Item = u32> {
        (0..)
            .zip(&self.submesh_ends)
            .scan(0, |first, (submesh, &end)| {
                let strips = end - std::mem::replace(first, end);
                Some(std::iter::repeat_n(submesh, strips as usize))
            })
            .flatten()
    }
    /// The vertices of a strip.
    ///
    /// # Panics
    /// If there is no such strip.
    #[must_use]
    pub fn strip(&self, strip: usize) -> &[u32] {
        &self.indices[self.range(strip)]
    }
    /// All strips, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.len()).map(|s| self.strip(s))
    }
    /// The strips of a submesh.
    ///
    /// # Panics
    /// If there is no such submesh.
    #[must_use]
    pub fn submesh(&self, submesh: usize) -> Range<usize> {
        let first = if submesh == 0 { 0 } else { self.submesh_ends[submesh - 1] };
        first as usize..self.submesh_ends[submesh] as usize
    }
    /// Returns the number of submeshes, with strips or without.
    #[must_use]
    pub fn submesh_count(&self) -> usize {
        self.submesh_ends.len()
    }
    /// Returns the number of indices that are drawn if every strip is a call of its own.
    #[must_use]
    pub fn separate_indices(&self) -> u64 {
        self.indices.len() as u64
    }
    /// Returns the number of indices of one buffer with a restart index between strips.
    #[must_use]
    pub fn restart_indices(&self) -> u64 {
        (self.indices.len() + self.len().saturating_sub(1)) as u64
    }
    /// All triangles drawn, submesh by submesh, in drawing order.
    pub fn triangles(&self) -> impl Iterator<Item = OrientedTriangle> {
        (0..self.submesh_count()).flat_map(move |submesh| {
            let strips = self.submesh(submesh).flat_map(move |s| strip_triangles(self.strip(s)));
            strips.map(move |t| OrientedTriangle::new(submesh as u32, t))
        })
    }
    /// Proves that the strips draw exactly the mesh's oriented triangles, each as often as it is
    /// there.
    ///
    /// # Errors
    /// The first triangle that is drawn too often or not often enough, in order of submesh and
    /// corners.
    pub fn check(&self, mesh: &Mesh) -> Result<(), StripSetError> {
        if self.submesh_count() != mesh.submeshes().len() {
            let (found, wanted) = (self.submesh_count(), mesh.submeshes().len());
            return Err(StripSetError::Submeshes { found, wanted });
        }
        let mut drawn: Vec<OrientedTriangle> = self.triangles().collect();
        let mut wanted: Vec<OrientedTriangle> = Vec::with_capacity(mesh.triangles().len());
        for (i, submesh) in mesh.submeshes().iter().enumerate() {
            wanted.extend(
                mesh.triangles()[submesh.triangles()]
                    .iter()
                    .map(|&t| OrientedTriangle::new(i as u32, t)),
            );
        }
        drawn.sort_unstable();
        wanted.sort_unstable();
        let differs = drawn.iter().zip(&wanted).find(|(d, w)| d != w);
        match differs {
            Some((d, w)) if d < w => Err(StripSetError::Extra(*d)),
            Some((_, w)) => Err(StripSetError::Missing(*w)),
            None if drawn.len() > wanted.len() => Err(StripSetError::Extra(drawn[wanted.len()])),
            None if drawn.len() < wanted.len() => Err(StripSetError::Missing(wanted[drawn.len()])),
            None => Ok(()),
        }
    }
}

/// The triangles that a strip draws, with their orientation.
pub fn strip_triangles(strip: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let windows = strip.windows(3).enumerate();
    let turned =
        windows.map(|(k, w)| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
    turned.filter(|&t| !is_degenerate(t))
}

/// Strips as one list to be drawn with primitive restart: [`NONE`] follows each that has a vertex.
pub fn restart_list<'a>(strips: impl Iterator<Item = &'a [u32]>) -> Vec<u32> {
    strips.filter(|s| !s.is_empty()).flat_map(|s| s.iter().copied().chain([NONE])).collect()
}

/// The triangles with an area that a strip draws: those whose corners are at three positions.
pub fn live_triangles<'a>(
    strip: &'a [u32],
    submesh: u32,
    positions: &'a PositionIds,
) -> impl Iterator<Item = OrientedTriangle> + 'a {
    let has_area = |t: &[u32; 3]| !is_degenerate(t.map(|v| positions.of_vertex[v as usize]));
    strip_triangles(strip).filter(has_area).map(move |t| OrientedTriangle::new(submesh, t))
}

/// A difference between strips and the mesh that they should draw.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StripSetError {
    /// Ends of strips or submeshes that fall, or do not end with everything.
    #[error("strips that do not end where they should")]
    Ends,
    /// Another number of submeshes.
    #[error("strips of {found} submeshes for a mesh of {wanted}")]
    Submeshes {
        /// Submeshes of the strips.
        found: usize,
        /// Submeshes of the mesh.
        wanted: usize,
    },
    /// A triangle is drawn that the mesh does not have, or not so often.
    #[error("triangle {:?} of submesh {} is drawn too often", .0.corners, .0.submesh)]
    Extra(OrientedTriangle),
    /// A triangle of the mesh is not drawn, or not often enough.
    #[error("triangle {:?} of submesh {} is not drawn", .0.corners, .0.submesh)]
    Missing(OrientedTriangle),
}
