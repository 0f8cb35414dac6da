//! Simulated annealing on a stretch of the drawing order: strips take triangles from others, or
//! are reversed. The cost of a change, in fetched vertices and indices, is counted by sending the
//! changed stretch through the cache again, until the cache holds what it held before.

use super::paths::{Strip, Surface};
use crate::adjacency::decode;
use crate::anneal::{below, exp_minus};
use crate::cover::is_none;
use lodc_mesh::{NONE, SplitMix64};

/// The length and the temperatures of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    /// Changes to try, per triangle.
    pub(crate) proposals: f64,
    /// Triangles of a stretch, roughly.
    pub(crate) stretch: usize,
    /// Temperature at the start, in fetched vertices.
    pub(crate) start_temperature: f64,
    /// Temperature at the end, in the same unit.
    pub(crate) end_temperature: f64,
}

/// One proposal in this many reverses a strip, all others link two strips. Proposals that only cut
/// a strip, or move it among the others, never paid: links do both on the way. The share is chosen
/// by hand.
const REVERSE_ONE_IN: u64 = 16;
/// Fetched vertices that a change may still save after the strips that it changes. Where it has
/// lost more than that and than chance allows, it is refused before the rest is counted: counting
/// to the end takes a seventh more time and gains nothing that can be measured.
const MAX_REGAINED: f32 = 1.0;
/// The number of temperatures, which fall linearly. Chosen by hand.
const STAGES: usize = 16;

/// The cache at some point: when each vertex was fetched last.
pub(crate) struct Fifo {
    /// For each vertex the number of the fetch that brought it last.
    fetched: Vec<u32>,
    /// The number of the last fetch.
    clock: u32,
    /// Number of vertices that the cache holds.
    size: u32,
}

impl Fifo {
    pub(crate) fn new(vertices: usize, size: u32) -> Self {
        Self { fetched: vec![0; vertices], clock: size, size }
    }
    /// Forgets everything, then fetches some vertices.
    fn restart(&mut self, contents: &[u32]) {
        self.clock += self.size;
        for &v in contents {
            self.clock += 1;
            self.fetched[v as usize] = self.clock;
        }
    }
    /// Draws indices and appends the vertices that are fetched for them.
    fn draw(&mut self, indices: &[u32], misses: &mut Vec<u32>) {
        for &v in indices {
            if self.clock - self.fetched[v as usize] >= self.size {
                self.clock += 1;
                self.fetched[v as usize] = self.clock;
                misses.push(v);
            }
        }
    }
}

/// The state that the stretches of one surface share, one after the other.
pub(crate) struct Workspace<'a> {
    surface: &'a Surface,
    fifo: Fifo,
    random: &'a mut SplitMix64,
    /// The strip of each triangle of the surface; [`NONE`] outside of the stretch.
    strip_of: Vec<u32>,
}

impl<'a> Workspace<'a> {
    /// Prepares the search on a surface with a number of vertices, for a cache of `size`.
    pub(crate) fn new(
        surface: &'a Surface,
        vertices: usize,
        size: u32,
        random: &'a mut SplitMix64,
    ) -> Self {
        let strip_of = vec![NONE; surface.triangles.len()];
        Self { surface, fifo: Fifo::new(vertices, size), random, strip_of }
    }
}

/// The one or two strips that a proposed change adds, by their numbers.
struct NewStrips {
    strips: [u32; 2],
    count: usize,
}

impl NewStrips {
    fn one(strip: u32) -> Self {
        Self { strips: [strip, 0], count: 1 }
    }

    fn two(a: u32, b: u32) -> Self {
        Self { strips: [a, b], count: 2 }
    }
}

/// A stretch of the drawing order.
pub(crate) struct Stretch<'w, 'a> {
    shared: &'w mut Workspace<'a>,
    /// Strips by number; those that are in use are in `sequence`.
    strips: Vec<Strip>,
    unused: Vec<u32>,
    sequence: Vec<u32>,
    /// The vertices that drawing the head, the stretch and the tail fetches, in order.
    history: Vec<u32>,
    /// The length of the history before each strip of the sequence, before the tail, and at its
    /// end.
    marks: Vec<usize>,
    /// Indices that are drawn after the stretch.
    tail: Vec<u32>,
    /// The sequence with a proposed change.
    trial: Vec<u32>,
    /// What it fetches from the first strip that differs on, behind the cache's contents there.
    trial_history: Vec<u32>,
    trial_marks: Vec<usize>,
}

impl<'w, 'a> Stretch<'w, 'a> {
    /// Draws the stretch once, after `head` and before `tail`.
    pub(crate) fn new(
        shared: &'w mut Workspace<'a>,
        strips: Vec<Strip>,
        head: &[u32],
        tail: Vec<u32>,
    ) -> Self {
        let mut stretch = Self {
            shared,
            unused: Vec::new(),
            sequence: (0..strips.len() as u32).collect(),
            strips,
            history: Vec::new(),
            marks: Vec::new(),
            tail,
            trial: Vec::new(),
            trial_history: Vec::new(),
            trial_marks: Vec::new(),
        };
        stretch.shared.fifo.restart(&[]);
        stretch.shared.fifo.draw(head, &mut stretch.history);
        for (i, s) in stretch.strips.iter().enumerate() {
            stretch.marks.push(stretch.history.len());
            stretch.shared.fifo.draw(&s.indices, &mut stretch.history);
            for &c in &s.path {
                stretch.shared.strip_of[decode(c).0 as usize] = i as u32;
            }
        }
        stretch.marks.push(stretch.history.len());
        stretch.shared.fifo.draw(&stretch.tail, &mut stretch.history);
        stretch.marks.push(stretch.history.len());
        stretch
    }
    /// Searches, and gives back the strips in their new order.
    pub(crate) fn search(mut self, schedule: &Schedule) -> Vec<Strip> {
        let triangles: usize = self.strips.iter().map(|s| s.path.len()).sum();
        let proposals = (triangles as f64 * schedule.proposals) as usize;
        for stage in 0..STAGES {
            let share = stage as f64 / (STAGES - 1) as f64;
            let temperature = schedule.start_temperature
                + (schedule.end_temperature - schedule.start_temperature) * share;
            for _ in proposals * stage / STAGES..proposals * (stage + 1) / STAGES {
                self.try_change(temperature);
            }
        }
        for s in &self.sequence {
            for &c in &self.strips[*s as usize].path {
                self.shared.strip_of[decode(c).0 as usize] = NONE;
            }
        }
        let mut strips = self.strips;
        self.sequence.iter().map(|&s| std::mem::take(&mut strips[s as usize])).collect()
    }
    /// Proposes a random change, and makes it if it is accepted.
    fn try_change(&mut self, temperature: f64) {
        let bits = self.shared.random.bits();
        let position = below(bits, self.sequence.len());
        self.trial.clone_from(&self.sequence);
        let proposed = if bits.is_multiple_of(REVERSE_ONE_IN) {
            self.propose_reversal(position)
        } else {
            self.propose_link(position, bits >> 4 & 0xff)
        };
        let Some(proposed) = proposed else { return };
        let new = &proposed.strips[..proposed.count];
        if self.accept(temperature) {
            for &s in &self.sequence {
                // Its triangles are in the new ones.
                if !self.trial.contains(&s) {
                    self.unused.push(s);
                }
            }
            std::mem::swap(&mut self.sequence, &mut self.trial);
            for &s in new {
                for &c in &self.strips[s as usize].path {
                    self.shared.strip_of[decode(c).0 as usize] = s;
                }
            }
        } else {
            self.unused.extend(new);
        }
    }
    /// Adds a strip, of which `write` appends the path. Returns its number.
    fn add(&mut self, write: impl FnOnce(&Self, &mut Vec<u32>)) -> u32 {
        let s = self.unused.pop().unwrap_or_else(|| {
            self.strips.push(Strip::default());
            self.strips.len() as u32 - 1
        });
        let Strip { mut path, mut indices } = std::mem::take(&mut self.strips[s as usize]);
        path.clear();
        write(self, &mut path);
        indices.clear();
        self.shared.surface.write_indices(&path, &mut indices);
        self.strips[s as usize] = Strip { path, indices };
        s
    }
    fn path(&self, s: u32) -> &[u32] {
        &self.strips[s as usize].path
    }
    /// Reverses a strip.
    fn propose_reversal(&mut self, position: usize) -> Option<NewStrips> {
        let old = self.sequence[position];
        if self.path(old).len() == 1 {
            return None;
        }
        let s = self.add(|stretch, path| stretch.write_reversed(stretch.path(old), path));
        self.trial[position] = s;
        Some(NewStrips::one(s))
    }
    fn write_reversed(&self, path: &[u32], reversed: &mut Vec<u32>) {
        self.shared.surface.write_reversed(path, reversed);
    }
    /// Links an end of strip `a` to a neighbouring triangle, the target, in another strip `b`,
    /// which is cut there if it goes on.
    ///
    /// Of the random bits (lowest first) bit 0 chooses the end of `a`, bits 1 and 2 its slot, bit 3
    /// which part of `b` is joined, bit 4 which of the two comes first, and bits 5 and 6 where the
    /// result goes in the drawing order.
    fn propose_link(&mut self, a_position: usize, bits: u64) -> Option<NewStrips> {
        let a = self.sequence[a_position];
        let from_end = bits & 1 == 0;
        let path = self.path(a);
        let end_triangle = decode(if from_end { path[path.len() - 1] } else { path[0] }).0;
        let slot = (bits >> 1 & 3) as u32 % 3;
        let target_code = self.shared.surface.neighbours[end_triangle as usize][slot as usize];
        if is_none(target_code) {
            return None;
        }
        let (target, _) = decode(target_code);
        let b = self.shared.strip_of[target as usize];
        if b == NONE || b == a {
            return None;
        }
        let b_path = self.path(b);
        let target_index =
            b_path.iter().position(|&target_code| decode(target_code).0 == target)?;
        // What follows the target in `b`, or what comes before it, is joined with it.
        let length = b_path.len();
        let forward =
            length == 1 || target_index == 0 || (target_index + 1 < length && bits & 8 == 0);
        let (part, rest) = if forward {
            (target_index..length, 0..target_index)
        } else {
            (0..target_index + 1, target_index + 1..length)
        };
        let (b_position, target_first) =
            (self.sequence.iter().position(|&s| s == b)?, bits & 16 != 0);
        // From the far end of one strip to that of the other, or back.
        let joined = self.add(|stretch, path| {
            let (whole_a, part_of_b) = (stretch.path(a), &stretch.path(b)[part.clone()]);
            let push_a = |path: &mut Vec<u32>, reversed: bool| {
                if reversed { stretch.write_reversed(whole_a, path) } else { path.extend(whole_a) }
            };
            let push_b = |path: &mut Vec<u32>, reversed: bool| {
                if reversed {
                    stretch.write_reversed(part_of_b, path);
                } else {
                    push_last(path, part_of_b);
                }
            };
            // The first of the two is linked to the second through its last slot.
            let link = if target_first { decode(target_code).1 } else { slot };
            if target_first {
                push_b(path, forward);
            } else {
                push_a(path, !from_end);
            }
            if let Some(last) = path.last_mut() {
                *last = *last & !3 | link;
            }
            if target_first {
                push_a(path, from_end);
            } else {
                push_b(path, !forward);
            }
        });
        let mut new = NewStrips::one(joined);
        if rest.is_empty() {
            let (replaced, removed) =
                if bits & 32 == 0 { (a_position, b_position) } else { (b_position, a_position) };
            self.trial[replaced] = joined;
            self.trial.remove(removed);
        } else {
            let rest = self.add(|stretch, path| push_last(path, &stretch.path(b)[rest]));
            new = NewStrips::two(joined, rest);
            self.trial[b_position] = rest;
            if bits & 32 == 0 {
                self.trial[a_position] = joined;
            } else {
                self.trial.insert(b_position + (bits >> 6 & 1) as usize, joined);
                self.trial.remove(if a_position < b_position {
                    a_position
                } else {
                    a_position + 1
                });
            }
        }
        Some(new)
    }
    /// Decides whether the trial sequence is accepted, by the rule of Metropolis. If so, the
    /// history becomes that of the trial.
    ///
    /// Only what differs is drawn: from the first strip that does, with the cache's contents of
    /// then, to the first after the last at which the cache holds what it held there before.
    /// Behind, the old history still holds.
    fn accept(&mut self, temperature: f64) -> bool {
        let (old, new) = (&self.sequence, &self.trial);
        let first = old.iter().zip(new).take_while(|(a, b)| a == b).count();
        let max_equal = old.len().min(new.len()) - first;
        let equal_at_end = old
            .iter()
            .rev()
            .zip(new.iter().rev())
            .take(max_equal)
            .take_while(|(a, b)| a == b)
            .count();
        let count = |sequence: &[u32]| -> usize {
            sequence[first..sequence.len() - equal_at_end]
                .iter()
                .map(|&s| self.strips[s as usize].indices.len())
                .sum()
        };
        let indices = count(new) as f32 - count(old) as f32;

        let size = self.shared.fifo.size as usize;
        let start = self.marks[first];
        self.shared.fifo.restart(&self.history[start.saturating_sub(size)..start]);
        self.trial_history.clear();
        self.trial_history.extend(&self.history[start.saturating_sub(size)..start]);
        let cached = self.trial_history.len();
        self.trial_marks.clear();
        let shift = old.len() as isize - new.len() as isize;
        // The mark in the old history at which both caches are alike.
        let mut rejoins = None;
        // Drawn once, so that refusing early and in the end agree.
        let random = (self.shared.random.bits() >> 32) as f64;
        let refuses = |misses: f32| {
            // An index costs as much as a fetched vertex.
            let delta = f64::from(misses + indices);
            delta > 0.0 && random >= exp_minus(delta / temperature) * 4_294_967_296.0
        };
        for i in first..=new.len() {
            let old_strip = (i as isize + shift) as usize;
            if i + equal_at_end >= new.len() {
                if ends_alike(&self.trial_history, &self.history[..self.marks[old_strip]], size) {
                    rejoins = Some(old_strip);
                    break;
                }
                let lost = (start + self.trial_history.len() - cached) as f32
                    - self.marks[old_strip] as f32;
                if refuses(lost - MAX_REGAINED) {
                    return false;
                }
            }
            self.trial_marks.push(start + self.trial_history.len() - cached);
            let indices = new.get(i).map_or(&self.tail, |&s| &self.strips[s as usize].indices);
            self.shared.fifo.draw(indices, &mut self.trial_history);
        }
        let end = start + self.trial_history.len() - cached;
        let rejoins = rejoins.unwrap_or(old.len() + 1);
        let misses = end as f32 - self.marks[rejoins] as f32;
        if refuses(misses) {
            return false;
        }
        let moved = end as isize - self.marks[rejoins] as isize;
        let tail_start = self.marks[rejoins];
        self.marks[rejoins..].iter_mut().for_each(|m| *m = (*m as isize + moved) as usize);
        self.marks.splice(first..rejoins, self.trial_marks.iter().copied());
        self.history.splice(start..tail_start, self.trial_history[cached..].iter().copied());
        true
    }
}

/// Returns whether two caches hold the same vertices in the same order.
fn ends_alike(a: &[u32], b: &[u32], size: usize) -> bool {
    let tail = |h: &'_ [u32]| h.len().saturating_sub(size);
    a[tail(a)..] == b[tail(b)..]
}

/// Appends a part of a path as the end of a path: its last triangle is not left through any slot.
fn push_last(path: &mut Vec<u32>, part: &[u32]) {
    path.extend(part);
    if let Some(last) = path.last_mut() {
        *last |= 3;
    }
}
