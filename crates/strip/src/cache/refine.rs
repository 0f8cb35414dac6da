//! The local search along the whole drawing order, in chunks that do not depend on each other.

use super::paths::{Strip, Surface};
use super::window::{Fifo, Search, Window};
use crate::adjacency::{NONE, code, decode};
use crate::anneal::Random;
use crate::cover::{Cover, is_none};
use rayon::prelude::*;

/// Triangles of a chunk: what a thread works on at a time.
const CHUNK: usize = 1 << 12;
/// Indices before a stretch that fill the cache, and indices after it that are counted too.
const HEAD: usize = 160;
const TAIL: usize = 48;

/// Improves strips, given as paths in drawing order, and writes them down.
pub(crate) fn refine(
    paths: &[Vec<u32>],
    triangles: &[[u32; 3]],
    cover: &Cover,
    size: u32,
    price: f32,
    searches: &[Search],
) -> Vec<(u32, Vec<u32>)> {
    let mut chunks = Vec::new();
    let (mut start, mut sum) = (0, 0);
    for (i, path) in paths.iter().enumerate() {
        sum += path.len();
        if sum >= CHUNK || i + 1 == paths.len() {
            chunks.push((start, i + 1));
            (start, sum) = (i + 1, 0);
        }
    }
    let mut place = vec![NONE; triangles.len()];
    for &(start, end) in &chunks {
        let all = paths[start..end].iter().flatten();
        all.enumerate().for_each(|(i, &c)| place[decode(c).0 as usize] = i as u32);
    }
    let mut chunk_of = vec![NONE; triangles.len()];
    for (i, &(start, end)) in chunks.iter().enumerate() {
        paths[start..end].iter().flatten().for_each(|&c| chunk_of[decode(c).0 as usize] = i as u32);
    }
    let work = |(number, &(start, end)): (usize, &(usize, usize))| {
        let all: Vec<u32> = paths[start..end].iter().flatten().map(|&c| decode(c).0).collect();
        // What is drawn before and after the chunk, as it is drawn now.
        let written = |path: &Vec<u32>| {
            let mut indices = Vec::new();
            cover.write_forward(path, triangles, &mut indices);
            indices
        };
        let mut head: Vec<Vec<u32>> = Vec::new();
        let mut length = 0;
        for path in paths[..start].iter().rev() {
            if length >= HEAD {
                break;
            }
            head.push(written(path));
            length += path.len();
        }
        let mut head: Vec<u32> = head.into_iter().rev().flatten().collect();
        let mut tail: Vec<u32> =
            paths[end..].iter().take(TAIL).flat_map(written).take(TAIL).collect();

        let mut vertices: Vec<u32> = all.iter().flat_map(|&t| triangles[t as usize]).collect();
        vertices.extend(head.iter().chain(&tail));
        vertices.sort_unstable();
        vertices.dedup();
        let local =
            |v: u32| vertices.binary_search(&v).expect("gathered from the same triangles") as u32;
        head.iter_mut().chain(&mut tail).for_each(|v| *v = local(*v));
        let near = |c: u32| {
            if is_none(c) {
                return NONE;
            }
            let (u, slot) = decode(c);
            if chunk_of[u as usize] == number as u32 { code(place[u as usize], slot) } else { NONE }
        };
        let surface = Surface {
            triangles: all.iter().map(|&t| triangles[t as usize].map(local)).collect(),
            neighbours: all
                .iter()
                .map(|&t| [0, 1, 2].map(|slot| near(cover.neighbour(t, slot))))
                .collect(),
        };
        let mut strips: Vec<Strip> = paths[start..end]
            .iter()
            .map(|path| {
                let path = path
                    .iter()
                    .map(|&c| code(place[decode(c).0 as usize], decode(c).1))
                    .collect::<Vec<_>>();
                Strip { indices: surface.indices(&path), path }
            })
            .collect();
        let mut random = Random::new(number as u64);
        for search in searches {
            improve(&surface, &mut strips, (&head, &tail), size, price, search, &mut random);
        }
        let global = |s: &Strip| {
            let first = all[decode(s.path[0]).0 as usize];
            (first, s.indices.iter().map(|&v| vertices[v as usize]).collect::<Vec<_>>())
        };
        strips.iter().map(global).collect::<Vec<_>>()
    };
    let done: Vec<Vec<(u32, Vec<u32>)>> = chunks.par_iter().enumerate().map(work).collect();
    done.into_iter().flatten().collect()
}

/// Searches in stretches that overlap by half.
fn improve(
    surface: &Surface,
    strips: &mut Vec<Strip>,
    (head, tail): (&[u32], &[u32]),
    size: u32,
    price: f32,
    search: &Search,
    random: &mut Random,
) {
    let vertices = surface
        .triangles
        .iter()
        .flatten()
        .chain(head)
        .chain(tail)
        .max()
        .map_or(0, |&v| v as usize + 1);
    let mut fifo = Fifo::new(vertices, size);
    let mut strip_of = vec![u32::MAX; surface.triangles.len()];
    let mut done: Vec<Strip> = Vec::new();
    let mut waiting: std::collections::VecDeque<Strip> = std::mem::take(strips).into();
    let mut stretch: Vec<Strip> = Vec::new();
    // Each triangle is in two stretches.
    let half = Search { proposals: search.proposals / 2.0, ..*search };
    loop {
        let mut triangles: usize = stretch.iter().map(|s| s.path.len()).sum();
        while triangles < search.window {
            let Some(s) = waiting.pop_front() else { break };
            triangles += s.path.len();
            stretch.push(s);
        }
        let mut before: Vec<u32> = Vec::new();
        let mut from = done.len();
        let mut length = 0;
        while from > 0 && length < HEAD {
            from -= 1;
            length += done[from].indices.len();
        }
        if from == 0 {
            before.extend(head);
        }
        before.extend(done[from..].iter().flat_map(|s| &s.indices));
        let after = waiting
            .iter()
            .take(TAIL)
            .flat_map(|s| &s.indices)
            .chain(tail)
            .take(TAIL)
            .copied()
            .collect();
        let parts = (surface, &mut fifo, &mut *random, strip_of.as_mut_slice());
        stretch = Window::new(parts, price, stretch, &before, after).search(&half);
        if waiting.is_empty() {
            done.extend(stretch);
            break;
        }
        let mut out = 0;
        let mut drop = 0;
        while out < stretch.len() && drop < triangles / 2 {
            drop += stretch[out].path.len();
            out += 1;
        }
        done.extend(stretch.drain(..out));
    }
    *strips = done;
}
