//! The front door of the library: files that hold every level of a mesh.
