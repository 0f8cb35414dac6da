//! Points that are left without faces join another one as soon as they have none. So the coarsest
//! levels have few vertices, however many components a mesh has, and a stream, which is a sequence
//! backwards, shows triangles after a few vertices.

use crate::input::Input;
use crate::log::CollapseLog;

/// Returns the order of steps with those that join points moved forward: each comes right after the
/// last step that its points' group takes part in, but not before step `legal`. `order` has the
/// joins last.
pub(crate) fn join_early(
    log: &CollapseLog,
    legal: usize,
    input: &Input<'_>,
    order: &[u32],
) -> Vec<u32> {
    let first_join = log.steps.len() - log.joins;
    let last_use = last_uses(log, input, &order[..first_join]);
    let mut joins: Vec<(u32, u32)> = (first_join..log.steps.len())
        .map(|step| {
            let wedges = &log.wedges[log.records(step)];
            let end = wedges.iter().map(|&w| last_use[w as usize]).max().unwrap_or(0);
            (end.max(legal as u32), step as u32)
        })
        .collect();
    joins.sort_unstable();
    let mut joins = joins.into_iter().peekable();
    let mut result = Vec::with_capacity(order.len());
    for (number, &step) in (0..).zip(&order[..first_join]) {
        result.extend(std::iter::from_fn(|| joins.next_if(|j| j.0 <= number)).map(|j| j.1));
        result.push(step);
    }
    result.extend(joins.map(|j| j.1));
    result
}

/// For each wedge that is left before points are joined: how many steps of `order` there are until
/// nothing becomes it any more and no triangle has a corner there.
fn last_uses(log: &CollapseLog, input: &Input<'_>, order: &[u32]) -> Vec<u32> {
    let count = log.wedges.iter().map(|&w| w as usize + 1).max().unwrap_or(0);
    // What each wedge becomes before points are joined.
    let mut root: Vec<u32> = (0..count as u32).collect();
    for &step in order.iter().rev() {
        for record in log.records(step as usize).rev() {
            root[log.wedges[record] as usize] = root[log.targets[record] as usize];
        }
    }
    let mut last_use = vec![0; count];
    for (number, &step) in (1..).zip(order) {
        for record in log.records(step as usize) {
            last_use[root[log.targets[record] as usize] as usize] = number;
        }
        for &triangle in log.removals(step as usize) {
            for vertex in input.mesh.triangles()[triangle as usize] {
                last_use[root[input.wedge_of()[vertex as usize] as usize] as usize] = number;
            }
        }
    }
    last_use
}
