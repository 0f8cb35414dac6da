//! The fourth step: which collapse of a group is the cheapest that is legal?
//!
//! The input is a group and its prices; the output is a [`LegalCollapse`], and the plan of
//! what becomes of each wedge (true, twin or fake). Rules refuse what would turn a face over,
//! change the topology or tear a border; the terminal phase drops them one after another, so that
//! in the end every mesh is one vertex. Nearly always the collapse that was ranked best is legal,
//! and nothing else is priced. [`Heap`] says which group is asked first: the cheapest, and of equal
//! ones that with the smaller number.

mod heap;
mod legality;
pub(crate) mod link;
mod plan;

pub(crate) use heap::Heap;
pub(crate) use legality::{Rules, Stage};
pub(crate) use plan::{Planner, WedgePlan};

use crate::cut::{
    Choice, HIGH_VALENCE, InMotion, OPEN, RESTRICTED, Region, SEAM, STALE, WorkingMesh,
};
use crate::metric::Reevaluate;
use crate::price::{PriceLists, Priced, Pricer, Scratch};
use legality::{MovingFaces, Verdict, keeps_texture};
use link::Marks;

/// What each fake adds to the factor of a cost: a collapse with one fake costs nine times as much,
/// as one of three times the distance. A fake is one more vertex in every file, and mostly a seam
/// that leaves its line. Chosen by hand; not tuned.
const FAKE_FACTOR: f64 = 8.0;
/// Limit on faces times candidates of one group. Checking each neighbour of a high-valence group
/// against each of its faces would take quadratic time, so only its cheapest candidates are
/// checked: 128 for 128 faces, 16 for 1,000, at least 8 for any number. Chosen by hand.
const MAX_CHECKED_FACES: usize = 1 << 14;

/// A legal collapse of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegalCollapse {
    pub(crate) choice: Choice,
    pub(crate) changes_topology: bool,
    /// True if [`SelectionBuffers::plan`] holds its plan.
    pub(crate) is_planned: bool,
}

/// Buffers for selecting, used again and again.
#[derive(Default)]
pub(crate) struct SelectionBuffers<S> {
    pub(crate) scratch: Scratch<S>,
    /// The prices of groups that were priced one by one, for metrics that never change them.
    pub(crate) lists: PriceLists,
    marks: Marks,
    /// The faces of a group whose star is not a closed fan.
    faces: MovingFaces,
    /// The plan of a candidate.
    tried: WedgePlan,
    /// The plan of the selected collapse.
    pub(crate) plan: WedgePlan,
    /// True if a collapse of the group was refused, or its cost multiplied.
    pub(crate) refused: bool,
}

impl<S: Default> SelectionBuffers<S> {
    /// Buffers for a region, given its number of groups, whose prices are kept.
    pub(crate) fn new(groups: usize) -> Self {
        Self { lists: PriceLists::new(groups), ..Self::default() }
    }
}

/// The data that selecting reads.
pub(crate) struct Selector<'a, M> {
    pub(crate) pricer: Pricer<'a, M>,
    pub(crate) rules: Rules,
}

impl<M: Reevaluate> Selector<'_, M> {
    /// The cheapest legal collapse of a group, given its cheapest collapse of any kind.
    pub(crate) fn select(
        &self,
        from: u32,
        known: Choice,
        buffers: &mut SelectionBuffers<M::ViewScratch>,
    ) -> Option<LegalCollapse> {
        self.confirm(from, known, buffers).or_else(|| self.search(from, buffers))
    }

    /// The mesh at rest and in motion.
    #[inline]
    fn shapes(&self) -> (&WorkingMesh, Option<InMotion<'_>>) {
        (&self.pricer.region.mesh, self.pricer.in_motion())
    }

    /// Returns whether wedges decide about legality and price.
    fn wedges_matter(&self, from: u32) -> bool {
        self.pricer.region.mesh.has(from, SEAM) || self.pricer.context.attributes.texture.is_some()
    }

    /// The known choice, if it is legal at its price.
    fn confirm(
        &self,
        from: u32,
        known: Choice,
        buffers: &mut SelectionBuffers<M::ViewScratch>,
    ) -> Option<LegalCollapse> {
        let is_planned = self.wedges_matter(from);
        buffers.refused = false;
        // The choice of a restricted group is what a search has found, all factors included.
        let is_found =
            self.pricer.region.mesh.has(from, RESTRICTED) && !self.pricer.metric.is_active();
        let verdict = self.rules.check(self.shapes(), from, known.to, &mut buffers.marks)?;
        let factor = verdict.factor * self.loose_factor(from, verdict);
        if factor > 1.0 && !is_found {
            return None;
        }
        if is_planned {
            if !self.try_plan(from, known.to, buffers)
                || buffers.tried.costly_fakes > 0 && !is_found
            {
                return None;
            }
            std::mem::swap(&mut buffers.tried, &mut buffers.plan);
        }
        let choice = if self.pricer.metric.is_active() && !M::IS_LOCAL {
            self.pricer.reevaluate_choice(from, known, &mut buffers.scratch)?
        } else {
            known
        };
        Some(LegalCollapse { choice, changes_topology: verdict.changes_topology, is_planned })
    }

    /// Prices all collapses and takes the cheapest that is legal.
    pub(crate) fn search(
        &self,
        from: u32,
        buffers: &mut SelectionBuffers<M::ViewScratch>,
    ) -> Option<LegalCollapse> {
        buffers.refused = false;
        let is_planned = self.wedges_matter(from);
        self.price_all(from, buffers);
        let mut candidates = std::mem::take(&mut buffers.scratch.candidates);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let faces = self.pricer.region.mesh.valence(from);
        let most = if faces > HIGH_VALENCE && self.rules.stage < Stage::Links {
            (MAX_CHECKED_FACES / faces).max(8)
        } else {
            usize::MAX
        };
        let mesh = &self.pricer.region.mesh;
        let gathered = mesh.has(from, OPEN) && faces <= HIGH_VALENCE;
        if gathered {
            buffers.faces.gather(mesh, from);
        }
        let mut best: Option<(f64, u32, bool)> = None;
        for &(cost, to) in candidates.iter().take(most) {
            if best.is_some_and(|(least, ..)| cost >= least) {
                break;
            }
            let SelectionBuffers { marks, faces, .. } = &mut *buffers;
            let verdict = if gathered {
                self.rules.check_gathered(self.shapes(), from, to, marks, faces)
            } else {
                self.rules.check(self.shapes(), from, to, marks)
            };
            let Some(verdict) = verdict else {
                buffers.refused = true;
                continue;
            };
            let mut factor = verdict.factor * self.loose_factor(from, verdict);
            if is_planned {
                if !self.try_plan(from, to, buffers) {
                    buffers.refused = true;
                    continue;
                }
                factor *= 1.0 + FAKE_FACTOR * f64::from(buffers.tried.costly_fakes);
            }
            buffers.refused |= factor > 1.0;
            let cost = cost * factor;
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, to, verdict.changes_topology));
                std::mem::swap(&mut buffers.tried, &mut buffers.plan);
            }
        }
        buffers.scratch.candidates = candidates;
        best.map(|(cost, to, changes_topology)| LegalCollapse {
            choice: Choice { cost: self.pricer.key(from, cost), to },
            changes_topology,
            is_planned,
        })
    }

    /// By how much a collapse is dearer that takes a loose part away, or the first face of a card,
    /// whose other one follows.
    fn loose_factor(&self, from: u32, verdict: Verdict) -> f64 {
        let Pricer { context, region, .. } = &self.pricer;
        let group = region.groups[from as usize];
        let goes =
            verdict.vanishes || context.input.is_card(group) && !self.pricer.is_half_card(from);
        if goes { context.input.loose_factor(group) } else { 1.0 }
    }

    /// Fills the candidates of a group, from kept prices if there are any.
    fn price_all(&self, from: u32, buffers: &mut SelectionBuffers<M::ViewScratch>) {
        let SelectionBuffers { scratch, lists, .. } = buffers;
        let mesh = &self.pricer.region.mesh;
        if let Some(list) = self.prices(from, lists) {
            scratch.candidates.clear();
            scratch.candidates.extend(list.iter().map(|p| (p.cost(mesh), p.to)));
        } else {
            self.pricer.price_all(from, scratch);
            lists.keep(from, &scratch.priced);
        }
    }

    /// The kept prices of a group; none for high-valence groups, as not all changes around them are
    /// noticed.
    fn prices<'l>(&self, from: u32, lists: &'l PriceLists) -> Option<&'l [Priced]> {
        lists.get(from).filter(|_| self.pricer.region.mesh.valence(from) < HIGH_VALENCE)
    }

    /// Returns whether the choice of a restricted group, whose own faces are unchanged, is still
    /// the cheapest after some of its neighbours were touched: the choice is none of them, and each
    /// of them costs more or is illegal.
    pub(crate) fn is_still_best(
        &self,
        from: u32,
        is_touched: impl Fn(u32) -> bool,
        buffers: &mut SelectionBuffers<M::ViewScratch>,
    ) -> bool {
        let Region { mesh, choices, .. } = self.pricer.region;
        let SelectionBuffers { lists, marks, .. } = buffers;
        let known = choices[from as usize];
        let Some(list) = self.prices(from, lists).filter(|_| !mesh.has(from, STALE)) else {
            return false;
        };
        list.iter().filter(|p| is_touched(p.to)).all(|p| {
            p.to != known.to
                && (self.pricer.key(from, p.cost(mesh)) > known.cost
                    || self.rules.check(self.shapes(), from, p.to, marks).is_none())
        })
    }

    /// The data that planning reads.
    pub(crate) fn planner(&self) -> Planner<'_> {
        let Pricer { context, region, .. } = &self.pricer;
        Planner {
            input: context.input,
            mesh: &region.mesh,
            wedges: &region.wedges,
            attributes: &context.attributes,
            reuses_any: self.rules.stage >= Stage::Seams,
            size: context.input.size,
        }
    }

    /// Plans a collapse. False if that is refused.
    fn try_plan(&self, from: u32, to: u32, buffers: &mut SelectionBuffers<M::ViewScratch>) -> bool {
        let planner = self.planner();
        planner.plan(from, to, &mut buffers.tried);
        let Planner { mesh, wedges, attributes, .. } = planner;
        self.rules.stage >= Stage::Flips
            || keeps_texture(mesh, wedges, attributes, from, to, &buffers.tried)
    }
}
