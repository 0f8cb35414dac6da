//! Pattern that a filter depends on: positions of a strip that hold the same vertex, and vertices
//! that are at one position.

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
    places: [u8; LONGEST],
    /// Number of labels.
    count: usize,
    /// True if every label has a place of its own.
    plain: bool,
}

impl Pattern {
    /// The pattern of a strip of 3 to [`LONGEST`] vertices. `place` names the point in space at
    /// which a vertex is.
    pub(super) fn new(strip: &[u32], place: impl Fn(u32) -> u32) -> Self {
        let mut pattern = Self {
            len: strip.len(),
            labels: [0; LONGEST],
            places: [0; LONGEST],
            count: 0,
            plain: true,
        };
        let (mut vertices, mut points) = ([0; LONGEST], [0; LONGEST]);
        for (at, &v) in strip.iter().enumerate() {
            let known = vertices[..pattern.count].iter().position(|&w| w == v);
            pattern.labels[at] = known.unwrap_or_else(|| {
                let label = pattern.count;
                (vertices[label], points[label]) = (v, place(v));
                let mate = points[..label].iter().position(|&p| p == points[label]);
                pattern.plain &= mate.is_none();
                pattern.places[label] = mate.unwrap_or(label) as u8;
                pattern.count += 1;
                label
            }) as u8;
        }
        pattern
    }

    pub(super) fn labels(&self) -> &[u8] {
        &self.labels[..self.len]
    }

    /// Returns the number of different labels.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    pub(super) fn place(&self, label: u8) -> u8 {
        self.places[label as usize]
    }

    /// The whole strip.
    pub(super) fn all(&self) -> u64 {
        u64::MAX >> (64 - self.len)
    }

    /// The triangle of three consecutive drawn labels, unless it is degenerate: corners
    /// counter-clockwise, least first.
    pub(super) fn triangle(&self, [a, b, c]: [u8; 3], odd: bool) -> Option<[u8; 3]> {
        let [x, y, z] = [a, b, c].map(|label| self.place(label));
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
        let mut rest = mask;
        let mut next = move || {
            let at = rest.trailing_zeros() as usize;
            rest &= rest.wrapping_sub(1);
            (at < LONGEST).then(|| self.labels[at])
        };
        let mut window = [0, next().unwrap_or(0), next().unwrap_or(0)];
        let corners = std::iter::from_fn(move || {
            window = [window[1], window[2], next()?];
            Some(window)
        });
        corners.enumerate().filter_map(|(k, corners)| self.triangle(corners, k % 2 == 1))
    }

    /// The pattern as numbers, 4 bits a label: the labels, the places (0 if every label has its
    /// own) and the length.
    pub(super) fn key(&self) -> (u64, u64, usize) {
        let pack = |numbers: &[u8]| numbers.iter().fold(0, |key, &n| key << 4 | u64::from(n));
        (
            pack(self.labels()),
            if self.plain { 0 } else { pack(&self.places[..self.count]) },
            self.len,
        )
    }
}
