//! A search tree for the nearest triangle of a mesh under simplification, whose triangles move and
//! disappear: an implicit binary tree of boxes over the Morton order. Boxes grow when a triangle
//! moves and are closed when their triangles are gone.

use crate::bounds::Bounds;
use crate::triangle;
use glam::DVec3;
use lodc_mesh::NONE;

/// Triangles in one leaf. Chosen by hand: fewer take more memory, more take longer to look at.
const LEAF_TRIANGLES: usize = 4;

/// A set of triangles as a tree sees it.
pub trait Triangles {
    /// Returns the corners of a triangle.
    fn corners(&self, triangle: u32) -> [DVec3; 3];
    /// Returns whether a triangle is still there.
    fn is_live(&self, triangle: u32) -> bool;
}

/// A search for a triangle near a point.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// The point.
    pub point: DVec3,
    /// A triangle that is probably near, or [`NONE`].
    pub hint: u32,
    /// The search ends at the first triangle within this squared distance; with 0, at the nearest.
    pub enough: f64,
    /// The search ends when it has opened this many boxes.
    pub max_boxes: u32,
}

/// The nearest triangle found so far.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The squared distance to it; infinite before there is one.
    pub squared: f64,
    /// The triangle; [`NONE`] before there is one.
    pub triangle: u32,
}

impl Hit {
    /// Before there is one.
    pub const NONE: Self = Self { squared: f64::INFINITY, triangle: NONE };

    /// Replaces it by a triangle, given with its corners, if that is nearer to a point.
    #[inline]
    pub fn replace_if_nearer(&mut self, p: DVec3, corners: [DVec3; 3], triangle: u32) {
        if triangle::may_be_within(p, corners, self.squared) {
            let squared = triangle::distance_squared(p, corners);
            if squared < self.squared {
                *self = Self { squared, triangle };
            }
        }
    }
}

/// A tree over triangles that move and die. Boxes only grow, until all of their triangles have
/// died; dead ones are passed over.
#[derive(Clone, Debug)]
pub struct MovingTree {
    /// The triangles in the order of leaves, and the index of each in it, [`NONE`] if the tree does
    /// not hold it; both empty if the order is that of their numbers.
    order: Vec<u32>,
    order_index: Vec<u32>,
    count: u32,
    /// Box 1 is the root, boxes 2i and 2i + 1 are the children of box i. The last half of them are
    /// the leaves, of which the first ones may be a level higher than the others.
    boxes: Vec<Bounds>,
    first_leaf: usize,
}

impl MovingTree {
    /// Builds the tree of the triangles 0 to `count` (exclusive), whose numbers rise along a curve
    /// through them. `corners` returns the positions of a triangle's corners.
    #[must_use]
    pub fn of_all(count: u32, corners: impl Fn(u32) -> [[f32; 3]; 3]) -> Self {
        Self::build(vec![], vec![], count, corners)
    }

    /// Builds the tree of some triangles, given in an order in which neighbours are near each
    /// other, out of `all_count` triangles.
    #[must_use]
    pub fn of(order: Vec<u32>, all_count: usize, corners: impl Fn(u32) -> [[f32; 3]; 3]) -> Self {
        let mut order_index = vec![NONE; all_count];
        for (&t, index) in order.iter().zip(0..) {
            order_index[t as usize] = index;
        }
        let count = order.len() as u32;
        Self::build(order, order_index, count, corners)
    }

    fn build(
        order: Vec<u32>,
        order_index: Vec<u32>,
        count: u32,
        corners: impl Fn(u32) -> [[f32; 3]; 3],
    ) -> Self {
        let first_leaf = (count as usize).div_ceil(LEAF_TRIANGLES).max(1);
        let boxes = vec![Bounds::EMPTY; 2 * first_leaf];
        let mut tree = Self { order, order_index, count, boxes, first_leaf };
        for leaf in 0..(count as usize).div_ceil(LEAF_TRIANGLES) {
            let mut bounds = Bounds::EMPTY;
            for p in tree.leaf(leaf).flat_map(&corners) {
                bounds.include(p);
            }
            tree.boxes[first_leaf + leaf] = bounds;
        }
        for i in (1..first_leaf).rev() {
            tree.boxes[i] = Bounds::union(&tree.boxes[2 * i], &tree.boxes[2 * i + 1]);
        }
        tree
    }

    /// Returns the triangles that the tree holds, dead ones too.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + Clone {
        (0..self.count).map(|index| self.triangle(index))
    }

    /// Returns the triangles of a leaf.
    #[inline]
    fn leaf(&self, leaf: usize) -> impl Iterator<Item = u32> {
        let start = ((LEAF_TRIANGLES * leaf) as u32).min(self.count);
        (start..(start + LEAF_TRIANGLES as u32).min(self.count)).map(|index| self.triangle(index))
    }

    #[inline]
    fn triangle(&self, index: u32) -> u32 {
        if self.order.is_empty() { index } else { self.order[index as usize] }
    }

    /// Returns the leaf of a triangle, if the tree holds it.
    #[inline]
    fn leaf_of(&self, triangle: u32) -> Option<usize> {
        let index = if self.order_index.is_empty() {
            triangle
        } else {
            self.order_index[triangle as usize]
        };
        (index != NONE).then_some(index as usize / LEAF_TRIANGLES)
    }

    /// Returns a word of a triangle's leaf, to load its cache line early.
    #[inline]
    pub fn touch(&self, triangle: u32) -> u32 {
        let leaf = self.leaf_of(triangle).and_then(|leaf| self.boxes.get(self.first_leaf + leaf));
        leaf.map_or(0, |b| b.low()[0].to_bits())
    }

    /// Grows the boxes around a triangle to take in a new corner.
    pub fn grow(&mut self, triangle: u32, p: [f32; 3]) {
        let Some(leaf) = self.leaf_of(triangle) else { return };
        let mut i = self.first_leaf + leaf;
        while i > 0 && self.boxes[i].include(p) {
            i /= 2;
        }
    }

    /// Empties the boxes that hold no live triangle any more, after `triangle` has died.
    pub fn remove(&mut self, triangle: u32, is_live: impl Fn(u32) -> bool) {
        let Some(leaf) = self.leaf_of(triangle) else { return };
        if self.leaf(leaf).any(is_live) {
            return;
        }
        let mut i = self.first_leaf + leaf;
        self.boxes[i] = Bounds::EMPTY;
        while i > 1 && self.boxes[i ^ 1].is_empty() {
            i /= 2;
            self.boxes[i] = Bounds::EMPTY;
        }
    }

    /// Looks for a triangle nearer than `nearest`, from the leaf of the hint upwards. Returns how
    /// many boxes it has opened.
    pub fn search(&self, triangles: &impl Triangles, query: Query, nearest: &mut Hit) -> u32 {
        let Query { point, hint, enough, max_boxes } = query;
        let mut search =
            Search { tree: self, triangles, point, enough, nearest, boxes_left: max_boxes };
        match (hint != NONE).then(|| self.leaf_of(hint)).flatten() {
            Some(leaf) => {
                let mut i = self.first_leaf + leaf;
                search.visit_leaf(i);
                while i > 1 && !search.is_done() {
                    search.descend(i ^ 1);
                    i /= 2;
                }
            }
            None => search.descend(1),
        }
        max_boxes - search.boxes_left
    }
}

struct Search<'a, T> {
    tree: &'a MovingTree,
    triangles: &'a T,
    point: DVec3,
    enough: f64,
    nearest: &'a mut Hit,
    boxes_left: u32,
}

impl<T: Triangles> Search<'_, T> {
    fn is_done(&self) -> bool {
        self.nearest.squared <= self.enough || self.boxes_left == 0 && self.nearest.triangle != NONE
    }

    fn visit_leaf(&mut self, i: usize) {
        for t in self.tree.leaf(i - self.tree.first_leaf) {
            if self.triangles.is_live(t) {
                self.nearest.replace_if_nearer(self.point, self.triangles.corners(t), t);
                if self.nearest.squared <= self.enough {
                    return;
                }
            }
        }
    }

    /// Searches a subtree, the nearer of two boxes first.
    fn descend(&mut self, root: usize) {
        let boxes = &self.tree.boxes;
        let squared = boxes[root].distance_squared(self.point);
        // Before the stack is made: of most subtrees on the way up nothing is near enough.
        if squared >= self.nearest.squared {
            return;
        }
        // Squared distances and boxes: one entry for each level that was passed, of 31 at most,
        // and one more.
        let mut stack = [(0.0, 0usize); 40];
        stack[0] = (squared, root);
        let mut depth = 1;
        while depth > 0 && !self.is_done() {
            depth -= 1;
            let (squared, i) = stack[depth];
            if squared >= self.nearest.squared {
                continue;
            }
            self.boxes_left = self.boxes_left.saturating_sub(1);
            if i >= self.tree.first_leaf {
                self.visit_leaf(i);
                continue;
            }
            let mut nearer = (boxes[2 * i].distance_squared(self.point), 2 * i);
            let mut farther = (boxes[2 * i + 1].distance_squared(self.point), 2 * i + 1);
            // The nearer one is opened first, so it is pushed last.
            if farther.0 < nearer.0 {
                (nearer, farther) = (farther, nearer);
            }
            if farther.0 < self.nearest.squared {
                stack[depth] = farther;
                depth += 1;
            }
            if nearer.0 < self.nearest.squared {
                stack[depth] = nearer;
                depth += 1;
            }
        }
    }
}
