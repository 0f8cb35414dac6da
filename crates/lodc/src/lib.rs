//! The front door of the library: files that hold every level of a mesh.

pub mod build;
mod error;
mod file;
mod input;
pub mod level_mesh;
pub mod levels;
mod scene_levels;

pub use error::Error;
pub use file::{LodFile, LodObject, read, stored_bytes, write};
pub use input::{Input, read_input};
pub use scene_levels::SceneLevels;
