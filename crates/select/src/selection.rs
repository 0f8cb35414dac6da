//! Chooses one level of detail per object for a target: a record, a share, a count, an error.

use crate::candidate::Candidate;
use crate::number::{decimal, rms_threshold, threshold};
use crate::order::within_triangles;
use lodc_mesh::Lod;

/// What the levels of an object or a scene are to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// This many records applied.
    Lod(u32),
    /// At most this share of the input's triangles.
    Ratio(f64),
    /// At most this many triangles.
    Triangles(u64),
    /// At most this error, in world units; where each object is chosen by itself, in its own.
    Error(f64),
    /// At most this share of the bounding box's diagonal.
    ErrorShare(f64),
    /// At most this root mean square distance, in the units of errors. Objects whose distances were
    /// not measured stay as they are.
    Rms(f64),
    /// At most this share of the bounding box's diagonal as root mean square distance.
    RmsShare(f64),
}

/// The levels that were chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// One per object; always the end of a step.
    pub lods: Vec<Lod>,
    /// The largest error of an object, in world units.
    pub error: f64,
    /// The largest root mean square distance of an object, in world units; none if it was not
    /// measured.
    pub rms: Option<f64>,
    /// Targets that could not be met in full: one line each.
    pub warnings: Vec<String>,
}

/// Why a record number names no level.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordError {
    /// It was asked of several objects at once.
    #[error("a record number means one object, and there are {objects}")]
    OfScene {
        /// Number of objects.
        objects: usize,
    },
    /// That level lacks something that is locked.
    #[error("{object}: what is locked is there down to LOD {}", coarsest.0)]
    Unlocks {
        /// The object's name.
        object: String,
        /// The coarsest level that keeps what is locked.
        coarsest: Lod,
    },
}

/// Chooses one level of detail per object. Unless `per_object`, objects meet an error in world
/// units each for itself, and several meet numbers of triangles together: triangles are removed
/// where they err least, and among nearly equal errors where least is lost. `losses` returns for
/// each object its loss after each step, never falling; it is called only if the target is a number
/// of triangles for several objects.
///
/// # Errors
/// If a record number is asked of several objects at once, or one past what is locked.
pub fn select<L: AsRef<[Vec<f64>]>>(
    objects: &[Candidate<'_>],
    target: Target,
    per_object: bool,
    losses: impl FnOnce() -> L,
) -> Result<Selection, RecordError> {
    if let Target::Lod(n) = target
        && let Some(o) = objects.iter().find(|o| o.coarsest < o.collapses.last().min(Lod(n)))
        && (per_object || objects.len() == 1)
    {
        let (object, coarsest) = (o.name.to_owned(), o.coarsest);
        return Err(RecordError::Unlocks { object, coarsest });
    }
    let mut chosen = Selection::default();
    match objects {
        [one] if !per_object => {
            let lod = level_of_object(one, own(one, target), &mut chosen.warnings);
            chosen.lods.push(lod);
        }
        several if several.len() > 1 && !per_object => {
            levels_of_scene(several, target, losses, &mut chosen)?;
        }
        each => {
            for object in each {
                let lod = level_of_object(object, target, &mut chosen.warnings);
                chosen.lods.push(lod);
            }
        }
    }
    chosen.measure(objects);
    Ok(chosen)
}

impl Selection {
    /// Takes no level coarser than that of `cap`, a selection over the same objects.
    pub fn cap(&mut self, objects: &[Candidate<'_>], cap: &Self) {
        for (lod, &coarsest) in self.lods.iter_mut().zip(&cap.lods) {
            *lod = coarsest.min(*lod);
        }
        self.measure(objects);
    }

    /// Gives some objects, by their numbers, levels that meet targets of their own.
    pub fn put(
        &mut self,
        objects: &[Candidate<'_>],
        own_targets: impl Iterator<Item = (usize, Target)>,
    ) {
        for (number, target) in own_targets {
            self.lods[number] = level_of_object(&objects[number], target, &mut self.warnings);
        }
        self.measure(objects);
    }

    /// Sets the error and the root mean square distance to those of the chosen levels.
    fn measure(&mut self, objects: &[Candidate<'_>]) {
        let pairs = || objects.iter().zip(&self.lods);
        let errors = pairs().map(|(o, &lod)| decimal(o.collapses.error_at(lod)) * o.world_scale());
        let error = errors.fold(0.0, f64::max);
        let rms =
            pairs().map(|(o, &lod)| Some(decimal(o.collapses.rms_at(lod)?) * o.world_scale()));
        let rms: Option<Vec<f64>> = rms.collect();
        self.rms = rms.map(|all| all.into_iter().fold(0.0, f64::max));
        self.error = error;
    }
}

/// A target in an object's own units, given one in world units.
fn own(object: &Candidate<'_>, target: Target) -> Target {
    match target {
        Target::Error(e) => Target::Error(e / object.world_scale()),
        Target::Rms(e) => Target::Rms(e / object.world_scale()),
        other => other,
    }
}

/// The level of one object, in its own units.
fn level_of_object(object: &Candidate<'_>, target: Target, warnings: &mut Vec<String>) -> Lod {
    let c = object.collapses;
    let lod = match target {
        Target::Lod(n) => {
            if n > c.last().0 {
                warnings.push(format!(
                    "{}: LOD {n} does not exist: used the last one, LOD {}",
                    object.name,
                    c.last().0
                ));
            }
            return c.floor(Lod(n.min(c.last().0)));
        }
        Target::Ratio(r) => c.lod_for_triangles(share(r, u64::from(c.parts().triangles))),
        Target::Triangles(n) => c.lod_for_triangles(u32::try_from(n).unwrap_or(u32::MAX)),
        Target::Error(e) => by_error(object, e),
        Target::ErrorShare(s) => by_error(object, s * object.diagonal),
        Target::Rms(e) => by_rms(object, e),
        Target::RmsShare(s) => by_rms(object, s * object.diagonal),
    };
    let last = object.last();
    if lod > last {
        warnings.push(format!(
            "{}: stopped at LOD {}, the last that {}",
            object.name,
            last.0,
            object.why_last()
        ));
    }
    lod.min(last)
}

/// The levels of several objects, in world units or for a number of triangles of all.
fn levels_of_scene<L: AsRef<[Vec<f64>]>>(
    objects: &[Candidate<'_>],
    target: Target,
    losses: impl FnOnce() -> L,
    chosen: &mut Selection,
) -> Result<(), RecordError> {
    let all: u64 = objects.iter().map(|o| u64::from(o.collapses.parts().triangles)).sum();
    let budget = match target {
        Target::Lod(_) => return Err(RecordError::OfScene { objects: objects.len() }),
        Target::Error(e) => {
            choose_within(objects, e, by_error, chosen);
            return Ok(());
        }
        Target::ErrorShare(s) => {
            choose_within(objects, s * scene_diagonal(objects), by_error, chosen);
            return Ok(());
        }
        Target::Rms(e) => {
            choose_within(objects, e, by_rms, chosen);
            return Ok(());
        }
        Target::RmsShare(s) => {
            choose_within(objects, s * scene_diagonal(objects), by_rms, chosen);
            return Ok(());
        }
        Target::Ratio(r) => u64::from(share(r, all)),
        Target::Triangles(n) => n,
    };
    if all <= budget {
        chosen.lods = vec![Lod(0); objects.len()];
        return Ok(());
    }
    chosen.lods = within_triangles(objects, losses().as_ref(), budget);
    let live = |(o, &lod): (&Candidate<'_>, &Lod)| u64::from(o.collapses.triangles_at(lod));
    let remaining: u64 = objects.iter().zip(&chosen.lods).map(live).sum();
    let is_stopped = |(o, lod): &(&Candidate<'_>, &Lod)| **lod == o.last() && lod.0 > 0;
    let stopped = objects.iter().zip(&chosen.lods).filter(is_stopped).map(|(o, _)| o);
    let stopped: Vec<&Candidate<'_>> = stopped.collect();
    if remaining > budget {
        let locks = stopped.iter().any(|o| o.coarsest < o.collapses.last_visible());
        let or_lock = if locks { ", or that keeps what is locked" } else { "" };
        chosen.warnings.push(format!(
            "{budget} triangles cannot be reached: every object stopped at its last LOD that has a \
             triangle{or_lock}, {remaining} in all"
        ));
        return Ok(());
    }
    warn_of_stopped(&stopped, objects.len(), chosen);
    Ok(())
}

/// The largest distance that a target allows an object, in mesh units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Limit {
    /// Error.
    Error(f64),
    /// Root mean square distance.
    Rms(f64),
}

/// The limit of each object; none if the target is no distance. `per_object` as for [`select`].
pub(crate) fn limits(
    objects: &[Candidate<'_>],
    target: Target,
    per_object: bool,
) -> Vec<Option<Limit>> {
    let is_scene = objects.len() > 1 && !per_object;
    let limit = |o: &Candidate<'_>| {
        let unit = if per_object { 1.0 } else { o.world_scale() };
        let of_diagonal = |s: f64| match is_scene {
            true => s * scene_diagonal(objects) / o.world_scale(),
            false => s * o.diagonal,
        };
        match target {
            Target::Error(e) => Some(Limit::Error(e / unit)),
            Target::ErrorShare(s) => Some(Limit::Error(of_diagonal(s))),
            Target::Rms(e) => Some(Limit::Rms(e / unit)),
            Target::RmsShare(s) => Some(Limit::Rms(of_diagonal(s))),
            Target::Lod(_) | Target::Ratio(_) | Target::Triangles(_) => None,
        }
    };
    objects.iter().map(limit).collect()
}

/// The diagonal that percentages refer to: that of the largest object as the scene shows it, in
/// world units.
#[must_use]
pub fn scene_diagonal(objects: &[Candidate<'_>]) -> f64 {
    objects.iter().map(|o| o.diagonal * o.world_scale()).fold(0.0, f64::max)
}

/// Finds an object's coarsest level within a distance in mesh units, as it is written.
type ByDistance = fn(&Candidate<'_>, f64) -> Lod;

fn by_error(object: &Candidate<'_>, error: f64) -> Lod {
    object.collapses.lod_for_error(threshold(error, object.rounding))
}

fn by_rms(object: &Candidate<'_>, rms: f64) -> Lod {
    object.collapses.lod_for_rms(rms_threshold(rms, object.rounding)).unwrap_or_default()
}

/// Chooses each object's coarsest level within a distance in world units.
fn choose_within(
    objects: &[Candidate<'_>],
    distance: f64,
    find: ByDistance,
    chosen: &mut Selection,
) {
    let mut stopped = Vec::new();
    for o in objects {
        let lod = find(o, distance / o.world_scale());
        let last = o.last();
        if lod > last {
            stopped.push(o);
        }
        chosen.lods.push(lod.min(last));
    }
    warn_of_stopped(&stopped, objects.len(), chosen);
}

/// Largest number of names that a warning lists. Chosen by hand.
const MAX_NAMES: usize = 8;

/// Warns that some of `all` objects stopped at their last level.
fn warn_of_stopped(stopped: &[&Candidate<'_>], all: usize, chosen: &mut Selection) {
    for reason in ["has a triangle", "keeps what is locked"] {
        let names = stopped.iter().filter(|o| o.why_last() == reason).map(|o| o.name);
        let names: Vec<&str> = names.collect();
        if names.is_empty() {
            continue;
        }
        let mut list = names[..names.len().min(MAX_NAMES)].join(", ");
        if names.len() > MAX_NAMES {
            list.push_str(", …");
        }
        chosen.warnings.push(format!(
            "{} of {all} objects stopped at their last LOD that {reason}: {list}",
            names.len()
        ));
    }
}

fn share(ratio: f64, triangles: u64) -> u32 {
    // Counts are below 2^53, where f64 is exact. The cast truncates: "at most this share".
    (ratio * triangles as f64) as u32
}

#[cfg(test)]
#[path = "selection_tests.rs"]
mod tests;
