//! What an encoder knows and a decoder does not: the vertex splits of an object. The coding of
//! splits asks for them piece by piece through the trait `SplitSource`. Its implementation for
//! decoders returns placeholders, which nothing reads.

pub(crate) mod batches;
pub(crate) mod coding_parents;
pub(crate) mod encoder_source;
pub(crate) mod face_lists;
pub(crate) mod first_appearance;
pub(crate) mod split_source;
#[cfg(test)]
mod tests;
