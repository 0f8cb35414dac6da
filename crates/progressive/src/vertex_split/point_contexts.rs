//! The adaptive probabilities of points, which share none with vertex splits.

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::integer_codes::GammaCode;
use crate::vertex_data::values::ValueContexts;

/// Contexts of points.
#[derive(Clone, Debug)]
pub(crate) struct PointContexts {
    /// Number of points.
    pub(crate) count: GammaCode,
    /// A neighbouring point, in numbering, is a wedge of the same group: 0 the one before, 1 the
    /// one behind.
    pub(crate) wedge: [AdaptiveBit; 2],
    /// The step of the point before the group continues with the group.
    pub(crate) continues: AdaptiveBit,
    /// The parent is in the group that came last.
    pub(crate) in_last: AdaptiveBit,
    /// The parent of the first point of a group that comes.
    pub(crate) parent: GammaCode,
    /// Distance from the parent of the wedge that came last to that of the next one.
    pub(crate) next_parent: GammaCode,
    /// The submesh is that of the reference, the vertex from which the point is predicted.
    pub(crate) same_submesh: AdaptiveBit,
    pub(crate) values: ValueContexts,
}

impl PointContexts {
    pub(crate) fn new() -> Self {
        Self {
            count: GammaCode::NEW,
            wedge: [AdaptiveBit::NEW; 2],
            continues: AdaptiveBit::NEW,
            in_last: AdaptiveBit::NEW,
            parent: GammaCode::NEW,
            next_parent: GammaCode::NEW,
            same_submesh: AdaptiveBit::NEW,
            values: ValueContexts::new(),
        }
    }
}
