//! The order of steps in batches, in which most streams have them: cheaper to code than the order
//! of collapses, and with the same levels at the ends of batches.
//!
//! A level of half-edge collapses depends on the set of its vertices alone, so any order with
//! targets before what splits off them gives the same levels where the sets are the same. Steps are
//! cut into batches; within one they come in the order in which a list of all wedge groups is
//! walked through once. A group goes on being split until the batch has no more splits of it; each
//! new group follows right behind the one that it splits off. One bit for each group that is
//! visited codes it all.
//!
//! ```text
//!   list           0   1   2          before the batch
//!   splits         3 off 0, 4 off 2, 5 off 3
//!   walked         0 3 5 1 2 4        bits 1 0 · 1 0 · 0 · 0 · 1, and the batch is over
//! ```

use lodc_mesh::{CollapseSequence, Lod, Mesh};
use lodc_mesh::{MeshParts, NONE, PositionIds, SequenceParts, Simplified, removal_lods};

/// A batch has one step, and one more for each this many steps before it: it grows the mesh by a
/// third. Shorter ones cost more bits (growing by a quarter: 0.3 bits for each vertex), longer ones
/// have fewer levels that a prefix can show, since within a batch the order is not the metric's.
const STEPS_FOR_ONE_MORE: usize = 3;

/// The splits of an object in stream order.
pub(crate) struct StepTree<'a> {
    /// The target of each vertex.
    pub(crate) targets: &'a [u32],
    /// For each vertex whether its step continues with the next one.
    pub(crate) continues: &'a [bool],
    /// The first vertex of the wedge group of each one.
    pub(crate) groups: &'a [u32],
    /// Vertices before the first triangle.
    pub(crate) points: u32,
    /// Numbers of vertices at which a level must not be changed: the last legal one, and the first
    /// with another topology.
    pub(crate) fixed: [u32; 2],
}

/// Two steps of which the first must come before the second, each by its first vertex.
type Precedence = [u32; 2];

/// How often each group may be passed in the walks of all batches, on average. Passes through lists
/// that grow by a third add up to four of the whole list; while steps are few beside the points,
/// some dozens of batches pass through all of these. Other orders would take quadratic time, and
/// are given up here.
const MAX_PASSES: usize = 64;

/// The list of wedge groups, each named by its first vertex, and the pass of a batch through it.
struct ListWalk {
    /// The group behind each one.
    next: Vec<u32>,
    /// Number of groups that may still be passed.
    budget: usize,
}

impl ListWalk {
    fn new(points: u32, vertices: usize) -> Self {
        let mut next: Vec<u32> = (1..=vertices as u32).collect();
        if let Some(last) = (points as usize).checked_sub(1) {
            next[last] = NONE;
        }
        Self { next, budget: MAX_PASSES * (vertices + 1) }
    }

    /// Puts a new group behind the one that it splits off.
    fn split(&mut self, group: u32, step: u32) {
        self.next[step as usize] = std::mem::replace(&mut self.next[group as usize], step);
    }

    /// Undoes the last split.
    fn join(&mut self, group: u32, step: u32) {
        self.next[group as usize] = self.next[step as usize];
    }

    /// Goes on to the next group; none behind the last, or when the budget is spent.
    fn advance(&mut self, group: u32) -> Option<u32> {
        self.budget = self.budget.checked_sub(1)?;
        Some(self.next[group as usize]).filter(|&next| next != NONE)
    }
}

impl StepTree<'_> {
    fn group_of_target(&self, vertex: u32) -> u32 {
        self.groups[self.targets[vertex as usize] as usize]
    }

    /// Cuts steps, in the order that they have, into the fewest batches: the first vertex and the
    /// number of steps of each. `None` if they are in no order of batches.
    pub(crate) fn batches(&self) -> Option<Vec<[u32; 2]>> {
        let steps = self.steps()?;
        let mut walk = ListWalk::new(self.points, self.targets.len());
        let mut batches = Vec::new();
        let mut remaining = &steps[..];
        while let Some(&first) = remaining.first() {
            let (mut group, mut count) = (0, 0);
            while let Some(&step) = remaining.get(count) {
                if self.group_of_target(step) == group {
                    walk.split(group, step);
                    count += 1;
                } else {
                    match walk.advance(group) {
                        Some(next) => group = next,
                        None => break,
                    }
                }
            }
            batches.push([first, count as u32]);
            remaining = &remaining[count..];
            // An order that was not made of batches has about one for each two steps. One in which
            // each grows by a third has 2.4 for each doubling: four, eight more at the beginning,
            // and one in 32 steps leave room for cuts at fixed levels and before late steps.
            let done = steps.len() - remaining.len();
            let max_batches = 8 + 4 * (usize::BITS - done.leading_zeros()) as usize + done / 32;
            if count == 0 || batches.len() > max_batches {
                return None;
            }
        }
        Some(batches)
    }

    /// Puts steps into an order of batches: the first vertex of each, as they are numbered now,
    /// with `precedences` kept. Calls `begin` with the number of steps before each batch.
    fn plan(&self, precedences: &[Precedence], mut begin: impl FnMut(usize)) -> Option<Vec<u32>> {
        let steps = self.steps()?;
        let mut walk = ListWalk::new(self.points, self.targets.len());
        let mut order = Vec::with_capacity(steps.len());
        // The steps of the batch by the group that they split off, in their order.
        let (mut first_split, mut next_split) =
            (vec![NONE; self.targets.len()], vec![NONE; self.targets.len()]);
        let mut index_in_order = vec![u32::MAX; self.targets.len()];
        while order.len() < steps.len() {
            let done = order.len();
            let max_end = (done + 1 + done / STEPS_FOR_ONE_MORE).min(steps.len());
            let is_fixed = |&end: &usize| steps.get(end).is_some_and(|s| self.fixed.contains(s));
            let mut end = (done + 1..max_end).find(is_fixed).unwrap_or(max_end);
            begin(done);
            loop {
                for &step in steps[done..end].iter().rev() {
                    let head = &mut first_split[self.group_of_target(step) as usize];
                    next_split[step as usize] = std::mem::replace(head, step);
                }
                let mut group = 0;
                while order.len() < end {
                    let step = first_split[group as usize];
                    if step == NONE {
                        group = walk.advance(group)?;
                    } else {
                        first_split[group as usize] = next_split[step as usize];
                        walk.split(group, step);
                        index_in_order[step as usize] = order.len() as u32;
                        order.push(step);
                    }
                }
                let too_late = |&&[a, b]: &&Precedence| {
                    let [a, b] = [a, b].map(|step| index_in_order[step as usize]);
                    a != u32::MAX && b != u32::MAX && a > b
                };
                let is_earlier = |&[_, b]: &Precedence| b < steps[done];
                let candidates = &precedences[precedences.partition_point(is_earlier)..];
                let next_batch = steps.get(end).copied().unwrap_or(u32::MAX);
                let violated =
                    candidates.iter().take_while(|[_, b]| *b < next_batch).find(too_late);
                let Some(&[_, cut]) = violated else { break };
                // The batch ends before the step that came too early, and is walked anew: the
                // shorter batch may have another order.
                for step in order.drain(done..).rev() {
                    walk.join(self.group_of_target(step), step);
                    index_in_order[step as usize] = u32::MAX;
                }
                end = steps.partition_point(|&step| step < cut);
            }
        }
        Some(order)
    }

    /// The first vertex of each step behind the points, if all are whole groups off one group.
    fn steps(&self) -> Option<Vec<u32>> {
        let mut steps = Vec::new();
        for v in self.points as usize..self.targets.len() {
            let continued = v > 0 && self.continues[v - 1] && v > self.points as usize;
            if !continued {
                if self.groups[v] as usize != v {
                    return None;
                }
                steps.push(v as u32);
            } else {
                // Points are there from the beginning, whatever group they are of.
                let follows = self.targets[v] < self.points
                    || self.group_of_target(v as u32) == self.group_of_target(v as u32 - 1);
                if self.groups[v] != self.groups[v - 1] || !follows {
                    return None;
                }
            }
        }
        Some(steps)
    }
}

/// Returns for each vertex whether its step continues with the next one.
pub(crate) fn continues(simplified: &Simplified) -> Vec<bool> {
    let collapses = simplified.collapses();
    let last = collapses.records();
    let mut continues = vec![true; simplified.mesh().vertex_count()];
    for &end in std::iter::once(&0).chain(&collapses.parts().step_ends) {
        // The first record of a step is the last vertex that comes with it.
        if let Some(c) = continues.get_mut((last - end.min(last)) as usize) {
            *c = false;
        }
    }
    continues
}

/// Returns the first vertex of each one's group: those of a step that have the same position as the
/// vertex before.
pub(crate) fn wedge_groups(
    continues: &[bool],
    same_position: impl Fn(usize, usize) -> bool,
) -> Vec<u32> {
    let mut groups: Vec<u32> = (0..continues.len() as u32).collect();
    for v in 1..groups.len() {
        if continues[v - 1] && same_position(v - 1, v) {
            groups[v] = groups[v - 1];
        }
    }
    groups
}

/// Returns a mesh with the steps of its sequence in batches, as a stream has them: the levels at
/// the ends of batches are as they were, and so are their errors. `None` if it has an order in
/// which streams cannot have it, or if it is in that order already.
#[must_use]
pub fn in_batches(simplified: &Simplified) -> Option<Simplified> {
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let (vertices, last) = (mesh.vertex_count(), collapses.records());
    let targets = collapses.targets().iter().rev().map(|&t| last - t);
    let targets: Vec<u32> = std::iter::once(0).chain(targets).take(vertices).collect();
    let continues = continues(simplified);
    let bits = |v: usize| mesh.positions()[last as usize - v].map(f32::to_bits);
    let parts = collapses.parts();
    let visible = parts.step_triangles.partition_point(|&t| t > 0);
    let points = match parts.step_ends.get(visible) {
        Some(&end) if !mesh.triangles().is_empty() => vertices as u32 - end,
        _ => vertices as u32,
    };
    let tree = StepTree {
        targets: &targets,
        continues: &continues,
        groups: &wedge_groups(&continues, |a, b| bits(a) == bits(b)),
        points,
        fixed: fixed_levels(simplified),
    };
    if tree.batches().is_some() {
        return None;
    }
    let precedences =
        if mesh.submeshes().len() > 1 { tree.crossings_first(simplified) } else { Vec::new() };
    let mut batches = Vec::new();
    let order = tree.plan(&precedences, |done| batches.push(done))?;
    batches.push(order.len());
    reordered(simplified, points, &continues, &order, &batches)
}

impl StepTree<'_> {
    /// Where a vertex becomes one of another submesh, its triangles are gone by then: the steps
    /// that must stay before those that bring the triangles, sorted by the latter.
    fn crossings_first(&self, simplified: &Simplified) -> Vec<Precedence> {
        let last = simplified.collapses().records();
        let submesh = |v: u32| simplified.mesh().vertex_submesh()[(last - v) as usize];
        let mut first_of_step: Vec<u32> = (0..=last).collect();
        // The nearest vertex on the way to the points whose target is of another submesh.
        let mut crossing = vec![NONE; self.targets.len()];
        for v in self.points..=last {
            let target = self.targets[v as usize];
            if v > self.points && self.continues[v as usize - 1] {
                first_of_step[v as usize] = first_of_step[v as usize - 1];
            }
            let crosses = submesh(v) != submesh(target);
            crossing[v as usize] = if crosses { v } else { crossing[target as usize] };
        }
        let mut precedences = Vec::new();
        for appearance in super::first_appearance::first_appearances(simplified) {
            let first_visible = first_of_step[appearance.vertices[0] as usize];
            for v in appearance.vertices {
                let crossing = crossing[v as usize];
                if crossing != NONE && first_of_step[crossing as usize] < first_visible {
                    precedences.push([first_of_step[crossing as usize], first_visible]);
                }
            }
        }
        precedences.sort_unstable_by_key(|&[a, b]| [b, a]);
        precedences.dedup();
        precedences
    }
}

/// The numbers of vertices at the levels that batches leave as they are.
pub(crate) fn fixed_levels(simplified: &Simplified) -> [u32; 2] {
    let parts = simplified.collapses().parts();
    let topology = parts.first_topology_change.unwrap_or(parts.last_legal_lod);
    [parts.last_legal_lod, topology].map(|Lod(lod)| simplified.mesh().vertex_count() as u32 - lod)
}

/// The mesh with its vertices in the order of a plan.
fn reordered(
    simplified: &Simplified,
    points: u32,
    continues: &[bool],
    order: &[u32],
    batches: &[usize],
) -> Option<Simplified> {
    let last = simplified.collapses().records();
    // In stream order: for each vertex its number before.
    let mut old_numbers: Vec<u32> = (0..points).collect();
    let mut steps = Vec::with_capacity(order.len());
    for &step in order {
        let further = continues[step as usize..].iter().take_while(|&&c| c).count() as u32;
        steps.push(further + 1);
        old_numbers.extend(step..=step + further);
    }
    let old_number = |k: u32| last - old_numbers[(last - k) as usize];
    let mut new_number = vec![0; old_numbers.len()];
    for k in 0..=last {
        new_number[old_number(k) as usize] = k;
    }
    let (mesh, sequence) = simplified.clone().into_parts();
    let (mesh, sequence) = (mesh.into_parts(), sequence.into_parts());
    let renumbered = || (0..=last).map(|k| old_number(k) as usize);
    let attributes = mesh.attributes.iter().map(|a| {
        let stride = a.stride();
        let bytes = renumbered().flat_map(|v| &a.bytes[v * stride..][..stride]).copied().collect();
        lodc_mesh::Attribute { bytes, ..a.described() }
    });
    let mesh = MeshParts {
        positions: renumbered().map(|v| mesh.positions[v]).collect(),
        vertex_submesh: renumbered().map(|v| mesh.vertex_submesh[v]).collect(),
        attributes: attributes.collect(),
        triangles: mesh.triangles.iter().map(|t| t.map(|v| new_number[v as usize])).collect(),
        submeshes: mesh.submeshes,
    };
    let targets =
        (0..last).map(|k| new_number[sequence.targets[old_number(k) as usize] as usize]).collect();
    let (errors, rms) = errors_of_batches(&sequence, batches);
    let mut step_ends = Vec::with_capacity(sequence.step_ends.len());
    let mut end = 0;
    for &step in steps.iter().rev() {
        end += step;
        step_ends.push(end);
    }
    step_ends.extend_from_slice(&sequence.step_ends[steps.len()..]);
    let sequence = SequenceParts {
        targets,
        step_triangles: vec![sequence.triangles; step_ends.len()],
        step_ends,
        step_errors: errors,
        step_rms: rms,
        ..sequence
    };
    let mesh = Mesh::try_from(mesh).ok()?;
    let unmeasured = SequenceParts {
        step_errors: vec![0.0; sequence.step_errors.len()],
        step_rms: Vec::new(),
        ..sequence.clone()
    };
    let simplified = Simplified::new(mesh, CollapseSequence::try_from(unmeasured).ok()?).ok()?;
    let simplified = with_removals(simplified)?;
    if simplified.mesh().submeshes().len() > 1 && has_triangles_across_submeshes(&simplified) {
        return None;
    }
    let (mesh, counted) = simplified.into_parts();
    let parts = counted.into_parts();
    let (step_errors, step_rms) = (sequence.step_errors, sequence.step_rms);
    let parts = SequenceParts { step_errors, step_rms, ..parts };
    Simplified::new(mesh, CollapseSequence::try_from(parts).ok()?).ok()
}

/// Returns whether a triangle of a level has corners in two submeshes: where a vertex goes on as
/// one of another submesh, its triangles are to be gone by then.
fn has_triangles_across_submeshes(simplified: &Simplified) -> bool {
    let submesh = simplified.mesh().vertex_submesh();
    let targets = simplified.collapses().targets();
    // How often the submesh changes on the way from a vertex to the last one.
    let mut changes = vec![0u32; submesh.len()];
    for v in (0..targets.len()).rev() {
        let target = targets[v] as usize;
        changes[v] = changes[target] + u32::from(submesh[v] != submesh[target]);
    }
    let last = simplified.collapses().records();
    let appearances = super::first_appearance::first_appearances(simplified);
    let is_across =
        |(appearance, triangle): (&super::first_appearance::FirstAppearance, &[u32; 3])| {
            (0..3).any(|i| {
                let first = last - appearance.vertices[i];
                let finest = triangle[(appearance.rotation + i) % 3];
                changes[first as usize] != changes[finest as usize]
            })
        };
    appearances.iter().zip(simplified.mesh().triangles()).any(is_across)
}

/// The errors after each step: within a batch those at its beginning. `batches` has the number of
/// steps of the stream before each batch, and the number of all last.
fn errors_of_batches(sequence: &SequenceParts, batches: &[usize]) -> (Vec<f32>, Vec<f32>) {
    let (mut errors, mut rms) = (sequence.step_errors.clone(), sequence.step_rms.clone());
    let all = batches.last().copied().unwrap_or_default();
    for batch in batches.windows(2) {
        // Collapsed, its last step comes first, and its first leads to the level at its beginning.
        let (start, end) = (all - batch[1], all - batch[0]);
        for list in [&mut errors, &mut rms] {
            if let Some(&last) = list.get(end - 1) {
                list[start..end].fill(last);
            }
        }
    }
    (errors, rms)
}

/// Counts the triangles after each step, and puts triangles that are removed first last. `None` for
/// a mesh and a sequence that do not belong together.
#[must_use]
pub fn with_removals(simplified: Simplified) -> Option<Simplified> {
    let removals = removal_lods(&simplified, &PositionIds::new(simplified.mesh().positions()));
    let (mesh, sequence) = simplified.into_parts();
    let (mut mesh, mut sequence) = (mesh.into_parts(), sequence.into_parts());
    let mut sorted = removals.clone();
    sorted.sort_unstable();
    let live =
        |&end: &u32| (sorted.len() - sorted.partition_point(|&removal| removal <= end)) as u32;
    sequence.step_triangles = sequence.step_ends.iter().map(live).collect();
    for submesh in &mesh.submeshes {
        let range = submesh.triangles();
        let mut order: Vec<usize> = range.clone().collect();
        order.sort_by_key(|&t| std::cmp::Reverse(removals[t]));
        let triangles: Vec<[u32; 3]> = order.into_iter().map(|t| mesh.triangles[t]).collect();
        mesh.triangles[range].copy_from_slice(&triangles);
    }
    let mesh = Mesh::try_from(mesh).ok()?;
    Simplified::new(mesh, CollapseSequence::try_from(sequence).ok()?).ok()
}
