//! All adaptive probabilities of a stream, which its objects share. docs/STREAM.md names each.

use crate::entropy::adaptive_probability::{AdaptiveBit, AdaptiveSymbol};
use crate::entropy::integer_codes::{BoundedCode, GammaCode};
use crate::vertex_data::values::ValueContexts;
use crate::vertex_split::corner_transfer::TransferContexts;
use crate::vertex_split::face_list::FaceListContexts;
use crate::vertex_split::group_list::BatchContexts;
use crate::vertex_split::new_triangles::TriangleContexts;
use crate::vertex_split::point_contexts::PointContexts;
use crate::vertex_split::turns::TurnContexts;

/// The contexts of a stream. They go on from block to block and from object to object.
/// `docs/STREAM.md` has a table of them.
#[derive(Clone, Debug)]
pub struct Contexts {
    /// An index (a value in its number system) of the object's first vertex, which has no
    /// reference.
    pub(crate) first_index: GammaCode,
    /// Distance in stream order to the parent.
    pub(crate) parent: BoundedCode,
    /// Distance along the circle of wedges to the parent: 1 for the first vertex of a step, else 0.
    pub(crate) wedge_distance: [AdaptiveSymbol; 2],
    /// The submesh is the parent's.
    pub(crate) same_submesh: AdaptiveBit,
    pub(crate) turns: TurnContexts,
    pub(crate) batches: BatchContexts,
    pub(crate) face_list: FaceListContexts,
    pub(crate) triangles: TriangleContexts,
    pub(crate) transfer: TransferContexts,
    /// The target is the parent's target; for a vertex that takes over no triangle of a
    /// high-valence vertex.
    pub(crate) repeats_target: AdaptiveBit,
    /// The position is that of the vertex before.
    pub(crate) same_position: AdaptiveBit,
    /// By the number of the vertex in its step, up to 3, and the wedges of the parent's circle less
    /// one, up to 3: the step continues with the next vertex.
    pub(crate) continues: [[AdaptiveBit; 4]; 4],
    /// The error falls.
    pub(crate) error_falls: AdaptiveBit,
    /// By how much the error's code falls.
    pub(crate) error_drop: GammaCode,
    /// The root mean square distance falls.
    pub(crate) rms_falls: AdaptiveBit,
    /// By how much its code falls.
    pub(crate) rms_drop: GammaCode,
    pub(crate) values: ValueContexts,
    pub(crate) points: PointContexts,
}

impl Contexts {
    /// The contexts at the beginning of a stream.
    #[must_use]
    pub fn new() -> Self {
        Self {
            first_index: GammaCode::NEW,
            parent: BoundedCode::NEW,
            wedge_distance: [AdaptiveSymbol::NEW; 2],
            same_submesh: AdaptiveBit::NEW,
            turns: TurnContexts::NEW,
            batches: BatchContexts::NEW,
            face_list: FaceListContexts::NEW,
            triangles: TriangleContexts::NEW,
            transfer: TransferContexts::NEW,
            repeats_target: AdaptiveBit::NEW,
            same_position: AdaptiveBit::NEW,
            continues: [[AdaptiveBit::NEW; 4]; 4],
            error_falls: AdaptiveBit::NEW,
            error_drop: GammaCode::NEW,
            rms_falls: AdaptiveBit::NEW,
            rms_drop: GammaCode::NEW,
            values: ValueContexts::new(),
            points: PointContexts::new(),
        }
    }
}

impl Default for Contexts {
    fn default() -> Self {
        Self::new()
    }
}
