//! Limits on what one input may take of a machine.

/// Limits on inputs. Reaching one is [`crate::Fault::Limit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one file.
    pub file_bytes: u64,
    /// Bytes of all files of one input together.
    pub total_bytes: u64,
    /// Vertices of one input.
    pub vertices: u64,
    /// Triangles of one input.
    pub triangles: u64,
    /// Bytes of one line of a text format.
    pub line_bytes: u64,
    /// Nesting of JSON.
    pub json_depth: u32,
    /// Pixels of all images of one input that are decoded, each image once.
    pub pixels: u64,
}

impl Limits {
    /// The limits unless options raise them. All are chosen by hand: far above the largest models
    /// in use, and low enough for one machine.
    pub const DEFAULT: Self = Self {
        file_bytes: 4 << 30,
        total_bytes: 8 << 30,
        vertices: 1 << 28,
        triangles: 1 << 28,
        line_bytes: 64 << 20,
        json_depth: 128,
        // 128 images of 4,096 x 4,096.
        pixels: 1 << 31,
    };
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}
