//! Wavefront OBJ and MTL.

mod appearance;
pub(crate) mod mtl;
pub(crate) mod read;
pub(crate) mod write;

pub(crate) use appearance::appearance;
pub(crate) use mtl::read_textures;
