//! The trait through which the coding of splits asks for the splits of an object, and its decoder
//! side, whose answers are placeholders that a decoder ignores.

/// A triangle that comes with a vertex: its two other corners, (new, next, previous)
/// counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct SourceTriangle {
    pub(crate) next: u32,
    pub(crate) previous: u32,
}

/// The splits of an object. Vertices and triangles are numbered in stream order. The answers of a
/// decoder's source are passed to the coder, which ignores them.
pub(crate) trait SplitSource {
    /// Returns the number of points: the vertices of all steps before the first triangle.
    fn points(&self) -> u32;
    /// Returns the vertex that a new one splits off.
    fn parent(&self, new: u32) -> u32;
    /// Returns the first vertex of the wedge group of a vertex.
    fn group(&self, vertex: u32) -> u32;
    /// Returns the number of steps of the batch that begins with a vertex.
    fn batch(&self, new: u32) -> u32;
    /// Returns whether the target of a new vertex is that of its parent, and not its parent.
    fn repeats_target(&self, new: u32) -> bool;
    /// Returns whether the step continues after a vertex.
    fn continues(&self, new: u32) -> bool;
    /// Returns the submesh of a vertex.
    fn submesh(&self, new: u32) -> u32;
    /// Returns the triangles that come with a vertex.
    fn new_triangles(&self, new: u32) -> &[SourceTriangle];
    /// Returns whether a corner of a live triangle is transferred to a new vertex.
    fn is_transferred(&self, corner: u32, new: u32) -> bool;
    /// Returns the triangles that a new vertex takes over, if they are to be named.
    fn named_star(&self, new: u32) -> Option<&[u32]>;
    /// Returns the indices of all channels of a vertex; none for a decoder.
    fn indices(&self, new: u32) -> &[i32];
    /// Returns the codes of the error and of the root mean square distance after the step that ends
    /// with a vertex.
    fn error_codes(&self, new: u32) -> [u32; 2];
}

/// The source of a decoder: every answer is a placeholder.
pub(crate) struct DecoderSource;

impl SplitSource for DecoderSource {
    fn points(&self) -> u32 {
        0
    }
    fn parent(&self, _: u32) -> u32 {
        0
    }
    fn group(&self, _: u32) -> u32 {
        0
    }
    fn batch(&self, _: u32) -> u32 {
        1
    }
    fn repeats_target(&self, _: u32) -> bool {
        false
    }
    fn continues(&self, _: u32) -> bool {
        false
    }
    fn submesh(&self, _: u32) -> u32 {
        0
    }
    fn new_triangles(&self, _: u32) -> &[SourceTriangle] {
        &[]
    }
    fn is_transferred(&self, _: u32, _: u32) -> bool {
        false
    }
    fn named_star(&self, _: u32) -> Option<&[u32]> {
        None
    }
    fn indices(&self, _: u32) -> &[i32] {
        &[]
    }
    fn error_codes(&self, _: u32) -> [u32; 2] {
        [0; 2]
    }
}
