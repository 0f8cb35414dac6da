//! What tests of several models need.

use lodc_mesh::OrientedTriangle;

/// The multiset difference of two sorted lists.
pub(crate) fn without(all: &[OrientedTriangle], fewer: &[OrientedTriangle]) -> Vec<OrientedTriangle> {
    let mut fewer = fewer.iter().peekable();
    let mut rest = Vec::new();
    for t in all {
        while fewer.peek().is_some_and(|f| *f < t) {
            fewer.next();
        }
        if fewer.peek() == Some(&t) {
            fewer.next();
        } else {
            rest.push(*t);
        }
    }
    rest
}
