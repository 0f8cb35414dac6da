//! Cutting long strips. Masks have one bit for each vertex of a strip; and a record costs as much
//! as the strips that it changes are long.

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
        for mut rest in strips.submesh(submesh).map(|s| strips.strip(s)) {
            let pieces = (rest.len() - 2).div_ceil(longest - 2);
            for left in (2..=pieces).rev() {
                let step = step(rest, left, longest - 2);
                indices.extend_from_slice(&rest[..step + 2 - usize::from(turns(rest, step))]);
                ends.push(indices.len() as u32);
                rest = &rest[step..];
            }
            indices.extend_from_slice(rest);
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
/// `most` are enough for each of the others. Where the strip turns if it does, else about as many
/// as in the others.
fn step(strip: &[u32], pieces: usize, most: usize) -> usize {
    let all = strip.len() - 2;
    let even = all.div_ceil(pieces).next_multiple_of(2);
    let least = all.saturating_sub((pieces - 1) * most).next_multiple_of(2).max(2);
    let steps = (least..=most).step_by(2).filter(|&step| step < all);
    steps
        .max_by_key(|&step| (turns(strip, step), Reverse(step.abs_diff(even)), step))
        .unwrap_or(even)
}

/// Returns whether the last of the first `triangles` triangles is degenerate, so that a cut need
/// not repeat it.
fn turns(strip: &[u32], triangles: usize) -> bool {
    let [a, b, c] = [strip[triangles - 1], strip[triangles], strip[triangles + 1]];
    triangles > 2 && (a == b || b == c || c == a)
}
