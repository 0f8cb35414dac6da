//! The triangles that come with a vertex, told by how they are reached from its survivor.

use super::Broken;
use super::coder::{Bit, Coder};
use super::growth::NONE;
use super::model::{Natural, Tree, Unary};
use super::record::Object;
use super::script::{Birth, Script};
use super::strips::PlaceModels;

/// Rims of up to so many vertices have models of their own.
const RIM: usize = 16;
/// The most triangles that come with one vertex in few bits.
const MANY: usize = 20;

/// What is known about triangles that come.
#[derive(Clone, Debug)]
pub(super) struct BirthModels {
    count: [[Unary<MANY>; 2]; 3],
    more: Natural,
    kind: [[[Bit; 2]; 4]; 3],
    in_rim: [Bit; 4],
    /// By the number of vertices around: the first corner, and how far on the second is.
    corner: [[Tree<16>; RIM + 1]; 3],
}

impl BirthModels {
    pub(super) const NEW: Self = Self {
        count: [const { [Unary::NEW; 2] }; 3],
        more: Natural::NEW,
        kind: [[[Bit::NEW; 2]; 4]; 3],
        in_rim: [Bit::NEW; 4],
        corner: [const { [Tree::NEW; RIM + 1] }; 3],
    };
}

/// What is said about one corner of a new triangle: how it is reached from the survivor.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The survivor follows the other corner: right of the new edge.
    Right,
    /// The survivor follows the new vertex: left of the new edge.
    Left,
    /// The survivor is no corner.
    Apart,
}

impl Kind {
    pub(super) fn of(birth: Birth, survivor: u32) -> Self {
        if birth.after == survivor {
            Self::Right
        } else if birth.next == survivor {
            Self::Left
        } else {
            Self::Apart
        }
    }
}

impl Object {
    /// The triangles that come: into `self.births`.
    pub(super) fn births<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut BirthModels,
        survivor: u32,
    ) -> Result<(), Broken> {
        let live = self.growth.vertices();
        let truth = script.births(live - 1);
        let size = match self.ring.len() {
            0 => 0,
            1..=3 => 1,
            _ => 2,
        };
        let model = &mut models.count[size][usize::from(self.open)];
        let mut count = model.code(coder, truth.len() as u32);
        if count == MANY as u32 {
            count = count.saturating_add(models.more.code(coder, (truth.len() as u32).wrapping_sub(count)));
        }
        self.births.clear();
        let mut before = 3;
        let mut right = None;
        for i in 0..count as usize {
            let wanted = truth.get(i).copied().unwrap_or_default();
            let kind = Kind::of(wanted, survivor);
            let model = &mut models.kind[i.min(2)][before];
            let kind = if coder.bit(&mut model[0], kind == Kind::Apart) {
                Kind::Apart
            } else if coder.bit(&mut model[1], kind == Kind::Right) {
                Kind::Right
            } else {
                Kind::Left
            };
            before = kind as usize;
            let birth = match kind {
                Kind::Right => {
                    let corner = self.corner(coder, models, wanted.next, None);
                    right = right.or(corner.1);
                    Birth { next: corner.0, after: survivor }
                }
                Kind::Left => {
                    let corner = self.corner(coder, models, wanted.after, right);
                    Birth { next: survivor, after: corner.0 }
                }
                Kind::Apart => {
                    let next = self.corner(coder, models, wanted.next, None).0;
                    Birth { next, after: self.corner(coder, models, wanted.after, None).0 }
                }
            };
            let Birth { next, after } = birth;
            let own = self.growth.submesh[live as usize - 1];
            let foreign = [next, after].iter().any(|&v| self.growth.submesh[v as usize] != own);
            if next == after || next == live - 1 || after == live - 1 || foreign {
                return Err(Broken("has a triangle that cannot be"));
            }
            self.births.push(birth);
            if self.births.len() > 1 << 20 {
                return Err(Broken("has more triangles at one vertex than can be meant"));
            }
        }
        Ok(())
    }

    /// A corner of a new triangle: one of the vertices around the survivor, or any. Returns its place around it too.
    /// `right` is where the triangle right of the new edge lies.
    fn corner<C: Coder>(
        &mut self,
        coder: &mut C,
        models: &mut BirthModels,
        wanted: u32,
        right: Option<usize>,
    ) -> (u32, Option<usize>) {
        let n = self.rim.len();
        self.packages += 1;
        let place = if C::WRITES { self.rim.iter().position(|&v| v == wanted) } else { None };
        let model = &mut models.in_rim[n.min(3)];
        if n == 0 || !coder.bit(model, place.is_some()) {
            self.packages += 4;
            return (coder.uniform(self.growth.vertices(), wanted), None);
        }
        // Counted from the other triangle, if there is one: so many triangles go over.
        let from = right.unwrap_or(0);
        let far = ((place.unwrap_or(0) + n - from) % n) as u32;
        let far = if n <= RIM {
            let closed = n == self.ring.len();
            let set = if right.is_none() { 0 } else { 1 + usize::from(closed) };
            models.corner[set][n].code(coder, far) as usize
        } else {
            coder.uniform(n as u32, far) as usize
        };
        let place = (far + from) % n;
        (self.rim[place], Some(place))
    }

    /// Adds the triangles that come, and puts them into their strips.
    pub(super) fn faces<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut PlaceModels,
        new: u32,
        survivor: u32,
    ) -> Result<(), Broken> {
        let mut sibling = NONE;
        for &birth in &self.births {
            let face = self.growth.add_face([new, birth.next, birth.after]);
            let Some(order) = &mut self.order else { continue };
            // The triangles beyond the two edges that were one before.
            let (x, right) = match Kind::of(birth, survivor) {
                Kind::Right => (birth.next, true),
                Kind::Left => (birth.after, false),
                Kind::Apart => (NONE, false),
            };
            let beyond = |follows: bool| {
                let spoke = self.ring.iter().find(|s| x == if follows { s.a } else { s.b });
                spoke.map_or(NONE, |s| s.face())
            };
            let explicit = order.place(coder, script, models, [beyond(right), beyond(!right), sibling])?;
            self.packages += if explicit { 5 } else { 1 };
            sibling = face;
        }
        Ok(())
    }
}
