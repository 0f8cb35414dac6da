//! Stanford PLY.

pub(crate) mod write;
