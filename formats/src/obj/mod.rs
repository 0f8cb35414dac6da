//! Wavefront OBJ and MTL.

#[cfg(feature = "import")]
mod appearance;
pub(crate) mod coordinates;
pub(crate) mod mtl;
#[cfg(feature = "import")]
pub(crate) mod read;
#[cfg(feature = "export")]
pub(crate) mod write;

#[cfg(feature = "import")]
pub(crate) use appearance::appearance;
pub(crate) use coordinates::coordinates;
