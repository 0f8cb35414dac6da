//! The collapse loop of one region: always commit the cheapest legal collapse.

mod refresh;

use crate::choice::Choice;
use crate::choose::heap::Heap;
use crate::choose::legality::{Rules, Stage};
use crate::choose::{LegalCollapse, SelectionBuffers, Selector};
use crate::commit::log::CollapseLog;
use crate::commit::{Commit, join_points};
use crate::context::{Context, Progress};
use crate::cut::mesh::{LOCKED, RESTRICTED, STALE};
use crate::cut::region::Region;
use crate::metric::Reprice;
use crate::price::{Pricer, Scratch};
use crate::scratch_pool::ScratchPool;
use crate::touched::Touched;
use rayon::prelude::*;

/// The queue is filled again if at least one in so many groups collapsed since.
const REFILL_PART: usize = 64;

/// The simplification of one region.
pub(crate) struct Engine<'a, M: Reprice> {
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
    /// Buffers of other threads.
    pool: ScratchPool<Scratch<S>>,
    touched: Touched,
    /// Groups to be ranked again.
    due: Vec<u32>,
    /// Collapses whose neighbours wait for it.
    waiting: usize,
    /// Number of groups that are flagged as restricted.
    restricted: u32,
}

/// The groups that a queue takes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Queue {
    /// Those that cost at most this and are not locked. What is refused waits for the next round.
    UpTo(f32),
    /// All. What is refused is checked again when something near it changes.
    All,
}

impl<'a, M: Reprice> Engine<'a, M> {
    pub(crate) fn new(
        context: &'a Context<'a>,
        region: &'a mut Region,
        metric: &'a mut M,
        stage: Stage,
    ) -> Self {
        let preserve_topology = context.options.preserve_topology;
        let lists = if M::REPRICES { 0 } else { region.groups.len() };
        let state = LoopState {
            selection: SelectionBuffers::new(lists),
            touched: Touched::new(region.groups.len()),
            pool: ScratchPool::new(M::REPRICES),
            ..LoopState::default()
        };
        let rules = Rules { stage, preserve_topology, unites: true };
        Self { context, region, metric, rules, log: CollapseLog::default(), state }
    }

    /// Runs all stages, then joins the points that are left. Returns the log and how many of its
    /// steps are legal.
    pub(crate) fn run_all(mut self, progress: &Progress<'_>) -> (CollapseLog, usize) {
        let Region { mesh, wedges, groups, .. } = &*self.region;
        let wedges = wedges.ids.len().max(groups.len());
        self.log = CollapseLog::with_room(groups.len(), wedges, mesh.live_faces as usize);
        let mut legal = 0;
        for stage in Stage::ALL {
            self.rules.stage = stage;
            if M::REPRICES {
                self.metric.toggle(&self.region.mesh, stage == Stage::Legal);
            }
            while self.region.mesh.live_faces > 0 {
                let (before, faces) = (self.log.steps.len(), self.region.mesh.live_faces as usize);
                self.rank_all();
                if !self.run_queue(Queue::All, progress) {
                    self.metric.toggle(&self.region.mesh, stage == Stage::Legal);
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

    /// Collapses what costs at most `limit`, as far as it is this region's alone.
    pub(crate) fn run_round(mut self, limit: f32, progress: &Progress<'_>) -> CollapseLog {
        self.rules.unites = false;
        for group in 0..self.region.own() as u32 {
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
        let pricer = Pricer { context, region, metric: &**metric, stage: rules.stage };
        (Selector { pricer, rules: *rules }, state)
    }

    /// Ranks every group.
    pub(crate) fn rank_all(&mut self) {
        let own = self.region.own() as u32;
        let (Selector { pricer, .. }, _) = self.parts();
        let rank = |scratch: &mut Scratch<M::ViewScratch>, g: u32| pricer.rank(g, scratch);
        let choices = (0..own)
            .into_par_iter()
            .with_min_len(if M::REPRICES { 64 } else { 4096 })
            .map_init(Scratch::default, rank)
            .collect();
        self.region.choices = choices;
        self.state.selection.lists.clear();
        for flags in &mut self.region.mesh.flags {
            *flags &= !(STALE | RESTRICTED);
        }
        self.state.restricted = 0;
    }

    /// Collapses while there is something to collapse: true when there is not, false when prices
    /// change their meaning.
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
                if self.state.waiting == 0 {
                    return true;
                }
                self.rerank_waiting(&mut heap);
                continue;
            };
            self.region.mesh.prefetch_neighbours(from);
            if self.region.mesh.has(from, STALE) {
                if self.state.waiting > 0 {
                    self.rerank_waiting(&mut heap);
                    continue;
                }
                self.rerank(from);
                let cost = self.region.choices[from as usize].cost;
                if cost.is_nan() || cost > limit {
                    continue;
                }
                if cost > key && cost > heap.least() {
                    heap.set(from, cost);
                    continue;
                }
            }
            let Some(legal) = self.select_legal_collapse(from) else {
                self.region.choices[from as usize] = Choice::NONE;
                continue;
            };
            self.region.choices[from as usize] = legal.choice;
            if legal.choice.cost > limit {
                continue;
            }
            if legal.choice.cost > key && legal.choice.cost > heap.least() {
                heap.set(from, legal.choice.cost);
                continue;
            }
            self.commit(from, legal);
            self.refresh(legal.choice.to, queue, limit, &mut heap);
            if self.log.steps.len().is_multiple_of(if M::REPRICES { 64 } else { 4096 }) {
                progress.report(self.log.steps.len() as u64);
            }
            if M::REPRICES && self.metric.should_toggle(&self.region.mesh) {
                self.rerank_waiting(&mut heap);
                return false;
            }
        }
    }

    /// The cheapest legal collapse of a group.
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
        self.set_restricted(from, false);
        self.state.selection.lists.release(from);
        let Self { context, region, metric, log, state, .. } = self;
        let LoopState { selection, touched, .. } = state;
        Commit { context, region, metric: &mut **metric, log, touched }.run(
            from,
            legal,
            &mut selection.plan,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::QuadricOnly;
    use crate::number::input::Input;
    use crate::options::Options;
    use crate::price::attributes::Attributes;
    use crate::price::price_lists::PriceLists;

    #[test]
    fn prices_that_are_kept_change_nothing() {
        let random = (0..20).map(lodc_fixtures::random);
        let shapes = [lodc_fixtures::machine_part(), lodc_fixtures::uv_sphere(24, 16)];
        for mesh in random.chain(shapes) {
            let input = Input::new(&mesh);
            let attributes =
                Attributes::new(&mesh, |_| crate::Weights::DEFAULT, input.scale, input.size);
            let context = Context { input: &input, options: Options::DEFAULT, attributes };
            let steps = |kept: bool| {
                let mut region = Region::whole(&input, context.is_bare());
                let mut metric = QuadricOnly;
                let mut engine = Engine::new(&context, &mut region, &mut metric, Stage::Legal);
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
