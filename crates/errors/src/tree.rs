//! A search tree over triangles that move: an implicit binary tree of boxes over the Morton order.

use crate::triangle;
use glam::DVec3;
use lodc_mesh::NONE;

/// Triangles in one leaf.
const LEAF: usize = 4;

/// A set of triangles as a tree sees it.
pub(crate) trait Triangles {
    /// Returns the corners of a triangle.
    fn corners(&self, triangle: u32) -> [DVec3; 3];
    /// Returns whether a triangle is still there.
    fn is_live(&self, triangle: u32) -> bool;
}

#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    #[inline]
    fn distance_squared(&self, p: DVec3) -> f64 {
        let outside = |x: f64, low: f32, high: f32| {
            let below = f64::from(low) - x;
            let above = x - f64::from(high);
            let out = if below > above { below } else { above };
            if out > 0.0 { out } else { 0.0 }
        };
        let x = outside(p.x, self.low[0], self.high[0]);
        let y = outside(p.y, self.low[1], self.high[1]);
        let z = outside(p.z, self.low[2], self.high[2]);
        x * x + y * y + z * z
    }

    fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }

    /// Takes a point in. Returns whether the box grew.
    fn include(&mut self, p: [f32; 3]) -> bool {
        let mut grew = false;
        for (axis, x) in p.into_iter().enumerate() {
            if x < self.low[axis] {
                (self.low[axis], grew) = (x, true);
            }
            if x > self.high[axis] {
                (self.high[axis], grew) = (x, true);
            }
        }
        grew
    }

    fn union(a: &Self, b: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| a.low[i].min(b.low[i])),
            high: std::array::from_fn(|i| a.high[i].max(b.high[i])),
        }
    }
}

/// The nearest triangle found so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// The squared distance to it; infinite before there is one.
    pub(crate) squared: f64,
    /// The triangle; [`NONE`] before there is one.
    pub(crate) triangle: u32,
}

impl Nearest {
    pub(crate) const NOTHING: Self = Self { squared: f64::INFINITY, triangle: NONE };

    /// Takes a triangle if it is nearer.
    #[inline]
    pub(crate) fn offer(&mut self, squared: f64, triangle: u32) {
        if squared < self.squared {
            *self = Self { squared, triangle };
        }
    }
}

/// A tree. Boxes only grow, until all of their triangles have died; dead ones are passed over.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// The triangles in the order of leaves.
    order: Vec<u32>,
    /// The place of each triangle in `order`; [`NONE`] if the tree does not hold it.
    place: Vec<u32>,
    /// Box 1 is the root, boxes 2i and 2i + 1 are the children of box i.
    boxes: Vec<Bounds>,
    first_leaf: usize,
}

impl Tree {
    /// Builds the tree of some triangles, given in an order in which neighbours are near, out of
    /// `all` triangles. `corners` returns the positions of a triangle's corners.
    pub(crate) fn new(order: Vec<u32>, all: usize, corners: impl Fn(u32) -> [[f32; 3]; 3]) -> Self {
        let mut place = vec![NONE; all];
        for (&t, at) in order.iter().zip(0..) {
            place[t as usize] = at;
        }
        let first_leaf = order.len().div_ceil(LEAF).max(1).next_power_of_two();
        let mut boxes = vec![Bounds::EMPTY; 2 * first_leaf];
        for (leaf, triangles) in boxes[first_leaf..].iter_mut().zip(order.chunks(LEAF)) {
            for p in triangles.iter().flat_map(|&t| corners(t)) {
                leaf.include(p);
            }
        }
        for i in (1..first_leaf).rev() {
            boxes[i] = Bounds::union(&boxes[2 * i], &boxes[2 * i + 1]);
        }
        Self { order, place, boxes, first_leaf }
    }

    /// The triangles that the tree holds, dead ones too.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Returns a word of a triangle's leaf, to have it read.
    #[inline]
    pub(crate) fn touch(&self, triangle: u32) -> u32 {
        let leaf = self.first_leaf + self.place[triangle as usize] as usize / LEAF;
        self.boxes.get(leaf).map_or(0, |b| b.low[0].to_bits())
    }

    /// Makes room for a new corner of a triangle.
    pub(crate) fn grow(&mut self, triangle: u32, p: [f32; 3]) {
        let place = self.place[triangle as usize];
        if place == NONE {
            return;
        }
        let mut i = self.first_leaf + place as usize / LEAF;
        while i > 0 && self.boxes[i].include(p) {
            i /= 2;
        }
    }

    /// Closes the boxes that hold no live triangle any more, after one has died.
    pub(crate) fn remove(&mut self, triangle: u32, is_live: impl Fn(u32) -> bool) {
        let place = self.place[triangle as usize];
        if place == NONE {
            return;
        }
        let leaf = place as usize / LEAF;
        let end = (LEAF * (leaf + 1)).min(self.order.len());
        if self.order[LEAF * leaf..end].iter().any(|&t| is_live(t)) {
            return;
        }
        let mut i = self.first_leaf + leaf;
        self.boxes[i] = Bounds::EMPTY;
        while i > 1 && self.boxes[i ^ 1].is_empty() {
            i /= 2;
            self.boxes[i] = Bounds::EMPTY;
        }
    }

    /// Looks for a triangle nearer than `nearest`, from the leaf of `hint` upwards, and stops at
    /// the first within the squared distance `enough`, or when it has opened `patience` boxes.
    /// Returns how many it has opened.
    pub(crate) fn search(
        &self,
        triangles: &impl Triangles,
        p: DVec3,
        hint: u32,
        enough: f64,
        patience: u32,
        nearest: &mut Nearest,
    ) -> u32 {
        let mut search = Search { tree: self, triangles, p, enough, nearest, left: patience };
        match self.place.get(hint as usize) {
            Some(&place) if place != NONE => {
                let mut i = self.first_leaf + place as usize / LEAF;
                search.leaf(i);
                while i > 1 && !search.is_done() {
                    search.down(i ^ 1);
                    i /= 2;
                }
            }
            _ => search.down(1),
        }
        patience - search.left
    }
}

struct Search<'a, T> {
    tree: &'a Tree,
    triangles: &'a T,
    p: DVec3,
    enough: f64,
    nearest: &'a mut Nearest,
    left: u32,
}

impl<T: Triangles> Search<'_, T> {
    fn is_done(&self) -> bool {
        self.nearest.squared <= self.enough || self.left == 0 && self.nearest.triangle != NONE
    }

    fn leaf(&mut self, i: usize) {
        let start = (i - self.tree.first_leaf) * LEAF;
        let order = &self.tree.order;
        for &t in &order[start.min(order.len())..(start + LEAF).min(order.len())] {
            if self.triangles.is_live(t) {
                self.nearest
                    .offer(triangle::distance_squared(self.p, self.triangles.corners(t)), t);
                if self.nearest.squared <= self.enough {
                    return;
                }
            }
        }
    }

    fn down(&mut self, root: usize) {
        let boxes = &self.tree.boxes;
        let mut open = [(0.0, 0usize); 40];
        open[0] = (boxes[root].distance_squared(self.p), root);
        let mut depth = 1;
        while depth > 0 && !self.is_done() {
            depth -= 1;
            let (distance, i) = open[depth];
            if distance >= self.nearest.squared {
                continue;
            }
            self.left = self.left.saturating_sub(1);
            if i >= self.tree.first_leaf {
                self.leaf(i);
                continue;
            }
            let mut near = (boxes[2 * i].distance_squared(self.p), 2 * i);
            let mut far = (boxes[2 * i + 1].distance_squared(self.p), 2 * i + 1);
            // The nearer one is opened first, so it is put down last.
            if far.0 < near.0 {
                (near, far) = (far, near);
            }
            if far.0 < self.nearest.squared {
                open[depth] = far;
                depth += 1;
            }
            if near.0 < self.nearest.squared {
                open[depth] = near;
                depth += 1;
            }
        }
    }
}

/// Sorts triangles along a Morton curve through their centroids, 10 bits an axis.
pub(crate) fn morton_order(
    triangles: impl Iterator<Item = u32> + Clone,
    corners: impl Fn(u32) -> [[f32; 3]; 3],
) -> Vec<u32> {
    let mut bounds = Bounds::EMPTY;
    for p in triangles.clone().flat_map(&corners) {
        bounds.include(p);
    }
    let extent = (0..3).map(|i| bounds.high[i] - bounds.low[i]).fold(0.0, f32::max);
    let cells = if extent > 0.0 { 1023.0 / extent } else { 0.0 };
    let code = |t: u32| {
        let [a, b, c] = corners(t);
        (0..3).fold(0, |code, i| {
            let middle = ((a[i] - bounds.low[i]) + (b[i] - bounds.low[i]) + (c[i] - bounds.low[i]))
                * (1.0 / 3.0);
            code | spread((middle * cells) as u32) << i
        })
    };
    let mut keyed: Vec<(u32, u32)> = triangles.map(|t| (code(t), t)).collect();
    let mut sorted = vec![(0, 0); keyed.len()];
    for shift in [0, 10, 20] {
        let digit = |code: u32| (code >> shift) as usize & 1023;
        let mut starts = [0u32; 1025];
        for &(code, _) in &keyed {
            starts[digit(code) + 1] += 1;
        }
        for i in 0..1024 {
            starts[i + 1] += starts[i];
        }
        for &entry in &keyed {
            let at = &mut starts[digit(entry.0)];
            sorted[*at as usize] = entry;
            *at += 1;
        }
        std::mem::swap(&mut keyed, &mut sorted);
    }
    keyed.into_iter().map(|(_, t)| t).collect()
}

/// Puts two zeros between the bits of a number of 10 bits.
fn spread(x: u32) -> u32 {
    let x = x.min(1023);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}
