//! Lists of numbers packed one behind the other (compressed sparse rows), filled by counting sort.

use std::ops::Range;

/// Rows of `u32` values in one array: row `i` is `values[offsets[i]..offsets[i + 1]]`.
///
/// Built in linear time by counting: one pass over the entries for the lengths, one to place them.
/// Entries keep their order within a row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Csr {
    /// Start of each row, and the length of `values` at the end.
    pub offsets: Vec<u32>,
    /// The values of all rows.
    pub values: Vec<u32>,
}

impl Csr {
    /// Sorts `(row, value)` entries into `rows` rows. Iterates over `entries` twice.
    ///
    /// # Panics
    /// If an entry names a row that does not exist.
    #[must_use]
    pub fn new(rows: usize, entries: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut offsets = vec![0u32; rows + 1];
        for (row, _) in entries.clone() {
            offsets[row as usize + 1] += 1;
        }
        for row in 0..rows {
            offsets[row + 1] += offsets[row];
        }
        let mut next_slots = offsets.clone();
        let mut values = vec![0; offsets[rows] as usize];
        for (row, value) in entries {
            let slot = &mut next_slots[row as usize];
            values[*slot as usize] = value;
            *slot += 1;
        }
        Self { offsets, values }
    }

    /// The corners of triangles by vertex: row `v` holds `3 * triangle + corner` for each corner at
    /// `v`, rising.
    #[must_use]
    pub fn corners(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let corners = triangles.as_flattened().iter().zip(0..);
        Self::new(vertices, corners.map(|(&v, corner)| (v, corner)))
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Range of a row's values.
    #[must_use]
    pub fn range(&self, row: u32) -> Range<usize> {
        self.offsets[row as usize] as usize..self.offsets[row as usize + 1] as usize
    }

    /// The values of a row.
    #[must_use]
    pub fn row(&self, row: u32) -> &[u32] {
        &self.values[self.range(row)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_keep_their_order_within_rows() {
        let entries = [(2, 7), (0, 1), (2, 3), (3, 9), (0, 1)];
        let csr = Csr::new(5, entries.into_iter());
        let rows: Vec<&[u32]> = (0..5).map(|r| csr.row(r)).collect();
        assert_eq!(rows, [&[1, 1][..], &[], &[7, 3], &[9], &[]]);
        assert_eq!((csr.rows(), Csr::new(0, std::iter::empty()).rows()), (5, 0));
    }

    #[test]
    fn corners_are_found_by_vertex() {
        let csr = Csr::corners(&[[0, 1, 2], [2, 1, 3]], 4);
        assert_eq!((csr.row(1), csr.row(2), csr.row(3)), (&[1, 4][..], &[2, 3][..], &[5][..]));
    }
}
