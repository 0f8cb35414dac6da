//! The twin of a device: a cursor on the CPU that is compared with the reference before a device is
//! compared with it.

use lodc_mesh::{Lod, PositionIds};
use lodc_model::Model;
use lodc_verify::first_difference;

/// Moves a cursor, and returns what it then shows other than the reference, if anything.
pub(crate) fn move_and_compare<M: Model>(
    model: &M,
    cursor: &mut M::Cursor,
    lod: Lod,
    positions: &PositionIds,
) -> Option<String> {
    model.seek(cursor, lod, &mut ());
    let truth = model.simplified().triangles_at_with(lod, positions);
    first_difference(lod, truth, model.triangles(cursor)).map(|difference| difference.to_string())
}
