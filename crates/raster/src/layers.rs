//! Everything behind every pixel of one picture, sorted by depth: what is seen, and what would be without it.

/// What of an item lies at a pixel: items at one depth are sorted by number.
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

/// Sorted lists of fragments, one for each pixel.
#[derive(Clone, Debug)]
pub struct Layers {
    heads: Vec<u32>,
    nodes: Vec<Node>,
    free: u32,
}

impl Layers {
    /// Nothing behind any of so many pixels.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        Self { heads: vec![END; pixels], nodes: Vec::new(), free: END }
    }

    /// Puts a fragment behind a pixel.
    pub fn insert(&mut self, pixel: usize, fragment: Fragment) {
        let mut before = END;
        let mut at = self.heads[pixel];
        while at != END && self.nodes[at as usize].fragment < fragment {
            before = at;
            at = self.nodes[at as usize].next;
        }
        let node = Node { fragment, next: at };
        let new = if self.free == END {
            self.nodes.push(node);
            self.nodes.len() as u32 - 1
        } else {
            let new = self.free;
            self.free = std::mem::replace(&mut self.nodes[new as usize], node).next;
            new
        };
        *self.link(pixel, before) = new;
    }

    /// Takes an item's fragment away. It must be there.
    pub fn remove(&mut self, pixel: usize, item: u32) {
        let mut before = END;
        let mut at = self.heads[pixel];
        while self.nodes[at as usize].fragment.item() != item {
            before = at;
            at = self.nodes[at as usize].next;
        }
        *self.link(pixel, before) = self.nodes[at as usize].next;
        self.nodes[at as usize].next = std::mem::replace(&mut self.free, at);
    }

    fn link(&mut self, pixel: usize, before: u32) -> &mut u32 {
        if before == END { &mut self.heads[pixel] } else { &mut self.nodes[before as usize].next }
    }

    /// The item that is seen at a pixel, `u32::MAX` if none.
    #[must_use]
    #[inline]
    pub fn front(&self, pixel: usize) -> u32 {
        let head = self.heads[pixel];
        if head == END { u32::MAX } else { self.nodes[head as usize].fragment.item() }
    }

    /// The fragments behind a pixel, nearest first.
    #[inline]
    pub fn at(&self, pixel: usize) -> impl Iterator<Item = Fragment> + '_ {
        let mut at = self.heads[pixel];
        std::iter::from_fn(move || {
            let node = self.nodes.get(at as usize)?;
            at = node.next;
            Some(node.fragment)
        })
    }
}
