//! The distance from a point to the nearest of many triangles, by a tree of boxes.

use super::normals::dot;

type Point = [f64; 3];

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Triangles that can be asked for the nearest one.
pub(super) struct Nearest {
    nodes: Vec<Node>,
    triangles: Vec<[Point; 3]>,
}

struct Node {
    low: Point,
    high: Point,
    /// Its triangles if it is a leaf; otherwise where the second child is. The first child follows its parent.
    content: Content,
}

enum Content {
    Leaf(std::ops::Range<usize>),
    Inner(usize),
}

impl Nearest {
    /// A tree over triangles.
    pub(super) fn new(mut triangles: Vec<[Point; 3]>) -> Self {
        let mut nodes = Vec::new();
        if !triangles.is_empty() {
            let all = 0..triangles.len();
            grow(&mut nodes, &mut triangles, all);
        }
        Self { nodes, triangles }
    }

    /// The distance of the nearest triangle; 0 if there is none.
    pub(super) fn distance(&self, p: Point) -> f64 {
        let mut best = f64::INFINITY;
        // Halving keeps the tree far shallower than this.
        let mut open = Vec::with_capacity(64);
        if !self.nodes.is_empty() {
            open.push((self.nodes[0].squared(p), 0));
        }
        while let Some((squared, node)) = open.pop() {
            if squared >= best {
                continue;
            }
            match &self.nodes[node].content {
                Content::Leaf(range) => {
                    for t in &self.triangles[range.clone()] {
                        best = best.min(to_triangle(p, t));
                    }
                }
                Content::Inner(second) => {
                    let mut children = [node + 1, *second].map(|n| (self.nodes[n].squared(p), n));
                    if children[0].0 < children[1].0 {
                        children.swap(0, 1);
                    }
                    open.extend(children);
                }
            }
        }
        if best.is_finite() { best.sqrt() } else { 0.0 }
    }
}

impl Node {
    /// Squared distance from its box.
    fn squared(&self, p: Point) -> f64 {
        let out: Point = std::array::from_fn(|i| (self.low[i] - p[i]).max(p[i] - self.high[i]).max(0.0));
        dot(out, out)
    }
}

/// Adds the node of some triangles and everything below it, halving along the longest side of the box.
fn grow(nodes: &mut Vec<Node>, triangles: &mut [[Point; 3]], range: std::ops::Range<usize>) {
    let corners = || triangles[range.clone()].iter().flatten();
    let low: Point = std::array::from_fn(|i| corners().fold(f64::INFINITY, |l, c| l.min(c[i])));
    let high: Point = std::array::from_fn(|i| corners().fold(f64::NEG_INFINITY, |h, c| h.max(c[i])));
    let node = nodes.len();
    nodes.push(Node { low, high, content: Content::Leaf(range.clone()) });
    if range.len() <= LEAF {
        return;
    }
    let side = |i: &usize| high[*i] - low[*i];
    let axis = (0..3).max_by(|a, b| side(a).total_cmp(&side(b))).expect("three axes");
    let middle = range.len() / 2;
    let at = |t: &[Point; 3]| t[0][axis] + t[1][axis] + t[2][axis];
    triangles[range.clone()].select_nth_unstable_by(middle, |a, b| at(a).total_cmp(&at(b)));
    let middle = range.start + middle;
    grow(nodes, triangles, range.start..middle);
    nodes[node].content = Content::Inner(nodes.len());
    grow(nodes, triangles, middle..range.end);
}

/// Squared distance from a triangle: from its plane if the foot lies inside, else from its nearest edge.
fn to_triangle(p: Point, [a, b, c]: &[Point; 3]) -> f64 {
    let n = cross(minus(*b, *a), minus(*c, *a));
    let size = dot(n, n);
    let left = |from: &Point, to: &Point| dot(cross(minus(*to, *from), minus(p, *from)), n) >= 0.0;
    if size > 0.0 && left(a, b) && left(b, c) && left(c, a) {
        let height = dot(minus(p, *a), n);
        return height * height / size;
    }
    to_edge(p, a, b).min(to_edge(p, b, c)).min(to_edge(p, c, a))
}

fn to_edge(p: Point, a: &Point, b: &Point) -> f64 {
    let (along, to) = (minus(*b, *a), minus(p, *a));
    let length = dot(along, along);
    let t = if length > 0.0 { (dot(along, to) / length).clamp(0.0, 1.0) } else { 0.0 };
    let off: Point = std::array::from_fn(|i| to[i] - t * along[i]);
    dot(off, off)
}

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_fixtures::Rng;

    #[test]
    fn the_tree_agrees_with_asking_every_triangle() {
        let mut rng = Rng::new(5);
        let mut point = |size: f64| -> Point { std::array::from_fn(|_| f64::from(rng.unit()) * size) };
        for count in [1, 2, 5, 60, 400] {
            let triangles: Vec<[Point; 3]> = (0..count)
                .map(|_| {
                    let at = point(4.0);
                    [at, point(1.0), point(1.0)].map(|d| std::array::from_fn(|i| at[i] + d[i]))
                })
                .collect();
            let tree = Nearest::new(triangles.clone());
            for _ in 0..100 {
                let p = point(6.0);
                let naive = triangles.iter().map(|t| to_triangle(p, t)).fold(f64::INFINITY, f64::min).sqrt();
                assert!((tree.distance(p) - naive).abs() < 1e-12, "{count} triangles");
            }
        }
        assert_eq!(Nearest::new(Vec::new()).distance([1.0; 3]), 0.0);
    }

    #[test]
    fn distances_from_faces_edges_and_corners_are_right() {
        let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        for (p, squared) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([2.0, -2.0, 0.0], 4.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([4.0, 4.0, 0.0], 8.0),
            ([6.0, 0.0, 1.0], 5.0),
        ] {
            assert!((to_triangle(p, &t) - squared).abs() < 1e-12, "{p:?}");
        }
        let line = [[0.0; 3], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        assert_eq!(to_triangle([1.0, 2.0, 0.0], &line), 4.0);
    }
}
