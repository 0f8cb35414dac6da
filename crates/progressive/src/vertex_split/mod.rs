//! Coding of vertex splits: one step after another, each some vertices with their triangles.
//!
//! Ripollés 2009, 4.3.3, "UpdatePackage". The order in which the parts of a split are coded:
//!
//! ```text
//!  batch  = number of steps, step, step, ... , errors
//!  step   = group, vertex, vertex, ...
//!  vertex = parent | submesh | continues | face list | pattern | new triangles | corner transfer
//!           | same position | values
//! ```
//!
//! Vertices before the first triangle are points. Each is coded right behind what first needs it:
//! as a parent, or as a corner of the new triangles.

pub(crate) mod budget;
pub(crate) mod contexts;
pub(crate) mod corner_transfer;
pub(crate) mod face_list;
#[cfg(test)]
mod face_list_tests;
pub(crate) mod group_list;
pub(crate) mod neighbourhood;
pub(crate) mod new_triangles;
pub(crate) mod object_codec;
mod parent_distance;
pub(crate) mod point_contexts;
pub(crate) mod points;
pub(crate) mod points_code;
#[cfg(test)]
mod points_tests;
pub(crate) mod turns;
