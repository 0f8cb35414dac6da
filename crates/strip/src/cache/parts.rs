//! Parts of a mesh that are drawn one after the other, so that strips of several are begun at once.

use crate::adjacency::{Neighbours, code, decode};
use crate::cover::Cover;
use lodc_mesh::{NONE, is_degenerate};
use std::collections::VecDeque;

/// The most triangles of a part. No strip crosses the border between two, so that large ones are
/// better: halves of this cost 0.3 % more indices and 1 % more misses than the whole (bunny).
const PART: usize = 1 << 16;

/// A part with triangles and vertices numbered by itself.
pub(super) struct Part {
    /// The triangles of the mesh.
    pub(super) of: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) vertices: usize,
    /// Without links.
    pub(super) cover: Cover,
}

/// Divides the triangles that have an area into parts that grow over the surface. They follow from
/// the mesh alone.
pub(super) fn divide(
    triangles: &[[u32; 3]],
    neighbours: &Neighbours,
    vertex_count: usize,
) -> Vec<Part> {
    let order = grown(triangles, neighbours);
    let mut place = vec![NONE; triangles.len()];
    for (i, &t) in (0..).zip(&order) {
        place[t as usize] = i;
    }
    // All alike: a small rest would be nothing but border.
    let size = order.len().div_ceil(order.len().div_ceil(PART).max(1)).max(1);
    // The number of each vertex in the part that had it last.
    let (mut number, mut part_of) = (vec![0; vertex_count], vec![NONE; vertex_count]);
    let parts = (0..).zip(order.chunks(size)).map(|(part, of)| {
        let first = part * size as u32;
        let local = |c: u32| {
            let (u, slot) = decode(c);
            let at = if c == NONE { NONE } else { place[u as usize].wrapping_sub(first) };
            if (at as usize) < of.len() { code(at, slot) } else { NONE }
        };
        let mut vertices = 0;
        let mut corner = |v: u32| {
            if std::mem::replace(&mut part_of[v as usize], part) != part {
                number[v as usize] = vertices;
                vertices += 1;
            }
            number[v as usize]
        };
        Part {
            triangles: of.iter().map(|&t| triangles[t as usize].map(&mut corner)).collect(),
            cover: Cover::new(of.iter().map(|&t| neighbours[t as usize].map(local))),
            vertices: vertices as usize,
            of: of.to_vec(),
        }
    });
    parts.collect()
}

/// The triangles that have an area, each beside one before it where that can be.
fn grown(triangles: &[[u32; 3]], neighbours: &Neighbours) -> Vec<u32> {
    let mut taken: Vec<bool> = triangles.iter().map(|&t| is_degenerate(t)).collect();
    let (mut order, mut waiting) = (Vec::with_capacity(triangles.len()), VecDeque::new());
    for seed in 0..triangles.len() as u32 {
        if std::mem::replace(&mut taken[seed as usize], true) {
            continue;
        }
        waiting.push_back(seed);
        while let Some(t) = waiting.pop_front() {
            order.push(t);
            for &c in neighbours[t as usize].iter().filter(|&&c| c != NONE) {
                let (u, _) = decode(c);
                if !std::mem::replace(&mut taken[u as usize], true) {
                    waiting.push_back(u);
                }
            }
        }
    }
    order
}
