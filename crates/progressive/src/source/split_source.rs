//! The trait through which the coding of splits asks for the splits of an object, and its
//! implementation for decoders, which returns placeholders.

use crate::error_code::ErrorCodes;

/// A triangle that comes with a vertex: its two other corners, (new, next, previous)
/// counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct SourceTriangle {
    pub(crate) next: u32,
    pub(crate) previous: u32,
}

/// The splits of an object. Vertices and triangles are numbered in stream order. What a decoder's
/// source returns is passed to its coder, which ignores it.
pub(crate) trait SplitSource {
    /// Returns the number of points: the vertices of all steps before the first triangle.
    fn points(&self) -> u32;
    /// Returns the vertex that a new one is coded as split off.
    fn parent(&self, new: u32) -> u32;
    /// Returns the first vertex of the wedge group of a vertex.
    fn group(&self, vertex: u32) -> u32;
    /// Returns the number of steps of the batch that begins with a vertex.
    fn batch_steps(&self, new: u32) -> u32;
    /// Returns whether the target of a new vertex is not its parent but its parent's target.
    fn repeats_target(&self, new: u32) -> bool;
    /// Returns whether the step continues with the vertex after this one.
    fn continues(&self, new: u32) -> bool;
    /// Returns the submesh of a vertex.
    fn submesh(&self, new: u32) -> u32;
    /// Returns the triangles that come with a vertex.
    fn new_triangles(&self, new: u32) -> &[SourceTriangle];
    /// Returns whether a corner of a live triangle is transferred to a new vertex.
    fn is_transferred(&self, corner: u32, new: u32) -> bool;
    /// Returns the triangles that a new vertex takes over, if it has an explicit face list.
    fn face_list(&self, new: u32) -> Option<&[u32]>;
    /// Returns the indices of all channels of a vertex; none for a decoder.
    fn indices(&self, new: u32) -> &[i32];
    /// Returns the codes of the error and of the root mean square distance after the step that ends
    /// with a vertex.
    fn error_codes(&self, new: u32) -> ErrorCodes;
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
    fn batch_steps(&self, _: u32) -> u32 {
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
    fn face_list(&self, _: u32) -> Option<&[u32]> {
        None
    }
    fn indices(&self, _: u32) -> &[i32] {
        &[]
    }
    fn error_codes(&self, _: u32) -> ErrorCodes {
        ErrorCodes::default()
    }
}
