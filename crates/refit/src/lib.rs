//! Refitting: the vertices of a level of detail, moved to where they fit the input best.
//!
//! A half-edge simplification leaves every vertex of a level where the input had it. A level that
//! is taken out for good need not: this package moves its vertices by least squares, connectivity
//! unchanged, so that the mean squared distance between both surfaces falls to 0.2–0.5 of what it
//! was. Each iteration ties samples of either surface to the nearest point of the other, solves the
//! normal equations of point-to-plane distances for one move per position, and holds back what
//! would turn a face over. Vertices at one position move together, so seams stay closed; borders,
//! borders of materials and seams of charts are tied to each other as curves. Attributes are taken
//! from the input at the new place, within their chart.
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
mod fit;
mod guard;
mod input;
mod level;
mod quadrature;
mod seams;
mod sides;
mod skin;
mod system;
#[cfg(test)]
mod tests;

use fit::Fit;
use glam::DVec3;
use input::Input;
use level::Level;
use lodc_mesh::{Lod, Mesh, MeshError, Simplified};

/// Effort of a refit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Iterations of ties and moves. Two give some 93 % of what five do.
    pub iterations: u32,
}

impl Options {
    /// Three iterations.
    pub const DEFAULT: Self = Self { iterations: 3 };
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Returns the level of detail `lod` with its vertices moved to where they fit LOD 0 best. The
/// triangles are those of the level, in the order of [`Mesh::extract`].
///
/// Of all iterations the one with the least mean squared distance counts, the start included. The
/// result does not depend on the number of threads.
#[must_use]
pub fn refit(simplified: &Simplified, lod: Lod, options: &Options) -> Mesh {
    let level = Level::new(simplified, simplified.collapses().floor(lod));
    if level.faces.is_empty() || lod.0 == 0 {
        return level.mesh;
    }
    let input = Input::new(simplified.mesh(), level.faces.len());
    let mut positions = Fit::new(&input, &level).run(options.iterations);
    // Positions are stored as f32: what that makes of slivers is known only afterwards.
    loop {
        match Mesh::try_from(attributes::resample(
            simplified.mesh(),
            &input.tree,
            &level,
            &positions,
        )) {
            Ok(mesh) => return mesh,
            Err(MeshError::Degenerate { .. }) => put_back(&level, &mut positions),
            Err(e) => unreachable!("only positions and values of attributes changed: {e}"),
        }
    }
}

/// Puts the corners of all faces that `f32` makes degenerate back to where they were.
fn put_back(level: &Level, positions: &mut [DVec3]) {
    let stored = |p: u32| positions[p as usize].as_vec3();
    let collapsed = |f: &&[u32; 3]| {
        let [a, b, c] = f.map(stored);
        a == b || b == c || c == a
    };
    let points: Vec<u32> = level.faces.iter().filter(collapsed).flatten().copied().collect();
    for p in points {
        positions[p as usize] = level.points[p as usize];
    }
}
