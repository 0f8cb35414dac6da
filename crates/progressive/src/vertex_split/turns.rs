//! Turns: which object of a scene goes on, where a block has steps of several.

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::coder::Coder;
use crate::entropy::integer_codes::GammaCode;

/// Contexts of turns, and the object that is expected next.
#[derive(Clone, Debug)]
pub(crate) struct TurnContexts {
    /// Distance from the object expected to the one that goes on.
    pub(crate) object: GammaCode,
    /// After a batch the same object goes on.
    pub(crate) goes_on: AdaptiveBit,
    /// The object behind the one of the last turn.
    expected: u32,
}

impl TurnContexts {
    pub(crate) const NEW: Self =
        Self { object: GammaCode::NEW, goes_on: AdaptiveBit::NEW, expected: 0 };

    /// Codes the object, one of `objects`, that has the next turn.
    pub(crate) fn code_object<C: Coder>(
        &mut self,
        coder: &mut C,
        objects: u32,
        wanted: u32,
    ) -> u32 {
        let objects = u64::from(objects.max(1));
        let expected = u64::from(self.expected);
        let distance = (u64::from(wanted) + objects - expected) % objects;
        let distance = self.object.code(coder, distance as u32);
        let object = (expected + u64::from(distance)) % objects;
        self.expected = ((object + 1) % objects) as u32;
        object as u32
    }
}
