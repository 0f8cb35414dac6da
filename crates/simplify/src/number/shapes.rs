//! The shapes that a mesh takes in motion: the positions of its groups in each of them, as far as
//! they are others than at rest.

use crate::SeenShapes;
use glam::Vec3;

/// The most shapes of a mesh besides the one at rest: a bit of a [`ShapeSet`] for each.
pub(crate) const MAX_SHAPES: usize = ShapeSet::BITS as usize;

/// A set of shapes: one bit for each.
pub(crate) type ShapeSet = u128;

/// Iterates over the shapes of a set, rising.
#[inline]
pub(crate) fn each_shape(mut set: ShapeSet) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let shape = set.trailing_zeros();
        set &= set.wrapping_sub(1);
        (shape < ShapeSet::BITS).then_some(shape)
    })
}

/// The number of shapes of a set before one of them: its index in a row with one entry for each.
#[inline]
pub(crate) fn index_in(set: ShapeSet, shape: u32) -> usize {
    (set & ((1 << shape) - 1)).count_ones() as usize
}

/// The positions of groups in motion.
#[derive(Default)]
pub(crate) struct GroupShapes {
    /// For each group the shapes in which it is elsewhere than at rest; empty without shapes.
    moved: Vec<ShapeSet>,
    /// The start of each group's positions.
    starts: Vec<u32>,
    /// In working units, by group and shape.
    positions: Vec<Vec3>,
    /// The factor of costs in each shape.
    weights: Vec<f64>,
}

impl GroupShapes {
    /// The positions of groups, each given by one of its vertices. `scale` turns mesh units into
    /// working units.
    pub(crate) fn new(
        seen: &SeenShapes,
        at_rest: &[[f32; 3]],
        vertices: impl Iterator<Item = u32>,
        scale: f64,
    ) -> Self {
        let others = &seen.others[..seen.others.len().min(MAX_SHAPES)];
        if others.is_empty() {
            return Self::default();
        }
        let weights = others.iter().map(|shape| shape.weight).collect();
        let mut shapes = Self { weights, ..Self::default() };
        for v in vertices {
            shapes.starts.push(shapes.positions.len() as u32);
            let mut moved = 0;
            for (shape, number) in others.iter().zip(0..) {
                let position = shape.positions[v as usize];
                if position != at_rest[v as usize] {
                    moved |= 1 << number;
                    let scaled = position.map(|c| (f64::from(c) * scale) as f32);
                    shapes.positions.push(Vec3::from(scaled));
                }
            }
            shapes.moved.push(moved);
        }
        shapes
    }

    /// Returns whether the mesh has one shape only.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.moved.is_empty()
    }

    /// The shapes in which a group is elsewhere than at rest.
    #[inline]
    pub(crate) fn moved(&self, group: u32) -> ShapeSet {
        self.moved.get(group as usize).copied().unwrap_or(0)
    }

    /// The position of a group in a shape, in working units; none if it is that at rest.
    #[inline]
    pub(crate) fn position(&self, group: u32, shape: u32) -> Option<Vec3> {
        let moved = self.moved[group as usize];
        (moved >> shape & 1 != 0)
            .then(|| self.positions[self.starts[group as usize] as usize + index_in(moved, shape)])
    }

    /// The factor of costs in a shape.
    #[inline]
    pub(crate) fn weight(&self, shape: u32) -> f64 {
        self.weights[shape as usize]
    }
}
