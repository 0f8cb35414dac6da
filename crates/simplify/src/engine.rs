//! The collapse loop: rank every group, then always commit the cheapest legal collapse, down to one
//! vertex.

use crate::Options;
use crate::attributes::{Attributes, Gradient};
use crate::fan::{Fan, MAX_FAN};
use crate::heap::Heap;
use crate::legality::{self, Stage};
use crate::log::Log;
use crate::metric::Metric;
use crate::neighborhood::{Neighborhood, SpokeKind};
use crate::plan::Plan;
use crate::pool::Pool;
use crate::wedges::Wedges;
use crate::working::{OPEN, RESTRICTED, SEAM, Working};
use lodc_mesh::{Lod, Mesh};
use rayon::prelude::*;

/// The simplification of one mesh.
pub(crate) struct Engine<'a, M> {
    pub(crate) input: &'a Mesh,
    pub(crate) options: Options,
    pub(crate) mesh: Working,
    pub(crate) wedges: Wedges,
    pub(crate) attributes: Attributes,
    /// The mesh's diagonal in working units.
    pub(crate) size: f64,
    pub(crate) metric: M,
    pub(crate) stage: Stage,
    /// How many groups are flagged as restricted.
    pub(crate) restricted: u32,
    pub(crate) log: Log,
}

/// Buffers of one thread.
#[derive(Default)]
pub(crate) struct Scratch<E> {
    around: Neighborhood,
    gradients: Vec<(u32, Gradient)>,
    /// Candidates of one group: cost and target.
    candidates: Vec<(f64, u32)>,
    fan: Fan,
    view: E,
}

/// Buffers of the serial loop.
#[derive(Default)]
pub(crate) struct Serial<E> {
    scratch: Scratch<E>,
    /// Buffers of other threads.
    pub(crate) pool: Pool<E>,
    legality: legality::Buffers,
    pub(crate) plan: Plan,
    /// Groups whose ranking is out of date.
    pub(crate) stale: Vec<u32>,
    /// Groups that may have become free, or follow the group that others were moved to.
    outer: Vec<u32>,
    marks: Vec<u32>,
    pub(crate) epoch: u32,
}

impl<E> Serial<E> {
    /// Whether this is the first time since the last commit.
    pub(crate) fn first_time(&mut self, group: u32) -> bool {
        std::mem::replace(&mut self.marks[group as usize], self.epoch) != self.epoch
    }
}

/// The best collapse of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// NaN if there is none.
    pub(crate) cost: f32,
    to: u32,
}

/// Spokes that a group may move along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Permitted {
    All,
    /// Seams and borders.
    Features,
    Borders,
}

impl Permitted {
    fn allows(self, kind: SpokeKind) -> bool {
        match self {
            Self::All => true,
            Self::Features => kind != SpokeKind::Smooth,
            Self::Borders => kind == SpokeKind::Border,
        }
    }
}

/// Everything a mesh of `f32` can cost fits `f32` when scaled up; exact zeros stay.
fn as_key(cost: f64) -> f32 {
    (cost * 1e12).min(f64::from(f32::MAX)) as f32
}

impl<M: Metric> Engine<'_, M> {
    /// Runs all stages, then joins the points that are left.
    pub(crate) fn run(&mut self, progress: &(dyn Fn(u64, u64) + Sync)) {
        let groups = self.mesh.places.len();
        let pool = if M::REPRICES { Pool::new() } else { Pool::default() };
        let mut serial = Serial { marks: vec![0; groups], pool, ..Serial::default() };
        for stage in Stage::ALL {
            self.stage = stage;
            if M::REPRICES {
                self.metric.toggle(&self.mesh, stage == Stage::Legal);
            }
            while self.mesh.live_faces > 0 && !self.run_stage(&mut serial, progress) {
                self.metric.toggle(&self.mesh, stage == Stage::Legal);
            }
            if stage == Stage::Legal {
                self.log.last_legal = Lod(self.log.order.len() as u32);
            }
        }
        self.join_points();
    }

    /// What is left when all is done.
    pub(crate) fn into_result(self) -> (Wedges, Log) {
        (self.wedges, self.log)
    }

    /// Collapses while there is something to collapse: true when there is not, false when prices
    /// change their meaning.
    fn run_stage(
        &mut self,
        serial: &mut Serial<M::ViewScratch>,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> bool {
        let groups = self.mesh.places.len() as u32;
        let this = &*self;
        let mut best: Vec<Choice> = (0..groups)
            .into_par_iter()
            .with_min_len(if M::REPRICES { 64 } else { 1024 })
            .map_init(Scratch::<M::ViewScratch>::default, |scratch, g| this.rank(g, scratch))
            .collect();
        let mut heap = Heap::new(best.iter().map(|c| c.cost));
        while let Some((from, key)) = heap.pop() {
            self.warm(&heap, &best);
            let known = best[from as usize];
            let Some((choice, changes_topology)) = self.settle(from, known, serial) else {
                continue;
            };
            best[from as usize] = choice;
            if choice.cost > key && choice.cost > heap.least() {
                heap.set(from, choice.cost);
                continue;
            }
            self.commit(from, choice.to, changes_topology, serial);
            self.refresh(choice.to, &mut best, &mut heap, serial);
            if self.log.step_ends.len().is_multiple_of(if M::REPRICES { 64 } else { 4096 }) {
                progress(self.log.step_ends.len() as u64, u64::from(groups));
            }
            if M::REPRICES && self.metric.should_toggle(&self.mesh) {
                return false;
            }
        }
        true
    }

    /// Reads what the next collapses will need, so that it is on its way from memory while this one
    /// is computed.
    fn warm(&self, heap: &Heap, best: &[Choice]) {
        let mut sum = 0;
        for (i, group) in heap.upcoming().enumerate() {
            let star = self.mesh.star(group);
            sum ^= star.first().map_or(0, |c| c.0);
            if i == 0 {
                for &corner in star {
                    sum ^= self.mesh.faces[corner.face() as usize].triangle;
                }
                let to = best[group as usize].to;
                sum ^= self.mesh.star(to).first().map_or(0, |c| c.0);
            }
        }
        std::hint::black_box(sum);
    }

    /// Ranks again what a commit onto `to` may have changed.
    fn refresh(
        &mut self,
        to: u32,
        best: &mut [Choice],
        heap: &mut Heap,
        serial: &mut Serial<M::ViewScratch>,
    ) {
        if self.metric.is_active() {
            self.look_again(best, heap, serial);
            return;
        }
        let stale = std::mem::take(&mut serial.stale);
        for &g in &stale {
            if !self.is_due(g) {
                continue;
            }
            self.rerank(g, best, heap, &mut serial.scratch);
            if self.restricted == 0 {
                continue;
            }
            self.mesh.each_neighbour(g, |other| {
                if self.mesh.has(other, RESTRICTED) && serial.first_time(other) {
                    serial.outer.push(other);
                }
            });
        }
        // Around the target nothing moved but its own history, and that only grew: only those bound
        // for it care.
        self.mesh.each_neighbour(to, |g| {
            if best[g as usize].to == to && serial.first_time(g) {
                serial.outer.push(g);
            }
        });
        let outer = std::mem::take(&mut serial.outer);
        for &g in &outer {
            self.rerank(g, best, heap, &mut serial.scratch);
        }
        serial.stale = stale;
        serial.outer = outer;
        serial.outer.clear();
    }

    /// Whether a group is to be ranked again although a neighbour moves. Hubs with hundreds of
    /// neighbours are looked at after some of them moved, else a fan would take quadratic time;
    /// legality is always asked anew.
    pub(crate) fn is_due(&self, group: u32) -> bool {
        let faces = self.mesh.star(group).len();
        faces < HUB || faces % (faces / 16).next_power_of_two() < 2
    }

    fn rerank(
        &mut self,
        g: u32,
        best: &mut [Choice],
        heap: &mut Heap,
        scratch: &mut Scratch<M::ViewScratch>,
    ) {
        self.set_restricted(g, false);
        best[g as usize] = self.rank(g, scratch);
        if best[g as usize].cost.is_nan() {
            heap.remove(g);
        } else {
            heap.set(g, best[g as usize].cost);
        }
    }

    /// Notes whether some of a group's collapses were refused, and how many such groups there are.
    pub(crate) fn set_restricted(&mut self, group: u32, restricted: bool) {
        if self.mesh.has(group, RESTRICTED) != restricted {
            self.mesh.flags[group as usize] ^= RESTRICTED;
            self.restricted = if restricted { self.restricted + 1 } else { self.restricted - 1 };
        }
    }

    /// The cheapest collapse of a group, legality and prices left aside: never more than the true
    /// cost.
    pub(crate) fn rank(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) -> Choice {
        let mut best = (f64::INFINITY, u32::MAX);
        if self.is_plain(from) && scratch.fan.gather(&self.mesh, from) {
            // By far the most common case.
            let Scratch { fan, around, .. } = scratch;
            fan.fold_planes(&self.mesh, from, &mut around.planes);
            let local = self.metric.local(from, fan.facets(), &around.planes);
            let costs = &mut fan.costs[..fan.len];
            self.metric.costs(&local, &fan.lanes, costs);
            for (&cost, &to) in costs.iter().zip(&fan.neighbours) {
                if cost < best.0 || cost == best.0 && to < best.1 {
                    best = (cost, to);
                }
            }
        } else {
            self.price_all(from, scratch);
            for &(cost, to) in &scratch.candidates {
                if cost < best.0 || cost == best.0 && to < best.1 {
                    best = (cost, to);
                }
            }
        }
        Choice { cost: if best.1 == u32::MAX { f32::NAN } else { as_key(best.0) }, to: best.1 }
    }

    /// Whether a group has a closed fan of faces, none of them at a border or seam, and no
    /// attributes to mind.
    fn is_plain(&self, group: u32) -> bool {
        self.attributes.is_empty() && !self.mesh.has(group, OPEN | SEAM) && !self.metric.is_active()
    }

    /// Prices every collapse of a group that borders and seams permit.
    fn price_all(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) {
        self.price_geometry(from, scratch);
        if self.metric.is_active() {
            self.metric.reprice(
                &self.mesh,
                &self.wedges,
                from,
                &mut scratch.candidates,
                &mut scratch.view,
            );
        }
    }

    /// What they cost without looking.
    fn price_geometry(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) {
        let Scratch { around, gradients, candidates, fan, .. } = scratch;
        candidates.clear();
        if self.mesh.star(from).is_empty() {
            return;
        }
        let with_attributes = !self.attributes.is_empty() && self.mesh.star(from).len() <= MANY;
        around.look(&self.mesh, &self.wedges, from);
        let Some(permitted) = self.permitted(around) else { return };
        let local = self.metric.local(from, &around.facets, &around.planes);
        if with_attributes {
            self.fit_gradients(from, gradients);
        }
        let attribute_weight = self.metric.attribute_weight();
        let here = self.mesh.position(from);
        for spokes in around.spokes.chunks(MAX_FAN) {
            for (i, spoke) in spokes.iter().enumerate() {
                let delta = self.mesh.position(spoke.group) - here;
                (fan.lanes.x[i], fan.lanes.y[i], fan.lanes.z[i]) = (delta.x, delta.y, delta.z);
                fan.lanes.arrival[i] = f64::from(self.mesh.places[spoke.group as usize].arrival);
            }
            let costs = &mut fan.costs[..spokes.len()];
            self.metric.costs(&local, &fan.lanes, costs);
            for (spoke, mut cost) in
                spokes.iter().zip(costs.iter().copied()).filter(|(s, _)| permitted.allows(s.kind))
            {
                if with_attributes {
                    cost += attribute_weight * self.attribute_cost(from, spoke, around, gradients);
                }
                candidates.push((if cost.is_nan() { f64::INFINITY } else { cost }, spoke.group));
            }
        }
    }

    /// Which spokes a group may move along at the present stage, if any.
    fn permitted(&self, around: &Neighborhood) -> Option<Permitted> {
        if self.stage >= Stage::Seams {
            return Some(Permitted::All);
        }
        match around.borders {
            0 if around.seams < 2 => Some(Permitted::All),
            0 => Some(Permitted::Features),
            _ if self.options.lock_border => None,
            2 => Some(Permitted::Borders),
            _ if self.options.preserve_topology => None,
            _ => Some(Permitted::Features),
        }
    }

    /// The known choice as it is seen now, unless it has become dearer: then others may be better.
    fn look_closer(
        &self,
        from: u32,
        known: Choice,
        scratch: &mut Scratch<M::ViewScratch>,
    ) -> Option<Choice> {
        self.price_geometry(from, scratch);
        let Scratch { candidates, view, .. } = scratch;
        let mut one = [*candidates.iter().find(|c| c.1 == known.to)?];
        self.metric.reprice(&self.mesh, &self.wedges, from, &mut one, view);
        let cost = as_key(one[0].0);
        (cost <= known.cost).then_some(Choice { cost, ..known })
    }

    /// The cheapest legal collapse of a group with its price, and whether it changes the topology.
    fn settle(
        &mut self,
        from: u32,
        known: Choice,
        serial: &mut Serial<M::ViewScratch>,
    ) -> Option<(Choice, bool)> {
        let wedges_matter = self.mesh.has(from, SEAM) || self.attributes.texture.is_some();
        if !wedges_matter {
            match self.judge(from, known.to, &mut serial.legality) {
                Some(verdict) if verdict.price <= 1.0 => {
                    if !self.metric.is_active() {
                        return Some((known, verdict.changes_topology));
                    }
                    if let Some(choice) = self.look_closer(from, known, &mut serial.scratch) {
                        return Some((choice, verdict.changes_topology));
                    }
                }
                _ => {}
            }
        }
        self.price_all(from, &mut serial.scratch);
        serial.scratch.candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(f64, u32, bool)> = None;
        let mut refused = false;
        for &(cost, to) in &serial.scratch.candidates {
            if best.is_some_and(|b| cost >= b.0) {
                break;
            }
            let Some(verdict) = self.judge(from, to, &mut serial.legality) else {
                refused = true;
                continue;
            };
            let mut price = verdict.price;
            if wedges_matter {
                self.plan(from, to, &mut serial.plan);
                if self.stage < Stage::Flips && !self.keeps_texture(from, to, &serial.plan) {
                    refused = true;
                    continue;
                }
                price *= 1.0 + FAKE_PRICE * f64::from(serial.plan.fakes);
            }
            refused |= price > 1.0;
            let cost = cost * price;
            if best.is_none_or(|b| cost < b.0) {
                best = Some((cost, to, verdict.changes_topology));
            }
        }
        if refused {
            self.set_restricted(from, true);
        }
        best.map(|(cost, to, topology)| (Choice { cost: as_key(cost), to }, topology))
    }
}

/// Groups with more faces than this are priced without their attributes.
const MANY: usize = 1024;
/// Groups with this many faces are hubs.
const HUB: usize = 64;
/// How much dearer each fake makes a collapse.
const FAKE_PRICE: f64 = 8.0;
