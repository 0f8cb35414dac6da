//! crates/lod
