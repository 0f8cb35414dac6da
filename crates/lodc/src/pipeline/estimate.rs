//! Memory that the stages of a build need, from the size of a mesh.
//!
//! The bytes for each triangle and vertex were measured on a closed scan, a mesh with seams and
//! loose triangles (docs/BENCHMARKS.md), and rounded up. Vertices count beside triangles, since
//! loose triangles have three each.

use lodc_formats::SceneObject;
use lodc_lod::ModelKind;
use lodc_scene::MAX_TARGET_SHAPES;
use lodc_simplify::MetricKind;

/// The size of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Triangles of all objects.
    pub triangles: u64,
    /// Vertices of all objects.
    pub vertices: u64,
    /// Vertices of objects in motion, once for each shape that collapses are priced in, at most.
    pub moving: u64,
}

/// Poses of an animation that are priced, by default.
const POSES: u64 = super::DEFAULT_POSES as u64;
/// Bytes for each vertex and shape: positions of the vertex and of its group, and a quadric.
const MOVING_BYTES: u64 = 130;

/// Bytes that a stage may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Need {
    /// Bytes at the stage's peak.
    pub bytes: u64,
    /// The stage's name in reports.
    pub stage: &'static str,
}

impl Size {
    /// The size of some meshes, given by their triangles and vertices.
    pub fn of(meshes: impl Iterator<Item = (usize, usize)>) -> Self {
        let none = Self { triangles: 0, vertices: 0, moving: 0 };
        meshes.fold(none, |all, (triangles, vertices)| Self {
            triangles: all.triangles.saturating_add(triangles as u64),
            vertices: all.vertices.saturating_add(vertices as u64),
            ..all
        })
    }

    /// The size of the objects of a scene.
    pub fn of_objects(objects: &[SceneObject]) -> Self {
        let moving = |o: &SceneObject| {
            let moving = || o.mesh.attributes().iter().filter(|a| a.moves());
            let targets = moving().filter_map(|a| a.morph_target).max().map_or(0, |t| t + 1);
            let shapes = u64::from(targets.min(MAX_TARGET_SHAPES as u32)) + POSES;
            if moving().next().is_some() { o.mesh.vertex_count() as u64 * shapes } else { 0 }
        };
        let sizes = objects.iter().map(|o| (o.mesh.triangles().len(), o.mesh.vertex_count()));
        Self { moving: objects.iter().map(moving).sum(), ..Self::of(sizes) }
    }

    /// The need of simplification. Metrics other than the quadric simplify the mesh as a whole.
    pub fn simplify(self, mut metrics: impl Iterator<Item = MetricKind>) -> Need {
        let is_visual = |metric| metric != MetricKind::Quadric;
        let loose = self.bytes(0, 490).saturating_sub(self.bytes(60, 0));
        let plain = self.bytes(205, 0).max(loose);
        let visual = if metrics.any(is_visual) { self.bytes(500, 0) } else { 0 };
        let moving = self.moving.saturating_mul(MOVING_BYTES);
        Need { bytes: plain.max(visual).saturating_add(moving), stage: "simplify" }
    }

    /// The need of measuring errors.
    pub fn errors(self) -> Need {
        Need { bytes: self.bytes(100, 230), stage: "errors" }
    }

    /// The need of models and of their check.
    pub fn models(self, kinds: &[ModelKind]) -> Need {
        let bytes = match kinds.len() as u64 {
            0 => 0,
            n => self.bytes(70 + 40 * n, 150 + 30 * n),
        };
        Need { bytes, stage: "models" }
    }

    /// The need of strips alone.
    pub fn strips(self) -> Need {
        Need { bytes: self.bytes(60, 160), stage: "strips" }
    }

    fn bytes(self, per_triangle: u64, per_vertex: u64) -> u64 {
        let triangles = self.triangles.saturating_mul(per_triangle);
        triangles.saturating_add(self.vertices.saturating_mul(per_vertex))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_lie_above_what_was_measured() {
        let size = |triangles, vertices_per_triangle: f64| Size {
            triangles,
            vertices: (triangles as f64 * vertices_per_triangle) as u64,
            moving: 0,
        };
        let quadric = || std::iter::once(MetricKind::Quadric);
        // Bytes a triangle: a grid of 2,000,000 triangles, then 300,000 loose ones.
        for (size, simplify, errors, models) in
            [(size(2_000_000, 0.5), 171, 214, 281), (size(300_000, 3.0), 1_374, 742, 823)]
        {
            let needs = [size.simplify(quadric()), size.errors(), size.models(&ModelKind::ALL)];
            for (need, measured) in needs.into_iter().zip([simplify, errors, models]) {
                let [least, most] = [measured, measured * 5 / 4].map(|b| b * size.triangles);
                assert!((least..most).contains(&need.bytes), "{need:?} {measured}");
            }
        }
    }

    #[test]
    fn a_hundred_million_triangles_fit_into_24_gigabytes() {
        let size = |triangles| Size { triangles, vertices: triangles / 2, moving: 0 };
        assert!(size(100_000_000).errors().bytes < 24_000_000_000);
        assert!(size(30_000_000).errors().bytes < 8_000_000_000);
    }

    #[test]
    fn sizes_without_end_need_all_there_is() {
        let size = Size { triangles: u64::MAX, vertices: 3, moving: 0 };
        assert_eq!(size.errors().bytes, u64::MAX);
        assert_eq!(size.models(&[]).bytes, 0);
    }
}
