//! Triangle order for vertex caches: fan after fan, each about the cached vertex where that pays
//! most (after Lin and Yu 2006, with the weights of our own).

use crate::front::{Front, Touch};
use lodc_mesh::{Mesh, NONE};

// What a fan is judged by, in fetched vertices. Found by trying, on three scans.
/// Per vertex that is thrown out with triangles left.
const EVICTED: f32 = 0.3;
/// For each vertex without triangles left.
const FINISHED: f32 = 0.2;
/// For each triangle.
const TRIANGLE: f32 = 0.5;
/// Per place in the cache: those that have to leave first have their turn first.
const AGE: f32 = 0.1;
/// So many vertices are tried, those that have to leave first. More gain nothing that can be
/// measured.
const TRIED: usize = 6;

/// The mesh's triangles in an order in which a first-in first-out cache of `cache_size` vertices (4
/// to 64; the nearest of those otherwise) seldom fetches a vertex twice. Triangles stay in their
/// submesh, and corners in their order.
#[must_use]
pub fn order(mesh: &Mesh, cache_size: u32) -> Vec<[u32; 3]> {
    let triangles = mesh.triangles();
    let mut front = Front::new(triangles, mesh.vertex_count(), cache_size.clamp(4, 64));
    let mut order: Vec<u32> = Vec::with_capacity(triangles.len());
    let mut cursor = 0;
    let mut fan = Vec::new();
    loop {
        let mut best: Option<(f32, u32)> = None;
        let recent = front.recent();
        let mut tried = 0;
        for miss in recent.clone() {
            let Some(v) = front.live(miss) else { continue };
            tried += 1;
            if tried > TRIED {
                break;
            }
            let mut cost = AGE * (miss - recent.start) as f32;
            for i in front.left(v) {
                let t = front.incident(i);
                if front.done[t as usize] {
                    continue;
                }
                for corner in front.triangles[t as usize] {
                    cost += match front.touch(corner) {
                        Touch::Hit => 0.0,
                        Touch::Miss => 1.0,
                        Touch::MissAndLoss => 1.0 + EVICTED,
                    };
                }
                cost -= TRIANGLE + FINISHED * front.draw(t) as f32;
            }
            front.undo();
            if best.is_none_or(|(c, _)| cost < c) {
                best = Some((cost, v));
            }
        }
        let next = best.map(|(_, v)| v).or_else(|| front.go_back()).or_else(|| {
            while cursor < triangles.len() && front.done[cursor] {
                cursor += 1;
            }
            triangles.get(cursor).map(|t| t[0])
        });
        let Some(v) = next else { break };
        fan.clear();
        fan.extend(front.left(v).map(|i| front.incident(i)).filter(|&t| !front.done[t as usize]));
        draw_fan(&mut front, &mut fan, &mut order);
    }
    let submesh = crate::cover::submesh_of(mesh);
    order.sort_by_key(|&t| submesh[t as usize]);
    order.iter().map(|&t| triangles[t as usize]).collect()
}

/// Draws the triangles of a fan, each time the one that needs the fewest vertices.
fn draw_fan(front: &mut Front<'_>, fan: &mut Vec<u32>, order: &mut Vec<u32>) {
    let mut last = [NONE; 3];
    while !fan.is_empty() {
        let key = |t: u32| {
            let corners = front.triangles[t as usize];
            let missing = corners.iter().filter(|&&v| !front.is_cached(v)).count();
            let shared = corners.iter().filter(|v| last.contains(v)).count();
            (missing, 3 - shared)
        };
        let (at, _) = fan.iter().enumerate().min_by_key(|(_, t)| key(**t)).expect("not empty");
        let t = fan.remove(at);
        last = front.triangles[t as usize];
        for v in last {
            front.touch(v);
        }
        front.draw(t);
        order.push(t);
    }
    front.keep();
}
