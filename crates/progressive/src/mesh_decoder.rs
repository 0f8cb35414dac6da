//! The decoder of one object: takes blocks of steps, and gives the mesh after any block.

use crate::entropy::decoder::Decoder;
use crate::error_code::{error_value, rms_value};
use crate::header::MeshHeader;
use crate::invalid::InvalidStream;
use crate::source::split_source::DecoderSource;
use crate::vertex_data::vertex_layout::AttributeStream;
use crate::vertex_split::contexts::Contexts;
use crate::vertex_split::object_codec::{ObjectCodec, StepLimits};
use lodc_mesh::{Attribute, MeshParts, Submesh};
use std::ops::Range;

/// Decodes the steps of one object.
///
/// Vertices and triangles are numbered in stream order: they keep their numbers when more come,
/// only corners of triangles change. Vertex `i` is vertex `n − 1 − i` of the `n` vertices that the
/// object has in collapse order.
#[derive(Clone, Debug)]
pub struct MeshDecoder {
    header: MeshHeader,
    codec: ObjectCodec,
    /// Steps decoded so far.
    steps: u32,
}

/// Steps as a block holds them.
#[derive(Clone, Copy, Debug)]
pub struct StepBlock<'a> {
    /// Number of steps.
    pub steps: u32,
    /// The substream of vertex splits.
    pub splits: &'a [u8],
    /// Bytes of the stream up to the end of this block. They bound the memory and time that its
    /// steps may take.
    pub bytes: usize,
}

impl MeshDecoder {
    /// A decoder before the first step.
    #[must_use]
    pub fn new(header: MeshHeader) -> Self {
        let submeshes = header.submeshes.len() as u32;
        let codec = ObjectCodec::new(header.layout.clone(), submeshes, header.exact);
        Self { header, codec, steps: 0 }
    }

    /// Decodes a block. After an error the decoder has the steps before the faulty one, and what
    /// could be decoded of that.
    ///
    /// # Errors
    /// If the block cannot be what an encoder wrote after the blocks before it.
    pub fn decode(
        &mut self,
        contexts: &mut Contexts,
        block: StepBlock<'_>,
    ) -> Result<(), InvalidStream> {
        if block.steps == 0 || block.steps > self.header.steps - self.steps {
            return Err(InvalidStream("has no steps, or more than the header says"));
        }
        let mut coder = Decoder::new(block.splits);
        for remaining in (0..block.steps).rev() {
            self.decode_step(&mut coder, contexts, block.bytes, remaining == 0)?;
        }
        Ok(())
    }

    /// Decodes a step, the last one of its block or another.
    pub(crate) fn decode_step(
        &mut self,
        coder: &mut Decoder<'_>,
        contexts: &mut Contexts,
        bytes: usize,
        is_last: bool,
    ) -> Result<(), InvalidStream> {
        if self.has_all_steps() {
            return Err(InvalidStream("has more steps than the header says"));
        }
        let MeshHeader { vertices, triangles, .. } = self.header;
        let limits = StepLimits { vertices, triangles, bytes };
        let step = self.codec.code_step(coder, &DecoderSource, contexts, limits);
        let checked = step.and_then(|()| self.check_step(coder, is_last));
        if let Err(e) = checked {
            self.codec.complete_values();
            return Err(e);
        }
        self.steps += 1;
        Ok(())
    }

    /// Returns whether as many steps have been decoded as the header says.
    pub(crate) fn has_all_steps(&self) -> bool {
        self.steps == self.header.steps
    }

    /// Returns whether no batch has begun of which steps are still to come.
    pub(crate) fn is_between_batches(&self) -> bool {
        self.codec.is_between_batches()
    }

    fn check_step(&self, coder: &Decoder<'_>, is_last: bool) -> Result<(), InvalidStream> {
        if self.codec.has_infinite_position {
            return Err(InvalidStream("has a position that is not a finite number"));
        }
        if coder.is_exhausted() {
            return Err(InvalidStream("ends before its steps do"));
        }
        if is_last && !coder.is_finished() {
            return Err(InvalidStream("does not end with its steps"));
        }
        if self.triangle_count() > self.header.triangles {
            return Err(InvalidStream("has more triangles than the header says"));
        }
        Ok(())
    }

    /// Sets the triangles above which a star is large: those of the encoder's [`StarRule`].
    ///
    /// [`StarRule`]: crate::source::coding_parents::StarRule
    #[cfg(test)]
    pub(crate) fn set_large_star(&mut self, large_star: u32) {
        self.codec.large_star = large_star;
    }

    /// The header, known before the first step.
    #[must_use]
    pub fn header(&self) -> &MeshHeader {
        &self.header
    }

    /// Returns whether everything that the header says has been decoded.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.has_all_steps()
            && self.vertex_count() == self.header.vertices
            && self.triangle_count() == self.header.triangles
            && self.codec.points.are_complete()
    }

    /// Steps decoded so far.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Vertices so far, including points of which only the number is known: the mesh is that of the
    /// LOD with this number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.codec.mesh.vertex_count()
    }

    /// Returns whether a vertex has come: its parent, submesh and values are known. Triangles use
    /// only such vertices; points that are announced come later.
    #[must_use]
    pub fn has_come(&self, vertex: u32) -> bool {
        vertex < self.vertex_count() && !self.codec.points.is_missing(vertex)
    }

    /// Triangles decoded so far.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        self.codec.mesh.face_count()
    }

    /// Object-space error of the mesh so far, in its units; at most 1/16 above the true one.
    #[must_use]
    pub fn error(&self) -> f32 {
        error_value(self.codec.errors.error)
    }

    /// Root mean square distance of the mesh so far, in its units; at most 1/16 above the true one.
    /// Nothing if the stream has none.
    #[must_use]
    pub fn rms(&self) -> Option<f32> {
        (self.vertex_count() > 0).then(|| rms_value(self.codec.errors.rms)).flatten()
    }

    /// The triangles so far.
    #[must_use]
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> {
        (0..self.triangle_count()).map(|f| self.codec.mesh.face(f))
    }

    /// A triangle, numbered in the order in which they came.
    #[must_use]
    pub fn triangle(&self, number: u32) -> [u32; 3] {
        self.codec.mesh.face(number)
    }

    /// Appends the values of some vertices, in stream order: their positions as `f32` for stream 0,
    /// else the bytes of an attribute, of which stream 1 is the first.
    pub fn put_stream(&self, stream: usize, vertices: Range<u32>, out: &mut Vec<u8>) {
        let Some(attribute) = stream.checked_sub(1).map(|a| &self.header.attributes[a]) else {
            let positions = vertices.flat_map(|v| self.position(v));
            out.extend(positions.flat_map(f32::to_le_bytes));
            return;
        };
        self.put_attribute(attribute, &self.header.layout.streams[stream], vertices, out);
    }

    /// The submesh of each vertex; 0 for one that has not come.
    #[must_use]
    pub fn vertex_submesh(&self) -> &[u32] {
        &self.codec.mesh.submesh
    }

    /// The target of each vertex, mostly the parent that it split off; 0 for the first and for one
    /// that has not come.
    #[must_use]
    pub fn targets(&self) -> &[u32] {
        &self.codec.targets
    }

    /// For each vertex whether its step continues with the next one.
    #[must_use]
    pub fn continues(&self) -> &[bool] {
        &self.codec.continues
    }

    /// The mesh so far with all its vertices, in collapse order, and its triangles in stream order.
    /// A vertex that has not come has index 0 in each channel, and no triangle.
    /// It may be no valid mesh: quantisation can make triangles degenerate.
    #[must_use]
    pub fn mesh_parts(&self) -> MeshParts {
        let last = self.vertex_count().wrapping_sub(1);
        let mut by_submesh: Vec<Vec<[u32; 3]>> = vec![Vec::new(); self.header.submeshes.len()];
        for t in self.triangles() {
            let submesh = self.vertex_submesh()[t[0] as usize];
            by_submesh[submesh as usize].push(t.map(|v| last - v));
        }
        let mut first_triangle = 0;
        let submesh = |(s, triangles): (&Submesh, &Vec<[u32; 3]>)| {
            let triangle_count = triangles.len() as u32;
            let submesh = Submesh { first_triangle, triangle_count, ..s.clone() };
            first_triangle += triangle_count;
            submesh
        };
        let streams = &self.header.layout.streams;
        let attributes = self.header.attributes.iter().zip(&streams[1..]);
        MeshParts {
            positions: self.vertices().map(|v| self.position(v)).collect(),
            vertex_submesh: self.vertex_submesh().iter().rev().copied().collect(),
            attributes: attributes.map(|(a, stream)| self.attribute(a, stream)).collect(),
            submeshes: self.header.submeshes.iter().zip(&by_submesh).map(submesh).collect(),
            triangles: by_submesh.concat(),
        }
    }

    /// The numbers of all vertices in stream order, listed in collapse order.
    fn vertices(&self) -> impl Iterator<Item = u32> {
        (0..self.vertex_count()).rev()
    }

    /// The indices of all channels of a vertex.
    fn indices(&self, vertex: u32) -> &[i32] {
        let channels = self.codec.values.channels();
        &self.codec.values.indices[vertex as usize * channels..][..channels]
    }

    fn position(&self, vertex: u32) -> [f32; 3] {
        let (systems, indices) = (&self.header.layout.systems, self.indices(vertex));
        std::array::from_fn(|c| systems[c].value(indices[c]))
    }

    fn attribute(&self, attribute: &Attribute, stream: &AttributeStream) -> Attribute {
        let mut bytes = Vec::with_capacity(self.vertex_count() as usize * attribute.stride());
        self.put_attribute(attribute, stream, self.vertices(), &mut bytes);
        Attribute { bytes, ..attribute.described() }
    }

    fn put_attribute(
        &self,
        attribute: &Attribute,
        stream: &AttributeStream,
        vertices: impl Iterator<Item = u32>,
        out: &mut Vec<u8>,
    ) {
        for v in vertices {
            let indices = &self.indices(v)[stream.first_channel..][..stream.channels];
            self.header.layout.append_bytes(attribute.component, stream, indices, out);
        }
    }
}
