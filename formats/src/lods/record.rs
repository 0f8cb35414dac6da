//! One vertex after another: where each comes from, the triangles that come with it, those that go
//! over to it.
//!
//! Thesis 4.3.3's UpdatePackage. Written once for both sides (see `coder.rs`).

use super::births::BirthModels;
use super::chances::{Bit, Symbol};
use super::coder::{Coder, Runs};
use super::growth::{Born, Growth, RimVertex, Spoke, rim};
use super::model::{Below, Natural};
use super::moves::MoveModels;
use super::script::Script;
use super::strips::{Order, PlaceModels};
use super::values::{Near, Stream, ValueModels};
use super::{Broken, may_hold};

/// What is known about growing.
#[derive(Clone, Debug)]
pub(super) struct Models {
    survivor: Below,
    mates: Symbol,
    submesh: Bit,
    births: BirthModels,
    moves: MoveModels,
    same_place: Bit,
    goes_on: [Bit; 2],
    falls: Bit,
    fall: Natural,
    values: ValueModels,
    places: PlaceModels,
}

impl Models {
    pub(super) fn new() -> Self {
        Self {
            survivor: Below::NEW,
            mates: Symbol::NEW,
            submesh: Bit::NEW,
            births: BirthModels::NEW,
            moves: MoveModels::NEW,
            same_place: Bit::NEW,
            goes_on: [Bit::NEW; 2],
            falls: Bit::NEW,
            fall: Natural::NEW,
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
    pub(super) submeshes: u32,
    /// For each vertex where it came from, and whether its step went on after it.
    pub(super) survivors: Vec<u32>,
    pub(super) goes_on: Vec<bool>,
    /// The error of the last whole step, as it is written.
    pub(super) error: u32,
    /// Spokes looked at: a measure of work.
    pub(super) work: u64,
    /// Bytes that the packages would take as plain words and bytes, without the vertices
    /// themselves: the survivor (4), flags and counts (1), a bit for each triangle that may go
    /// over, and for each that comes a corner and a strip.
    pub(super) packages: u64,
    /// Whether the last vertex's step goes on.
    pub(super) open: bool,
    pub(super) last_survivor: u32,
    /// That of the step that comes next.
    next_survivor: u32,
    /// The triangles at the survivor, the vertices around it, and whether they are one fan that
    /// closes.
    pub(super) ring: Vec<Spoke>,
    pub(super) rim: Vec<RimVertex>,
    pub(super) closed: bool,
    pub(super) births: Vec<Born>,
    pub(super) expected: Vec<u8>,
    pub(super) moves: Vec<bool>,
    /// The triangles at the new vertex.
    around: Vec<Spoke>,
    /// The vertices around it.
    near: Vec<u32>,
    found: Vec<i32>,
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
            next_survivor: 0,
            ring: Vec::new(),
            rim: Vec::new(),
            closed: false,
            births: Vec::new(),
            expected: Vec::new(),
            moves: Vec::new(),
            around: Vec::new(),
            near: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Says one step: its vertices, then the error of the mesh that shows them. There will be
    /// `most` vertices, and so many bytes are there that tell of them.
    pub(super) fn step<C: Coder, S: Script>(
        &mut self,
        runs: &mut Runs<C>,
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
                self.first(&mut runs.mesh, script);
            } else {
                self.vertex(runs, script, models, most)?;
            }
            let coder = &mut runs.mesh;
            self.goes_on.push(self.open);
            if !may_hold(bytes, self) {
                return Err(Broken("says more than so few bytes may"));
            }
            if !self.open {
                let error = script.error(new);
                let fall = self.error.wrapping_sub(error);
                let fall = if coder.bit(&mut models.falls, fall != 0) {
                    models.fall.code(coder, fall)
                } else {
                    0
                };
                self.error = self.error.wrapping_sub(fall);
                return Ok(());
            }
        }
    }

    /// Makes a whole of an object that broke within a step: it may look wrong, but it can be looked
    /// at.
    pub(super) fn mend(&mut self) {
        let growth = &mut self.growth;
        growth.numbers.resize(growth.vertices() as usize * growth.channels(), 0);
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

    fn vertex<C: Coder, S: Script>(
        &mut self,
        runs: &mut Runs<C>,
        script: &S,
        models: &mut Models,
        most: u32,
    ) -> Result<(), Broken> {
        let coder = &mut runs.mesh;
        let new = self.growth.vertices();
        let survivor =
            if self.open { self.mate(coder, script, models) } else { self.next_survivor };
        let like = self.growth.submesh[survivor as usize];
        let submesh =
            if self.submeshes == 1 || coder.bit(&mut models.submesh, script.submesh(new) == like) {
                like
            } else {
                coder.uniform(self.submeshes, script.submesh(new))
            };
        let mate = self.open.then(|| new - 1);
        self.survivors.push(survivor);
        self.last_survivor = survivor;
        self.growth.add_vertex(submesh);
        let goes_on = coder.bit(&mut models.goes_on[usize::from(self.open)], script.goes_on(new));
        if !goes_on && new + 1 < most {
            // Said so early that a reader can have it at hand when it comes to it.
            self.next_survivor =
                survivor_beside(coder, models, survivor, new + 1, script.survivor(new + 1));
            self.growth.touch(self.next_survivor);
        }

        self.closed = self.growth.ring(survivor, &mut self.ring);
        if !self.closed {
            rim(&self.ring, &mut self.rim);
        }
        self.work += 2 + self.ring.len() as u64;
        self.packages += 5 + self.ring.len().div_ceil(8) as u64;
        let shape = self.births(coder, script, &mut models.births, survivor)?;
        let arcs = self.arcs(shape);
        if !arcs
            .is_some_and(|arcs| self.growth.part([survivor, new], &self.ring, arcs, &mut self.near))
        {
            self.moving(coder, script, &mut models.moves, new, shape)?;
            self.growth.split(
                [survivor, new],
                &self.ring,
                &self.moves,
                &self.births,
                &mut self.around,
            );
            rim(&self.around, &mut self.rim);
            self.near.clear();
            self.near.extend(self.rim.iter().map(|r| r.vertex));
        }
        // Lists of corners into which those of new triangles are put.
        self.work += self
            .births
            .iter()
            .map(|b| u64::from(self.growth.fans.count(b.next).max(self.growth.fans.count(b.after))))
            .sum::<u64>();
        self.places(&mut runs.strips, script, &mut models.places)?;

        let same = |v: u32| script.index(v).get(..3) == script.index(new).get(..3);
        let mate = mate.filter(|&m| coder.bit(&mut models.same_place, same(m)));
        if let Some(m) = mate {
            self.growth.mate[new as usize] =
                std::mem::replace(&mut self.growth.mate[m as usize], new);
        }
        self.growth.touch_numbers(self.next_survivor);
        self.open = goes_on;
        let near = Near { survivor, mate, rim: &self.near };
        self.growth.values(coder, script, &mut models.values, &self.streams, near, &mut self.found);
        Ok(())
    }

    /// Where a further vertex of a step comes from: mostly the survivor before, or one of its
    /// mates.
    fn mate<C: Coder, S: Script>(&mut self, coder: &mut C, script: &S, models: &mut Models) -> u32 {
        let live = self.growth.vertices();
        let wanted = script.survivor(live);
        let most = 8;
        let (mut rank, mut v) = (0, self.last_survivor);
        while rank < most && v != wanted {
            v = self.growth.mate[v as usize];
            rank = if v == self.last_survivor { most } else { rank + 1 };
        }
        let rank = coder.symbol(&mut models.mates, rank);
        if rank < most {
            return (0..rank).fold(self.last_survivor, |v, _| self.growth.mate[v as usize]);
        }
        survivor_beside(coder, models, self.last_survivor, live, wanted)
    }
}

/// A survivor among `live` vertices, counted from another one.
fn survivor_beside<C: Coder>(
    coder: &mut C,
    models: &mut Models,
    from: u32,
    live: u32,
    wanted: u32,
) -> u32 {
    let on = if wanted >= from { wanted - from } else { wanted + live - from };
    let on = models.survivor.code(coder, live, on);
    let to_end = live - from;
    if on >= to_end { on - to_end } else { from + on }
}
