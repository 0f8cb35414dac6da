//! Numbers groups and wedges along a space-filling curve.

pub(crate) mod curve;
pub(crate) mod input;
