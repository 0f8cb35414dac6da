//! Carries out on the whole mesh what was collapsed on the shell (one layer of coincident faces):
//! every layer gets the same collapses.

use crate::choose::{LegalCollapse, Planner, WedgePlan};
use crate::commit::{CollapseLog, Commit, Sources, Touched, join_points};
use crate::cut::{Choice, DEAD, Region};
use crate::metric::QuadricOnly;
use crate::number::Input;
use crate::output;
use crate::price::Context;
use lodc_mesh::NONE;

/// A collapse of the shell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayerCollapse {
    /// A vertex of the whole mesh at the position that moves.
    from: u32,
    /// One at the position that it moves onto.
    to: u32,
    /// In working units.
    error: f32,
    changes_topology: bool,
}

/// The collapses of a log in their final order, of which the first `legal` ones are legal.
/// `vertices` are the vertices of the whole mesh that the shell's are.
pub(crate) fn layer_collapses(
    input: &Input<'_>,
    vertices: &[u32],
    log: &CollapseLog,
    legal: usize,
    by_stamp: bool,
) -> Vec<LayerCollapse> {
    // For each fake a vertex of the whole mesh at its position, once one is known.
    let mut fakes: Vec<u32> = Vec::new();
    let vertex_of_wedge = |fakes: &[u32], wedge: u32| match input.vertex_of().get(wedge as usize) {
        Some(&vertex) => vertices[vertex as usize],
        None => fakes.get(wedge as usize - input.wedges()).copied().unwrap_or(NONE),
    };
    let order = output::final_order(log, legal, by_stamp);
    let mut collapses = Vec::with_capacity(order.len());
    for step in order {
        let (records, step) = (log.records(step as usize), &log.steps[step as usize]);
        let (wedges, targets) = (&log.wedges[records.clone()], &log.targets[records]);
        let first_known = |list: &[u32]| {
            list.iter()
                .map(|&wedge| vertex_of_wedge(&fakes, wedge))
                .find(|&v| v != NONE)
                .unwrap_or(NONE)
        };
        let (from, to) = (first_known(wedges), first_known(targets));
        for &fake in targets.iter().filter(|&&t| t as usize >= input.wedges()) {
            let at = fake as usize - input.wedges();
            fakes.resize(fakes.len().max(at + 1), NONE);
            fakes[at] = to;
        }
        let (error, changes_topology) = (step.error, step.changes_topology);
        collapses.push(LayerCollapse { from, to, error, changes_topology });
    }
    collapses
}

/// Carries collapses out, of which the first `legal` ones are legal. Returns the log and how many
/// of its steps are legal; none if the whole mesh cannot follow, as a legal collapse of the shell
/// is along no edge of it.
pub(crate) fn follow(
    context: &Context<'_>,
    collapses: &[LayerCollapse],
    legal: usize,
    sources: &mut Sources<'_>,
) -> Option<(CollapseLog, usize)> {
    let input = context.input;
    let mut region = Region::whole(input, context.is_bare());
    let mut log = CollapseLog::with_room(input.groups(), input.wedges(), collapses.len());
    let mut following = Following {
        context,
        touched: Touched::new(region.groups.len()),
        plan: WedgePlan::default(),
        united: vec![NONE; region.groups.len()],
        region: &mut region,
        log: &mut log,
    };
    let mut legal_steps = 0;
    for (i, step) in collapses.iter().enumerate() {
        let [from, to] = [step.from, step.to].map(|v| following.group(v));
        if from == to {
            // Groups at one position that were united earlier than in the shell.
            continue;
        }
        if !following.is_edge(from, to) {
            if i < legal {
                return None;
            }
            // What is left of the shell are points.
            break;
        }
        following.collapse(from, to, i >= legal, step.changes_topology);
        if let Some(last) = following.log.steps.last_mut() {
            last.error = step.error;
        }
        legal_steps += usize::from(i < legal);
    }
    following.collapse_rest();
    join_points(&region, &mut log);
    sources.number_fakes(&mut region, &mut log);
    Some((log, legal_steps))
}

/// The whole mesh while it follows.
struct Following<'a> {
    context: &'a Context<'a>,
    region: &'a mut Region,
    log: &'a mut CollapseLog,
    touched: Touched,
    plan: WedgePlan,
    /// The group with which each was united; `NONE` if it was not.
    united: Vec<u32>,
}

impl Following<'_> {
    /// The group that a vertex was in at first, or the one that this has been united with.
    fn group(&self, vertex: u32) -> u32 {
        let mut group = self.context.input.group_of[vertex as usize];
        while self.united[group as usize] != NONE {
            group = self.united[group as usize];
        }
        group
    }

    /// Returns whether two groups share a face.
    fn is_edge(&self, from: u32, to: u32) -> bool {
        let mesh = &self.region.mesh;
        mesh.star(from).iter().any(|&corner| mesh.others(corner).contains(&to))
    }

    /// Moves a group onto a neighbour.
    fn collapse(&mut self, from: u32, to: u32, reuses_any: bool, changes_topology: bool) {
        let Self { context, region, log, touched, plan, united } = self;
        let input = context.input;
        plan.clear();
        if !region.wedges.is_bare() {
            let planner = Planner {
                input,
                mesh: &region.mesh,
                wedges: &region.wedges,
                attributes: &context.attributes,
                reuses_any,
                size: input.size,
            };
            planner.plan(from, to, plan);
        }
        let choice = Choice { cost: 0.0, to };
        let legal = LegalCollapse { choice, changes_topology, is_planned: true };
        let metric = &mut QuadricOnly;
        let commit = Commit { input, region, metric, log, touched };
        commit.run(from, legal, plan);
        for &other in &touched.united {
            united[other as usize] = to;
        }
    }

    /// Collapses faces that are left when the shell has none: their positions are the shell's, but
    /// not their edges.
    fn collapse_rest(&mut self) {
        for group in 0..self.region.own_groups() as u32 {
            while !self.region.mesh.has(group, DEAD) {
                let Some(&corner) = self.region.mesh.star(group).first() else { break };
                let [to, _] = self.region.mesh.others(corner);
                let (reuses_any, changes_topology) = (true, true);
                self.collapse(group, to, reuses_any, changes_topology);
            }
        }
    }
}
