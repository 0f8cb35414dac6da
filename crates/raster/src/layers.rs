//! Everything behind every pixel of one picture, sorted by depth: what is seen, and what would be
//! without it.

/// One item at a pixel: items at one depth are sorted by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fragment(u64);

impl Fragment {
    /// Behind everything.
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

const END: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Node {
    fragment: Fragment,
    next: u32,
}

/// Sorted lists of fragments, one for each pixel. The first of each is in the picture itself.
#[derive(Clone, Debug)]
pub struct Layers {
    heads: Vec<Node>,
    nodes: Vec<Node>,
    free: u32,
}

impl Layers {
    /// Nothing behind any of `pixels` pixels.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        Self {
            heads: vec![Node { fragment: Fragment::NOTHING, next: END }; pixels],
            nodes: Vec::new(),
            free: END,
        }
    }

    /// Puts a fragment behind a pixel.
    pub fn insert(&mut self, pixel: usize, fragment: Fragment) {
        let head = self.heads[pixel];
        if fragment < head.fragment {
            let next = if head.fragment == Fragment::NOTHING { END } else { self.keep(head) };
            self.heads[pixel] = Node { fragment, next };
            return;
        }
        let mut before = END;
        let mut at = head.next;
        while at != END && self.nodes[at as usize].fragment < fragment {
            before = at;
            at = self.nodes[at as usize].next;
        }
        let new = self.keep(Node { fragment, next: at });
        *self.link(pixel, before) = new;
    }

    /// Takes an item's fragment away. It must be there.
    pub fn remove(&mut self, pixel: usize, item: u32) {
        let head = self.heads[pixel];
        if head.fragment.item() == item {
            let empty = Node { fragment: Fragment::NOTHING, next: END };
            self.heads[pixel] = if head.next == END { empty } else { self.take(head.next) };
            return;
        }
        let mut before = END;
        let mut at = head.next;
        while self.nodes[at as usize].fragment.item() != item {
            before = at;
            at = self.nodes[at as usize].next;
        }
        let next = self.take(at).next;
        *self.link(pixel, before) = next;
    }

    /// Finds room for a node.
    fn keep(&mut self, node: Node) -> u32 {
        if self.free == END {
            self.nodes.push(node);
            return self.nodes.len() as u32 - 1;
        }
        let new = self.free;
        self.free = std::mem::replace(&mut self.nodes[new as usize], node).next;
        new
    }

    /// Frees a node's room.
    fn take(&mut self, at: u32) -> Node {
        let node = self.nodes[at as usize];
        self.nodes[at as usize].next = std::mem::replace(&mut self.free, at);
        node
    }

    /// Slot of the number of the node after `before`, `END` being the head.
    fn link(&mut self, pixel: usize, before: u32) -> &mut u32 {
        if before == END {
            &mut self.heads[pixel].next
        } else {
            &mut self.nodes[before as usize].next
        }
    }

    /// Returns the item seen at a pixel.
    #[must_use]
    #[inline]
    pub fn front(&self, pixel: usize) -> Fragment {
        self.heads[pixel].fragment
    }

    /// Returns the items seen at consecutive pixels.
    #[inline]
    pub fn fronts(&self, first: usize, count: usize) -> impl Iterator<Item = Fragment> + '_ {
        self.heads[first..first + count].iter().map(|node| node.fragment)
    }

    /// The fragments behind the first one, nearest first.
    #[inline]
    pub fn behind(&self, pixel: usize) -> impl Iterator<Item = Fragment> + '_ {
        let mut at = self.heads[pixel].next;
        std::iter::from_fn(move || {
            let node = self.nodes.get(at as usize)?;
            at = node.next;
            Some(node.fragment)
        })
    }
}
