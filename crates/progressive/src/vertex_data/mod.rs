//! Values of vertices: positions and attributes as integers of number systems, and their coding.
//!
//! ```text
//! vertex   = streams   [ position     | NORMAL       | TEXCOORD_0 | ... ]
//! stream   = channels  [ x   y   z    | x   y   z    | u   v      | ... ]
//! channel  = an index into its number system: value = system[index]
//! coded    = index - predicted index
//! ```

pub(crate) mod number_system;
pub(crate) mod octahedral;
pub(crate) mod prediction;
pub(crate) mod quantize;
pub(crate) mod values;
pub(crate) mod vertex_layout;
pub(crate) mod vertex_values;
