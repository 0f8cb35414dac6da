//! The first step: groups and wedges get numbers.
//!
//! The input is a [`Mesh`](lodc_mesh::Mesh) as its file has it, with vertices in any order.
//! Vertices at one position whose triangles hang together are a group, and each is one of its
//! wedges. Groups are numbered along a space-filling curve, wedges group by group. All later steps
//! read a group together with its neighbours, so neighbours in space have to be neighbours in
//! memory. The mesh itself stays as it is: the output, [`Input`], says what has which number.

mod cards;
mod curve;
mod flat;
mod input;
mod loose;
mod shapes;

pub(crate) use curve::{Curve, sorted};
pub(crate) use input::{FollowerPlane, Input, Wedge, same_attributes};
pub(crate) use shapes::{GroupShapes, MAX_SHAPES, ShapeSet, each_shape, index_in};
