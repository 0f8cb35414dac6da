//! The functions that a WebAssembly host calls. Numbers only: a host writes to and reads from the
//! memory at the addresses it is given.

#[cfg(not(feature = "full"))]
mod decoder;
#[cfg(feature = "full")]
mod sessions;
