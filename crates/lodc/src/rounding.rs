//! What writing rounds, and how far that takes levels from the input.

use crate::LodObject;
use crate::shapes::{bends, farthest_vertex, stated_shapes};
use lodc_formats::export::{
    ExportFormat, ExportObject, Precision, RoundedObject, flattening_error, reading_error, rounded,
};
use lodc_formats::{Document, FormatError, Limits};
use lodc_mesh::{Mesh, PositionIds, is_degenerate};
use lodc_scene::ObjectShapes;
use lodc_select::{rounded_error, rounded_rms};
use std::collections::BTreeSet;

/// What writing rounds in the meshes of one level, or in those that several levels share: how far
/// coordinates stand from where the input has them, as it was read and as the format stores them,
/// and what quantising does.
#[derive(Debug)]
pub struct Rounding<'a> {
    by_object: Vec<ObjectRounding<'a>>,
}

#[derive(Debug)]
struct ObjectRounding<'a> {
    object: &'a LodObject,
    /// How far reading and the format move vertices at most, in mesh units.
    stored: f64,
    /// None if no vertex is quantised.
    quantised: Option<Quantised>,
    /// Why positions are not quantised although they were to be.
    kept: Option<&'static str>,
}

impl<'a> Rounding<'a> {
    /// What writing rounds in `meshes`, one for each object.
    ///
    /// # Errors
    /// If the document is damaged.
    pub fn new(
        objects: &'a [LodObject],
        document: &Document,
        meshes: impl Iterator<Item = &'a Mesh>,
        format: ExportFormat,
        precision: Precision,
    ) -> Result<Self, FormatError> {
        let one = |(o, mesh): (&'a LodObject, &'a Mesh)| ExportObject { info: &o.info, mesh };
        let exported: Vec<ExportObject<'a>> = objects.iter().zip(meshes).map(one).collect();
        let stored = flattening_error(format, document, &exported)?;
        let rounded = rounded(document, &exported, precision)?;
        let mut shapes = match rounded {
            Some(_) => stated_shapes(objects, document, &Limits::DEFAULT)?.into_iter(),
            None => Vec::new().into_iter(),
        };
        let mut rounded = rounded.into_iter().flatten();
        let triangles: usize = objects.iter().map(|o| o.simplified.mesh().triangles().len()).sum();
        let is_small = triangles <= MAX_MEASURED_TRIANGLES;
        let mut by_object = Vec::with_capacity(objects.len());
        for ((object, stored), exported) in objects.iter().zip(stored).zip(&exported) {
            let rounded = rounded.next().zip(shapes.next());
            let kept = rounded.as_ref().and_then(|(rounded, _)| rounded.stays);
            let stored = stored + reading_error(document, object.simplified.mesh());
            let quantised =
                |(rounded, shapes)| Quantised::new(exported.mesh, rounded, shapes, is_small);
            let quantised = rounded.map(quantised).filter(|q| q.moved > 0.0);
            by_object.push(ObjectRounding { object, stored, quantised, kept });
        }
        Ok(Self { by_object })
    }

    /// How far quantising moves the vertices of each object at most, in mesh units.
    #[must_use]
    pub fn quantising(&self) -> Vec<f64> {
        self.by_object.iter().map(|o| o.quantised.as_ref().map_or(0.0, |q| q.moved)).collect()
    }

    /// The error and the root mean square distance of an object's level as a file has it, in mesh
    /// units, given those before rounding. `triangles` are those of the level, over the mesh that
    /// this was made for.
    #[must_use]
    pub fn distances(
        &self,
        object: usize,
        triangles: &[[u32; 3]],
        before: (f64, Option<f64>),
    ) -> (f64, Option<f64>) {
        let ObjectRounding { object, stored, quantised, .. } = &self.by_object[object];
        let (error, rms) = match quantised {
            Some(quantised) => quantised.distances(object.simplified.mesh(), triangles, before),
            None => before,
        };
        added((error, rms), *stored)
    }

    /// One line for each object whose positions are not quantised although they were to be.
    #[must_use]
    pub fn kept(&self) -> Vec<String> {
        let line = |of: &ObjectRounding<'_>| {
            Some(format!("{}: positions are not quantised: {}", of.object.info.name, of.kept?))
        };
        self.by_object.iter().filter_map(line).collect()
    }

    /// One line for each object with triangles that quantising leaves without area; `triangles` are
    /// those of each.
    #[must_use]
    pub fn flattened(&self, triangles: &[&[[u32; 3]]]) -> Vec<String> {
        let line = |(o, triangles): (&ObjectRounding<'_>, &&[[u32; 3]])| {
            let quantised = o.quantised.as_ref()?;
            let lost = triangles.iter().filter(|t| quantised.flattens(t)).count();
            let triangles = if lost == 1 { "triangle has" } else { "triangles have" };
            let name = &o.object.info.name;
            (lost > 0).then(|| format!("{name}: {lost} {triangles} no area after quantising"))
        };
        self.by_object.iter().zip(triangles).filter_map(line).collect()
    }
}

/// Distances with what moving vertices by at most `moved` adds.
fn added((error, rms): (f64, Option<f64>), moved: f64) -> (f64, Option<f64>) {
    (rounded_error(error, moved), rms.map(|rms| rounded_rms(rms, moved)))
}

/// A mesh as quantising leaves it.
#[derive(Debug)]
struct Quantised {
    /// The farthest that a vertex moves in the placements and poses that errors are the largest
    /// over: where targets add to each other or joints move vertices, farther than at rest.
    moved: f64,
    /// Its vertices, without triangles.
    mesh: Mesh,
    /// Vertices that have come together have one number.
    ids: PositionIds,
    #[cfg(feature = "build")]
    shapes: ObjectShapes,
    /// Whether the scene is so small that levels are measured where a bound is loose.
    is_small: bool,
    #[cfg(feature = "build")]
    originals: std::sync::OnceLock<Vec<lodc_errors::Measurable>>,
}

impl Quantised {
    #[cfg_attr(
        not(feature = "build"),
        expect(
            clippy::needless_pass_by_value,
            reason = "shapes are kept where errors are measured"
        )
    )]
    fn new(mesh: &Mesh, rounded: RoundedObject, shapes: ObjectShapes, is_small: bool) -> Self {
        let mut moved = rounded.moved;
        if bends(mesh) {
            let all = 0..mesh.vertex_count() as u32;
            moved = moved.max(farthest_vertex(shapes.all(), mesh, &rounded.mesh, &all));
        }
        Self {
            moved,
            ids: rounded.mesh.position_ids(),
            mesh: rounded.mesh,
            #[cfg(feature = "build")]
            shapes,
            is_small,
            #[cfg(feature = "build")]
            originals: std::sync::OnceLock::new(),
        }
    }

    /// Returns whether a triangle has two corners at one place.
    fn flattens(&self, triangle: &[u32; 3]) -> bool {
        is_degenerate(self.numbers(triangle))
    }

    fn numbers(&self, triangle: &[u32; 3]) -> [u32; 3] {
        triangle.map(|v| self.ids.of_vertex[v as usize])
    }

    /// The distances of a level of `input` once it is quantised.
    fn distances(
        &self,
        input: &Mesh,
        triangles: &[[u32; 3]],
        before: (f64, Option<f64>),
    ) -> (f64, Option<f64>) {
        let bound = added(before, self.moved);
        if triangles.is_empty() || !before.0.is_finite() {
            return bound;
        }
        // No point of a face moves farther than its corners. But what is left without area is not
        // drawn: the bound holds if other faces are where it was.
        let holds = self.covers(triangles);
        let is_near = holds && before.0 + self.moved <= NEAR_ENOUGH * before.0;
        let unseen = self.unseen();
        let is_blurred = unseen > MAX_UNSEEN * self.moved;
        if holds && (is_near || !self.is_small || is_blurred) {
            return bound;
        }
        let (error, rms) = added(self.measured(input, triangles), unseen);
        (if holds { error.min(bound.0) } else { error }, bound.1.and(rms))
    }

    /// How far the vertices are at most from where the file has them: they have single precision,
    /// which may be less than that of a grid far from the origin.
    fn unseen(&self) -> f64 {
        let coordinates = self.mesh.positions().as_flattened().iter();
        let largest = coordinates.fold(0.0, |most: f32, c| most.max(c.abs()));
        3f64.sqrt() * f64::from(largest) * f64::from(f32::EPSILON / 2.0)
    }

    /// Returns whether each triangle that is left without area, a line or a point by now, is an
    /// edge or a corner of one with area.
    fn covers(&self, triangles: &[[u32; 3]]) -> bool {
        let lost: Vec<[u32; 3]> =
            triangles.iter().filter(|t| self.flattens(t)).map(|t| self.numbers(t)).collect();
        if lost.is_empty() {
            return true;
        }
        let edges = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
        let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let (mut kept_edges, mut kept_corners) = (BTreeSet::new(), BTreeSet::new());
        for t in triangles.iter().filter(|t| !self.flattens(t)).map(|t| self.numbers(t)) {
            kept_edges.extend(edges(t).map(sorted));
            kept_corners.extend(t);
        }
        let is_kept = |edge: [u32; 2]| match edge {
            [a, b] if a == b => kept_corners.contains(&a),
            _ => kept_edges.contains(&sorted(edge)),
        };
        lost.into_iter().all(|t| edges(t).into_iter().all(is_kept))
    }

    /// Measures the triangles that have an area: upper bound and root mean square distance, the
    /// largest over all shapes.
    #[cfg(feature = "build")]
    fn measured(&self, input: &Mesh, triangles: &[[u32; 3]]) -> (f64, Option<f64>) {
        use lodc_errors::{Distances, Measurable};
        let shapes = self.shapes.all();
        let surface = |triangles: &[[u32; 3]], at: &[[f32; 3]]| {
            Measurable::new(triangles.iter().map(|t| t.map(|v| at[v as usize])))
        };
        let originals = self.originals.get_or_init(|| {
            shapes.iter().map(|shape| surface(input.triangles(), &shape.of(input))).collect()
        });
        let kept: Vec<[u32; 3]> = triangles.iter().filter(|t| !self.flattens(t)).copied().collect();
        let mut largest = Distances::default();
        for (shape, original) in shapes.iter().zip(originals) {
            largest = largest.max(original.distances(&surface(&kept, &shape.of(&self.mesh))));
        }
        (largest.upper, Some(largest.rms))
    }

    /// Nothing is known without what measures.
    #[cfg(not(feature = "build"))]
    fn measured(&self, _: &Mesh, _: &[[u32; 3]]) -> (f64, Option<f64>) {
        let farthest = f64::INFINITY;
        (farthest, Some(farthest))
    }
}

/// A bound that is at most this many times the error before rounding is near enough, and nothing
/// is measured. Chosen by hand.
const NEAR_ENOUGH: f64 = 1.05;

/// The largest share of what quantising moves vertices by that measuring may miss. Chosen by hand.
const MAX_UNSEEN: f64 = 0.1;

/// Triangles of a scene above which bounds are stated where they hold: measuring takes up to as
/// long as extracting the finest level does, some 20 ms for so many. Chosen by hand.
const MAX_MEASURED_TRIANGLES: usize = 4_000;

#[cfg(all(test, feature = "build"))]
mod tests {
    use super::*;
    use crate::Source;

    #[test]
    fn what_single_precision_cannot_tell_counts() {
        let places = [5e6, 5e6 + 0.5, 5e6 + 20.5].map(|x| ([x, 5e6, 0.0], 9.5));
        let (error, _) = written(&places, 8);
        // A cell is 30/254; there coordinates are multiples of 0.5, and the grid is not.
        assert!((0.1..0.11).contains(&error), "{error}");
    }

    /// The error of flat squares, each a corner and a side, as a GLB of some bits has them, and
    /// warnings.
    fn written(squares: &[([f32; 3], f32)], bits: u8) -> (f64, Vec<String>) {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for &([x, y, z], side) in squares {
            let first = positions.len() as u32;
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            positions.extend(corners.map(|[u, v]| [x + u * side, y + v * side, z]));
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v: u32| first + v)));
        }
        let file = crate::build(Source::arrays(positions, triangles, vec![])).run();
        let file = file.expect("squares are a mesh");
        let (objects, document) = (file.objects(), &file.content().document);
        let mesh = objects[0].simplified.mesh();
        let precision = Precision { position: Some(bits), ..Precision::default() };
        let meshes = std::iter::once(mesh);
        let rounding = Rounding::new(objects, document, meshes, ExportFormat::Glb, precision);
        let rounding = rounding.expect("a sound document");
        let triangles = mesh.triangles();
        let (error, _) = rounding.distances(0, triangles, (0.0, Some(0.0)));
        (error, rounding.flattened(&[triangles]))
    }

    #[test]
    fn a_part_that_is_smaller_than_a_cell_is_as_far_as_what_is_left() {
        let (error, warnings) = written(&[([0.0; 3], 1000.0)], 10);
        assert!(error <= 0.87 && warnings.is_empty(), "{error} {warnings:?}");
        let part = ([2000.2, 0.2, 0.2], 0.1);
        let (error, warnings) = written(&[([0.0; 3], 1000.0), part], 10);
        assert!((1000.0..1030.0).contains(&error), "{error}");
        assert!(warnings[0].ends_with("2 triangles have no area after quantising"), "{warnings:?}");
        // Nothing is left.
        let (error, _) = written(&[part, ([0.2; 3], 0.1)], 10);
        assert_eq!(error, f64::INFINITY);
    }

    #[test]
    fn what_moves_within_its_plane_is_hardly_farther() {
        let cell = 1000.0 / 62.0;
        let (error, _) = written(&[([0.0, 0.0, 3.0], 1000.0)], 6);
        assert!(error < 0.5 * cell, "{error}: half the diagonal of a cell is {}", 0.87 * cell);
    }
}
