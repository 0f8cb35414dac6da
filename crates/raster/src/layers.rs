//! For every pixel of a picture, the list of all fragments there, sorted by depth: what is seen,
//! and what would be seen if a triangle were removed. A fragment is an *item* (the number of a
//! triangle, say) at a depth.

/// An item at a depth. The order is by depth, nearest first, then by item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fragment(u64);

impl Fragment {
    /// No item, behind everything.
    pub const NOTHING: Self = Self(u64::MAX);

    /// An item at a depth.
    #[must_use]
    #[inline]
    pub fn new(item: u32, depth: i32) -> Self {
        // With the sign bit turned over, integers sort as unsigned ones.
        Self(u64::from(depth as u32 ^ 0x8000_0000) << 32 | u64::from(item))
    }

    /// The item; `u32::MAX` for [`NOTHING`](Self::NOTHING).
    #[must_use]
    #[inline]
    pub fn item(self) -> u32 {
        self.0 as u32
    }
}

/// The end of a list.
const END: u32 = u32::MAX;

/// An element of a list.
#[derive(Clone, Copy, Debug)]
struct Node {
    fragment: Fragment,
    /// The index of the next one in [`Layers::nodes`], or [`END`].
    next: u32,
}

/// Sorted lists of fragments, one for each pixel. The first of each is in the picture itself.
#[derive(Clone, Debug)]
pub struct Layers {
    /// The first node of each pixel; one with [`Fragment::NOTHING`] for an empty list.
    heads: Vec<Node>,
    /// All other nodes, free ones among them.
    nodes: Vec<Node>,
    /// The first free node, which leads to the next one; [`END`] for none.
    free: u32,
}

impl Layers {
    /// Empty lists for `pixels` pixels.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        Self {
            heads: vec![Node { fragment: Fragment::NOTHING, next: END }; pixels],
            nodes: Vec::new(),
            free: END,
        }
    }

    /// Inserts a fragment at a pixel.
    pub fn insert(&mut self, pixel: usize, fragment: Fragment) {
        let head = self.heads[pixel];
        if fragment < head.fragment {
            let next = if head.fragment == Fragment::NOTHING { END } else { self.allocate(head) };
            self.heads[pixel] = Node { fragment, next };
            return;
        }
        let mut previous = END;
        let mut current = head.next;
        while current != END && self.nodes[current as usize].fragment < fragment {
            previous = current;
            current = self.nodes[current as usize].next;
        }
        let new = self.allocate(Node { fragment, next: current });
        *self.link(pixel, previous) = new;
    }

    /// Removes an item's fragment, which must be there.
    pub fn remove(&mut self, pixel: usize, item: u32) {
        let head = self.heads[pixel];
        if head.fragment.item() == item {
            let empty = Node { fragment: Fragment::NOTHING, next: END };
            self.heads[pixel] = if head.next == END { empty } else { self.free_node(head.next) };
            return;
        }
        let mut previous = END;
        let mut current = head.next;
        while self.nodes[current as usize].fragment.item() != item {
            previous = current;
            current = self.nodes[current as usize].next;
        }
        let next = self.free_node(current).next;
        *self.link(pixel, previous) = next;
    }

    /// Stores a node in a free slot. Returns its number.
    fn allocate(&mut self, node: Node) -> u32 {
        if self.free == END {
            self.nodes.push(node);
            return self.nodes.len() as u32 - 1;
        }
        let new = self.free;
        self.free = std::mem::replace(&mut self.nodes[new as usize], node).next;
        new
    }

    /// Frees a node's slot. Returns the node.
    fn free_node(&mut self, current: u32) -> Node {
        let node = self.nodes[current as usize];
        self.nodes[current as usize].next = std::mem::replace(&mut self.free, current);
        node
    }

    /// The link to the node after `previous`; `END` stands for the head.
    fn link(&mut self, pixel: usize, previous: u32) -> &mut u32 {
        if previous == END {
            &mut self.heads[pixel].next
        } else {
            &mut self.nodes[previous as usize].next
        }
    }

    /// Returns the fragment seen at a pixel.
    #[must_use]
    #[inline]
    pub fn front(&self, pixel: usize) -> Fragment {
        self.heads[pixel].fragment
    }

    /// Returns the fragments seen at consecutive pixels.
    #[inline]
    pub fn fronts(&self, first: usize, count: usize) -> impl Iterator<Item = Fragment> + '_ {
        self.heads[first..first + count].iter().map(|node| node.fragment)
    }

    /// The fragments behind the first one, nearest first.
    #[inline]
    pub fn behind(&self, pixel: usize) -> impl Iterator<Item = Fragment> + '_ {
        let mut current = self.heads[pixel].next;
        std::iter::from_fn(move || {
            let node = self.nodes.get(current as usize)?;
            current = node.next;
            Some(node.fragment)
        })
    }
}
