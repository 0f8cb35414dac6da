//! Refitting: the vertices of a level of detail, moved to where they fit the input best.
//!
//! A half-edge simplification leaves every vertex of a level where the input had it. A level that
//! is taken out for good need not: this package moves its vertices by least squares, connectivity
//! unchanged, so that the mean squared distance between both surfaces falls to 0.2–0.5 of what it
//! was. Each iteration ties samples of either surface to the nearest point of the other, solves the
//! normal equations of point-to-plane distances for one move per position, and holds back what
//! would turn a face over. Vertices at one position move together, so seams stay closed; borders,
//! borders of materials and seams of charts are tied to each other as curves. Normals and texture
//! coordinates are fitted by least squares, too; other attributes are taken from the input at the
//! new position, within their chart.
//!
//! ```
//! use lodc_mesh::{Lod, Mesh};
//! # let mesh: Mesh = lodc_fixtures::named("torus").expect("a fixture");
//! let simplified = lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {});
//! let lod = simplified.collapses().lod_for_triangles(80);
//! let refitted = lodc_refit::refit(&simplified, lod, &lodc_refit::Options::DEFAULT);
//! assert_eq!(refitted.triangles().len(), simplified.collapses().triangles_at(lod) as usize);
//! ```

mod attributes;
mod blend;
mod charts;
mod face_distances;
mod fit;
mod guard;
mod input;
mod interpolation;
mod level;
mod neighbours;
mod normals;
mod quadrature;
mod seams;
mod sheets;
mod sides;
mod skin;
mod system;
#[cfg(test)]
mod tests;
mod texture;
mod ties;

use fit::Fitted;
use glam::DVec3;
use guard::{Guard, cross};
use input::Input;
use level::CoarseMesh;
use lodc_mesh::{Lod, Mesh, MeshError, MeshParts, Simplified};
use normals::InputNormals;

/// Most rounds in which faces that face away from their normals are moved back. Chosen by hand.
const MAX_REFUSALS: u32 = 4;

/// Effort of a refit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Iterations, each of which ties samples and moves vertices.
    pub iterations: u32,
}

impl Options {
    /// Two iterations, which gain some 93 % of what five do.
    pub const DEFAULT: Self = Self { iterations: 2 };
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Returns the level of detail `lod` with its vertices moved to where they fit LOD 0 best:
/// [`Refit::mesh`] with a share of 1.
#[must_use]
pub fn refit(simplified: &Simplified, lod: Lod, options: &Options) -> Mesh {
    Refit::new(simplified, lod, options, &|| ()).mesh(1.0)
}

/// A level of detail and the positions at which its vertices fit LOD 0 best.
pub struct Refit<'a> {
    original: &'a Mesh,
    level: CoarseMesh,
    /// LOD 0 as the input of a fit, and the positions; none where nothing moves.
    fitted: Option<(Fitted, InputNormals<'a>)>,
}

impl<'a> Refit<'a> {
    /// Finds the positions. Of all iterations the one with the least mean squared distance counts,
    /// the start included. `tick` is called before each iteration; where it unwinds, so does this.
    /// The result does not depend on the number of threads.
    #[must_use]
    pub fn new(
        simplified: &'a Simplified,
        lod: Lod,
        options: &Options,
        tick: &(dyn Fn() + Sync),
    ) -> Self {
        tick();
        let original = simplified.mesh();
        let level = CoarseMesh::new(simplified, simplified.collapses().floor(lod));
        if level.faces.is_empty() || lod.0 == 0 {
            return Self { original, level, fitted: None };
        }
        let input = Input::new(original, level.faces.len());
        let fitted = fit::fit(input, &level, options.iterations, tick);
        Self { original, level, fitted: Some((fitted, InputNormals::new(original))) }
    }

    /// Returns a distance that a point of the level, as the simplifier left it, or of LOD 0 has at
    /// least from the other.
    #[must_use]
    pub fn unmoved_distance(&self) -> f64 {
        self.fitted.as_ref().map_or(0.0, |(fitted, _)| fitted.first_distance)
    }

    /// Returns whether a vertex of the level has a better position than its own.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.fitted.as_ref().is_some_and(|(fitted, _)| fitted.positions != self.level.points)
    }

    /// Returns the level as the simplifier left it.
    #[must_use]
    pub fn unmoved(&self) -> Mesh {
        self.level.mesh.clone()
    }

    /// Returns the level with its vertices a share of the way to the positions that fit best, from
    /// 0 to 1, with normals and texture coordinates that fit LOD 0's best and with other attributes
    /// as LOD 0 has them there. The triangles are those of the level, in the order of
    /// [`Mesh::extract`].
    #[must_use]
    pub fn mesh(&self, share: f64) -> Mesh {
        let level = &self.level;
        let Some((fitted, normals)) = &self.fitted else { return self.unmoved() };
        let mut positions = part_way(level, &fitted.positions, share);
        // Positions are stored as f32, which may make slivers degenerate.
        let mut rounds_left = MAX_REFUSALS;
        loop {
            let mut parts = attributes::resample(self.original, &fitted.input, level, &positions);
            let ties = if normals.is_empty() && !texture::is_there(self.original) {
                Vec::new()
            } else {
                ties::ties(level, fitted, &positions)
            };
            let input = &fitted.input;
            texture::fit(self.original, &input.charts, level, &ties, &mut parts);
            let refused = normals::fit(normals, input, level, &positions, &ties, &mut parts);
            let refused = with_faces_around(level, &refused);
            if rounds_left > 0 && move_back(level, refused.into_iter(), &mut positions) {
                rounds_left -= 1;
                continue;
            }
            keep_locked(level, &mut parts);
            match Mesh::try_from(parts) {
                Ok(mesh) => return mesh,
                Err(MeshError::Degenerate { .. }) => reset_degenerate(level, &mut positions),
                Err(e) => unreachable!("only positions and values of attributes changed: {e}"),
            }
        }
    }
}

/// Gives locked vertices the attributes that the simplifier left them.
fn keep_locked(level: &CoarseMesh, parts: &mut MeshParts) {
    if level.locked.is_empty() {
        return;
    }
    let befores = level.mesh.attributes().iter().filter(|a| attributes::stays(a));
    for (attribute, before) in parts.attributes.iter_mut().zip(befores) {
        let stride = attribute.stride();
        for (v, &point) in level.point_of_vertex.iter().enumerate() {
            if level.is_locked(point) {
                attribute.bytes[v * stride..][..stride].copy_from_slice(before.at(v as u32));
            }
        }
    }
}

/// Returns the points of a level a share of the way to other positions, so that no face turns over.
fn part_way(level: &CoarseMesh, positions: &[DVec3], share: f64) -> Vec<DVec3> {
    if share >= 1.0 {
        return positions.to_vec();
    }
    let normals: Vec<DVec3> =
        level.corners(&level.points).into_iter().map(|t| cross(t).normalize_or_zero()).collect();
    let moves: Vec<DVec3> =
        positions.iter().zip(&level.points).map(|(&to, &from)| (to - from) * share).collect();
    // Zeros: faces are held to their own first normals alone.
    let no_normals = vec![DVec3::ZERO; level.faces.len()];
    Guard { level, first_normals: &normals, input_normals: &no_normals }
        .limit(&level.points, &moves)
}

/// Moves the corners of all faces that `f32` makes degenerate back to where they were.
fn reset_degenerate(level: &CoarseMesh, positions: &mut [DVec3]) {
    let stored = |p: u32| positions[p as usize].as_vec3();
    let is_degenerate = |f: &usize| {
        let [a, b, c] = level.faces[*f].map(stored);
        a == b || b == c || c == a
    };
    let faces: Vec<usize> = (0..level.faces.len()).filter(is_degenerate).collect();
    move_back(level, faces.into_iter(), positions);
}

/// Returns some faces and those around them.
fn with_faces_around(level: &CoarseMesh, faces: &[usize]) -> Vec<usize> {
    if faces.is_empty() {
        return Vec::new();
    }
    let mut is_near = vec![false; level.points.len()];
    faces.iter().flat_map(|&f| level.faces[f]).for_each(|p| is_near[p as usize] = true);
    let touches = |f: &usize| level.faces[*f].iter().any(|&p| is_near[p as usize]);
    (0..level.faces.len()).filter(touches).collect()
}

/// Moves the corners of faces back to where they were; returns whether any was elsewhere.
fn move_back(
    level: &CoarseMesh,
    faces: impl Iterator<Item = usize>,
    positions: &mut [DVec3],
) -> bool {
    let mut any_moved = false;
    for p in faces.flat_map(|f| level.faces[f]) {
        let (position, before) = (&mut positions[p as usize], level.points[p as usize]);
        any_moved |= *position != before;
        *position = before;
    }
    any_moved
}
