//! Knowledge that an encoder has and a decoder lacks: the next vertex split, asked for piece by
//! piece.

pub(crate) mod batches;
pub(crate) mod coding_parents;
pub(crate) mod encoder_source;
pub(crate) mod first_appearance;
pub(crate) mod named_stars;
pub(crate) mod split_source;
#[cfg(test)]
mod tests;
