//! LOD 0 as the input of a refit, the same over all iterations: a tree over its triangles, samples
//! on them, charts, and curves with their own tree.

use crate::charts::{Continuity, charts, curves};
use crate::quadrature::{Rule, rules_for_ratio};
use crate::sheets::Sheet;
use glam::DVec3;
use lodc_mesh::{DisjointSets, Mesh, Semantic};
use lodc_nearest::{TriangleTree, point_at};

pub(crate) struct Input {
    /// Unit normals of the triangles; zero for those without area.
    pub(crate) normals: Vec<DVec3>,
    pub(crate) tree: TriangleTree,
    /// The tree of the curves (each a segment), and the two points of Gauss's rule on each.
    pub(crate) curve_tree: TriangleTree,
    pub(crate) curve_points: Vec<DVec3>,
    /// The length that each of `curve_points` represents: half a curve's.
    pub(crate) curve_lengths: Vec<f64>,
    /// The chart of each triangle, as far as texture coordinates and colours go.
    pub(crate) charts: Vec<u32>,
    /// The same as far as normals go, too.
    pub(crate) shading_charts: Vec<u32>,
    /// The component of each triangle: what hangs together by positions.
    pub(crate) components: Vec<u32>,
    pub(crate) area: f64,
    /// Length of the bounding box's diagonal.
    pub(crate) diagonal: f64,
    /// The points on each of the level's faces.
    pub(crate) level_rule: Rule,
    segments: Vec<[DVec3; 2]>,
    corners: Vec<[DVec3; 3]>,
    areas: Vec<f64>,
    rule: Rule,
}

impl Input {
    pub(crate) fn new(mesh: &Mesh, level_triangles: usize) -> Self {
        let point = |v: u32| DVec3::from_array(mesh.positions()[v as usize].map(f64::from));
        let corners: Vec<[DVec3; 3]> = mesh.triangles().iter().map(|t| t.map(point)).collect();
        let crosses = corners.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a));
        let (normals, areas): (Vec<DVec3>, Vec<f64>) =
            crosses.map(|n| (n.normalize_or_zero(), n.length() / 2.0)).unzip();
        let ids = mesh.position_ids();
        let shading_charts = charts(mesh, &ids, Continuity::Shading);
        let has_normals = mesh.attributes().iter().any(|a| a.semantic == Semantic::Normal);
        let charts = if has_normals {
            charts(mesh, &ids, Continuity::Texture)
        } else {
            shading_charts.clone()
        };
        let faces: Vec<[u32; 3]> =
            mesh.triangles().iter().map(|t| t.map(|v| ids.of_vertex[v as usize])).collect();
        let curves = curves(&faces, &charts);
        let mut sets = DisjointSets::new(ids.len());
        for &[a, b, c] in &faces {
            sets.join(a, b);
            sets.join(a, c);
        }
        let components = faces.iter().map(|f| sets.find(f[0])).collect();
        let segment = |&side: &u32| {
            let (t, k) = (corners[side as usize / 3], side as usize % 3);
            [t[k], t[(k + 1) % 3]]
        };
        let segments: Vec<[DVec3; 2]> = curves.iter().map(segment).collect();
        // The first of the two points of Gauss's rule.
        let gauss = 0.5 - 0.5 / 3f64.sqrt();
        let curve_points = segments
            .iter()
            .flat_map(|[a, b]| [gauss, 1.0 - gauss].map(|t| a.lerp(*b, t)))
            .collect();
        let curve_lengths = segments.iter().flat_map(|[a, b]| [a.distance(*b) / 2.0; 2]).collect();
        let [rule, level_rule] = rules_for_ratio(corners.len(), level_triangles);
        Self {
            tree: TriangleTree::new(&corners),
            curve_tree: TriangleTree::of_segments(&segments),
            curve_points,
            curve_lengths,
            charts,
            components,
            shading_charts,
            area: areas.iter().sum(),
            diagonal: mesh.diagonal(),
            rule,
            level_rule,
            normals,
            segments,
            corners,
            areas,
        }
    }

    /// Returns the number of samples on all triangles.
    pub(crate) fn sample_count(&self) -> usize {
        self.rule.len() * self.corners.len()
    }

    /// Returns the triangle of a sample, its barycentric coordinates there, and its share of the
    /// whole area. Samples with consecutive numbers are near each other.
    pub(crate) fn sample_location(&self, i: usize) -> (usize, [f64; 3], f64) {
        let triangle = self.tree.spatial_order()[i / self.rule.len()] as usize;
        let (barycentric, share) = self.rule[i % self.rule.len()];
        (triangle, barycentric, self.areas[triangle] * share / self.area)
    }

    /// Returns the sheet of a triangle.
    pub(crate) fn sheet(&self, triangle: usize) -> Sheet {
        Sheet { component: self.components[triangle], normal: self.normals[triangle] }
    }

    /// Returns the point of a triangle with given barycentric coordinates.
    pub(crate) fn surface_point(&self, triangle: usize, barycentric: [f64; 3]) -> DVec3 {
        point_at(self.corners[triangle], barycentric)
    }

    /// Returns the point of a curve at `t`, from 0 to 1.
    pub(crate) fn point_on_curve(&self, curve: usize, t: f64) -> DVec3 {
        let [a, b] = self.segments[curve];
        a.lerp(b, t)
    }
}
