//! Bits that numbers keep in quantised geometry.

/// Bits per number, 2 to 16, of each kind of stream; `None` keeps the numbers as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Precision {
    /// Positions: the longest side of the scene has 2^n − 2 steps.
    pub position: Option<u8>,
    /// Normals and tangents: on an octahedron whose sides have so many bits.
    pub normal: Option<u8>,
    /// Texture coordinates: the longest side of their range in a material has 2^n − 1 steps.
    pub uv: Option<u8>,
    /// Colours, from 0 to 1.
    pub color: Option<u8>,
    /// Weights of joints, from 0 to 1; their sum stays 1.
    pub weight: Option<u8>,
}
