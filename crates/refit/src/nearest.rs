//! The nearest point of a set of triangles: a tree of boxes, searched from a hint.

use glam::DVec3;
use lodc_mesh::NONE;

/// No leaf has more triangles than this.
const LEAF: usize = 4;

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// The triangle that it lies on, by its number when the tree was made.
    pub(crate) triangle: u32,
    /// Barycentric coordinates of the point on it.
    pub(crate) barycentric: [f64; 3],
    /// The squared distance to it.
    pub(crate) squared: f64,
}

/// A box, rounded outwards to `f32`, and what is in it.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    lo: [f32; 3],
    hi: [f32; 3],
    /// A leaf's first slot, or an inner node's second child; the first child is the next node.
    first: u32,
    /// A leaf's triangles; 0 for inner nodes.
    count: u32,
}

impl Node {
    fn squared(&self, p: DVec3) -> f64 {
        let out = |k: usize| {
            let (lo, hi) = (f64::from(self.lo[k]) - p[k], p[k] - f64::from(self.hi[k]));
            lo.max(hi).max(0.0)
        };
        let [x, y, z] = [out(0), out(1), out(2)];
        x * x + y * y + z * z
    }
}

/// A search tree over triangles. A triangle may be a segment: two of its corners may be one.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// The triangle in each slot, and the slot of each triangle.
    order: Vec<u32>,
    slot: Vec<u32>,
    /// The corners of the triangle in each slot.
    corners: Vec<[DVec3; 3]>,
}

impl Tree {
    /// The tree of triangles by their corners, in `O(n log n)`.
    pub(crate) fn new(corners: &[[DVec3; 3]]) -> Self {
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        let mut nodes = vec![Node::default(); nodes_of(corners.len())];
        build(corners, &mut order, Place { node: 0, slot: 0 }, &mut nodes);
        let mut slot = vec![0; order.len()];
        for (&triangle, at) in order.iter().zip(0..) {
            slot[triangle as usize] = at;
        }
        let corners = order.iter().map(|&t| corners[t as usize]).collect();
        Self { nodes, order, slot, corners }
    }

    /// The triangles in an order in which neighbours are near each other.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Returns the nearest point to `p`, of equally near triangles one that the search meets first;
    /// `hint` is a triangle that is probably near, or [`NONE`]. Nothing if there is no triangle.
    pub(crate) fn nearest(&self, p: DVec3, hint: u32) -> Option<Nearest> {
        let mut best = Nearest { triangle: NONE, barycentric: [0.0; 3], squared: f64::INFINITY };
        let visit = |slot: usize, best: &mut Nearest| {
            let (barycentric, squared) = closest(p, self.corners[slot]);
            if squared < best.squared {
                *best = Nearest { triangle: self.order[slot], barycentric, squared };
            }
        };
        if let Some(&slot) = self.slot.get(hint as usize) {
            visit(slot as usize, &mut best);
        }
        let mut open = [(0.0, 0u32); 64];
        let mut depth = usize::from(!self.order.is_empty());
        while depth > 0 {
            depth -= 1;
            let (squared, at) = open[depth];
            if squared >= best.squared {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                let first = node.first as usize;
                (first..first + node.count as usize).for_each(|slot| visit(slot, &mut best));
                continue;
            }
            let mut children = [at + 1, node.first].map(|c| (self.nodes[c as usize].squared(p), c));
            // The nearer one is opened first, so it is put down last.
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            open[depth..depth + 2].copy_from_slice(&children);
            depth += 2;
        }
        (best.triangle != NONE).then_some(best)
    }
}

/// Number of nodes the tree of `n` triangles has: its shape depends on their number alone.
fn nodes_of(n: usize) -> usize {
    /// Those of `n` and of `n + 1` triangles.
    fn pair(n: usize) -> (usize, usize) {
        if n < LEAF {
            return (1, 1);
        }
        let (half, more) = pair(n / 2);
        let of = |a: usize, b: usize, n: usize| if n <= LEAF { 1 } else { 1 + a + b };
        if n.is_multiple_of(2) {
            (of(half, half, n), of(half, more, n + 1))
        } else {
            (of(half, more, n), of(more, more, n + 1))
        }
    }
    pair(n).0
}

/// Place of a subtree: its first node and the slot of its first triangle.
#[derive(Clone, Copy)]
struct Place {
    node: u32,
    slot: u32,
}

/// Triangles from which on both halves of a subtree are built at once.
const PARALLEL: usize = 4096;

/// Builds the subtree of some triangles into `nodes`.
fn build(corners: &[[DVec3; 3]], order: &mut [u32], at: Place, nodes: &mut [Node]) {
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &p in order.iter().flat_map(|&t| &corners[t as usize]) {
        (lo, hi) = (lo.min(p), hi.max(p));
    }
    let outwards = |p: DVec3, up: bool| {
        p.to_array().map(|x| {
            let near = x as f32;
            match (up, f64::from(near).total_cmp(&x)) {
                (true, std::cmp::Ordering::Less) => near.next_up(),
                (false, std::cmp::Ordering::Greater) => near.next_down(),
                _ => near,
            }
        })
    };
    let (node, nodes) = nodes.split_first_mut().expect("every subtree has a node");
    *node = Node {
        lo: outwards(lo, false),
        hi: outwards(hi, true),
        first: at.slot,
        count: order.len() as u32,
    };
    if order.len() <= LEAF {
        return;
    }
    // Halves of equal number: the tree is never deeper than the logarithm, whatever the mesh.
    let extent = hi - lo;
    let axis = (0..3).max_by(|&i, &j| extent[i].total_cmp(&extent[j])).unwrap_or(0);
    let middle = |t: u32| corners[t as usize].iter().map(|c| c[axis]).sum::<f64>();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
    let parallel = order.len() >= PARALLEL;
    let (near, far) = order.split_at_mut(half);
    let (near_nodes, far_nodes) = nodes.split_at_mut(nodes_of(half));
    let first = Place { node: at.node + 1, slot: at.slot };
    let second = Place { node: first.node + near_nodes.len() as u32, slot: at.slot + half as u32 };
    (node.first, node.count) = (second.node, 0);
    let mut near = || build(corners, near, first, near_nodes);
    let mut far = || build(corners, far, second, far_nodes);
    if parallel {
        rayon::join(near, far);
    } else {
        near();
        far();
    }
}

/// Returns the point of a triangle that is closest to `p`, as barycentric coordinates, and its
/// squared distance (Ericson 2005, 5.1.5).
pub(crate) fn closest(p: DVec3, [a, b, c]: [DVec3; 3]) -> ([f64; 3], f64) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let barycentric = region(ab, ac, ap, p - b, p - c);
    let point = a * barycentric[0] + b * barycentric[1] + c * barycentric[2];
    (barycentric, (point - p).length_squared())
}

fn region(ab: DVec3, ac: DVec3, ap: DVec3, bp: DVec3, cp: DVec3) -> [f64; 3] {
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    let (from_b, from_c) = (d4 - d3, d5 - d6);
    if va <= 0.0 && from_b >= 0.0 && from_c >= 0.0 && from_b + from_c > 0.0 {
        let w = from_b / (from_b + from_c);
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    if sum > 0.0 { [va / sum, vb / sum, vc / sum] } else { [1.0, 0.0, 0.0] }
}

/// The point of a triangle with given barycentric coordinates.
pub(crate) fn at([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    a * u + b * v + c * w
}

/// The tree of segments.
pub(crate) fn segment_tree(segments: &[[DVec3; 2]]) -> Tree {
    Tree::new(&segments.iter().map(|[a, b]| [*a, *b, *b]).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SplitMix64;

    #[test]
    fn the_tree_agrees_with_looking_at_every_triangle() {
        let mut random = SplitMix64::new(3);
        let mut point = |s: f64| DVec3::from_array([(); 3].map(|()| f64::from(random.unit()))) * s;
        let mut corners: Vec<[DVec3; 3]> = (0..300)
            .map(|_| {
                let at = point(4.0);
                [at, at + point(1.0), at + point(1.0)]
            })
            .collect();
        // Segments, too.
        corners.iter_mut().step_by(7).for_each(|t| t[2] = t[1]);
        let tree = Tree::new(&corners);
        for i in 0..300 {
            let p = point(6.0);
            let slow = corners.iter().map(|&t| closest(p, t).1).fold(f64::INFINITY, f64::min);
            for hint in [NONE, i] {
                let found = tree.nearest(p, hint).expect("there are triangles");
                assert!((found.squared - slow).abs() <= 1e-12 * (1.0 + slow), "{found:?} {slow}");
            }
        }
        assert!(Tree::new(&[]).nearest(DVec3::ZERO, NONE).is_none());
    }
}
