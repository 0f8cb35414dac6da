//! Images as files: PNG and JPEG in, PNG out.

mod decode;
mod encode;

pub use decode::decode;
pub use encode::png;

#[cfg(test)]
mod tests;
