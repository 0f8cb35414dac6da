//! Which triangles of a survivor go over to the new vertex: mostly what the new triangles suggest.

use super::births::Kind;
use super::coder::{Bit, Coder};
use super::growth::Spoke;
use super::record::Object;
use super::script::{Birth, Script};

/// What is known about triangles that go over.
#[derive(Clone, Debug)]
pub(super) struct MoveModels {
    /// All go as expected; all go although nothing is expected.
    all: [[Bit; 2]; 2],
    one: [[[Bit; 3]; 4]; 2],
}

impl MoveModels {
    pub(super) const NEW: Self = Self { all: [[Bit::NEW; 2]; 2], one: [[[Bit::NEW; 3]; 4]; 2] };
}

impl Object {
    /// Which triangles of the survivor go over: into `self.moves`, as the ring has them.
    pub(super) fn moving<C: Coder, S: Script>(&mut self, coder: &mut C, script: &S, models: &mut MoveModels, new: u32) {
        let mut expected = std::mem::take(&mut self.expected);
        expect(&self.ring, &self.births, self.last_survivor, &mut expected);
        self.say_moves(coder, script, models, new, &expected);
        self.expected = expected;
    }

    fn say_moves<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut MoveModels,
        new: u32,
        expected: &[u8],
    ) {
        let n = self.ring.len();
        self.moves.clear();
        if n == 0 {
            return;
        }
        let sure = expected.iter().all(|e| matches!(e, 1 | 2));
        if sure {
            let right = (self.ring.iter().zip(expected)).all(|(s, &e)| script.moves(s.corner, new) == (e == 2));
            if coder.bit(&mut models.all[0][usize::from(self.open)], right) {
                self.moves.extend(expected.iter().map(|&e| e == 2));
                return;
            }
        } else if self.births.is_empty() {
            // Nothing comes: all go over, as with a vertex that was made for a seam, or none do.
            let all = self.ring.iter().all(|s| script.moves(s.corner, new));
            if coder.bit(&mut models.all[1][usize::from(self.open)], all) {
                self.moves.resize(n, true);
                return;
            }
        }
        let mut before = 0;
        for (spoke, &e) in self.ring.iter().zip(expected) {
            let model = &mut models.one[usize::from(sure)][usize::from(e)][before];
            let moves = coder.bit(model, script.moves(spoke.corner, new));
            before = 1 + usize::from(moves);
            self.moves.push(moves);
        }
    }
}

/// For each triangle around the survivor whether it goes over: 0 not known, 1 stays, 2 goes, 3 contradictory.
fn expect(ring: &[Spoke], births: &[Birth], survivor: u32, expected: &mut Vec<u8>) {
    expected.clear();
    expected.resize(ring.len(), 0);
    for &birth in births {
        // A triangle right of the new edge lies between one that stays and one that goes, one left of it too.
        let (x, follows, precedes) = match Kind::of(birth, survivor) {
            Kind::Right => (birth.next, 1, 2),
            Kind::Left => (birth.after, 2, 1),
            Kind::Apart => continue,
        };
        for (spoke, e) in ring.iter().zip(expected.iter_mut()) {
            *e |= if spoke.a == x { follows } else { 0 } | if spoke.b == x { precedes } else { 0 };
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
