//! Cutting long strips: masks have one bit for each vertex of a strip.

use lodc_strip::StripSet;

/// The same strips with those of more than `longest` (even, at least 4) vertices cut; `None` if there are none. Pieces
/// start at even positions, so that every triangle keeps its orientation, and each repeats two vertices of the one before.
pub(super) fn cut(strips: &StripSet, longest: usize) -> Option<StripSet> {
    if strips.iter().all(|strip| strip.len() <= longest) {
        return None;
    }
    let (mut indices, mut ends, mut submesh_ends) = (Vec::new(), Vec::new(), Vec::new());
    for submesh in 0..strips.submesh_count() {
        for mut rest in strips.submesh(submesh).map(|s| strips.strip(s)) {
            while rest.len() > longest {
                indices.extend_from_slice(&rest[..longest]);
                ends.push(indices.len() as u32);
                rest = &rest[longest - 2..];
            }
            indices.extend_from_slice(rest);
            ends.push(indices.len() as u32);
        }
        submesh_ends.push(ends.len() as u32);
    }
    Some(StripSet::from_parts(indices, ends, submesh_ends).expect("ends rise to the end of everything"))
}
