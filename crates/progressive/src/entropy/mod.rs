//! Adaptive entropy coding: one substream of bytes that is written and read by the same code.
//!
//! A substream has two ends. Values with adaptive probabilities are coded by asymmetric numeral
//! systems (Duda 2013, range variant) from the front; plain bits fill it from the back. Bytes in
//! between are padding.
//!
//! ```text
//!  byte 0                                                        last byte
//!  +--------------+--------------------+ - - - - +-----------------------+
//!  | state, 4 B   | renormalisation    | padding |            plain bits |
//!  |              | words, 2 B each -> |         | <- lowest bit of the  |
//!  |              |                    |         |    last byte first    |
//!  +--------------+--------------------+ - - - - +-----------------------+
//! ```

pub(crate) mod adaptive_probability;
pub(crate) mod coder;
pub(crate) mod decoder;
pub(crate) mod encoder;
pub(crate) mod integer_codes;
#[cfg(test)]
mod tests;
pub(crate) mod text_codec;
