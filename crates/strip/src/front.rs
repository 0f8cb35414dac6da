//! State of generators of drawing orders: the triangles left at each vertex, and what a first-in
//! first-out cache holds.
//!
//! All of it can be taken back, so that a generator can try before it draws.

use lodc_mesh::is_degenerate;

/// Number of entries of a vertex's list of triangles that are looked at. Surfaces have about six; a
/// vertex with a million shows a few at a time.
const LOOK: usize = 24;

/// A vertex.
#[derive(Clone, Copy, Default)]
pub(crate) struct Vertex {
    /// The number of the miss that fetched it last, from 1; 0 for never.
    pub(crate) fetched: u32,
    /// Number of triangles it still has.
    pub(crate) left: u32,
}

/// The effect of asking the cache for a vertex.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Touch {
    /// It was there.
    Hit,
    /// It was fetched.
    Miss,
    /// It was fetched, and a vertex was thrown out that has triangles left.
    MissAndLoss,
}

/// The state of drawing.
pub(crate) struct Front<'a> {
    pub(crate) triangles: &'a [[u32; 3]],
    pub(crate) size: u32,
    pub(crate) vertices: Vec<Vertex>,
    /// Triangles of each vertex; those before `first_left` are done.
    incident: Vec<u32>,
    first_left: Vec<u32>,
    last: Vec<u32>,
    /// The vertex of each miss.
    pub(crate) history: Vec<u32>,
    /// Vertices to go back to when nothing in the cache has triangles left.
    behind: Vec<u32>,
    pub(crate) done: Vec<bool>,
    /// Vertices fetched since the last [`Front::keep`] or [`Front::undo`], with when they were
    /// fetched before.
    before: Vec<(u32, u32)>,
    /// Triangles drawn since then.
    pub(crate) drawn: Vec<u32>,
}

impl<'a> Front<'a> {
    pub(crate) fn new(triangles: &'a [[u32; 3]], vertex_count: usize, size: u32) -> Self {
        let mut vertices = vec![Vertex::default(); vertex_count];
        let real = || triangles.iter().enumerate().filter(|(_, t)| !is_degenerate(**t));
        for v in real().flat_map(|(_, t)| t) {
            vertices[*v as usize].left += 1;
        }
        let mut sum = 0;
        let mut first_left = Vec::with_capacity(vertex_count);
        for v in &vertices {
            first_left.push(sum);
            sum += v.left;
        }
        let mut last = first_left.clone();
        let mut incident = vec![0; sum as usize];
        for (i, t) in real() {
            for &v in t {
                incident[last[v as usize] as usize] = i as u32;
                last[v as usize] += 1;
            }
        }
        Self {
            triangles,
            size,
            vertices,
            incident,
            first_left,
            last,
            history: Vec::new(),
            behind: Vec::new(),
            done: triangles.iter().map(|&t| is_degenerate(t)).collect(),
            before: Vec::new(),
            drawn: Vec::new(),
        }
    }
    pub(crate) fn is_cached(&self, v: u32) -> bool {
        let fetched = self.vertices[v as usize].fetched;
        fetched != 0 && self.history.len() as u32 - fetched < self.size
    }
    /// Numbers of the misses whose vertices may still be cached.
    pub(crate) fn recent(&self) -> std::ops::Range<usize> {
        self.history.len().saturating_sub(self.size as usize)..self.history.len()
    }
    /// The vertex of a recent miss, if it has triangles left.
    pub(crate) fn live(&self, miss: usize) -> Option<u32> {
        let v = self.history[miss];
        (self.vertices[v as usize].left > 0).then_some(v)
    }
    /// A bounded part of a vertex's triangles, beginning with the first that is not done: a range
    /// for [`Front::incident`].
    pub(crate) fn left(&mut self, v: u32) -> std::ops::Range<usize> {
        let (mut first, last) =
            (self.first_left[v as usize] as usize, self.last[v as usize] as usize);
        while first < last && self.done[self.incident[first] as usize] {
            first += 1;
        }
        self.first_left[v as usize] = first as u32;
        first..last.min(first + LOOK)
    }
    /// A triangle of a vertex.
    pub(crate) fn incident(&self, i: usize) -> u32 {
        self.incident[i]
    }
    /// The vertex fetched last that still has triangles.
    pub(crate) fn go_back(&mut self) -> Option<u32> {
        while let Some(&v) = self.behind.last() {
            if self.vertices[v as usize].left > 0 {
                return Some(v);
            }
            self.behind.pop();
        }
        None
    }
    /// Asks the cache for a vertex.
    pub(crate) fn touch(&mut self, v: u32) -> Touch {
        if self.is_cached(v) {
            return Touch::Hit;
        }
        let mut touch = Touch::Miss;
        if let Some(out) = self.history.len().checked_sub(self.size as usize)
            && self.vertices[self.history[out] as usize].left > 0
        {
            touch = Touch::MissAndLoss;
        }
        let vertex = &mut self.vertices[v as usize];
        self.before.push((v, vertex.fetched));
        self.history.push(v);
        vertex.fetched = self.history.len() as u32;
        touch
    }
    /// Counts a triangle as drawn, and says how many of its vertices have none left now.
    pub(crate) fn draw(&mut self, t: u32) -> u32 {
        self.done[t as usize] = true;
        self.drawn.push(t);
        let mut finished = 0;
        for v in self.triangles[t as usize] {
            let left = &mut self.vertices[v as usize].left;
            *left -= 1;
            finished += u32::from(*left == 0);
        }
        finished
    }
    /// Takes back everything since the last time.
    pub(crate) fn undo(&mut self) {
        while let Some(t) = self.drawn.pop() {
            self.done[t as usize] = false;
            for v in self.triangles[t as usize] {
                self.vertices[v as usize].left += 1;
            }
        }
        self.history.truncate(self.history.len() - self.before.len());
        while let Some((v, fetched)) = self.before.pop() {
            self.vertices[v as usize].fetched = fetched;
        }
    }
    /// Keeps everything since the last time.
    pub(crate) fn keep(&mut self) {
        self.behind.extend(self.before.drain(..).map(|(v, _)| v));
        self.drawn.clear();
    }
}
