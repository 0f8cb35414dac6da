//! The shortest filter of a strip: the fewest positions that draw exactly its live triangles, by a
//! breadth-first search.
//!
//! Drawn in order, every kept position after the second either draws a live triangle or is
//! *wasted*: it makes a degenerate one. All filters draw the same triangles, so the shortest is the
//! one that wastes least. States (last two labels, parity, remaining triangles) are searched in
//! layers of equal waste; of the same state only the one that ends at the earliest position
//! matters, since whatever can follow the later one can follow it too. A state is given up as soon
//! as a remaining triangle cannot be drawn any more: one of its corners does not come again, and is
//! not among the last two. Results depend on the pattern alone.

use super::pattern::{LONGEST, Pattern};
use lodc_mesh::NONE;

/// Slots of the hash table of states: twice as many as a search may keep ([`Search::LIMIT`]).
const SLOTS: usize = 1 << 14;

/// The working memory of searches, reused to save allocating.
pub(super) struct Search {
    /// The live triangles, equal ones side by side.
    triangles: Vec<[u8; 3]>,
    /// For each label the triangles that have it as a corner; here and below, a bit for each
    /// triangle or position.
    triangles_with: [u64; LONGEST],
    /// For each label its positions.
    positions: [u64; LONGEST],
    /// For each point in space the positions of the labels that are there.
    positions_at: [u64; LONGEST],
    /// For each position the triangles with a corner that does not come again after it.
    unreachable: [u64; LONGEST],
    /// All states that were reached.
    nodes: Vec<Node>,
    /// Open addressing: the best node of each state.
    slots: Vec<u32>,
    /// The entries of `slots` to clear after a search.
    used_slots: Vec<u32>,
    /// Nodes of the present layer of equal waste that are not expanded yet, and those that are.
    open: Vec<u32>,
    expanded: Vec<u32>,
}

/// A kept position, and the state that it leads to.
#[derive(Clone, Copy)]
struct Node {
    /// Triangles that are still to be drawn.
    remaining: u64,
    parent: u32,
    /// The labels kept last, `q` after `p`.
    p: u8,
    q: u8,
    /// The position at which `q` was kept.
    at: u8,
    /// True if the next triangle is turned.
    odd: bool,
}

impl Search {
    /// States that one search may keep. Strips of real meshes need some tens; those made to be hard
    /// get a [`trimmed`](super::trim::trimmed) filter.
    pub(super) const LIMIT: usize = SLOTS / 2;

    pub(super) fn new() -> Self {
        Self {
            triangles: Vec::new(),
            triangles_with: [0; LONGEST],
            positions: [0; LONGEST],
            positions_at: [0; LONGEST],
            unreachable: [0; LONGEST],
            nodes: Vec::new(),
            slots: vec![NONE; SLOTS],
            used_slots: Vec::new(),
            open: Vec::new(),
            expanded: Vec::new(),
        }
    }

    /// The positions of a shortest filter; 0 if no triangle is live. `None` if more than `limit`
    /// states would have to be looked at.
    pub(super) fn shortest(&mut self, pattern: &Pattern, limit: usize) -> Option<u64> {
        self.triangles.clear();
        self.triangles.extend(pattern.drawn(pattern.all()));
        if self.triangles.is_empty() || self.triangles.len() + 2 == pattern.labels().len() {
            return Some(if self.triangles.is_empty() { 0 } else { pattern.all() });
        }
        self.triangles.sort_unstable();
        self.fill_tables(pattern);
        let found = self.search(pattern, limit.min(Self::LIMIT));
        for slot in self.used_slots.drain(..) {
            self.slots[slot as usize] = NONE;
        }
        found
    }

    /// Fills what depends on the pattern and its live triangles only.
    fn fill_tables(&mut self, pattern: &Pattern) {
        for table in [&mut self.triangles_with, &mut self.positions, &mut self.positions_at] {
            table[..pattern.label_count()].fill(0);
        }
        for (bit, triangle) in self.triangles.iter().enumerate() {
            for &corner in triangle {
                self.triangles_with[corner as usize] |= 1 << bit;
            }
        }
        for (at, &label) in pattern.labels().iter().enumerate() {
            self.positions[label as usize] |= 1 << at;
            self.positions_at[pattern.point_of(label) as usize] |= 1 << at;
        }
        let mut unreachable = 0;
        for (at, &label) in pattern.labels().iter().enumerate() {
            if after(self.positions[label as usize], at as u8) == 0 {
                unreachable |= self.triangles_with[label as usize];
            }
            self.unreachable[at] = unreachable;
        }
    }

    /// Searches layer by layer.
    fn search(&mut self, pattern: &Pattern, limit: usize) -> Option<u64> {
        self.nodes.clear();
        self.open.clear();
        self.start(pattern, false);
        // One wasted position at the start turns what follows; a second one would turn it back.
        for wasted in 0.. {
            if wasted == 1 {
                self.start(pattern, true);
            }
            self.expanded.clear();
            while let Some(node) = self.open.pop() {
                if self.nodes.len() > limit {
                    return None;
                }
                if self.is_best(node) {
                    if let Some(last) = self.expand_drawing(pattern, node) {
                        return Some(self.kept_positions(last));
                    }
                    self.expanded.push(node);
                }
            }
            if wasted > 0 && self.expanded.is_empty() {
                break;
            }
            for i in 0..self.expanded.len() {
                if self.is_best(self.expanded[i]) {
                    self.expand_wasting(pattern, self.expanded[i]);
                }
            }
        }
        unreachable!("keeping every position draws every live triangle")
    }

    /// Adds the states in which any triangle can be the first.
    fn start(&mut self, pattern: &Pattern, odd: bool) {
        let remaining = u64::MAX >> (64 - self.triangles.len());
        for t in 0..self.triangles.len() {
            let [a, b, c] = self.triangles[t];
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let (p, q, mut min_position) = if odd { (q, p, 0) } else { (p, q, 0) };
                let mut parent = NONE;
                if odd {
                    // Any vertex at the point of either makes the first triangle degenerate.
                    let at_point = self.positions_at[pattern.point_of(p) as usize]
                        | self.positions_at[pattern.point_of(q) as usize];
                    let at = at_point.trailing_zeros() as u8;
                    let label = pattern.labels()[at as usize];
                    parent = self.nodes.len() as u32;
                    self.nodes.push(Node { remaining, parent: NONE, p: label, q: label, at, odd });
                    min_position = at + 1;
                }
                let at = from_on(self.positions[p as usize], min_position).trailing_zeros() as u8;
                let next_position = if at < 64 { after(self.positions[q as usize], at) } else { 0 };
                if next_position != 0 {
                    self.nodes.push(Node { remaining, parent, p, q: p, at, odd });
                    let parent = self.nodes.len() as u32 - 1;
                    self.add(Node {
                        remaining,
                        parent,
                        p,
                        q,
                        at: next_position.trailing_zeros() as u8,
                        odd,
                    });
                }
            }
        }
    }

    /// Adds what follows by drawing a triangle. Returns the node that draws the last one.
    fn expand_drawing(&mut self, pattern: &Pattern, parent: u32) -> Option<u32> {
        let Node { remaining, p, q, at, odd, .. } = self.nodes[parent as usize];
        let mut candidates =
            remaining & self.triangles_with[p as usize] & self.triangles_with[q as usize];
        let mut last_drawn = None;
        while candidates != 0 {
            let bit = candidates.trailing_zeros();
            candidates &= candidates - 1;
            let t = self.triangles[bit as usize];
            let [a, b, c] = t;
            let (from, to) = if odd { (q, p) } else { (p, q) };
            let next = match (from, to) {
                _ if p == q || last_drawn == Some(t) => continue,
                _ if (from, to) == (a, b) => c,
                _ if (from, to) == (b, c) => a,
                _ if (from, to) == (c, a) => b,
                _ => continue,
            };
            last_drawn = Some(t);
            debug_assert!(pattern.triangle([p, q, next], odd) == Some(t));
            let next_position = after(self.positions[next as usize], at);
            if next_position != 0 {
                let remaining = remaining & !(1 << bit);
                let node = Node {
                    remaining,
                    parent,
                    p: q,
                    q: next,
                    at: next_position.trailing_zeros() as u8,
                    odd: !odd,
                };
                let added = self.add(node);
                if remaining == 0 {
                    return added;
                }
            }
        }
        None
    }

    /// Adds what follows by a degenerate triangle.
    fn expand_wasting(&mut self, pattern: &Pattern, parent: u32) {
        let Node { remaining, p, q, at, odd, .. } = self.nodes[parent as usize];
        let points = (pattern.point_of(p), pattern.point_of(q));
        let choices = if points.0 == points.1 {
            pattern.all()
        } else {
            self.positions_at[points.0 as usize] | self.positions_at[points.1 as usize]
        };
        let mut choices = after(choices, at);
        while choices != 0 {
            let at = choices.trailing_zeros() as u8;
            let next = pattern.labels()[at as usize];
            // Only the first of each label: later ones can do no more.
            choices &= !self.positions[next as usize];
            self.add(Node { remaining, parent, p: q, q: next, at, odd: !odd });
        }
    }

    /// Adds a node, unless it leads nowhere or its state was reached at an earlier or the same
    /// position. Returns its index.
    fn add(&mut self, node: Node) -> Option<u32> {
        if node.remaining != 0 && !self.can_finish(&node) {
            return None;
        }
        let slot = self.slot(&node);
        match self.slots[slot] {
            NONE => self.used_slots.push(slot as u32),
            best if self.nodes[best as usize].at <= node.at => return None,
            _ => {}
        }
        let index = self.nodes.len() as u32;
        self.slots[slot] = index;
        self.nodes.push(node);
        self.open.push(index);
        Some(index)
    }

    /// Returns whether each remaining triangle, by itself, can still be drawn. False is certain;
    /// true is not, since triangles may exclude each other.
    fn can_finish(&self, node: &Node) -> bool {
        let mut last_chance = node.remaining & self.unreachable[node.at as usize];
        while last_chance != 0 {
            let t = self.triangles[last_chance.trailing_zeros() as usize];
            last_chance &= last_chance - 1;
            let missing = |v: u8| after(self.positions[v as usize], node.at) == 0;
            // A corner that does not come again must be one of the last two; and the older of them
            // is of use only in the very next triangle, which has both.
            let drawable = t
                .into_iter()
                .all(|v| !missing(v) || v == node.q || v == node.p && t.contains(&node.q));
            if !drawable {
                return false;
            }
        }
        true
    }

    /// Returns whether a node is still the one that reached its state at the earliest position.
    fn is_best(&self, index: u32) -> bool {
        self.slots[self.slot(&self.nodes[index as usize])] == index
    }

    /// Returns the slot of the hash table in which the best node of a node's state is, or belongs.
    fn slot(&self, node: &Node) -> usize {
        let state = |n: &Node| (n.remaining, n.p, n.q, n.odd);
        let bits = node.remaining
            ^ u64::from(node.p) << 49
            ^ u64::from(node.q) << 56
            ^ u64::from(node.odd) << 63;
        let mut slot = (bits.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize % SLOTS;
        while self.slots[slot] != NONE
            && state(&self.nodes[self.slots[slot] as usize]) != state(node)
        {
            slot = (slot + 1) % SLOTS;
        }
        slot
    }

    /// The positions kept on the way to a node.
    fn kept_positions(&self, mut node: u32) -> u64 {
        let mut mask = 0;
        while node != NONE {
            mask |= 1 << self.nodes[node as usize].at;
            node = self.nodes[node as usize].parent;
        }
        mask
    }
}

/// The positions of a mask that come after one.
fn after(mask: u64, at: u8) -> u64 {
    mask & (u64::MAX << at << 1)
}

/// The positions of a mask from one on.
fn from_on(mask: u64, at: u8) -> u64 {
    if at < 64 { mask & u64::MAX << at } else { 0 }
}
