//! Local search on a cover by paths, with simulated annealing: joining two strips, dividing one,
//! and *tunnelling* — an end is linked to a neighbour inside a strip, which lets go of one of its
//! own links there (Stewart 2001, made aware of what swaps cost).

use crate::adjacency::{code, decode};
use crate::anneal::{below, exp_minus, generator};
use crate::cover::{Cover, is_none};
use lodc_mesh::{NONE, SplitMix64};

/// One pass of the search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Round {
    /// Changes to try, per triangle.
    pub(crate) proposals: f64,
    /// Temperature at the start, in indices.
    pub(crate) warm: f64,
    /// Temperature at the end.
    pub(crate) cold: f64,
    /// Indices that a strip costs beyond its triangles and swaps.
    pub(crate) strip: i32,
}

/// A strip longer than this is not followed to see whether it would close: that change is not made.
const LONGEST_WALK: usize = 4096;

/// The number of temperatures of a round.
const STAGES: usize = 64;

/// Of so many changes…
const CHANGES: u64 = 16;
/// … this many divide a strip …
const DIVIDE: u64 = 1;
/// … and this many link two triangles anywhere, the others an end. What the two make is ends, which
/// cost a little and then wander until they meet others: without that, swaps far from any end would
/// stay for ever.
const ANYWHERE: u64 = 6;

/// Improves a cover.
pub(crate) fn search(cover: &mut Cover, round: &Round, seed: u64) {
    let ends = (0..cover.nodes.len() as u32).filter(|&t| cover.is_end(t)).collect::<Vec<_>>();
    let mut place = vec![NONE; cover.nodes.len()];
    for (i, &t) in ends.iter().enumerate() {
        place[t as usize] = i as u32;
    }
    let mut search =
        Search { cover, ends, place, random: generator(seed), likely: [0; 12], strip: round.strip };
    let proposals = (search.cover.nodes.len() as f64 * round.proposals) as usize;
    for stage in 0..STAGES {
        let share = stage as f64 / (STAGES - 1) as f64;
        search.set_temperature(round.warm + (round.cold - round.warm) * share);
        for _ in proposals * stage / STAGES..proposals * (stage + 1) / STAGES {
            search.step();
        }
    }
}

struct Search<'a> {
    cover: &'a mut Cover,
    /// Triangles with fewer than two links, in any order, and where each stands.
    ends: Vec<u32>,
    place: Vec<u32>,
    random: SplitMix64,
    /// The probability that a change for the worse is accepted, by indices, in units of 2⁻³².
    likely: [u64; 12],
    strip: i32,
}

impl Search<'_> {
    fn set_temperature(&mut self, t: f64) {
        for (i, l) in self.likely.iter_mut().enumerate() {
            *l = (exp_minus(i as f64 / t) * 4_294_967_296.0) as u64;
        }
    }
    fn accepts(&self, delta: i32, bits: u64) -> bool {
        delta <= 0 || self.likely.get(delta as usize).is_some_and(|&l| bits & 0xffff_ffff < l)
    }
    fn step(&mut self) {
        let bits = self.random.bits();
        let more = self.random.bits();
        let kind = (more >> 40) % CHANGES;
        if kind < DIVIDE {
            let t = below(bits, self.cover.nodes.len()) as u32;
            self.divide(t, more >> 8, bits);
            return;
        }
        let x = if kind < DIVIDE + ANYWHERE {
            below(bits, self.cover.nodes.len()) as u32
        } else if self.ends.is_empty() {
            return;
        } else {
            self.ends[below(bits, self.ends.len())]
        };
        // One of the edges that are not linked; which of two, by a bit.
        let mut open = !self.cover.links(x) & 7;
        match open.count_ones() {
            3 => open = 1 << ((more >> 8) % 3),
            2 if more & 16 != 0 => open &= open - 1,
            _ => {}
        }
        let slot = open.trailing_zeros();
        let c = self.cover.neighbour(x, slot);
        if !is_none(c) {
            self.link(x, slot, more, bits);
        }
    }
    /// Tries to take the link away at one of a triangle's slots.
    fn divide(&mut self, t: u32, choice: u64, bits: u64) {
        let slot = (choice % 3) as u32;
        if self.cover.links(t) & 1 << slot == 0 {
            return;
        }
        let (u, _) = decode(self.cover.neighbour(t, slot));
        let around = [t, u];
        let before = self.swaps_around(&around);
        self.cover.toggle(t, slot);
        let after = self.swaps_around(&around);
        if self.accepts(self.strip + after - before, bits) {
            for t in around {
                self.update(t);
            }
        } else {
            self.cover.toggle(t, slot);
        }
    }
    /// The slot that a triangle gives up when it gets another link, and the triangle there.
    fn given(&self, t: u32, second: bool) -> Option<(u32, u32)> {
        let links = self.cover.links(t);
        (links.count_ones() == 2).then(|| {
            let slot = if second {
                (links & (links - 1)).trailing_zeros()
            } else {
                links.trailing_zeros()
            };
            (slot, decode(self.cover.neighbour(t, slot)).0)
        })
    }
    /// Tries to link a triangle to a neighbour. Each of them gives up one of its links if it has
    /// two.
    fn link(&mut self, x: u32, slot: u32, choice: u64, bits: u64) {
        let (y, _) = decode(self.cover.neighbour(x, slot));
        let from_x = self.given(x, choice & 64 != 0);
        let from_y = self.given(y, choice & 32 != 0);
        let delta = self.strip * (i32::from(from_x.is_some()) + i32::from(from_y.is_some()) - 1);
        let mut around = [x, y, 0, 0];
        let mut n = 2;
        for (_, z) in from_x.into_iter().chain(from_y) {
            if z == x || z == y {
                // Linked to each other already, by another edge.
                return;
            }
            if !(n == 3 && around[2] == z) {
                around[n] = z;
                n += 1;
            }
        }
        let around = &around[..n];
        let before = self.swaps_around(around);
        let change = |search: &mut Self| {
            from_x.into_iter().for_each(|(g, _)| search.cover.toggle(x, g));
            from_y.into_iter().for_each(|(g, _)| search.cover.toggle(y, g));
            search.cover.toggle(x, slot);
        };
        change(self);
        let after = self.swaps_around(around);
        if self.accepts(delta + after - before, bits) && !self.closes(x, slot) {
            for &t in around {
                self.update(t);
            }
        } else {
            change(self);
        }
    }
    /// Swaps at all links of some triangles, each link once.
    fn swaps_around(&self, around: &[u32]) -> i32 {
        let mut swaps = 0;
        for (i, &t) in around.iter().enumerate() {
            let mut links = self.cover.links(t);
            while links != 0 {
                let slot = links.trailing_zeros();
                links &= links - 1;
                let (u, _) = decode(self.cover.neighbour(t, slot));
                // Counted already from the other side.
                swaps += i32::from(self.cover.swaps(t, slot) && !around[..i].contains(&u));
            }
        }
        swaps
    }
    /// Returns whether the new link at a slot of x closes a ring: whether the way from x, away from
    /// the link, comes back.
    fn closes(&self, x: u32, slot: u32) -> bool {
        let back = code(x, slot);
        let (mut at, mut leave) = (x, self.cover.other(x, slot));
        for _ in 0..LONGEST_WALK {
            let Some(l) = leave else { return false };
            let (next, entered) = decode(self.cover.neighbour(at, l));
            leave = self.cover.other(next, entered);
            at = next;
            if leave.is_some_and(|l| self.cover.neighbour(at, l) == back) {
                return true;
            }
        }
        true
    }
    /// Keeps the list of ends in step with a triangle's links.
    fn update(&mut self, t: u32) {
        let listed = self.place[t as usize];
        if self.cover.is_end(t) {
            if listed == NONE {
                self.place[t as usize] = self.ends.len() as u32;
                self.ends.push(t);
            }
        } else if listed != NONE {
            self.place[t as usize] = NONE;
            self.ends.swap_remove(listed as usize);
            if let Some(&moved) = self.ends.get(listed as usize) {
                self.place[moved as usize] = listed;
            }
        }
    }
}
