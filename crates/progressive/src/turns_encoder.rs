//! The encoder of a block in which several objects take turns.

use crate::entropy::coder::Coder;
use crate::entropy::encoder::Encoder;
use crate::mesh_encoder::{EncodedSteps, MeshEncoder};
use crate::vertex_split::budget::Cost;
use crate::vertex_split::contexts::Contexts;

/// Encodes steps of several objects, which take turns, as one substream. A turn may end with each
/// batch.
pub struct TurnsEncoder<'c> {
    coder: Encoder,
    contexts: &'c mut Contexts,
    /// Number of objects of the stream.
    objects: u32,
    steps: u32,
    /// Above the costs of all objects that had a turn.
    cost: Cost,
}

impl<'c> TurnsEncoder<'c> {
    /// A block without steps, in a stream of `objects` objects.
    #[must_use]
    pub fn new(contexts: &'c mut Contexts, objects: u32) -> Self {
        let (coder, cost) = (Encoder::default(), Cost::default());
        Self { coder, contexts, objects, steps: 0, cost }
    }

    /// Estimated number of bytes so far.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.coder.len()
    }

    /// Encodes a turn of an object that is not complete: at least one step, then as many as follow
    /// until the block has `max_bytes` bytes, the object is complete, or `goes_on` is false after a
    /// batch. Returns whether a turn must follow in this block.
    #[must_use]
    pub fn turn(
        &mut self,
        number: u32,
        object: &mut MeshEncoder<'_>,
        max_bytes: usize,
        goes_on: impl Fn(&MeshEncoder<'_>) -> bool,
    ) -> bool {
        self.contexts.turns.code_object(&mut self.coder, self.objects, number);
        let must_follow = loop {
            object.encode_step(&mut self.coder, self.contexts);
            self.steps += 1;
            if object.is_complete() || self.bytes() >= max_bytes {
                break false;
            }
            if object.is_between_batches() {
                let goes_on = goes_on(object);
                if !self.coder.bit(&mut self.contexts.turns.goes_on, goes_on) {
                    break true;
                }
            }
        };
        self.cost = self.cost.max(object.cost());
        must_follow
    }

    /// Finishes the block, behind so many bytes of the stream.
    #[must_use]
    pub fn finish(self, bytes_before: usize) -> EncodedSteps {
        EncodedSteps::new(self.steps, self.coder, self.cost, bytes_before)
    }
}
