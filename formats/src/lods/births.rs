//! The triangles that come with a vertex, told by how they are reached from its survivor.

use super::Broken;
use super::chances::{Bit, Symbol};
use super::coder::Coder;
use super::growth::{Born, Kind, NONE, RimVertex};
use super::model::Natural;
use super::record::Object;
use super::script::{Birth, Script};
use super::strips::PlaceModels;

/// Rims of up to so many vertices have models of their own.
const RIM: usize = 16;
/// The most triangles that come with one vertex in few bits.
const MANY: u32 = 15;

/// What is usual, in one symbol: a triangle on each side of the edge, on one side, or none at all;
/// and what goes over is as expected (everything, if nothing comes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Both = 0,
    Right = 1,
    Left = 2,
    None = 3,
    /// All is told at length.
    Other = 4,
}

/// What is known about triangles that come.
#[derive(Clone, Debug)]
pub(super) struct BirthModels {
    /// By the size of the ring, whether it closes, and whether the step went on.
    shape: [[[Symbol; 2]; 2]; 4],
    count: [Symbol; 2],
    more: Natural,
    kind: [[[Bit; 2]; 4]; 3],
    in_rim: [Bit; 4],
    /// By the number of vertices around: the first corner, and how far on the second is.
    corner: [[Symbol; RIM + 1]; 3],
}

impl BirthModels {
    pub(super) const NEW: Self = Self {
        shape: [[[Symbol::NEW; 2]; 2]; 4],
        count: [Symbol::NEW; 2],
        more: Natural::NEW,
        kind: [[[Bit::NEW; 2]; 4]; 3],
        in_rim: [Bit::NEW; 4],
        corner: [[Symbol::NEW; RIM + 1]; 3],
    };
}

impl Kind {
    fn of(birth: Birth, survivor: u32) -> Self {
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
    ) -> Result<Shape, Broken> {
        let new = self.growth.vertices() - 1;
        let shape = if C::WRITES { self.shape(script, new, survivor) } else { Shape::Other };
        let size = self.ring.len().min(3);
        let model = &mut models.shape[size][usize::from(self.closed)][usize::from(self.open)];
        let shape = match coder.symbol(model, shape as u32) {
            0 => Shape::Both,
            1 => Shape::Right,
            2 => Shape::Left,
            3 => Shape::None,
            _ => Shape::Other,
        };
        self.births.clear();
        if shape == Shape::Other {
            self.births_at_length(coder, script, models, survivor)?;
            return Ok(shape);
        }
        if shape == Shape::None {
            return Ok(shape);
        }
        if self.around() == 0 {
            return Err(Broken("has a triangle beside nothing"));
        }
        let truth = script.births(new);
        let wanted = |i: usize| truth.get(i).copied().unwrap_or_default();
        let mut first = None;
        if shape != Shape::Left {
            let place = self.on_rim(coder, models, wanted(0).next, None);
            first = Some(place);
            self.born(self.on_place(place).vertex, Some(place), Kind::Right, survivor);
        }
        if shape != Shape::Right {
            let after = wanted(usize::from(shape == Shape::Both)).after;
            let place = self.on_rim(coder, models, after, first);
            self.born(self.on_place(place).vertex, Some(place), Kind::Left, survivor);
        }
        self.sound(0, new)?;
        Ok(shape)
    }

    /// What a writer has to say.
    fn shape<S: Script>(&mut self, script: &S, new: u32, survivor: u32) -> Shape {
        let truth = script.births(new);
        let kind = |i: usize| Kind::of(truth[i], survivor);
        let shape = match truth.len() {
            0 => Shape::None,
            1 if kind(0) == Kind::Right => Shape::Right,
            1 if kind(0) == Kind::Left => Shape::Left,
            2 if (kind(0), kind(1)) == (Kind::Right, Kind::Left) => Shape::Both,
            _ => return Shape::Other,
        };
        self.births.clear();
        for (i, birth) in truth.iter().enumerate() {
            let told = if kind(i) == Kind::Right { birth.next } else { birth.after };
            let Some(place) = self.place_on_rim(told) else { return Shape::Other };
            self.born(told, Some(place), kind(i), survivor);
        }
        if self.goes_as_expected(script, new, shape) { shape } else { Shape::Other }
    }

    fn place_on_rim(&self, vertex: u32) -> Option<usize> {
        (0..self.around()).position(|i| self.on_place(i).vertex == vertex)
    }

    /// How many vertices are around the survivor.
    #[inline]
    fn around(&self) -> usize {
        if self.closed { self.ring.len() } else { self.rim.len() }
    }

    /// One of them.
    #[inline]
    fn on_place(&self, i: usize) -> RimVertex {
        if !self.closed {
            return self.rim[i];
        }
        let before = if i == 0 { self.ring.len() } else { i } - 1;
        RimVertex { vertex: self.ring[i].a, beyond: [i as u32, before as u32] }
    }

    /// Adds a triangle that comes. `told` is the corner that is neither the new vertex nor the
    /// survivor.
    fn born(&mut self, told: u32, place: Option<usize>, kind: Kind, survivor: u32) {
        let beyond = place.map_or([NONE; 2], |p| self.on_place(p).beyond);
        let (next, after) = if kind == Kind::Right { (told, survivor) } else { (survivor, told) };
        self.births.push(Born { next, after, kind, beyond });
    }

    /// Whether all triangles from the one of that number on can be.
    fn sound(&self, from: usize, new: u32) -> Result<(), Broken> {
        let submesh = &self.growth.submesh;
        for b in &self.births[from..] {
            let foreign =
                |v: u32| self.submeshes > 1 && submesh[v as usize] != submesh[new as usize];
            if b.next == b.after
                || b.next == new
                || b.after == new
                || foreign(b.next)
                || foreign(b.after)
            {
                return Err(Broken("has a triangle that cannot be"));
            }
        }
        Ok(())
    }

    fn births_at_length<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut BirthModels,
        survivor: u32,
    ) -> Result<(), Broken> {
        let new = self.growth.vertices() - 1;
        let truth = script.births(new);
        let told = truth.len() as u32;
        let mut count = coder.symbol(&mut models.count[usize::from(self.open)], told.min(MANY));
        if count == MANY {
            count = count.saturating_add(models.more.code(coder, told.wrapping_sub(count)));
        }
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
            match kind {
                Kind::Right => {
                    let (corner, place) = self.corner(coder, models, wanted.next, None);
                    right = right.or(place);
                    self.born(corner, place, kind, survivor);
                }
                Kind::Left => {
                    let (corner, place) = self.corner(coder, models, wanted.after, right);
                    self.born(corner, place, kind, survivor);
                }
                Kind::Apart => {
                    let next = self.corner(coder, models, wanted.next, None).0;
                    let after = self.corner(coder, models, wanted.after, None).0;
                    self.births.push(Born { next, after, kind, beyond: [NONE; 2] });
                }
            }
            self.sound(i, new)?;
            if self.births.len() > 1 << 20 {
                return Err(Broken("has more triangles at one vertex than can be meant"));
            }
        }
        Ok(())
    }

    /// A corner of a new triangle: one of the vertices around the survivor, or any. Returns its
    /// place around it too.
    fn corner<C: Coder>(
        &mut self,
        coder: &mut C,
        models: &mut BirthModels,
        wanted: u32,
        right: Option<usize>,
    ) -> (u32, Option<usize>) {
        let n = self.around();
        let around = C::WRITES && self.place_on_rim(wanted).is_some();
        if n == 0 || !coder.bit(&mut models.in_rim[n.min(3)], around) {
            self.packages += 5;
            return (coder.uniform(self.growth.vertices(), wanted), None);
        }
        let place = self.on_rim(coder, models, wanted, right);
        (self.on_place(place).vertex, Some(place))
    }

    /// A place on the rim, which is not empty. `right` is where the triangle right of the new edge
    /// lies.
    fn on_rim<C: Coder>(
        &mut self,
        coder: &mut C,
        models: &mut BirthModels,
        wanted: u32,
        right: Option<usize>,
    ) -> usize {
        let n = self.around();
        self.packages += 1;
        // Counted from the other triangle, if there is one: so many triangles go over.
        let from = right.unwrap_or(0);
        let on = |place: usize| if place >= n { place - n } else { place };
        let far = if C::WRITES {
            on(self.place_on_rim(wanted).unwrap_or(0) + n - from) as u32
        } else {
            0
        };
        let far = if n <= RIM {
            let set = if right.is_none() { 0 } else { 1 + usize::from(self.closed) };
            // Only a writer of nonsense goes further than there are vertices.
            coder.symbol(&mut models.corner[set][n], far).min(n as u32 - 1) as usize
        } else {
            coder.uniform(n as u32, far) as usize
        };
        on(far + from)
    }

    /// Puts the triangles that came last into their strips.
    pub(super) fn places<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut PlaceModels,
    ) -> Result<(), Broken> {
        let Some(order) = &mut self.order else { return Ok(()) };
        let first = self.growth.faces() - self.births.len() as u32;
        let mut sibling = NONE;
        for (face, birth) in (first..).zip(&self.births) {
            let face_of = |i: u32| self.ring.get(i as usize).map_or(NONE, |s| s.face());
            // The triangles beyond the two edges that were one before: that which stays, and that
            // which goes.
            let [a, b] = birth.beyond.map(face_of);
            let beyond = if birth.kind == Kind::Right { [a, b] } else { [b, a] };
            let explicit = order.place(coder, script, models, [beyond[0], beyond[1], sibling])?;
            self.packages += if explicit { 5 } else { 1 };
            sibling = face;
        }
        Ok(())
    }
}
