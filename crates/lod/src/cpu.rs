//! The CPU version of a device that is compared with the reference before a device is
//! compared with it.

use lodc_mesh::{Lod, TriangleHash};
use lodc_model::Model;
use lodc_verify::Reference;

/// Moves a cursor to the end of a step, and returns what it then shows other than the reference, if
/// anything.
pub(crate) fn move_and_compare<M: Model>(
    model: &M,
    cursor: &mut M::Cursor,
    lod: Lod,
    reference: &Reference<'_>,
) -> Option<String> {
    model.seek(cursor, lod, &mut ());
    let mut hash = TriangleHash::default();
    model.for_each_triangle(cursor, |t| hash.add(t));
    let difference = reference.judge(lod, hash, || model.triangles(cursor));
    difference.map(|difference| difference.to_string())
}
