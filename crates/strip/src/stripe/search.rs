//! Simulated annealing on a cover by paths. Changes are: joining two strips, dividing one, and
//! *tunnelling*, where an end is linked to a triangle inside a strip, which gives up one of its own
//! links (Stewart 2001; the cost also counts swaps).

use crate::adjacency::{code, decode};
use crate::anneal::{below, exp_minus, generator};
use crate::cover::needs_swap;
use lodc_mesh::{NONE, SplitMix64};

/// One pass of the search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Round {
    /// Changes to try, per triangle.
    pub(crate) proposals: f64,
    /// Temperature at the start, in indices.
    pub(crate) start_temperature: f64,
    /// Temperature at the end, in the same unit.
    pub(crate) end_temperature: f64,
    /// Indices that a strip costs beyond its triangles and swaps.
    pub(crate) strip_cost: i32,
}

/// A strip longer than this is not followed to see whether a link would close it to a ring; the
/// link is not made. Half a region: strips of scans are shorter (bunny: up to 604 vertices).
const LONGEST_WALK: usize = 4096;
/// The number of temperatures of a round, which fall linearly. Chosen by hand.
const STAGES: usize = 64;
/// Of this many proposals [`DIVIDING`] divide a strip, [`LINKING_ANYWHERE`] link two triangles
/// anywhere, and all others link an end of a strip to a neighbour.
const ALL_PROPOSALS: u64 = 16;
/// Dividing and linking anywhere make ends, which cost a little and then wander from triangle to
/// triangle until two meet: without them, swaps far from any end could never be removed. Proposals
/// at ends are the ones that pay, so they are most. The shares were chosen on three scans.
const DIVIDING: u64 = 1;
/// See [`DIVIDING`].
const LINKING_ANYWHERE: u64 = 4;

/// Some triangles, numbered by themselves, and a cover of them by paths.
pub(super) struct Region {
    /// For each slot of a triangle the neighbour there, with its slot that leads back, as a code.
    pub(super) neighbours: Vec<[u32; 3]>,
    /// Bit `slot` of a triangle's links says that the neighbour there follows or precedes it in its
    /// path.
    pub(super) links: Vec<u8>,
}

/// Improves the cover of a region.
pub(super) fn search(region: &mut Region, round: &Round, seed: u64) {
    let count = region.links.len();
    let ends: Vec<u32> = (0..count as u32).filter(|&t| region.is_end(t)).collect();
    let mut index_in_ends = vec![NONE; count];
    for (i, &t) in ends.iter().enumerate() {
        index_in_ends[t as usize] = i as u32;
    }
    let mut search = Search {
        region,
        ends,
        index_in_ends,
        random: generator(seed),
        acceptance: [0; 12],
        strip_cost: round.strip_cost,
    };
    let proposals = (count as f64 * round.proposals) as usize;
    for stage in 0..STAGES {
        let share = stage as f64 / (STAGES - 1) as f64;
        search.set_temperature(
            round.start_temperature + (round.end_temperature - round.start_temperature) * share,
        );
        for _ in proposals * stage / STAGES..proposals * (stage + 1) / STAGES {
            search.try_change();
        }
    }
}

impl Region {
    fn links(&self, t: u32) -> u32 {
        u32::from(self.links[t as usize])
    }
    fn is_end(&self, t: u32) -> bool {
        self.links(t).count_ones() < 2
    }
    fn neighbour(&self, t: u32, slot: u32) -> u32 {
        self.neighbours[t as usize][slot as usize]
    }
    /// Links or unlinks a triangle and the neighbour at one of its slots.
    fn toggle(&mut self, t: u32, slot: u32) {
        let (u, f) = decode(self.neighbour(t, slot));
        self.links[t as usize] ^= 1 << slot;
        self.links[u as usize] ^= 1 << f;
    }
    /// The linked slot of a triangle that is not the given one.
    fn other(&self, t: u32, slot: u32) -> Option<u32> {
        let others = self.links(t) & !(1 << slot);
        (others != 0).then(|| others.trailing_zeros())
    }
    /// Swaps at all links of some triangles, each link once.
    fn swaps(&self, affected: &[u32]) -> i32 {
        let mut swaps = 0;
        for (i, &t) in affected.iter().enumerate() {
            let all = self.links(t);
            let mut links = all;
            // An end turns nowhere: its link needs no swap.
            if links.count_ones() < 2 {
                continue;
            }
            while links != 0 {
                let slot = links.trailing_zeros();
                links &= links - 1;
                let (u, f) = decode(self.neighbour(t, slot));
                // Those between two of the triangles are counted from the first.
                if needs_swap(all, slot, self.links(u), f) && !affected[..i].contains(&u) {
                    swaps += 1;
                }
            }
        }
        swaps
    }
}

struct Search<'a> {
    region: &'a mut Region,
    /// Triangles with fewer than two links, in any order.
    ends: Vec<u32>,
    /// For each triangle its index in `ends`; `NONE` if it is no end.
    index_in_ends: Vec<u32>,
    random: SplitMix64,
    /// The probability that a change for the worse is accepted, by indices, in units of 2⁻³². One
    /// that costs 12 indices or more never is.
    acceptance: [u64; 12],
    /// See [`Round::strip_cost`].
    strip_cost: i32,
}

impl Search<'_> {
    fn set_temperature(&mut self, t: f64) {
        for (i, probability) in self.acceptance.iter_mut().enumerate() {
            *probability = (exp_minus(i as f64 / t) * 4_294_967_296.0) as u64;
        }
    }
    /// The most indices that a change may cost to be accepted, by random bits: the rule of
    /// Metropolis, with the random number drawn before the cost is known.
    fn allowed_cost(&self, bits: u64) -> i32 {
        let bits = bits & 0xffff_ffff;
        // The usual case, without a search of the list.
        if bits >= self.acceptance[1] {
            return 0;
        }
        self.acceptance[1..].iter().take_while(|&&probability| bits < probability).count() as i32
    }
    /// Proposes a random change, and makes it if it is accepted.
    fn try_change(&mut self) {
        let bits = self.random.bits();
        let choices = self.random.bits();
        let kind = (choices >> 40) % ALL_PROPOSALS;
        let count = self.region.links.len();
        if kind < DIVIDING {
            let t = below(bits, count) as u32;
            self.divide(t, choices >> 8, bits);
            return;
        }
        let from = if kind < DIVIDING + LINKING_ANYWHERE {
            below(bits, count) as u32
        } else if self.ends.is_empty() {
            return;
        } else {
            self.ends[below(bits, self.ends.len())]
        };
        // One of the edges that are not linked; which of two, by a bit.
        let mut open = !self.region.links(from) & 7;
        match open.count_ones() {
            3 => open = 1 << ((choices >> 8) % 3),
            2 if choices & 16 != 0 => open &= open - 1,
            _ => {}
        }
        let slot = open.trailing_zeros();
        let c = self.region.neighbour(from, slot);
        if c != NONE {
            self.link(from, slot, choices, bits);
        }
    }
    /// Tries to take the link away at one of a triangle's slots.
    fn divide(&mut self, t: u32, choice: u64, bits: u64) {
        let slot = (choice % 3) as u32;
        if self.region.links(t) & 1 << slot == 0 {
            return;
        }
        let affected = [t, decode(self.region.neighbour(t, slot)).0];
        let max_swaps = self.allowed_cost(bits) + self.region.swaps(&affected) - self.strip_cost;
        if max_swaps < 0 {
            return;
        }
        self.region.toggle(t, slot);
        if self.region.swaps(&affected) <= max_swaps {
            affected.into_iter().for_each(|t| self.update(t));
        } else {
            self.region.toggle(t, slot);
        }
    }
    /// The slot that a triangle gives up when it gets another link, and the triangle there.
    fn link_to_give_up(&self, t: u32, second: bool) -> Option<(u32, u32)> {
        let links = self.region.links(t);
        (links.count_ones() == 2).then(|| {
            let first = links.trailing_zeros();
            let slot = if second { (links & (links - 1)).trailing_zeros() } else { first };
            (slot, decode(self.region.neighbour(t, slot)).0)
        })
    }
    /// Tries to link a triangle to a neighbour. Each of them gives up one of its links if it has
    /// two.
    fn link(&mut self, from: u32, slot: u32, choice: u64, bits: u64) {
        let (to, _) = decode(self.region.neighbour(from, slot));
        let given_by_from = self.link_to_give_up(from, choice & 64 != 0);
        let given_by_to = self.link_to_give_up(to, choice & 32 != 0);
        let strips_cost = self.strip_cost
            * (i32::from(given_by_from.is_some()) + i32::from(given_by_to.is_some()) - 1);
        let mut affected = [from, to, 0, 0];
        let mut n = 2;
        for (_, other) in given_by_from.into_iter().chain(given_by_to) {
            if other == from || other == to {
                // Linked to each other already, by another edge.
                return;
            }
            if !(n == 3 && affected[2] == other) {
                affected[n] = other;
                n += 1;
            }
        }
        let affected = &affected[..n];
        // The most swaps that the change may leave. Often that is below zero: then it need not be
        // made and counted only to be undone.
        let max_swaps = self.allowed_cost(bits) + self.region.swaps(affected) - strips_cost;
        if max_swaps < 0 {
            return;
        }
        let change = |region: &mut Region| {
            given_by_from.into_iter().for_each(|(slot, _)| region.toggle(from, slot));
            given_by_to.into_iter().for_each(|(slot, _)| region.toggle(to, slot));
            region.toggle(from, slot);
        };
        change(self.region);
        if self.region.swaps(affected) <= max_swaps && !self.closes_ring(from, slot) {
            affected.iter().for_each(|&t| self.update(t));
        } else {
            change(self.region);
        }
    }
    /// Returns whether the new link at a slot of `from` closes a ring: whether the way from there,
    /// away from the link, comes back.
    fn closes_ring(&self, from: u32, slot: u32) -> bool {
        let closing = code(from, slot);
        let (mut current, mut exit) = (from, self.region.other(from, slot));
        for _ in 0..LONGEST_WALK {
            let Some(slot) = exit else { return false };
            let (next, entered) = decode(self.region.neighbour(current, slot));
            exit = self.region.other(next, entered);
            current = next;
            if exit.is_some_and(|slot| self.region.neighbour(current, slot) == closing) {
                return true;
            }
        }
        true
    }
    /// Keeps the list of ends in step with a triangle's links.
    fn update(&mut self, t: u32) {
        let listed = self.index_in_ends[t as usize];
        if self.region.is_end(t) {
            if listed == NONE {
                self.index_in_ends[t as usize] = self.ends.len() as u32;
                self.ends.push(t);
            }
        } else if listed != NONE {
            self.index_in_ends[t as usize] = NONE;
            self.ends.swap_remove(listed as usize);
            if let Some(&moved) = self.ends.get(listed as usize) {
                self.index_in_ends[moved as usize] = listed;
            }
        }
    }
}
