//! Runs the local search (`search`) on regions of a cover, several at once.
//!
//! A region is a number of whole strips that lie together. Its strips are joined and divided among
//! themselves only: so regions are independent, no strip can close into a ring through another
//! region, and the result is the same for any number of threads. Each round divides the surface in
//! another way, so that strips can be joined across the borders of the round before.

use super::search::{Region, Round, search};
use crate::adjacency::{code, decode};
use crate::cover::{Cover, LINKS, is_none};
use crate::meter::Meter;
use lodc_mesh::NONE;
use rayon::prelude::*;

/// Triangles of a region, roughly: with 13 bytes each they fit a second-level cache. Chosen by
/// hand.
const REGION_TRIANGLES: usize = 1 << 13;
/// The list of strips is divided into this many equal shares; each pair of rounds begins at another
/// one. Chosen by hand.
const START_SHARES: usize = 7;

/// Runs all rounds.
pub(crate) fn improve(cover: &mut Cover, rounds: &[Round], meter: &Meter<'_>) {
    for (i, round) in rounds.iter().enumerate() {
        let (order, ends) = divide(cover, i);
        let mut index_in_order = vec![NONE; cover.nodes.len()];
        for (i, &t) in order.iter().enumerate() {
            index_in_order[t as usize] = i as u32;
        }
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let regions: Vec<(usize, usize)> = starts.zip(ends.iter().copied()).collect();
        let links: Vec<Vec<u8>> = regions
            .par_iter()
            .map(|&(start, end)| {
                let mut region =
                    local_region(cover, &order[start..end], &index_in_order, start, end);
                search(&mut region, round, (i as u64) << 32 | start as u64);
                meter.add(end - start);
                region.links
            })
            .collect();
        for (&t, &links) in order.iter().zip(links.iter().flatten()) {
            cover.nodes[t as usize][LINKS] = u32::from(links);
        }
    }
}

/// The triangles of a region with their neighbours in the region, numbered in the region's order.
fn local_region(
    cover: &Cover,
    order: &[u32],
    index_in_order: &[u32],
    start: usize,
    end: usize,
) -> Region {
    let local = |c: u32| {
        if is_none(c) {
            return NONE;
        }
        let (u, slot) = decode(c);
        let index = index_in_order[u as usize] as usize;
        if (start..end).contains(&index) { code((index - start) as u32, slot) } else { NONE }
    };
    let node = |&t: &u32| {
        let [a, b, c, links] = cover.nodes[t as usize];
        ([a, b, c].map(local), links as u8)
    };
    let (neighbours, links) = order.iter().map(node).unzip();
    Region { neighbours, links }
}

/// All triangles, region by region and strip by strip, and where each region ends. Regions grow
/// over the surface from strip to strip.
///
/// Each round starts with another strip and has regions of another size, so that borders of one
/// round lie inside regions of the next: the six rounds of the most thorough effort differ in the
/// first strip (both ends of the list, moved on by a seventh of it after every two rounds) and have
/// four sizes. The shares are chosen by hand; any that differ do.
fn divide(cover: &Cover, round: usize) -> (Vec<u32>, Vec<usize>) {
    let n = cover.nodes.len();
    let mut order = Vec::with_capacity(n);
    let mut ends = Vec::new();
    // Both ends of every strip, where a region may begin.
    let mut seeds: Vec<u32> = (0..n as u32).filter(|&t| cover.is_end(t)).collect();
    if round % 2 == 1 {
        seeds.reverse();
    }
    let first = seeds.len() / START_SHARES * (round / 2 % START_SHARES);
    seeds.rotate_left(first);
    let mut visited = vec![false; n];
    let mut path = Vec::new();
    let mut start = 0;
    let mut queue = std::collections::VecDeque::new();
    for seed in seeds {
        queue.push_back(seed);
        while let Some(t) = queue.pop_front() {
            if visited[t as usize] {
                continue;
            }
            if order.len() - start >= REGION_TRIANGLES - REGION_TRIANGLES / 8 * (round % 4) {
                ends.push(order.len());
                start = order.len();
                // The next region begins with the strip at hand. What is queued was next to this
                // region, on all sides of it, and would give the next one several parts.
                queue.clear();
            }
            cover.path(end_of(cover, t), &mut path);
            for &c in &path {
                let (u, _) = decode(c);
                visited[u as usize] = true;
                order.push(u);
            }
            for &c in &path {
                let (u, _) = decode(c);
                for slot in 0..3 {
                    let c = cover.neighbour(u, slot);
                    if !is_none(c) && !visited[decode(c).0 as usize] {
                        queue.push_back(decode(c).0);
                    }
                }
            }
        }
    }
    if order.len() > start {
        ends.push(order.len());
    }
    (order, ends)
}

/// An end of the strip of a triangle.
fn end_of(cover: &Cover, t: u32) -> u32 {
    let links = cover.links(t);
    if links.count_ones() < 2 {
        return t;
    }
    let (mut current, mut exit) = (t, Some(links.trailing_zeros()));
    while let Some(slot) = exit {
        let (next, entered) = decode(cover.neighbour(current, slot));
        current = next;
        exit = cover.other(next, entered);
    }
    current
}
