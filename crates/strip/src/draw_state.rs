//! The state of a greedy generator of drawing orders (`cache::greedy`, `order`): which triangles
//! each vertex still has to be drawn in, and what a first-in first-out cache holds.
//!
//! A generator tries orders by drawing them and taking that back ([`DrawState::undo`]), and keeps
//! one ([`DrawState::commit`]). Undoing restores the cache and the triangles. It need not restore
//! what [`DrawState::unfinished`] and [`DrawState::last_unfinished`] skip, as generators call these
//! between trials only, when all that is done stays done.

use lodc_mesh::is_degenerate;

/// Number of entries of a vertex's list of triangles that are offered at a time. Vertices of
/// surfaces have about six; of one with a million, offering all each time would take quadratic
/// time. Chosen by hand.
const MAX_OFFERED: usize = 24;

/// A vertex.
#[derive(Clone, Copy, Default)]
pub(crate) struct Vertex {
    /// The number of the miss that fetched it last, from 1; 0 for never.
    pub(crate) fetched: u32,
    /// Number of its triangles that are not drawn.
    pub(crate) remaining: u32,
}

/// What a reference to a vertex does to the cache.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reference {
    /// The vertex was there.
    Hit,
    /// It was fetched.
    Miss,
    /// It was fetched, and a vertex was evicted that has triangles to be drawn.
    MissEvicting,
}

/// The triangles of a mesh while they are being drawn, and the cache.
pub(crate) struct DrawState<'a> {
    pub(crate) triangles: &'a [[u32; 3]],
    /// Number of vertices that the cache holds.
    pub(crate) cache_size: u32,
    pub(crate) vertices: Vec<Vertex>,
    /// The triangles of each vertex, those with an area, vertex by vertex.
    incident: Vec<u32>,
    /// For each vertex the start in `incident` of its triangles, of which those that are known to
    /// be done are skipped, and the end.
    next_unfinished: Vec<u32>,
    end: Vec<u32>,
    /// The vertex of each miss.
    pub(crate) history: Vec<u32>,
    /// Vertices in the order in which they were fetched: when no vertex in the cache has triangles,
    /// the last of these that has goes on.
    fallback: Vec<u32>,
    pub(crate) done: Vec<bool>,
    /// Vertices fetched in the present trial, with the numbers of the misses before.
    fetched_in_trial: Vec<(u32, u32)>,
    /// Triangles drawn in it.
    drawn_in_trial: Vec<u32>,
}

impl<'a> DrawState<'a> {
    pub(crate) fn new(triangles: &'a [[u32; 3]], vertex_count: usize, cache_size: u32) -> Self {
        let mut vertices = vec![Vertex::default(); vertex_count];
        let with_area = || triangles.iter().enumerate().filter(|(_, t)| !is_degenerate(**t));
        for v in with_area().flat_map(|(_, t)| t) {
            vertices[*v as usize].remaining += 1;
        }
        let mut sum = 0;
        let mut next_unfinished = Vec::with_capacity(vertex_count);
        for v in &vertices {
            next_unfinished.push(sum);
            sum += v.remaining;
        }
        let mut end = next_unfinished.clone();
        let mut incident = vec![0; sum as usize];
        for (i, t) in with_area() {
            for &v in t {
                incident[end[v as usize] as usize] = i as u32;
                end[v as usize] += 1;
            }
        }
        Self {
            triangles,
            cache_size,
            vertices,
            incident,
            next_unfinished,
            end,
            history: Vec::new(),
            fallback: Vec::new(),
            done: triangles.iter().map(|&t| is_degenerate(t)).collect(),
            fetched_in_trial: Vec::new(),
            drawn_in_trial: Vec::new(),
        }
    }
    pub(crate) fn is_cached(&self, v: u32) -> bool {
        let fetched = self.vertices[v as usize].fetched;
        fetched != 0 && self.history.len() as u32 - fetched < self.cache_size
    }
    /// Numbers of the misses whose vertices may still be cached.
    pub(crate) fn recent(&self) -> std::ops::Range<usize> {
        self.history.len().saturating_sub(self.cache_size as usize)..self.history.len()
    }
    /// The vertex of a miss, if it has triangles to be drawn.
    pub(crate) fn unfinished_at(&self, miss: usize) -> Option<u32> {
        let v = self.history[miss];
        (self.vertices[v as usize].remaining > 0).then_some(v)
    }
    /// A vertex's triangles from the first that is not done, at most [`MAX_OFFERED`]: a range for
    /// [`DrawState::incident`]. Later ones may be done.
    pub(crate) fn unfinished(&mut self, v: u32) -> std::ops::Range<usize> {
        let (mut first, end) =
            (self.next_unfinished[v as usize] as usize, self.end[v as usize] as usize);
        while first < end && self.done[self.incident[first] as usize] {
            first += 1;
        }
        self.next_unfinished[v as usize] = first as u32;
        first..end.min(first + MAX_OFFERED)
    }
    /// A triangle of a vertex.
    pub(crate) fn incident(&self, i: usize) -> u32 {
        self.incident[i]
    }
    /// The vertex that was fetched last among those with triangles to be drawn.
    pub(crate) fn last_unfinished(&mut self) -> Option<u32> {
        while let Some(&v) = self.fallback.last() {
            if self.vertices[v as usize].remaining > 0 {
                return Some(v);
            }
            self.fallback.pop();
        }
        None
    }
    /// References a vertex: fetches it unless it is in the cache.
    pub(crate) fn reference(&mut self, v: u32) -> Reference {
        if self.is_cached(v) {
            return Reference::Hit;
        }
        let mut effect = Reference::Miss;
        // The vertex that leaves is that of `cache_size` misses ago.
        if let Some(evicted_miss) = self.history.len().checked_sub(self.cache_size as usize)
            && self.vertices[self.history[evicted_miss] as usize].remaining > 0
        {
            effect = Reference::MissEvicting;
        }
        let vertex = &mut self.vertices[v as usize];
        self.fetched_in_trial.push((v, vertex.fetched));
        self.history.push(v);
        vertex.fetched = self.history.len() as u32;
        effect
    }
    /// Marks a triangle as drawn. Returns how many of its vertices have none to be drawn now.
    pub(crate) fn draw(&mut self, t: u32) -> u32 {
        self.done[t as usize] = true;
        self.drawn_in_trial.push(t);
        let mut finished = 0;
        for v in self.triangles[t as usize] {
            let remaining = &mut self.vertices[v as usize].remaining;
            *remaining -= 1;
            finished += u32::from(*remaining == 0);
        }
        finished
    }
    /// Takes the trial back: everything since the last `undo` or `commit`.
    pub(crate) fn undo(&mut self) {
        while let Some(t) = self.drawn_in_trial.pop() {
            self.done[t as usize] = false;
            for v in self.triangles[t as usize] {
                self.vertices[v as usize].remaining += 1;
            }
        }
        self.history.truncate(self.history.len() - self.fetched_in_trial.len());
        while let Some((v, fetched)) = self.fetched_in_trial.pop() {
            self.vertices[v as usize].fetched = fetched;
        }
    }
    /// Keeps everything since the last `undo` or `commit`.
    pub(crate) fn commit(&mut self) {
        self.fallback.extend(self.fetched_in_trial.drain(..).map(|(v, _)| v));
        self.drawn_in_trial.clear();
    }
}
