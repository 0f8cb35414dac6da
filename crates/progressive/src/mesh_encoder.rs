//! The encoder of one object: writes blocks of steps of about a wanted size, coarse to fine.

use crate::entropy::encoder::Encoder;
use crate::error_code::error_value;
use crate::header::MeshHeader;
use crate::source::batches::StepOrder;
use crate::source::coding_parents::StarRule;
use crate::source::encoder_source::EncoderSource;
use crate::vertex_data::vertex_layout::VertexLayout;
use crate::vertex_split::budget::Cost;
use crate::vertex_split::contexts::Contexts;
use crate::vertex_split::object_codec::{ObjectCodec, StepLimits};
use lodc_mesh::Simplified;

/// Encodes the steps of one object, coarse to fine.
pub struct MeshEncoder<'a> {
    simplified: &'a Simplified,
    source: EncoderSource,
    codec: ObjectCodec,
    header: MeshHeader,
}

/// Some consecutive steps of an object, encoded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EncodedSteps {
    /// Number of steps.
    pub steps: u32,
    /// The substream of vertex splits.
    pub splits: Vec<u8>,
}

/// The size of a block, and where in the stream it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockTarget {
    /// Bytes after which no further step is added.
    pub bytes: usize,
    /// Bytes of the stream before this block: with its own they bound what it may decode to.
    pub bytes_before: usize,
    /// True if the block goes on until the object has a triangle, whatever its bytes.
    pub until_triangle: bool,
}

/// Bytes of padding that are added at a time. Chosen by hand: only streams that compress
/// extremely well are padded, so a few bytes too many do not matter.
const PADDING_UNIT: usize = 64;

impl EncodedSteps {
    /// Finishes steps of objects of which none has cost more, behind so many bytes of the stream.
    pub(crate) fn new(steps: u32, coder: Encoder, cost: Cost, bytes_before: usize) -> Self {
        let splits = coder.finish();
        // A decoder refuses steps that take more memory or time than their bytes may: splits that
        // compress that well are padded.
        let mut padding = 0;
        while !cost.is_within_budget(bytes_before + splits.len() + padding) {
            padding += PADDING_UNIT;
        }
        Self { steps, splits: splits.into_bytes(padding) }
    }
}

impl<'a> MeshEncoder<'a> {
    /// Prepares a mesh. Its steps are coded in batches if these are wanted and the steps are in
    /// such an order, see [`in_batches`](crate::in_batches); else each is coded with its parent.
    #[must_use]
    pub fn new(simplified: &'a Simplified, layout: VertexLayout, order: StepOrder) -> Self {
        Self::with_rule(simplified, layout, order, StarRule::DEFAULT)
    }

    /// Like [`Self::new`], with another rule for large stars: tests use smaller ones.
    pub(crate) fn with_rule(
        simplified: &'a Simplified,
        layout: VertexLayout,
        order: StepOrder,
        rule: StarRule,
    ) -> Self {
        let source = EncoderSource::new(simplified, &layout, order, rule);
        let submeshes = simplified.mesh().submeshes().len() as u32;
        let exact = source.batches().is_none();
        let header = MeshHeader::new(simplified, layout.clone(), source.count_steps(), exact);
        let mut codec = ObjectCodec::new(layout, submeshes, exact);
        codec.large_star = rule.large_star;
        Self { simplified, source, codec, header }
    }

    /// The header that a decoder needs before the first block.
    #[must_use]
    pub fn header(&self) -> &MeshHeader {
        &self.header
    }

    /// Number of vertices so far, including points of which only the number is encoded.
    #[must_use]
    pub fn vertices(&self) -> u32 {
        self.codec.mesh.vertex_count()
    }

    /// Number of levels that are certainly levels of the sequence: those at the ends of batches, or
    /// of all steps in the exact order.
    #[must_use]
    pub fn exact_levels(&self) -> u32 {
        let all = self.simplified.collapses().steps() as u32;
        self.source.batches().map_or(all, |batches| batches.len() as u32)
    }

    /// Number of triangles encoded so far.
    #[must_use]
    pub fn triangles(&self) -> u32 {
        self.codec.mesh.face_count()
    }

    /// Returns whether all steps are encoded.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.vertices() == self.header.vertices && self.codec.points.are_complete()
    }

    /// Object-space error of the mesh that is encoded so far, as a decoder knows it.
    #[must_use]
    pub fn error(&self) -> f32 {
        error_value(self.codec.errors.error)
    }

    /// Returns whether no batch has begun of which steps are still to come.
    pub(crate) fn is_between_batches(&self) -> bool {
        self.codec.is_between_batches()
    }

    /// What the object has cost so far.
    pub(crate) fn cost(&self) -> Cost {
        self.codec.cost()
    }

    /// Encodes the next step; the object must not be complete.
    pub(crate) fn encode_step(&mut self, coder: &mut Encoder, contexts: &mut Contexts) {
        let MeshHeader { vertices, triangles, .. } = self.header;
        let limits = StepLimits { vertices, triangles, bytes: usize::MAX };
        let step = self.codec.code_step(coder, &self.source, contexts, limits);
        step.expect("an encoder's source has only valid splits");
    }

    /// Encodes the next steps, at least one; the object must not be complete.
    pub fn encode(&mut self, contexts: &mut Contexts, target: BlockTarget) -> EncodedSteps {
        let mut coder = Encoder::default();
        let mut steps = 0;
        loop {
            self.encode_step(&mut coder, contexts);
            steps += 1;
            let must_go_on = target.until_triangle && self.triangles() == 0;
            if coder.len() >= target.bytes && !must_go_on || self.is_complete() {
                break;
            }
        }
        EncodedSteps::new(steps, coder, self.cost(), target.bytes_before)
    }

    /// Bytes of the thesis's packages for the steps so far, the uncompressed form that streams are
    /// compared with: plain words and bytes, positions only (table 4.3), and the parent's number.
    #[must_use]
    pub fn package_bytes(&self) -> u64 {
        let ObjectCodec { package_bytes, points, .. } = &self.codec;
        const POSITION_BYTES: u64 = 12;
        package_bytes + points.package_bytes + POSITION_BYTES * u64::from(self.vertices())
    }
}
