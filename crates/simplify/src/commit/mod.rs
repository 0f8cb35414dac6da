//! The fifth step: one collapse is carried out and written down.
//!
//! The input is a legal collapse with its plan. Wedges, then faces and quadrics of the group
//! move onto its target, and groups that have come to share a position there are united with it.
//! The output is a step of the [`CollapseLog`]: each wedge with the one that it became, the
//! triangles that died, the error, and a stamp that puts the step behind all that it builds on.
//! Everything that was ranked by what is now different is [`Touched`].

mod log;
mod merge;

pub(crate) use log::{CollapseLog, Sources, renumber_wedges};

use crate::choose::{LegalCollapse, WedgePlan};
use crate::cut::{DEAD, OPEN, Quadric, Region, SEAM};
use crate::metric::Reevaluate;
use crate::number::Input;
use lodc_mesh::NONE;

/// The groups whose faces a commit changed.
#[derive(Default)]
pub(crate) struct Touched {
    pub(crate) groups: Vec<u32>,
    /// Groups that were united with the target.
    pub(crate) united: Vec<u32>,
    /// By group: see `epoch`.
    marks: Vec<u32>,
    /// The mark of groups that the last commit touched; `epoch + 1` is that of others that were
    /// marked since.
    epoch: u32,
}

impl Touched {
    pub(crate) fn new(groups: usize) -> Self {
        Self { marks: vec![0; groups], ..Self::default() }
    }

    /// Begins a commit: nothing is touched.
    fn start(&mut self) {
        self.groups.clear();
        self.united.clear();
        // Two values for each commit, so that marks need not be cleared.
        self.epoch = self.epoch.checked_add(2).unwrap_or_else(|| {
            self.marks.fill(0);
            2
        });
    }

    /// Marks a group besides those that were touched. Returns whether it had no mark since the last
    /// commit.
    #[inline]
    pub(crate) fn mark(&mut self, group: u32) -> bool {
        let is_new = !self.is_marked(group);
        if is_new {
            self.marks[group as usize] = self.epoch + 1;
        }
        is_new
    }

    /// Returns whether a group has been marked or touched since the last commit.
    #[inline]
    pub(crate) fn is_marked(&self, group: u32) -> bool {
        self.marks[group as usize] >= self.epoch
    }

    /// Returns whether the last commit touched a group.
    #[inline]
    pub(crate) fn is_touched(&self, group: u32) -> bool {
        self.marks[group as usize] == self.epoch
    }

    /// Adds a touched group, once.
    #[inline]
    fn add(&mut self, group: u32) {
        if !self.is_marked(group) {
            self.marks[group as usize] = self.epoch;
            self.groups.push(group);
        }
    }
}

/// Everything that a commit changes.
pub(crate) struct Commit<'a, M> {
    pub(crate) input: &'a Input<'a>,
    pub(crate) region: &'a mut Region,
    pub(crate) metric: &'a mut M,
    pub(crate) log: &'a mut CollapseLog,
    pub(crate) touched: &'a mut Touched,
}

impl<M: Reevaluate> Commit<'_, M> {
    /// Moves `from` as planned and writes it down.
    pub(crate) fn run(mut self, from: u32, legal: LegalCollapse, plan: &mut WedgePlan) {
        let to = legal.choice.to;
        self.touched.start();
        self.touched.mark(from);
        self.touched.add(to);
        let Self { region, touched, .. } = &mut self;
        region.mesh.each_neighbour(from, |g| touched.add(g));
        touched.groups.iter().for_each(|&g| region.prefetch(g));
        // If so, edges that were smooth may be seams now, on which prices of all touched groups
        // depend.
        let seam_moves = plan.ambiguous || plan.fakes > 0;
        self.move_wedges(from, to, plan);

        let twins = self.region.mesh.twins(from, to).collect();
        self.merge(from, to);
        let mesh = &mut self.region.mesh;
        let inherited = mesh.flags[from as usize] & (OPEN | SEAM);
        mesh.add_flags(to, inherited);
        if legal.changes_topology || seam_moves {
            let open = if legal.changes_topology { OPEN } else { 0 };
            let flags = open | if seam_moves { SEAM } else { 0 };
            for &g in &self.touched.groups {
                mesh.add_flags(g, flags);
            }
        }
        self.unite_position(twins, to);
        self.end_step(from, legal);
    }

    /// Moves `from`'s faces and quadrics.
    fn merge(&mut self, from: u32, to: u32) {
        let Self { input, region, metric, log, .. } = self;
        metric.collapsed(&region.mesh, &region.wedges, from, to);
        region.merge_in_motion(&input.shapes, from, to);
        let moving_cost = region.moving.greatest(to, |quadric| quadric.c);
        region.quadrics.merge(&mut region.mesh, from, to, moving_cost);
        region.mesh.merge(from, to, |triangle| log.dead.push(triangle));
        region.mesh.add_flags(from, DEAD);
    }

    /// Writes the step down, with a stamp no less than those of all steps that it builds on.
    fn end_step(&mut self, from: u32, legal: LegalCollapse) {
        let Self { region, metric, log, touched, .. } = self;
        let stamps = &mut region.stamps;
        let mut stamp = legal.choice.cost.max(stamps[from as usize]);
        for &g in &touched.groups {
            stamp = stamp.max(stamps[g as usize]);
        }
        for &g in &touched.groups {
            stamps[g as usize] = stamp;
        }
        let to = legal.choice.to;
        let at_rest = metric.error().unwrap_or_else(|| region.quadrics.error(to));
        let error = at_rest.max(region.moving.greatest(to, Quadric::distance));
        log.end_step(stamp, error as f32, legal.changes_topology);
    }

    /// Unites groups at the position of `to` that have come to share a face with it: they are one
    /// group from now on.
    fn unite_position(&mut self, mut twins: Vec<u32>, to: u32) {
        while let Some(twin) = twins.pop() {
            let mesh = &mut self.region.mesh;
            if mesh.has(twin, DEAD) {
                continue;
            }
            for i in 0..mesh.valence(twin) {
                for g in mesh.faces[mesh.star(twin)[i].face() as usize].groups {
                    mesh.add_flags(g, OPEN | SEAM);
                    self.touched.add(g);
                }
            }
            twins.extend(self.region.mesh.twins(twin, to));
            self.touched.united.push(twin);
            self.merge(twin, to);
            self.region.wedges.merge_groups(twin, to);
            self.region.mesh.add_flags(to, OPEN | SEAM);
        }
    }

    /// Records a planned collapse and gives the faces their new wedges.
    fn move_wedges(&mut self, from: u32, to: u32, plan: &mut WedgePlan) {
        let Self { input, region, log, .. } = self;
        if region.wedges.is_bare() {
            log.record(from, to);
            return;
        }
        // Fakes come last: their position is that of the true edge's target, which has to be known.
        for p in plan.wedges.iter().filter(|p| p.target != NONE) {
            log.record(p.wedge, p.target);
        }
        let wedges = &mut region.wedges;
        for i in 0..plan.wedges.len() {
            let wedge = plan.wedges[i].wedge;
            if plan.wedges[i].target != NONE {
                continue;
            }
            // Wedges with the same attributes share a fake. A position with more than 64 wedges
            // (chosen by hand; real meshes have a handful) may get some it could have shared.
            let mut earlier = plan.wedges[..i].iter().filter(|p| p.is_fake).take(64);
            let target = match earlier.find(|p| wedges.alike(input.mesh, p.wedge, wedge)) {
                Some(p) => p.target,
                None => {
                    let sources = [plan.true_target, plan.wedges[i].attributes];
                    wedges.add_fake(input, to, wedge, sources)
                }
            };
            plan.wedges[i].target = target;
            plan.wedges[i].is_fake = true;
            log.record(wedge, target);
        }
        let mesh = &mut region.mesh;
        let corners = if mesh.one_wedge_each() { 0 } else { mesh.valence(from) };
        for i in 0..corners {
            let corner = mesh.star(from)[i];
            let old = mesh.wedges(corner.face())[corner.at()];
            if let Some(target) = plan.target(old) {
                mesh.set_wedge(corner, target);
            }
        }
        wedges.clear_group(from);
    }
}

/// Joins the points of a region that are left without faces: those of one submesh first, all of
/// them onto the last one, so that none passes through another. The last one goes into the log
/// without a target.
pub(crate) fn join_points(region: &Region, log: &mut CollapseLog) {
    let mut left: Vec<(u32, u32)> = (0..region.own_groups() as u32)
        .filter(|&g| !region.mesh.has(g, DEAD))
        .filter_map(|g| region.wedges.of_group(g).next().map(|w| (region.wedges.submesh(w), g)))
        .collect();
    left.sort_unstable();
    let Some(last_wedge) = left.last().and_then(|&(_, g)| region.wedges.of_group(g).last()) else {
        return;
    };
    for &(_, g) in &left {
        let before = log.wedges.len();
        for wedge in region.wedges.of_group(g).filter(|&w| w != last_wedge) {
            log.record(wedge, last_wedge);
        }
        if log.wedges.len() > before {
            log.end_step(f32::MAX, 0.0, false);
        }
    }
    log.wedges.push(last_wedge);
}
