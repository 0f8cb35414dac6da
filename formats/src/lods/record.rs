//! One vertex after another: where each comes from, the triangles that come with it, those that go over to it.
//!
//! Thesis 4.3.3's UpdatePackage. Written once for both sides (see `coder.rs`).

use super::coder::{Bit, Coder};
use super::growth::{Growth, NONE, Spoke, rim};
use super::model::{Natural, Tree, Unary};
use super::script::{Birth, Script};
use super::strips::{Order, PlaceModels};
use super::values::{Near, Stream, ValueModels};
use super::{Broken, may_hold};

/// Rims with fewer vertices than this have models of their own.
const RIM: usize = 16;
/// The most triangles that come with one vertex in few bits.
const MANY: usize = 20;

/// What is known about growing.
#[derive(Clone, Debug)]
pub(super) struct Models {
    survivor: Natural,
    first_of_step: Bit,
    mates: Unary<8>,
    submesh: Bit,
    births: [[Unary<MANY>; 2]; 3],
    more_births: Natural,
    kind: [[[Bit; 2]; 4]; 3],
    in_rim: [Bit; 4],
    /// By the number of vertices around: the first corner, and how far on the second is.
    corner: [[Tree<16>; RIM + 1]; 3],
    all_move: [[Bit; 2]; 2],
    moves: [[[Bit; 3]; 4]; 2],
    same_place: Bit,
    goes_on: [Bit; 2],
    error: Natural,
    values: ValueModels,
    places: PlaceModels,
}

impl Models {
    pub(super) fn new() -> Self {
        Self {
            survivor: Natural::NEW,
            first_of_step: Bit::NEW,
            mates: Unary::NEW,
            submesh: Bit::NEW,
            births: [const { [Unary::NEW; 2] }; 3],
            more_births: Natural::NEW,
            kind: [[[Bit::NEW; 2]; 4]; 3],
            in_rim: [Bit::NEW; 4],
            corner: [const { [Tree::NEW; RIM + 1] }; 3],
            all_move: [[Bit::NEW; 2]; 2],
            moves: [[[Bit::NEW; 3]; 4]; 2],
            same_place: Bit::NEW,
            goes_on: [Bit::NEW; 2],
            error: Natural::NEW,
            values: ValueModels::new(),
            places: PlaceModels::NEW,
        }
    }
}

/// One object as it grows.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub(super) growth: Growth,
    pub(super) order: Option<Order>,
    streams: Vec<Stream>,
    submeshes: u32,
    /// For each vertex where it came from, and whether its step went on after it.
    pub(super) survivors: Vec<u32>,
    pub(super) goes_on: Vec<bool>,
    /// The error of the last whole step, as it is written.
    pub(super) error: u32,
    /// Spokes looked at: a measure of work.
    pub(super) work: u64,
    /// Bytes that the packages would take as plain words and bytes, without the vertices themselves: the survivor (4),
    /// flags and counts (1), a bit for each triangle that may go over, and for each that comes a corner and a strip.
    pub(super) packages: u64,
    /// Whether the last vertex's step goes on.
    open: bool,
    last_survivor: u32,
    ring: Vec<Spoke>,
    rim: Vec<u32>,
    births: Vec<Birth>,
    expected: Vec<u8>,
    moves: Vec<bool>,
    found: Vec<i32>,
}

/// What is said about one corner of a new triangle: how it is reached from the survivor.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The survivor follows the other corner: right of the new edge.
    Right,
    /// The survivor follows the new vertex: left of the new edge.
    Left,
    /// The survivor is no corner.
    Apart,
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
    pub(super) fn new(growth: Growth, streams: Vec<Stream>, submeshes: u32, strips: bool) -> Self {
        Self {
            growth,
            order: strips.then(Order::new),
            streams,
            submeshes,
            survivors: Vec::new(),
            goes_on: Vec::new(),
            error: 0,
            work: 0,
            packages: 0,
            open: false,
            last_survivor: 0,
            ring: Vec::new(),
            rim: Vec::new(),
            births: Vec::new(),
            expected: Vec::new(),
            moves: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Says one step: its vertices, then the error of the mesh that shows them. There will be `most` vertices, and so many
    /// bytes are there that tell of them.
    pub(super) fn step<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut Models,
        most: u32,
        bytes: usize,
    ) -> Result<(), Broken> {
        loop {
            if self.growth.vertices() >= most {
                return Err(Broken("has more vertices than were promised"));
            }
            let new = self.growth.vertices();
            if new == 0 {
                self.first(coder, script)
            } else {
                self.vertex(coder, script, models)?
            }
            self.open = new > 0 && coder.bit(&mut models.goes_on[usize::from(self.open)], script.goes_on(new));
            self.goes_on.push(self.open);
            if !may_hold(bytes, self) {
                return Err(Broken("says more than so few bytes may"));
            }
            if !self.open {
                let error = script.error(new);
                let fall = models.error.code(coder, self.error.wrapping_sub(error));
                self.error = self.error.wrapping_sub(fall);
                return Ok(());
            }
        }
    }

    /// Makes a whole of an object that broke within a step: it may look wrong, but it can be looked at.
    pub(super) fn mend(&mut self) {
        let growth = &mut self.growth;
        let missing = growth.vertices() as usize * growth.channels() - growth.index.len();
        growth.index.resize(growth.index.len() + missing, 0);
        growth.value.resize(growth.index.len(), 0.0);
    }

    /// The vertex that is there from the beginning: its numbers as they are.
    fn first<C: Coder, S: Script>(&mut self, coder: &mut C, script: &S) {
        let submesh = coder.uniform(self.submeshes, script.submesh(0));
        self.growth.add_vertex(submesh);
        self.survivors.push(0);
        self.found.clear();
        for channel in 0..self.growth.channels() {
            let truth = script.index(0).get(channel).copied().unwrap_or_default();
            self.found.push(coder.raw(32, truth as u32) as i32);
        }
        self.growth.add_values(&self.found);
    }

    fn vertex<C: Coder, S: Script>(&mut self, coder: &mut C, script: &S, models: &mut Models) -> Result<(), Broken> {
        let survivor = self.survivor(coder, script, models);
        let new = self.growth.vertices();
        let like = self.growth.submesh[survivor as usize];
        let submesh = if self.submeshes == 1 || coder.bit(&mut models.submesh, script.submesh(new) == like) {
            like
        } else {
            coder.uniform(self.submeshes, script.submesh(new))
        };
        let mate = self.open.then(|| new - 1);
        self.survivors.push(survivor);
        self.last_survivor = survivor;
        self.growth.add_vertex(submesh);

        self.growth.ring(survivor, &mut self.ring);
        rim(&self.ring, &mut self.rim);
        self.work += 2 + self.ring.len() as u64;
        self.packages += 5 + self.ring.len().div_ceil(8) as u64;
        self.births(coder, script, models, survivor)?;
        self.moving(coder, script, models, new);
        self.growth.split(survivor, new, &self.ring, &self.moves);
        self.faces(coder, script, models, new, survivor)?;

        self.growth.ring(new, &mut self.ring);
        rim(&self.ring, &mut self.rim);
        self.work += self.ring.len() as u64;
        let same = |v: u32| script.index(v).get(..3) == script.index(new).get(..3);
        let mate = mate.filter(|&m| coder.bit(&mut models.same_place, same(m)));
        if let Some(m) = mate {
            self.growth.mate[new as usize] = std::mem::replace(&mut self.growth.mate[m as usize], new);
        }
        let near = Near { survivor, mate, rim: &self.rim };
        self.growth.values(coder, script, &mut models.values, &self.streams, near, &mut self.found);
        Ok(())
    }

    /// Where a new vertex comes from. Those of one step come from one place.
    fn survivor<C: Coder, S: Script>(&mut self, coder: &mut C, script: &S, models: &mut Models) -> u32 {
        let live = self.growth.vertices();
        let wanted = script.survivor(live);
        if self.open {
            // The survivor before, or one of its mates.
            let most = 8;
            let (mut rank, mut v) = (0, self.last_survivor);
            while rank < most && v != wanted {
                v = self.growth.mate[v as usize];
                rank = if v == self.last_survivor { most } else { rank + 1 };
            }
            let rank = models.mates.code(coder, rank);
            if rank < most {
                return (0..rank).fold(self.last_survivor, |v, _| self.growth.mate[v as usize]);
            }
        }
        let on =
            if wanted >= self.last_survivor { wanted - self.last_survivor } else { wanted + live - self.last_survivor };
        let on = models.survivor.code(coder, on);
        ((u64::from(self.last_survivor) + u64::from(on)) % u64::from(live)) as u32
    }

    /// The triangles that come: into `self.births`.
    fn births<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut Models,
        survivor: u32,
    ) -> Result<(), Broken> {
        let live = self.growth.vertices();
        let truth = script.births(live - 1);
        let size = match self.ring.len() {
            0 => 0,
            1..=3 => 1,
            _ => 2,
        };
        let model = &mut models.births[size][usize::from(self.open)];
        let mut count = model.code(coder, truth.len() as u32);
        if count == MANY as u32 {
            count = count.saturating_add(models.more_births.code(coder, (truth.len() as u32).wrapping_sub(count)));
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
        models: &mut Models,
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

    /// Which triangles of the survivor go over: into `self.moves`, as the ring has them.
    fn moving<C: Coder, S: Script>(&mut self, coder: &mut C, script: &S, models: &mut Models, new: u32) {
        let mut expected = std::mem::take(&mut self.expected);
        expect(&self.ring, &self.births, self.last_survivor, &mut expected);
        self.say_moves(coder, script, models, new, &expected);
        self.expected = expected;
    }

    fn say_moves<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut Models,
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
            if coder.bit(&mut models.all_move[0][usize::from(self.open)], right) {
                self.moves.extend(expected.iter().map(|&e| e == 2));
                return;
            }
        } else if self.births.is_empty() {
            // Nothing comes: all go over, as with a vertex that was made for a seam, or none do.
            let all = self.ring.iter().all(|s| script.moves(s.corner, new));
            if coder.bit(&mut models.all_move[1][usize::from(self.open)], all) {
                self.moves.resize(n, true);
                return;
            }
        }
        let mut before = 0;
        for (spoke, &e) in self.ring.iter().zip(expected) {
            let model = &mut models.moves[usize::from(sure)][usize::from(e)][before];
            let moves = coder.bit(model, script.moves(spoke.corner, new));
            before = 1 + usize::from(moves);
            self.moves.push(moves);
        }
    }

    /// Adds the triangles that come, and puts them into their strips.
    fn faces<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut Models,
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
            let explicit = order.place(coder, script, &mut models.places, [beyond(right), beyond(!right), sibling])?;
            self.packages += if explicit { 5 } else { 1 };
            sibling = face;
        }
        Ok(())
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
