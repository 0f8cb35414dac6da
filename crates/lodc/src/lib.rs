//! The front door of the library: files that hold every level of a mesh.

mod file;
mod input;

pub use file::{LodFile, LodObject, read, stored_bytes, write};
pub use input::{Input, read_input};
