//! Triangle order for a vertex cache, greedily fan by fan: the next fan is around the cached vertex
//! where it costs least (after Lin and Yu 2006, K-Cache-Reorder, with weights of our own).

use crate::draw_state::{DrawState, Reference};
use lodc_mesh::{Mesh, NONE};
use std::borrow::Cow;

// What a fan is judged by, in fetched vertices. Chosen by misses on three scans.
/// Per vertex that is evicted with triangles to be drawn.
const EVICTED: f32 = 0.3;
/// Gain for each vertex that has no triangles to be drawn afterwards.
const FINISHED: f32 = 0.2;
/// Gain for each triangle.
const TRIANGLE: f32 = 0.5;
/// Per vertex that will leave the cache before the fan's: the oldest have their turn first.
const AGE: f32 = 0.1;
/// Number of vertices that are tried, those that leave the cache first. More gain nothing that can
/// be measured on three scans.
const MAX_TRIED: usize = 6;

/// The mesh's triangles in an order in which a first-in first-out cache of `cache_size` vertices (4
/// to 64; the nearest of those otherwise) seldom fetches a vertex twice. Triangles stay in their
/// submesh, and corners in their order.
#[must_use]
pub fn order(mesh: &Mesh, cache_size: u32) -> Vec<[u32; 3]> {
    let mut order = greedy_order(mesh.triangles(), mesh.vertex_count(), cache_size);
    let submesh = crate::cover::submesh_of(mesh);
    order.sort_by_key(|&t| submesh[t as usize]);
    order.iter().map(|&t| mesh.triangles()[t as usize]).collect()
}

/// [`order`] for a list of triangles over `vertices` vertices.
#[must_use]
pub fn order_list(triangles: &[[u32; 3]], vertices: usize, cache_size: u32) -> Vec<[u32; 3]> {
    let (compact, count) = renumbered(triangles, vertices);
    let order = greedy_order(&compact, count, cache_size);
    order.into_iter().map(|t| triangles[t as usize]).collect()
}

/// Returns triangles with vertices numbered in the order in which they were, without those between
/// that none uses, and how many there are; as they are where that saves nothing. A mesh may have
/// thousands of submeshes, and lists of all vertices for each would take quadratic time.
pub(crate) fn renumbered(triangles: &[[u32; 3]], vertices: usize) -> (Cow<'_, [[u32; 3]]>, usize) {
    if 3 * triangles.len() >= vertices {
        return (Cow::Borrowed(triangles), vertices);
    }
    let mut used = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let number = |v: u32| used.partition_point(|&other| other < v) as u32;
    (triangles.iter().map(|t| t.map(number)).collect(), used.len())
}

/// The numbers of triangles in the order in which they are drawn.
fn greedy_order(triangles: &[[u32; 3]], vertices: usize, cache_size: u32) -> Vec<u32> {
    let mut state = DrawState::new(triangles, vertices, cache_size.clamp(4, 64));
    let mut order: Vec<u32> = Vec::with_capacity(triangles.len());
    let mut cursor = 0;
    let mut fan = Vec::new();
    loop {
        let mut best: Option<(f32, u32)> = None;
        let recent = state.recent();
        let mut tried = 0;
        for miss in recent.clone() {
            let Some(v) = state.unfinished_at(miss) else { continue };
            tried += 1;
            if tried > MAX_TRIED {
                break;
            }
            let mut cost = AGE * (miss - recent.start) as f32;
            for i in state.unfinished(v) {
                let t = state.incident(i);
                if state.done[t as usize] {
                    continue;
                }
                for corner in state.triangles[t as usize] {
                    cost += match state.reference(corner) {
                        Reference::Hit => 0.0,
                        Reference::Miss => 1.0,
                        Reference::MissEvicting => 1.0 + EVICTED,
                    };
                }
                cost -= TRIANGLE + FINISHED * state.draw(t) as f32;
            }
            state.undo();
            if best.is_none_or(|(c, _)| cost < c) {
                best = Some((cost, v));
            }
        }
        let next = best.map(|(_, v)| v).or_else(|| state.last_unfinished()).or_else(|| {
            while cursor < triangles.len() && state.done[cursor] {
                cursor += 1;
            }
            triangles.get(cursor).map(|t| t[0])
        });
        let Some(v) = next else { break };
        fan.clear();
        fan.extend(
            state.unfinished(v).map(|i| state.incident(i)).filter(|&t| !state.done[t as usize]),
        );
        draw_fan(&mut state, &mut fan, &mut order);
    }
    order
}

/// Draws the triangles of a fan, each time the one that needs the fewest vertices.
fn draw_fan(state: &mut DrawState<'_>, fan: &mut Vec<u32>, order: &mut Vec<u32>) {
    let mut last_drawn = [NONE; 3];
    while !fan.is_empty() {
        let key = |t: u32| {
            let corners = state.triangles[t as usize];
            let missing = corners.iter().filter(|&&v| !state.is_cached(v)).count();
            let shared = corners.iter().filter(|v| last_drawn.contains(v)).count();
            (missing, 3 - shared)
        };
        let (at, _) = fan.iter().enumerate().min_by_key(|(_, t)| key(**t)).expect("not empty");
        let t = fan.remove(at);
        last_drawn = state.triangles[t as usize];
        for v in last_drawn {
            state.reference(v);
        }
        state.draw(t);
        order.push(t);
    }
    state.commit();
}
