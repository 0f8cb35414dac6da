//! Which triangles of a survivor go over to the new vertex: mostly what the new triangles suggest.

use super::births::Shape;
use super::chances::Bit;
use super::coder::Coder;
use super::growth::{Born, Kind, Spoke};
use super::record::Object;
use super::script::Script;

/// What is known about triangles that go over.
#[derive(Clone, Debug)]
pub(super) struct MoveModels {
    /// By what is expected (0 to 3), and what the triangle before does.
    one: [[Bit; 3]; 4],
}

impl MoveModels {
    pub(super) const NEW: Self = Self { one: [[Bit::NEW; 3]; 4] };
}

/// What is expected of a triangle: these two bits, not known if none is set, contradictory if both
/// are.
const STAYS: u8 = 1;
const GOES: u8 = 2;

impl Object {
    /// Which triangles of the survivor go over: into `self.moves`, as the ring has them.
    pub(super) fn moving<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut MoveModels,
        new: u32,
        shape: Shape,
    ) -> Result<(), super::Broken> {
        self.moves.clear();
        match shape {
            Shape::None => self.moves.resize(self.ring.len(), true),
            Shape::Other => {
                expect(&self.ring, &self.births, &mut self.expected);
                let mut before = 0;
                for (spoke, &e) in self.ring.iter().zip(&self.expected) {
                    let model = &mut models.one[usize::from(e)][before];
                    let moves = coder.bit(model, script.moves(spoke.corner, new));
                    before = 1 + usize::from(moves);
                    self.moves.push(moves);
                }
            }
            // A writer has seen what is expected.
            _ => {
                if !C::WRITES {
                    expect(&self.ring, &self.births, &mut self.expected);
                }
                if self.expected.iter().any(|e| !matches!(*e, STAYS | GOES)) {
                    return Err(super::Broken("has triangles that neither stay nor go"));
                }
                self.moves.extend(self.expected.iter().map(|&e| e == GOES));
            }
        }
        Ok(())
    }

    /// What [`expect`] finds in the usual case, at once: two triangles come into a fan that closes.
    /// What stays begins with the triangle beyond the right one, what goes with that beyond the
    /// left one.
    pub(super) fn arcs(&self, shape: Shape) -> Option<[usize; 2]> {
        match (&self.births[..], shape) {
            ([right, left], Shape::Both) if self.closed => {
                let arcs = [right, left].map(|b| b.beyond[0] as usize);
                (arcs[0] != arcs[1]).then_some(arcs)
            }
            _ => None,
        }
    }

    /// Whether a shape other than [`Shape::Other`] tells what goes over, `self.births` being there:
    /// for a writer.
    pub(super) fn goes_as_expected<S: Script>(
        &mut self,
        script: &S,
        new: u32,
        shape: Shape,
    ) -> bool {
        let goes = |s: &Spoke| script.moves(s.corner, new);
        if shape == Shape::None {
            return self.ring.iter().all(goes);
        }
        expect(&self.ring, &self.births, &mut self.expected);
        let known = |(s, &e): (&Spoke, &u8)| matches!(e, STAYS | GOES) && goes(s) == (e == GOES);
        self.ring.iter().zip(&self.expected).all(known)
    }
}

/// For each triangle around the survivor whether it goes over.
fn expect(ring: &[Spoke], births: &[Born], expected: &mut Vec<u8>) {
    expected.clear();
    expected.resize(ring.len(), 0);
    for birth in births {
        // A triangle right of the new edge lies between one that stays and one that goes, one left
        // of it too.
        let fates = match birth.kind {
            Kind::Right => [STAYS, GOES],
            Kind::Left => [GOES, STAYS],
            Kind::Apart => continue,
        };
        for (at, fate) in birth.beyond.into_iter().zip(fates) {
            if let Some(e) = expected.get_mut(at as usize) {
                *e |= fate;
            }
        }
    }
    // Triangles with a common edge that no new one parts go together.
    let mut start = 0;
    while start < ring.len() {
        let more = ring[start..].windows(2).take_while(|w| w[0].b == w[1].a).count();
        let fan = start..=start + more;
        let closed = ring[start + more].b == ring[start].a;
        for _ in 0..=usize::from(closed) {
            let mut last = if closed { expected[start + more] } else { 0 };
            for e in &mut expected[fan.clone()] {
                *e = if *e == 0 { last } else { *e };
                last = *e;
            }
        }
        let mut last = 0;
        for e in expected[fan].iter_mut().rev() {
            *e = if *e == 0 { last } else { *e };
            last = *e;
        }
        start += more + 1;
    }
}
