//! The decoder of a block in which several objects take turns.

use crate::entropy::coder::Coder;
use crate::entropy::decoder::Decoder;
use crate::invalid::InvalidStream;
use crate::mesh_decoder::{MeshDecoder, StepBlock};
use crate::vertex_split::contexts::Contexts;

/// Decodes a block in which objects take turns: some of `objects`, of which a stream has `total`.
/// After an error the objects have the steps before the faulty one, and what could be decoded of
/// that.
///
/// # Errors
/// If the block cannot be what an encoder wrote after the blocks before it.
pub fn decode_turns<O: AsMut<MeshDecoder>>(
    objects: &mut [O],
    total: u32,
    contexts: &mut Contexts,
    block: StepBlock<'_>,
) -> Result<(), InvalidStream> {
    let mut coder = Decoder::new(block.splits);
    let mut remaining = block.steps;
    while remaining > 0 {
        let number = contexts.turns.code_object(&mut coder, total, 0);
        let object = objects.get_mut(number as usize);
        let object = object.ok_or(InvalidStream("names an object that has no header yet"))?;
        let object = object.as_mut();
        loop {
            remaining -= 1;
            object.decode_step(&mut coder, contexts, block.bytes, remaining == 0)?;
            if remaining == 0 || object.has_all_steps() {
                break;
            }
            if object.is_between_batches() && !coder.bit(&mut contexts.turns.goes_on, false) {
                break;
            }
        }
    }
    Ok(())
}
