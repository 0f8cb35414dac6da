//! The pattern that the filter of a strip depends on: which positions of the strip hold the same
//! vertex, and which vertices are at one point in space.

/// Longest strip that a mask covers: two masks fit into one word.
pub(super) const LONGEST: usize = 16;

/// A strip whose vertices are replaced by labels, numbered in order of first appearance. Two strips
/// with the same pattern have the same filters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pattern {
    len: usize,
    /// The label at each position of the strip.
    labels: [u8; LONGEST],
    /// For each label the first label that is at the same point in space.
    points: [u8; LONGEST],
    label_count: usize,
    /// True if no two labels are at one point.
    has_distinct_points: bool,
}

impl Pattern {
    /// The pattern of a strip of 3 to [`LONGEST`] vertices. `point_of` names the point in space at
    /// which a vertex is.
    pub(super) fn new(strip: &[u32], point_of: impl Fn(u32) -> u32) -> Self {
        let mut pattern = Self {
            len: strip.len(),
            labels: [0; LONGEST],
            points: [0; LONGEST],
            label_count: 0,
            has_distinct_points: true,
        };
        let (mut vertices, mut label_points) = ([0; LONGEST], [0; LONGEST]);
        for (index, &v) in strip.iter().enumerate() {
            let existing = vertices[..pattern.label_count].iter().position(|&w| w == v);
            pattern.labels[index] = existing.unwrap_or_else(|| {
                let label = pattern.label_count;
                (vertices[label], label_points[label]) = (v, point_of(v));
                let same_point =
                    label_points[..label].iter().position(|&p| p == label_points[label]);
                pattern.has_distinct_points &= same_point.is_none();
                pattern.points[label] = same_point.unwrap_or(label) as u8;
                pattern.label_count += 1;
                label
            }) as u8;
        }
        pattern
    }

    /// Returns the label at each position of the strip.
    pub(super) fn labels(&self) -> &[u8] {
        &self.labels[..self.len]
    }

    /// Returns the number of different labels.
    pub(super) fn label_count(&self) -> usize {
        self.label_count
    }

    /// Returns the first label that is at the same point in space.
    pub(super) fn point_of(&self, label: u8) -> u8 {
        self.points[label as usize]
    }

    /// Returns the mask of the whole strip.
    pub(super) fn all(&self) -> u64 {
        u64::MAX >> (64 - self.len)
    }

    /// The triangle of three consecutive drawn labels, unless it is degenerate: corners
    /// counter-clockwise, the least label first. `odd` says that it is every second triangle of the
    /// strip, which is turned.
    pub(super) fn triangle(&self, [a, b, c]: [u8; 3], odd: bool) -> Option<[u8; 3]> {
        let [x, y, z] = [a, b, c].map(|label| self.point_of(label));
        if x == y || y == z || z == x {
            return None;
        }
        let [a, b, c] = if odd { [b, a, c] } else { [a, b, c] };
        Some(if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        })
    }

    /// The triangles that the positions in `mask` draw, in order.
    pub(super) fn drawn(&self, mask: u64) -> impl Iterator<Item = [u8; 3]> {
        let mut mask_left = mask;
        let mut next = move || {
            let index = mask_left.trailing_zeros() as usize;
            mask_left &= mask_left.wrapping_sub(1);
            (index < LONGEST).then(|| self.labels[index])
        };
        let mut window = [0, next().unwrap_or(0), next().unwrap_or(0)];
        let corners = std::iter::from_fn(move || {
            window = [window[1], window[2], next()?];
            Some(window)
        });
        corners.enumerate().filter_map(|(k, corners)| self.triangle(corners, k % 2 == 1))
    }

    /// Returns the pattern as a key for a hash table.
    pub(super) fn key(&self) -> PatternKey {
        let pack = |numbers: &[u8]| numbers.iter().fold(0, |key, &n| key << 4 | u64::from(n));
        PatternKey {
            labels: pack(self.labels()),
            points: if self.has_distinct_points {
                0
            } else {
                pack(&self.points[..self.label_count])
            },
            len: self.len,
        }
    }
}

/// A pattern, packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PatternKey {
    /// 4 bits for each position of the strip.
    labels: u64,
    /// 4 bits for each label; 0 if no two labels are at one point.
    points: u64,
    len: usize,
}

impl PatternKey {
    /// The key of no pattern.
    pub(super) const NONE: Self = Self { labels: 0, points: 0, len: 0 };

    /// Mixes all bits; the multiplier is 2⁶⁴ over the golden ratio, the rotation chosen by hand.
    pub(super) fn hash(self) -> usize {
        let mixed = (self.labels ^ self.points.rotate_left(11) ^ self.len as u64)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 40) as usize
    }
}
