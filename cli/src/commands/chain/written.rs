//! The error and rms that each level of a chain states: those before writing, and what rounding and
//! quantising add to them.

use super::Chained;
use super::levels::ChosenLevel;
use lodc::Rounding;
use lodc::level_mesh;
use rayon::prelude::*;

/// Error and root mean square distance, in mesh units.
type Distances = (f64, Option<f64>);

/// States the distances of levels one by one, finest first, none smaller than a finer level's.
#[derive(Debug, Default)]
pub(super) struct Stated {
    /// Of each object at the level before, as stated.
    before: Vec<Distances>,
    /// A line for each object that quantising left alone or whose triangles it flattened, and for
    /// each distance that was asked and is no longer kept.
    pub(super) warnings: Vec<String>,
}

impl Stated {
    /// Sets a level's error and rms to those that its file will have. `triangles` are the level's,
    /// for each object, over the mesh that `rounding` was made for.
    pub(super) fn add(
        &mut self,
        chained: Chained<'_>,
        rounding: &Rounding<'_>,
        (number, level): (usize, &mut ChosenLevel),
        triangles: &[&[[u32; 3]]],
    ) {
        let one = |(o, triangles): (usize, &&[[u32; 3]])| {
            let distances = &level.distances[o];
            rounding.distances(o, triangles, (distances.error, distances.rms))
        };
        let mut written: Vec<Distances> = triangles.par_iter().enumerate().map(one).collect();
        for (now, before) in written.iter_mut().zip(&self.before) {
            let rms = |(now, before): (f64, f64)| now.max(before);
            *now = (now.0.max(before.0), now.1.zip(before.1).map(rms));
        }
        if number == 0 {
            self.warnings.extend(rounding.kept());
        }
        let flattened = rounding.flattened(triangles).into_iter();
        self.warnings.extend(flattened.map(|line| format!("level {number}: {line}")));
        self.warnings.extend(chained.state(number, level, &written));
        self.before = written;
    }
}

impl Chained<'_> {
    /// Sets a level's error and rms to the largest of `written`, those of each object as a file has
    /// it. Returns a line for each distance that was asked and is not kept.
    pub(super) fn state(
        self,
        number: usize,
        level: &mut ChosenLevel,
        written: &[Distances],
    ) -> Vec<String> {
        let distances = written.iter().copied();
        (level.error, level.rms) = level_mesh::largest_distance(&self.asset.objects, distances);
        let unrounded: Vec<Distances> = level.distances.iter().map(|d| (d.error, d.rms)).collect();
        let unmet = self.room.unmet(self.scene, &level.asked, &unrounded, written).into_iter();
        unmet.map(|line| format!("level {number}: {line}")).collect()
    }
}
