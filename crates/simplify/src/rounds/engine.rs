//! The collapse loop of one region: always commit the cheapest legal collapse, and rank again what
//! it has changed. To *rank* a group is to find its cheapest collapse, legality left aside. A group
//! is *restricted* while some of its collapses are refused by the rules, and *stale* while what it
//! was ranked by has changed: it is ranked again before it collapses.

use crate::choose::{Heap, LegalCollapse, Rules, SelectionBuffers, Selector, Stage};
use crate::commit::{CollapseLog, Commit, Touched, join_points};
use crate::cut::{Choice, DEAD, HIGH_VALENCE, LOCKED, RESTRICTED, Region, STALE};
use crate::metric::Reevaluate;
use crate::price::{Context, Pricer, Scratch};
use crate::recorded::RecordedCollapse;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// The queue is filled again at the end of a stage if at least one group for this many faces has
/// collapsed since it was filled last: some collapses that were refused may be legal now. Filling
/// it ranks all groups, which is not worth it for fewer. Chosen by hand.
const REFILL_PART: usize = 64;

/// If a group with more faces than this changes, the restricted groups next to it are not searched
/// again until the queue is filled anew. Chosen by hand.
const MAX_WALKED_FACES: usize = 32;
/// The most restricted groups, about, that are searched again after one collapse; the others wait
/// like those. Where everything is tangled (loose random triangles) they would be searched again
/// and again. Chosen by hand.
const MAX_SEARCHED_AGAIN: usize = 16;
/// The most collapses after which a metric prices their neighbours anew, all together. One collapse
/// has about seven: waking threads for seven groups takes as long as pricing them (two threads took
/// as long as one). With 32 collapses the bunny takes 7.3 s instead of 13.5.
const MAX_WAITING_COLLAPSES: usize = 32;
/// At most one collapse for this many faces waits: 32 would be a good part of a small mesh, and the
/// order would no longer be that of costs. Chosen by hand.
const FACES_PER_WAITING_COLLAPSE: usize = 512;
/// Collapses between two reports of progress, by [`Reevaluate::REPRICES`]: a metric that prices
/// anew takes longer.
const REPORT_INTERVALS: [usize; 2] = [4096, 64];
/// Groups that a thread ranks at a time, by [`Reevaluate::REPRICES`]. Chosen by hand.
const RANKED_TOGETHER: [usize; 2] = [4096, 64];

/// Reports of progress from all threads.
pub(crate) struct Progress<'a> {
    /// Gets the number of collapses so far, and that of groups.
    report: &'a (dyn Fn(u64, u64) + Sync),
    /// Collapses of the rounds that are over.
    done: AtomicU64,
    /// Groups of the whole mesh.
    groups: u64,
}

impl<'a> Progress<'a> {
    pub(crate) fn new(report: &'a (dyn Fn(u64, u64) + Sync), groups: u64) -> Self {
        Self { report, done: AtomicU64::new(0), groups }
    }

    /// Reports collapses since the end of the last round.
    fn report(&self, steps: u64) {
        (self.report)((self.done.load(Ordering::Relaxed) + steps).min(self.groups), self.groups);
    }

    /// Ends a round, given the number of its collapses.
    pub(super) fn end_round(&self, collapses: u64) {
        self.done.fetch_add(collapses, Ordering::Relaxed);
        self.report(0);
    }
}

/// One set of buffers for each thread.
struct ScratchPool<T>(Vec<Mutex<T>>);

impl<T> Default for ScratchPool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Default> ScratchPool<T> {
    /// One for each thread of the present pool, or none if they are not needed.
    fn new(needed: bool) -> Self {
        let threads = if needed { rayon::current_num_threads() } else { 0 };
        Self((0..threads).map(|_| Mutex::default()).collect())
    }

    /// Calls `work` with a set of buffers that is free.
    fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        match self.0.iter().find_map(|slot| slot.try_lock().ok()) {
            Some(mut scratch) => work(&mut scratch),
            // The pool of threads may have grown since: slower, but as right.
            None => work(&mut T::default()),
        }
    }
}

/// The simplification of one region.
pub(super) struct Engine<'a, M: Reevaluate> {
    context: &'a Context<'a>,
    region: &'a mut Region,
    metric: &'a mut M,
    rules: Rules,
    log: CollapseLog,
    state: LoopState<M::ViewScratch>,
}

/// Buffers of the loop.
#[derive(Default)]
struct LoopState<S> {
    selection: SelectionBuffers<S>,
    /// Buffers of the threads that rank groups together.
    pool: ScratchPool<Scratch<S>>,
    touched: Touched,
    /// Groups to be ranked again. Between two collapses it holds those that wait for more to be
    /// ranked together with, if the metric prices anew; else none.
    due: Vec<u32>,
    /// Collapses that made these due.
    waiting_collapses: usize,
    /// Number of groups that this engine has flagged as restricted.
    restricted: u32,
}

/// The groups that a queue takes.
#[derive(Clone, Copy, Debug)]
enum Queue {
    /// Those that cost at most this and are not locked. What is refused waits for the next round.
    UpTo(f32),
    /// All. What is refused is checked again when something near it changes.
    All,
}

impl<'a, M: Reevaluate> Engine<'a, M> {
    pub(super) fn new(context: &'a Context<'a>, region: &'a mut Region, metric: &'a mut M) -> Self {
        let preserve_topology = context.options.preserve_topology;
        // A price is kept until the group's own faces change; one that was repriced may change
        // earlier.
        let lists = if M::REPRICES { 0 } else { region.groups.len() };
        let state = LoopState {
            selection: SelectionBuffers::new(lists),
            touched: Touched::new(region.groups.len()),
            pool: ScratchPool::new(M::REPRICES),
            ..LoopState::default()
        };
        let rules = Rules { stage: Stage::Legal, preserve_topology, may_unite_groups: true };
        Self { context, region, metric, rules, log: CollapseLog::default(), state }
    }

    /// Runs all stages, then joins the points that are left. Returns the log and how many of its
    /// steps are legal.
    pub(super) fn run_all(mut self, progress: &Progress<'_>) -> (CollapseLog, usize) {
        let Region { mesh, wedges, groups, .. } = &*self.region;
        let wedges = wedges.ids.len().max(groups.len());
        self.log = CollapseLog::with_room(groups.len(), wedges, mesh.live_faces as usize);
        let mut legal = 0;
        for stage in Stage::ALL {
            self.rules.stage = stage;
            if M::REPRICES {
                self.metric.update_activity(&self.region.mesh, stage == Stage::Legal);
                if stage == Stage::Legal {
                    // The metric may have to start or stop reevaluating where these end.
                    self.collapse_as_given();
                    self.metric.update_activity(&self.region.mesh, true);
                }
            }
            while self.region.mesh.live_faces > 0 {
                let (before, faces) = (self.log.steps.len(), self.region.mesh.live_faces as usize);
                self.rank_all();
                if !self.run_queue(Queue::All, progress) {
                    self.metric.update_activity(&self.region.mesh, stage == Stage::Legal);
                } else if (self.log.steps.len() - before) * REFILL_PART <= faces {
                    // What is still refused stays so: hardly anything has changed.
                    break;
                }
            }
            if stage == Stage::Legal {
                legal = self.log.steps.len();
            }
        }
        join_points(self.region, &mut self.log);
        (self.log, legal)
    }

    /// Repeats the collapses that an earlier run began with; they were legal then, so they are now.
    fn collapse_as_given(&mut self) {
        while let Some(given) = self.metric.given(&self.region.mesh, self.log.steps.len()) {
            let choice = Choice { cost: 0.0, to: given.to };
            let changes_topology = given.changes_topology;
            self.commit(given.from, LegalCollapse { choice, changes_topology, is_planned: false });
        }
    }

    /// Collapses what costs at most `limit`, as far as it is this region's alone.
    pub(super) fn run_round(mut self, limit: f32, progress: &Progress<'_>) -> CollapseLog {
        self.rules.may_unite_groups = false;
        for group in 0..self.region.own_groups() as u32 {
            let choice = self.region.choices[group as usize];
            let restricted = self.region.mesh.has(group, RESTRICTED);
            if (choice.cost.is_nan() || restricted) && !self.region.mesh.star(group).is_empty() {
                self.rerank(group);
            }
        }
        self.run_queue(Queue::UpTo(limit), progress);
        self.log
    }

    /// The parts that pricing and selecting read, and the buffers that they write.
    fn parts(&mut self) -> (Selector<'_, M>, &mut LoopState<M::ViewScratch>) {
        let Self { context, region, metric, rules, state, .. } = self;
        let pricer = Pricer {
            context,
            region,
            metric: &**metric,
            features_may_go: rules.stage >= Stage::Seams,
        };
        (Selector { pricer, rules: *rules }, state)
    }

    /// Ranks every group.
    pub(super) fn rank_all(&mut self) {
        let own = self.region.own_groups() as u32;
        let (Selector { pricer, .. }, _) = self.parts();
        let rank = |scratch: &mut Scratch<M::ViewScratch>, g: u32| pricer.rank(g, scratch);
        let choices = (0..own)
            .into_par_iter()
            .with_min_len(RANKED_TOGETHER[usize::from(M::REPRICES)])
            .map_init(Scratch::default, rank)
            .collect();
        self.region.choices = choices;
        self.state.selection.lists.clear();
        for flags in &mut self.region.mesh.flags {
            *flags &= !(STALE | RESTRICTED);
        }
        self.state.restricted = 0;
    }

    /// Collapses groups, the cheapest first, until none is left in the queue (returns true), or
    /// until the metric starts or ends reevaluating, so that all prices change (returns false).
    fn run_queue(&mut self, queue: Queue, progress: &Progress<'_>) -> bool {
        let mesh = &self.region.mesh;
        let limit = match queue {
            Queue::UpTo(limit) => limit,
            Queue::All => f32::INFINITY,
        };
        let choices = (0..).zip(&self.region.choices);
        let takes = |(g, c): (u32, &Choice)| c.cost <= limit && !mesh.has(g, LOCKED);
        let cost = |choice: (u32, &Choice)| if takes(choice) { choice.1.cost } else { f32::NAN };
        let mut heap = Heap::new(choices.map(cost).collect::<Vec<f32>>().into_iter());
        loop {
            let Some((from, key)) = heap.pop() else {
                if self.state.waiting_collapses == 0 {
                    return true;
                }
                self.rerank_waiting(&mut heap);
                continue;
            };
            self.region.mesh.prefetch_neighbours(from);
            if self.region.mesh.has(from, STALE) {
                if self.state.waiting_collapses > 0 {
                    self.rerank_waiting(&mut heap);
                    continue;
                }
                self.rerank(from);
                let cost = self.region.choices[from as usize].cost;
                if cost.is_nan() || cost > limit {
                    continue;
                }
                // Another group may be cheaper now that this one's cost has risen.
                if cost > key && cost > heap.least() {
                    heap.set(from, cost);
                    continue;
                }
            }
            let Some(legal) = self.select_legal_collapse(from) else {
                // It stays out until something near it changes or the queue is filled anew.
                self.region.choices[from as usize] = Choice::NONE;
                continue;
            };
            self.region.choices[from as usize] = legal.choice;
            if legal.choice.cost > limit {
                continue;
            }
            // The same if only a dearer collapse is legal.
            if legal.choice.cost > key && legal.choice.cost > heap.least() {
                heap.set(from, legal.choice.cost);
                continue;
            }
            self.commit(from, legal);
            self.refresh(legal.choice.to, queue, limit, &mut heap);
            let report_interval = REPORT_INTERVALS[usize::from(M::REPRICES)];
            if self.log.steps.len().is_multiple_of(report_interval) {
                progress.report(self.log.steps.len() as u64);
            }
            if M::REPRICES && self.metric.activity_changes(&self.region.mesh) {
                self.rerank_waiting(&mut heap);
                return false;
            }
        }
    }

    /// The cheapest legal collapse of a group; none if all are refused.
    fn select_legal_collapse(&mut self, from: u32) -> Option<LegalCollapse> {
        let known = self.region.choices[from as usize];
        let (selector, state) = self.parts();
        let selected = selector.select(from, known, &mut state.selection);
        if self.state.selection.refused {
            self.set_restricted(from, true);
        }
        selected
    }

    /// Commits a collapse, planned before or now.
    fn commit(&mut self, from: u32, legal: LegalCollapse) {
        if !legal.is_planned {
            let (selector, state) = self.parts();
            let plan = &mut state.selection.plan;
            plan.clear();
            if !selector.pricer.region.wedges.is_bare() {
                selector.planner().plan(from, legal.choice.to, plan);
            }
        }
        if M::REPRICES && self.rules.stage == Stage::Legal {
            let LegalCollapse { choice, changes_topology, .. } = legal;
            self.log.recorded.0.push(RecordedCollapse { from, to: choice.to, changes_topology });
        }
        self.set_restricted(from, false);
        self.state.selection.lists.release(from);
        let Self { context, region, metric, log, state, .. } = self;
        let LoopState { selection, touched, .. } = state;
        Commit { input: context.input, region, metric: &mut **metric, log, touched }.run(
            from,
            legal,
            &mut selection.plan,
        );
    }

    /// Ranks again what a commit onto `to` may have changed.
    fn refresh(&mut self, to: u32, queue: Queue, limit: f32, heap: &mut Heap) {
        // Those that wait from earlier collapses, then (up to `changed`) those whose faces this one
        // changed, then restricted ones beside these.
        let mut due = std::mem::take(&mut self.state.due);
        let before = due.len();
        due.extend(self.state.touched.groups.iter().copied().filter(|&g| self.is_due(g)));
        let changed = due.len();
        if matches!(queue, Queue::All) && self.state.restricted > 0 {
            self.add_restricted(&mut due, before);
        }
        if self.metric.is_active() {
            self.state.due = due;
            self.defer_ranking(before, heap);
            return;
        }
        debug_assert_eq!(before, 0, "groups wait only while the metric prices anew");
        for &g in &due[..changed] {
            self.rerank(g);
            self.requeue(g, limit, heap);
        }
        due[changed..].iter().for_each(|&g| self.region.prefetch(g));
        for &g in &due[changed..] {
            if !self.is_still_best(g) {
                self.search_again(g);
                self.requeue(g, limit, heap);
            }
        }
        due.clear();
        self.state.due = due;
        self.note_risen_costs(to);
        if let Some(first) = heap.first() {
            self.region.prefetch(first);
        }
    }

    /// Flags the groups that the last collapse made due (those from `before` on) as stale, and
    /// ranks all due groups once enough collapses wait.
    fn defer_ranking(&mut self, before: usize, heap: &mut Heap) {
        let Self { region, state, .. } = self;
        let mut end = before;
        for i in before..state.due.len() {
            let g = state.due[i];
            if !region.mesh.has(g, STALE) {
                region.mesh.add_flags(g, STALE);
                state.due[end] = g;
                end += 1;
            }
        }
        state.due.truncate(end);
        state.waiting_collapses += 1;
        let limit = region.mesh.live_faces as usize / FACES_PER_WAITING_COLLAPSE;
        if state.waiting_collapses >= limit.clamp(1, MAX_WAITING_COLLAPSES) {
            self.rerank_waiting(heap);
        }
    }

    /// Adds the restricted groups next to those that are due.
    fn add_restricted(&mut self, due: &mut Vec<u32>, before: usize) {
        let Self { region, state, .. } = self;
        let touched = due.len();
        for i in before..touched {
            if region.mesh.valence(due[i]) > MAX_WALKED_FACES {
                continue;
            }
            if due.len() - touched > MAX_SEARCHED_AGAIN {
                break;
            }
            region.mesh.each_neighbour(due[i], |other| {
                if region.mesh.has(other, RESTRICTED) && state.touched.mark(other) {
                    due.push(other);
                }
            });
        }
    }

    /// Flags the groups whose choice is to move onto `to` as stale. Of what they were ranked by,
    /// only the accumulated cost of `to` has changed, and it has grown: their costs are lower
    /// bounds now.
    fn note_risen_costs(&mut self, to: u32) {
        if !self.is_due(to) {
            return;
        }
        let Region { mesh, choices, .. } = &mut *self.region;
        let LoopState { touched, due, .. } = &mut self.state;
        // Marked groups have just had their turn. Groups of other regions have no choice.
        let is_bound =
            |g: u32| choices.get(g as usize).is_some_and(|c| c.to == to) && !touched.is_marked(g);
        mesh.each_neighbour(to, |g| due.extend(is_bound(g).then_some(g)));
        for g in due.drain(..) {
            mesh.add_flags(g, STALE);
        }
    }

    /// Ranks all due groups at once. Others elsewhere, which the collapses may have hidden or
    /// uncovered, are priced anew when they come to the head of the queue ([`Selector::select`]).
    fn rerank_waiting(&mut self, heap: &mut Heap) {
        let mut due = std::mem::take(&mut self.state.due);
        due.retain(|&g| !self.region.mesh.has(g, DEAD));
        for &g in &due {
            self.set_restricted(g, false);
        }
        let (Selector { pricer, .. }, state) = self.parts();
        let pool = &state.pool;
        let rank = |&g: &u32| pool.with(|scratch| pricer.rank(g, scratch));
        let choices: Vec<Choice> = due.par_iter().with_max_len(4).map(rank).collect();
        for (&g, choice) in due.iter().zip(choices) {
            self.region.choices[g as usize] = choice;
            self.region.mesh.clear_flags(g, STALE);
            self.requeue(g, f32::INFINITY, heap);
        }
        due.clear();
        (self.state.due, self.state.waiting_collapses) = (due, 0);
    }

    /// Puts a group where it belongs in the queue.
    #[inline]
    fn requeue(&mut self, g: u32, limit: f32, heap: &mut Heap) {
        let cost = self.region.choices[g as usize].cost;
        if cost <= limit && !self.region.mesh.has(g, LOCKED) {
            heap.set(g, cost);
        } else {
            heap.remove(g);
        }
    }

    /// Returns whether a group is to be ranked again after a neighbour moved. High-valence groups
    /// (groups of very many faces) are ranked again only when their number of faces has just passed
    /// a multiple of about a sixteenth of it, else a fan would take quadratic time; legality is
    /// always checked anew.
    fn is_due(&self, group: u32) -> bool {
        let faces = self.region.mesh.valence(group);
        faces < HIGH_VALENCE || faces % (faces / 16).next_power_of_two() < 2
    }

    /// Ranks one group again.
    fn rerank(&mut self, g: u32) {
        self.set_restricted(g, false);
        self.region.mesh.clear_flags(g, STALE);
        let (Selector { pricer, .. }, state) = self.parts();
        let SelectionBuffers { scratch, lists, .. } = &mut state.selection;
        let choice = if let Some(choice) = pricer.rank_plain(g) {
            lists.forget(g);
            choice
        } else {
            let choice = pricer.rank_any(g, scratch);
            lists.keep(g, &scratch.priced);
            choice
        };
        self.region.choices[g as usize] = choice;
    }

    /// Returns whether the choice of a restricted group, whose own faces are unchanged, is still
    /// the cheapest after the last commit.
    fn is_still_best(&mut self, g: u32) -> bool {
        let (selector, LoopState { selection, touched, .. }) = self.parts();
        selector.is_still_best(g, |group| touched.is_touched(group), selection)
    }

    /// Looks for the cheapest legal collapse of a restricted group, whose own faces are unchanged.
    fn search_again(&mut self, g: u32) {
        let (selector, state) = self.parts();
        let found = selector.search(g, &mut state.selection);
        let restricted = state.selection.refused;
        self.set_restricted(g, restricted);
        self.region.mesh.clear_flags(g, STALE);
        self.region.choices[g as usize] = found.map_or(Choice::NONE, |legal| legal.choice);
    }

    /// Notes whether some of a group's collapses were refused, and how many such groups there are.
    fn set_restricted(&mut self, group: u32, restricted: bool) {
        if self.region.mesh.has(group, RESTRICTED) != restricted {
            self.region.mesh.flags[group as usize] ^= RESTRICTED;
            let count = &mut self.state.restricted;
            // A flag of an earlier round was not counted.
            *count = if restricted { *count + 1 } else { count.saturating_sub(1) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::QuadricOnly;
    use crate::number::Input;
    use crate::options::Options;
    use crate::price::{Attributes, PriceLists};

    #[test]
    fn prices_that_are_kept_change_nothing() {
        let random = (0..20).map(lodc_fixtures::random);
        let shapes = [lodc_fixtures::machine_part(), lodc_fixtures::uv_sphere(24, 16)];
        for mesh in random.chain(shapes) {
            let input = Input::new(&mesh);
            let attributes = Attributes::new(
                &mesh,
                &crate::SeenShapes::default(),
                |_| crate::Weights::DEFAULT,
                input.scale,
                input.size,
            );
            let context = Context { input: &input, options: Options::DEFAULT, attributes };
            let steps = |kept: bool| {
                let mut region = Region::whole(&input, context.is_bare());
                let mut metric = QuadricOnly;
                let mut engine = Engine::new(&context, &mut region, &mut metric);
                if !kept {
                    engine.state.selection.lists = PriceLists::default();
                }
                let (log, legal) = engine.run_all(&Progress::new(&|_, _| {}, 1));
                (log.wedges, log.targets, legal)
            };
            assert_eq!(steps(true), steps(false));
        }
    }
}
