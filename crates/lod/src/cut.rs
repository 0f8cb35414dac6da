//! Cuts long strips into pieces that draw the same triangles. Masks have one bit for each vertex of
//! a strip, and the time of a record grows with the length of the strips that it changes.

use lodc_strip::{StripSet, Strips};
use std::cmp::Reverse;
use std::sync::Arc;

/// The most vertices of a strip that is traced through a sequence. Where a vertex has thousands of
/// triangles, strips around it would have thousands of vertices, and each record there would cost a
/// walk along one of them. Those of other meshes are shorter (bunny: up to 604).
pub const LONGEST_TRACED: usize = 1024;

/// Returns the strips with those of more than `longest` vertices (even, at least 4) cut into pieces
/// that draw the same: the same ones if there are none.
#[must_use]
pub fn cut_long(strips: Arc<Strips>, longest: usize) -> Arc<Strips> {
    match cut(&strips, longest) {
        Some(set) => Arc::new(Strips { kind: strips.kind, set }),
        None => strips,
    }
}

/// The same strips with those of more than `longest` (even, at least 4) vertices cut into as few
/// pieces as possible; `None` if there are none. Pieces start at even positions, so that every
/// triangle keeps its orientation, and each repeats two vertices of the one before, or one where
/// the strip turns.
pub(crate) fn cut(strips: &StripSet, longest: usize) -> Option<StripSet> {
    if strips.iter().all(|strip| strip.len() <= longest) {
        return None;
    }
    let (mut indices, mut ends, mut submesh_ends) = (Vec::new(), Vec::new(), Vec::new());
    for submesh in 0..strips.submesh_count() {
        for mut remaining in strips.submesh(submesh).map(|s| strips.strip(s)) {
            let pieces = (remaining.len() - 2).div_ceil(longest - 2);
            for pieces_left in (2..=pieces).rev() {
                let count = piece_triangles(remaining, pieces_left, longest - 2);
                indices.extend_from_slice(
                    &remaining[..count + 2 - usize::from(turns(remaining, count))],
                );
                ends.push(indices.len() as u32);
                remaining = &remaining[count..];
            }
            indices.extend_from_slice(remaining);
            ends.push(indices.len() as u32);
        }
        submesh_ends.push(ends.len() as u32);
    }
    Some(
        StripSet::from_parts(indices, ends, submesh_ends)
            .expect("ends rise to the end of everything"),
    )
}

/// Returns the number of triangles of the first of `pieces` pieces: an even number, such that
/// `max_triangles` are enough for each of the others. Cut where the strip turns if it does, else so
/// that all pieces are about equally long.
fn piece_triangles(strip: &[u32], pieces: usize, max_triangles: usize) -> usize {
    let total = strip.len() - 2;
    let equal_share = total.div_ceil(pieces).next_multiple_of(2);
    let min_triangles =
        total.saturating_sub((pieces - 1) * max_triangles).next_multiple_of(2).max(2);
    let steps = (min_triangles..=max_triangles).step_by(2).filter(|&count| count < total);
    steps
        .max_by_key(|&count| (turns(strip, count), Reverse(count.abs_diff(equal_share)), count))
        .unwrap_or(equal_share)
}

/// Returns whether the last of the first `triangles` triangles is degenerate, so that a cut need
/// not repeat it.
fn turns(strip: &[u32], triangles: usize) -> bool {
    let [a, b, c] = [strip[triangles - 1], strip[triangles], strip[triangles + 1]];
    triangles > 2 && (a == b || b == c || c == a)
}
