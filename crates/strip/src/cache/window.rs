//! Local search on a stretch of the drawing order: strips are joined, cut, moved, turned, or take
//! triangles from others, with simulated annealing. What a change costs is counted by sending the
//! changed stretch through the cache again, until the cache holds what it held before.

use super::paths::{Strip, Surface};
use crate::adjacency::decode;
use crate::anneal::{below, exp_minus};
use crate::cover::is_none;
use lodc_mesh::{NONE, SplitMix64};

/// The length and the temperatures of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// Changes to try, per triangle.
    pub(crate) proposals: f64,
    /// Triangles of a stretch, roughly.
    pub(crate) window: usize,
    /// Temperature at the start, in fetched vertices.
    pub(crate) warm: f64,
    /// Temperature at the end.
    pub(crate) cold: f64,
}

/// The farthest that a strip moves in one change, in strips.
const FAR: usize = 6;
/// The number of temperatures.
const STAGES: usize = 16;

/// The cache at some point: when each vertex was fetched last.
pub(crate) struct Fifo {
    fetched: Vec<u32>,
    clock: u32,
    size: u32,
}

impl Fifo {
    pub(crate) fn new(vertices: usize, size: u32) -> Self {
        Self { fetched: vec![0; vertices], clock: size, size }
    }
    /// Forgets everything, then fetches these.
    fn restart(&mut self, with: &[u32]) {
        self.clock += self.size;
        for &v in with {
            self.clock += 1;
            self.fetched[v as usize] = self.clock;
        }
    }
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
    /// The price of an index, in fetched vertices.
    price: f32,
    /// The strip of each triangle of the surface; [`NONE`] outside of the stretch.
    strip_of: Vec<u32>,
}

impl<'a> Workspace<'a> {
    /// Prepares the search on a surface of so many vertices, for a cache of `size`.
    pub(crate) fn new(
        surface: &'a Surface,
        vertices: usize,
        size: u32,
        price: f32,
        random: &'a mut SplitMix64,
    ) -> Self {
        let strip_of = vec![NONE; surface.triangles.len()];
        Self { surface, fifo: Fifo::new(vertices, size), random, price, strip_of }
    }
}

/// Strips that a change makes, by their numbers.
struct Made {
    strips: [u32; 2],
    count: usize,
}

impl Made {
    const NOTHING: Self = Self { strips: [0; 2], count: 0 };

    fn one(strip: u32) -> Self {
        Self { strips: [strip, 0], count: 1 }
    }

    fn two(a: u32, b: u32) -> Self {
        Self { strips: [a, b], count: 2 }
    }
}

/// A stretch of the drawing order.
pub(crate) struct Window<'w, 'a> {
    shared: &'w mut Workspace<'a>,
    /// Strips by number; those that are in use are in `sequence`.
    strips: Vec<Strip>,
    unused: Vec<u32>,
    sequence: Vec<u32>,
    /// Vertices fetched so far, and how many before each strip of the sequence, and before the
    /// tail, and in all.
    history: Vec<u32>,
    marks: Vec<usize>,
    /// Indices that are drawn after the stretch.
    tail: Vec<u32>,
    // Kept between changes to save allocations.
    trial: Vec<u32>,
    fresh: Vec<u32>,
    fresh_marks: Vec<usize>,
}

impl<'w, 'a> Window<'w, 'a> {
    /// Draws the stretch once, after `head` and before `tail`.
    pub(crate) fn new(
        shared: &'w mut Workspace<'a>,
        strips: Vec<Strip>,
        head: &[u32],
        tail: Vec<u32>,
    ) -> Self {
        let mut window = Self {
            shared,
            unused: Vec::new(),
            sequence: (0..strips.len() as u32).collect(),
            strips,
            history: Vec::new(),
            marks: Vec::new(),
            tail,
            trial: Vec::new(),
            fresh: Vec::new(),
            fresh_marks: Vec::new(),
        };
        window.shared.fifo.restart(&[]);
        window.shared.fifo.draw(head, &mut window.history);
        for (i, s) in window.strips.iter().enumerate() {
            window.marks.push(window.history.len());
            window.shared.fifo.draw(&s.indices, &mut window.history);
            for &c in &s.path {
                window.shared.strip_of[decode(c).0 as usize] = i as u32;
            }
        }
        window.marks.push(window.history.len());
        window.shared.fifo.draw(&window.tail, &mut window.history);
        window.marks.push(window.history.len());
        window
    }
    /// Searches, and gives back the strips in their new order.
    pub(crate) fn search(mut self, search: &Search) -> Vec<Strip> {
        let triangles: usize = self.strips.iter().map(|s| s.path.len()).sum();
        let proposals = (triangles as f64 * search.proposals) as usize;
        for stage in 0..STAGES {
            let share = stage as f64 / (STAGES - 1) as f64;
            let temperature = search.warm + (search.cold - search.warm) * share;
            for _ in proposals * stage / STAGES..proposals * (stage + 1) / STAGES {
                self.step(temperature);
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
    fn step(&mut self, temperature: f64) {
        let bits = self.shared.random.bits();
        let at = below(bits, self.sequence.len());
        self.trial.clone_from(&self.sequence);
        let made = match bits & 7 {
            0..=2 => self.propose_link(at, bits >> 3 & 0xff),
            3 => self.propose_cut(at, bits >> 3 & 0x1fff_ffff),
            4..=6 => self.propose_move(at, bits >> 3 & 0xff),
            _ => self.propose_turn(at),
        };
        let Some(made) = made else { return };
        let new = &made.strips[..made.count];
        if self.improves(temperature) {
            for &s in &self.sequence {
                // Strips that are gone: their triangles are in the new ones.
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
    /// Takes up a strip under a number of its own.
    fn add(&mut self, path: Vec<u32>) -> u32 {
        let strip = Strip { indices: self.shared.surface.indices(&path), path };
        match self.unused.pop() {
            Some(s) => {
                self.strips[s as usize] = strip;
                s
            }
            None => {
                self.strips.push(strip);
                self.strips.len() as u32 - 1
            }
        }
    }
    fn path(&self, s: u32) -> &[u32] {
        &self.strips[s as usize].path
    }
    fn propose_turn(&mut self, at: usize) -> Option<Made> {
        let path = self.path(self.sequence[at]);
        if path.len() == 1 {
            return None;
        }
        let turned = self.shared.surface.reversed(path);
        let s = self.add(turned);
        self.trial[at] = s;
        Some(Made::one(s))
    }
    fn propose_move(&mut self, at: usize, bits: u64) -> Option<Made> {
        let far = 1 + (bits >> 1) as usize % FAR;
        let to = if bits & 1 == 0 { at.checked_sub(far)? } else { at + far };
        if to >= self.trial.len() {
            return None;
        }
        let s = self.trial.remove(at);
        self.trial.insert(to, s);
        Some(Made::NOTHING)
    }
    fn propose_cut(&mut self, at: usize, bits: u64) -> Option<Made> {
        let path = self.path(self.sequence[at]);
        if path.len() < 2 {
            return None;
        }
        let place = 1 + (bits >> 1) as usize % (path.len() - 1);
        let (a, b) = cut(path, place);
        let (a, b) = (self.add(a), self.add(b));
        let (a, b) = if bits & 1 == 0 { (a, b) } else { (b, a) };
        self.trial[at] = a;
        self.trial.insert(at + 1, b);
        Some(Made::two(a, b))
    }
    /// Links an end of a strip to a neighbour in another, which is cut there if it goes on.
    fn propose_link(&mut self, at: usize, bits: u64) -> Option<Made> {
        let a = self.sequence[at];
        let from_end = bits & 1 == 0;
        let path = self.path(a);
        let x = decode(if from_end { path[path.len() - 1] } else { path[0] }).0;
        let slot = (bits >> 1 & 3) as u32 % 3;
        let c = self.shared.surface.neighbours[x as usize][slot as usize];
        if is_none(c) {
            return None;
        }
        let (y, _) = decode(c);
        let b = self.shared.strip_of[y as usize];
        if b == NONE || b == a {
            return None;
        }
        let other = self.path(b);
        let k = other.iter().position(|&c| decode(c).0 == y)?;
        // What follows y, or what comes before it, goes along.
        let forward =
            if other.len() == 1 { true } else { k == 0 || (k + 1 < other.len() && bits & 8 == 0) };
        let (part, rest) = if forward {
            let (rest, part) = cut(other, k);
            (part, rest)
        } else {
            let (part, rest) = cut(other, k + 1);
            (self.shared.surface.reversed(&part), rest)
        };
        let mut joined = if from_end { path.to_vec() } else { self.shared.surface.reversed(path) };
        let last = joined.len() - 1;
        joined[last] = crate::adjacency::code(x, slot);
        joined.extend(part);
        if bits & 16 != 0 {
            joined = self.shared.surface.reversed(&joined);
        }
        let there = self.sequence.iter().position(|&s| s == b)?;
        let joined = self.add(joined);
        let mut made = Made::one(joined);
        if rest.is_empty() {
            let (stay, go) = if bits & 32 == 0 { (at, there) } else { (there, at) };
            self.trial[stay] = joined;
            self.trial.remove(go);
        } else {
            let rest = self.add(rest);
            made = Made::two(joined, rest);
            self.trial[there] = rest;
            if bits & 32 == 0 {
                self.trial[at] = joined;
            } else {
                self.trial.insert(there + (bits >> 6 & 1) as usize, joined);
                self.trial.remove(if at < there { at } else { at + 1 });
            }
        }
        Some(made)
    }
    /// Returns whether the trial sequence is accepted. If so, the history is that of the trial.
    fn improves(&mut self, temperature: f64) -> bool {
        let (old, new) = (&self.sequence, &self.trial);
        let first = old.iter().zip(new).take_while(|(a, b)| a == b).count();
        let most = old.len().min(new.len()) - first;
        let same =
            old.iter().rev().zip(new.iter().rev()).take(most).take_while(|(a, b)| a == b).count();
        let count = |sequence: &[u32]| -> usize {
            sequence[first..sequence.len() - same]
                .iter()
                .map(|&s| self.strips[s as usize].indices.len())
                .sum()
        };
        let indices = count(new) as f32 - count(old) as f32;

        let size = self.shared.fifo.size as usize;
        let start = self.marks[first];
        self.shared.fifo.restart(&self.history[start.saturating_sub(size)..start]);
        self.fresh.clear();
        self.fresh.extend(&self.history[start.saturating_sub(size)..start]);
        let given = self.fresh.len();
        self.fresh_marks.clear();
        let shift = old.len() as isize - new.len() as isize;
        let mut joins = None;
        for i in first..=new.len() {
            let was = (i as isize + shift) as usize;
            if i + same >= new.len()
                && ends_alike(&self.fresh, &self.history[..self.marks[was]], size)
            {
                joins = Some(was);
                break;
            }
            self.fresh_marks.push(start + self.fresh.len() - given);
            let indices = new.get(i).map_or(&self.tail, |&s| &self.strips[s as usize].indices);
            self.shared.fifo.draw(indices, &mut self.fresh);
        }
        let end = start + self.fresh.len() - given;
        let joins = joins.unwrap_or(old.len() + 1);
        let misses = end as f32 - self.marks[joins] as f32;
        let delta = f64::from(misses + self.shared.price * indices);
        if delta > 0.0
            && (self.shared.random.bits() >> 32) as f64
                >= exp_minus(delta / temperature) * 4_294_967_296.0
        {
            return false;
        }
        let moved = end as isize - self.marks[joins] as isize;
        let rest = self.marks[joins];
        self.marks[joins..].iter_mut().for_each(|m| *m = (*m as isize + moved) as usize);
        self.marks.splice(first..joins, self.fresh_marks.iter().copied());
        self.history.splice(start..rest, self.fresh[given..].iter().copied());
        true
    }
}

/// Returns whether two caches hold the same vertices in the same order.
fn ends_alike(a: &[u32], b: &[u32], size: usize) -> bool {
    let tail = |h: &'_ [u32]| h.len().saturating_sub(size);
    a[tail(a)..] == b[tail(b)..]
}

/// A path in two: the first `place` triangles, and the others.
fn cut(path: &[u32], place: usize) -> (Vec<u32>, Vec<u32>) {
    let mut a = path[..place].to_vec();
    if let Some(last) = a.last_mut() {
        *last |= 3;
    }
    (a, path[place..].to_vec())
}
