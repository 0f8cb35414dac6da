//! Cuts the mesh into regions.

pub(crate) mod gather;
pub(crate) mod mesh;
pub(crate) mod neighborhood;
pub(crate) mod quadrics;
pub(crate) mod region;
pub(crate) mod table;
pub(crate) mod wedges;
