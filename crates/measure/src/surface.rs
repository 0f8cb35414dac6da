//! A triangle surface in space.

use crate::texture::Pyramid;
use glam::{DVec3, Vec2, Vec3};
use lodc_nearest::TriangleTree;
use lodc_scene::Material;
use std::sync::Arc;

/// Triangles in one space, and what pictures of them need. Every index is in range, or measuring
/// panics.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Finite positions.
    pub positions: Vec<Vec3>,
    /// Corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One normal per position to shade with; empty if there are none.
    pub normals: Vec<Vec3>,
    /// One pair of texture coordinates per position; empty if there are none.
    pub texture: Vec<Vec2>,
    /// One linear colour per position, 0 to 1, by which others are multiplied; empty if there are
    /// none.
    pub colours: Vec<Vec3>,
    /// The material of each triangle; empty if there are none.
    pub material_of: Vec<u32>,
    /// Materials.
    pub materials: Vec<Material>,
    /// The images of materials' textures.
    pub images: Arc<[Pyramid]>,
}

impl Surface {
    /// A triangle's corners.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize].as_dvec3())
    }

    /// A search tree over the triangles.
    #[must_use]
    pub fn tree(&self) -> TriangleTree {
        TriangleTree::new(&(0..self.triangles.len()).map(|t| self.corners(t)).collect::<Vec<_>>())
    }

    /// Least and greatest coordinates of the corners of triangles; zeros if there are none.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let mut corners =
            self.triangles.iter().flatten().map(|&v| self.positions[v as usize].as_dvec3());
        let Some(first) = corners.next() else { return (DVec3::ZERO, DVec3::ZERO) };
        corners.fold((first, first), |(lo, hi), p| (lo.min(p), hi.max(p)))
    }

    /// Length of the bounding box's diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        let (lo, hi) = self.bounds();
        (hi - lo).length()
    }
}
