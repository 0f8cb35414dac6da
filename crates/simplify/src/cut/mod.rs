//! The second step: the mesh is cut into regions of neighbouring groups.
//!
//! The input is [`Input`](crate::number::Input), or, between two rounds, the regions of the round
//! before; the output is [`Region`]s. A region is a small mesh with numbers of its own and
//! everything that collapsing its groups needs, so that one thread works in its own cache and waits
//! for no other. Groups of other regions that share faces with it come along as position and cost
//! only; own groups next to those are locked. The mesh alone decides where it is cut, never the
//! number of threads.

mod gather;
mod in_motion;
mod mesh;
mod neighbourhood;
mod quadrics;
mod region;
mod table;
mod wedges;

pub(crate) use gather::{Home, RegionLists, Round};
pub(crate) use in_motion::InMotion;
pub(crate) use mesh::{
    Corner, DEAD, Facet, HIGH_VALENCE, IS_HIGH_VALENCE, LOCKED, OPEN, RESTRICTED, SEAM, STALE,
    Star, WorkingMesh, next, previous,
};
pub(crate) use neighbourhood::{
    EdgeKind, Entry, FeaturePlane, Neighbourhood, PosedSurroundings, fold_plane, is_seam,
    plane_along, seam_weight, target,
};
pub(crate) use quadrics::{Quadric, Quadrics, Symmetric, add_outer, times};
pub(crate) use region::{Choice, Region};
pub(crate) use wedges::{FakeSource, Wedges};
