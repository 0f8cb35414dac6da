//! The order of steps in batches, which most streams use: cheaper to code than the order of
//! collapses, and with the same levels at the ends of batches.
//!
//! A step is all vertex splits that undo one collapse: one for each wedge of a group. Steps are
//! named by their first vertex, wedge groups by theirs. The points are the vertices before the
//! first triangle; no step brings them.
//!
//! The triangles of a level depend on the set of its vertices alone. So any order of the steps in
//! which targets come before the vertices that split off them has the same levels wherever it has
//! the same sets. Steps are cut into batches; within a batch they come in the order in which a list
//! of all wedge groups is walked through once. A group is split until the batch has no more splits
//! of it; each new group is inserted right behind the one that it splits off. One bit at each visit
//! of a group (is it split?) codes the whole order.
//!
//! ```text
//!   list           0   1   2          before the batch
//!   splits         3 off 0, 4 off 2, 5 off 3
//!   walked         0 3 5 1 2 4        bits 1 0 · 1 0 · 0 · 0 · 1, and the batch is over
//! ```

use crate::source::first_appearance::{FirstAppearance, first_appearances};
use lodc_mesh::{
    Attribute, CollapseSequence, Lod, Mesh, MeshParts, NONE, SequenceParts, Simplified,
    removal_lods,
};

/// A batch has one step, and one more for this many steps before it: it grows the mesh by a third.
/// Shorter batches cost more bits (growing by a quarter: 0.3 bits for each vertex); longer ones
/// leave fewer levels that a prefix can show, since within a batch the order is not the metric's.
const EARLIER_STEPS_PER_STEP: usize = 3;

/// In a scene a batch ends early where the error falls below this share of that at its beginning,
/// so that objects take turns while their errors are alike. Chosen by hand, with the next two.
const SHARE_OF_ERROR: f32 = 0.8;
/// A batch that ends early has one step, and one more for this many steps before it.
const EARLIER_STEPS_PER_EARLY_STEP: usize = 32;
/// Batches end early as long as there are no more than these.
const MAX_EARLY_BATCHES: MaxBatches = MaxBatches { all: 4, per_bit: 3, steps: 64 };
/// Orders of more batches are not taken for such. An order that was not made of batches falls into
/// about one for each two steps. Batches that each grow the mesh by a third are 2.4 for each
/// doubling of the steps. Four, eight more at the beginning, and one for each 32 steps leave room
/// for cuts at fixed levels, where the error falls and before steps that must wait for others.
const MAX_BATCHES: MaxBatches = MaxBatches { all: 8, per_bit: 4, steps: 32 };

/// A bound on the number of batches.
struct MaxBatches {
    all: usize,
    /// More for each bit of the number of steps.
    per_bit: usize,
    /// One more for so many steps.
    steps: usize,
}

impl MaxBatches {
    fn of(&self, steps: usize) -> usize {
        let bits = (usize::BITS - steps.leading_zeros()) as usize;
        self.all + self.per_bit * bits + steps / self.steps
    }
}

/// The order of an object's steps in a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepOrder {
    /// That of the sequence: every level can be shown.
    Exact,
    /// Batches that grow as fast as they can, which is cheapest: for an object that is alone.
    Batches,
    /// Batches that end where the error falls: for objects that take turns.
    BatchesInTurns,
}

impl StepOrder {
    /// That of batches, for each object of a stream with so many.
    #[must_use]
    pub fn batches(objects: usize) -> Self {
        if objects > 1 { Self::BatchesInTurns } else { Self::Batches }
    }
}

/// The error of the level with each number of steps, from no step on; nothing where batches do not
/// depend on it.
pub(crate) fn errors_by_steps(
    simplified: &Simplified,
    points: u32,
    order: StepOrder,
) -> Option<Vec<f32>> {
    let parts = simplified.collapses().parts();
    let vertices = simplified.mesh().vertex_count() as u32;
    let steps = parts.step_ends.partition_point(|&end| end <= vertices - points);
    let errors = || parts.step_errors[..steps].iter().rev().copied().collect();
    (order == StepOrder::BatchesInTurns).then(errors)
}

/// Returns the number of steps at whose error the batch number `batches` ends early, if it begins
/// behind `done` steps.
fn early_end(errors: Option<&[f32]>, batches: usize, done: usize) -> Option<usize> {
    let errors = errors.filter(|_| batches <= MAX_EARLY_BATCHES.of(done))?;
    let least = SHARE_OF_ERROR * errors.get(done)?;
    let first = done + 1 + done / EARLIER_STEPS_PER_EARLY_STEP;
    Some(first + errors.get(first..)?.partition_point(|&error| error >= least))
}

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
    /// Numbers of vertices of two levels that batches must not change: the last legal one, and the
    /// first with another topology.
    pub(crate) fixed_levels: [u32; 2],
    /// What [`errors_by_steps`] gives.
    pub(crate) errors: Option<Vec<f32>>,
}

/// Consecutive steps that come in one walk through the list of groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Batch {
    pub(crate) first_vertex: u32,
    /// Number of its steps.
    pub(crate) steps: u32,
}

/// Two steps, each by its first vertex, of which `earlier` must come before `later`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Precedence {
    earlier: u32,
    later: u32,
}

/// How often each group may be passed in the walks of all batches, on average. Passes through lists
/// that grow by a third add up to four of the whole list; while steps are few beside the points,
/// some dozens of batches pass through all points. Orders that need more passes would take
/// quadratic time: they are given up. The number is chosen by hand.
const MAX_PASSES: usize = 64;

/// The list of wedge groups, each named by its first vertex, and the pass of a batch through it.
struct ListWalk {
    /// The group behind each one.
    next: Vec<u32>,
    /// Number of groups that may still be passed.
    passes_remaining: usize,
}

impl ListWalk {
    fn new(points: u32, vertices: usize) -> Self {
        let mut next: Vec<u32> = (1..=vertices as u32).collect();
        if let Some(last) = (points as usize).checked_sub(1) {
            next[last] = NONE;
        }
        Self { next, passes_remaining: MAX_PASSES * (vertices + 1) }
    }

    /// Puts a new group behind the one that it splits off.
    fn split(&mut self, group: u32, step: u32) {
        self.next[step as usize] = std::mem::replace(&mut self.next[group as usize], step);
    }

    /// Undoes the last split.
    fn join(&mut self, group: u32, step: u32) {
        self.next[group as usize] = self.next[step as usize];
    }

    /// Returns the group behind one; none behind the last, or after too many passes.
    fn advance(&mut self, group: u32) -> Option<u32> {
        self.passes_remaining = self.passes_remaining.checked_sub(1)?;
        Some(self.next[group as usize]).filter(|&next| next != NONE)
    }
}

impl StepTree<'_> {
    fn group_of_target(&self, vertex: u32) -> u32 {
        self.groups[self.targets[vertex as usize] as usize]
    }

    /// Cuts steps, in their present order, into the fewest batches, but for the first, of one step,
    /// so that errors are known from the first triangle on, and those that end early. `None` if
    /// that order was not made of batches.
    pub(crate) fn batches(&self) -> Option<Vec<Batch>> {
        let steps = self.steps()?;
        let mut walk = ListWalk::new(self.points, self.targets.len());
        let mut batches = Vec::new();
        let mut remaining = &steps[..];
        while let Some(&first) = remaining.first() {
            let (mut group, mut count) = (0, 0);
            let done = steps.len() - remaining.len();
            let early_end = early_end(self.errors.as_deref(), batches.len() + 1, done);
            let end = if done == 0 { Some(1) } else { early_end };
            let longest = end.map_or(remaining.len(), |end| end.saturating_sub(done).max(1));
            while let Some(&step) = remaining[..longest.min(remaining.len())].get(count) {
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
            batches.push(Batch { first_vertex: first, steps: count as u32 });
            remaining = &remaining[count..];
            if count == 0 || batches.len() > MAX_BATCHES.of(done + count) {
                return None;
            }
        }
        Some(batches)
    }

    /// Returns the steps in an order of batches that keeps `precedences`, each by its first vertex
    /// in the present order. Calls `begin` with the number of steps before each batch.
    fn order_in_batches(
        &self,
        precedences: &[Precedence],
        mut begin: impl FnMut(usize),
    ) -> Option<Vec<u32>> {
        let steps = self.steps()?;
        let mut walk = ListWalk::new(self.points, self.targets.len());
        let mut order = Vec::with_capacity(steps.len());
        // For each group a linked list of the steps of the batch that split off it, in their order.
        let (mut first_split, mut next_split) =
            (vec![NONE; self.targets.len()], vec![NONE; self.targets.len()]);
        let mut index_in_order = vec![u32::MAX; self.targets.len()];
        let mut batches = 0;
        while order.len() < steps.len() {
            let done = order.len();
            batches += 1;
            let max_end = (done + 1 + done / EARLIER_STEPS_PER_STEP).min(steps.len());
            let is_fixed =
                |&end: &usize| steps.get(end).is_some_and(|s| self.fixed_levels.contains(s));
            let mut end = (done + 1..max_end).find(is_fixed).unwrap_or(max_end);
            end = early_end(self.errors.as_deref(), batches, done).map_or(end, |e| e.min(end));
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
                let is_violated = |p: &&Precedence| {
                    let [a, b] = [p.earlier, p.later].map(|step| index_in_order[step as usize]);
                    a != u32::MAX && b != u32::MAX && a > b
                };
                let first = precedences.partition_point(|p| p.later < steps[done]);
                let next_batch = steps.get(end).copied().unwrap_or(u32::MAX);
                let mut of_batch = precedences[first..].iter().take_while(|p| p.later < next_batch);
                let Some(&Precedence { later: cut, .. }) = of_batch.find(is_violated) else {
                    break;
                };
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

    /// Returns the first vertex of each step after the points. `None` if a step is not exactly one
    /// group that splits off one other.
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
                // Points exist from the beginning, whatever their group.
                let has_same_target_group = self.targets[v] < self.points
                    || self.group_of_target(v as u32) == self.group_of_target(v as u32 - 1);
                if self.groups[v] != self.groups[v - 1] || !has_same_target_group {
                    return None;
                }
            }
        }
        Some(steps)
    }
}

/// Returns for each vertex, in stream order, whether its step continues with the next one.
pub(crate) fn find_continued_steps(simplified: &Simplified) -> Vec<bool> {
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

/// Returns for each vertex the first vertex of its wedge group. A vertex is in the group of the one
/// before it if both are of one step and have the same position.
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

/// Returns a mesh with the steps of its sequence in batches, the order of streams: the levels at
/// the ends of batches and their errors stay as they are. `None` if there is no such order for it,
/// if it is in one already, or if the order is exact.
#[must_use]
pub fn in_batches(simplified: &Simplified, order: StepOrder) -> Option<Simplified> {
    if order == StepOrder::Exact {
        return None;
    }
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let (vertices, last) = (mesh.vertex_count(), collapses.records());
    let targets = collapses.targets().iter().rev().map(|&t| last - t);
    let targets: Vec<u32> = std::iter::once(0).chain(targets).take(vertices).collect();
    let continues = find_continued_steps(simplified);
    let bits = |v: usize| mesh.positions()[last as usize - v].map(f32::to_bits);
    let parts = collapses.parts();
    let visible_steps = parts.step_triangles.partition_point(|&t| t > 0);
    let points = match parts.step_ends.get(visible_steps) {
        Some(&end) if !mesh.triangles().is_empty() => vertices as u32 - end,
        _ => vertices as u32,
    };
    let tree = StepTree {
        targets: &targets,
        continues: &continues,
        groups: &wedge_groups(&continues, |a, b| bits(a) == bits(b)),
        points,
        fixed_levels: fixed_levels(simplified),
        errors: errors_by_steps(simplified, points, order),
    };
    if tree.batches().is_some() {
        return None;
    }
    let precedences =
        if mesh.submeshes().len() > 1 { tree.submesh_precedences(simplified) } else { Vec::new() };
    let mut batches = Vec::new();
    let order = tree.order_in_batches(&precedences, |done| batches.push(done))?;
    batches.push(order.len());
    reordered(simplified, points, &continues, &order, &batches)
}

impl StepTree<'_> {
    /// When a collapse turns a vertex into one of another submesh, its triangles must be gone. So
    /// in a stream the step that crosses from one submesh to another must come before the steps
    /// that bring triangles of its vertices. Returns these pairs, sorted by the later step.
    fn submesh_precedences(&self, simplified: &Simplified) -> Vec<Precedence> {
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
        for appearance in first_appearances(simplified) {
            let first_visible = first_of_step[appearance.vertices[0] as usize];
            for v in appearance.vertices {
                let crossing = crossing[v as usize];
                if crossing != NONE && first_of_step[crossing as usize] < first_visible {
                    let earlier = first_of_step[crossing as usize];
                    precedences.push(Precedence { earlier, later: first_visible });
                }
            }
        }
        precedences.sort_unstable_by_key(|p| (p.later, p.earlier));
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

/// Returns the mesh with its steps in another order: `order` has the first vertex of each,
/// `batches` the number of steps before each batch and, last, of all.
fn reordered(
    simplified: &Simplified,
    points: u32,
    continues: &[bool],
    order: &[u32],
    batches: &[usize],
) -> Option<Simplified> {
    let last = simplified.collapses().records();
    // In stream order: the old number of each vertex.
    let mut old_numbers: Vec<u32> = (0..points).collect();
    let mut step_sizes = Vec::with_capacity(order.len());
    for &step in order {
        let further_vertices = continues[step as usize..].iter().take_while(|&&c| c).count() as u32;
        step_sizes.push(further_vertices + 1);
        old_numbers.extend(step..=step + further_vertices);
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
        Attribute { bytes, ..a.described() }
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
    for &size in step_sizes.iter().rev() {
        end += size;
        step_ends.push(end);
    }
    step_ends.extend_from_slice(&sequence.step_ends[step_sizes.len()..]);
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

/// Returns whether a triangle of any level has corners in two submeshes.
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
    let appearances = first_appearances(simplified);
    let is_across = |(appearance, triangle): (&FirstAppearance, &[u32; 3])| {
        (0..3).any(|i| {
            let first = last - appearance.vertices[i];
            let finest = triangle[(appearance.rotation + i) % 3];
            changes[first as usize] != changes[finest as usize]
        })
    };
    appearances.iter().zip(simplified.mesh().triangles()).any(is_across)
}

/// Returns the errors and root mean square distances after each collapse. Inside a batch levels are
/// not those that were measured, so all its collapses get the errors of the coarsest level, the one
/// at the beginning of the batch in the stream. `batches` has the number of steps of the stream
/// before each batch and, last, of all.
fn errors_of_batches(sequence: &SequenceParts, batches: &[usize]) -> (Vec<f32>, Vec<f32>) {
    let (mut errors, mut rms) = (sequence.step_errors.clone(), sequence.step_rms.clone());
    let all = batches.last().copied().unwrap_or_default();
    for batch in batches.windows(2) {
        // The sequence runs the other way: the batch's first step in the stream is its last
        // collapse, which leads to the level at the beginning of the batch.
        let (start, end) = (all - batch[1], all - batch[0]);
        for list in [&mut errors, &mut rms] {
            if let Some(&last) = list.get(end - 1) {
                list[start..end].fill(last);
            }
        }
    }
    (errors, rms)
}

/// Recounts the triangles after each step of the sequence, and sorts those of each submesh so that
/// the triangle that is removed first comes last. `None` if the mesh and the sequence do not belong
/// together.
#[must_use]
pub fn with_removals(simplified: Simplified) -> Option<Simplified> {
    let removals = removal_lods(&simplified, &simplified.mesh().position_ids());
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
