//! Normals that turn in motion. The attributes of a vertex are a row of numbers (`attributes`), of
//! which a normal is three columns; here is what each shape adds to them, where that is not zero.
//! The number of a shape is its index in [`SeenShapes::others`].

use crate::SeenShapes;
use crate::number::{MAX_SHAPES, ShapeSet, index_in};
use glam::{Vec3, Vec4};

/// Normals in motion, as differences from those at rest.
#[derive(Default)]
pub(super) struct TurnedNormals {
    /// For each vertex the shapes in which it has another normal than at rest; empty without any.
    sets: Vec<ShapeSet>,
    /// The start of each vertex's differences.
    starts: Vec<u32>,
    /// Vertex by vertex, for each shape of its set in order: the first of the three columns, and
    /// what is added to them, in working units.
    differences: Vec<(u32, Vec3)>,
}

impl TurnedNormals {
    /// The normals of all vertices. `difference` is given a vertex and its normal in a shape;
    /// returns the first of the normal's columns and what is added to them, if anything counts.
    pub(super) fn new(
        seen: &SeenShapes,
        vertices: u32,
        difference: impl Fn(u32, [f32; 3]) -> Option<(usize, Vec3)>,
    ) -> Self {
        let others = &seen.others[..seen.others.len().min(MAX_SHAPES)];
        let mut turned = Self::default();
        if others.iter().all(|shape| shape.normals.is_empty()) {
            return turned;
        }
        for v in 0..vertices {
            turned.starts.push(turned.differences.len() as u32);
            let mut set = 0;
            for (shape, number) in others.iter().zip(0..) {
                let normal = shape.normals.get(v as usize);
                let found = normal.and_then(|&normal| difference(v, normal));
                if let Some((column, delta)) = found.filter(|(_, delta)| *delta != Vec3::ZERO) {
                    set |= 1 << number;
                    turned.differences.push((column as u32, delta));
                }
            }
            turned.sets.push(set);
        }
        turned
    }

    /// Returns whether no vertex has another normal.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// The shapes in which a vertex has another normal than at rest.
    #[inline]
    pub(super) fn set(&self, vertex: u32) -> ShapeSet {
        self.sets.get(vertex as usize).copied().unwrap_or(0)
    }

    /// What a shape adds to four columns of a vertex, from the column `first` on.
    pub(super) fn four(&self, vertex: u32, first: usize, shape: u32) -> Vec4 {
        let set = self.set(vertex);
        if set >> shape & 1 == 0 {
            return Vec4::ZERO;
        }
        let row = self.starts[vertex as usize] as usize + index_in(set, shape);
        let (column, delta) = self.differences[row];
        let mut four = [0.0; 4];
        for (k, part) in delta.to_array().into_iter().enumerate() {
            // A column before the four wraps to an index far behind them.
            let at = (column as usize + k).wrapping_sub(first);
            if let Some(number) = four.get_mut(at) {
                *number = part;
            }
        }
        Vec4::from_array(four)
    }
}
