//! Chooses the levels of a scene's objects by one error for all, one number of triangles for all,
//! or for each object by itself.

use crate::candidate::Candidate;
use crate::loss::Visibility;
use crate::selection::{Limit, RecordError, Selection, Target, limits, select};
use lodc_mesh::Simplified;
use lodc_scene::Arrangement;
use std::sync::OnceLock;

/// Why levels cannot be chosen or shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SelectError {
    /// A record number names no level.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A root mean square distance was asked of an object that has none.
    #[error("{object}: has errors that are estimates, and no root mean square distances")]
    NotMeasured {
        /// Its name.
        object: String,
    },
    /// Instances have too many vertices in all for views.
    #[error("instances have more than {limit} vertices in all")]
    TooManyVertices {
        /// The largest number of vertices.
        limit: usize,
    },
    /// A view is no mesh: a bug.
    #[error("{object}: a view is no mesh: {what}")]
    NoMesh {
        /// The object's name.
        object: String,
        /// The fault of the mesh.
        what: String,
    },
}

/// An object of a scene with its levels.
#[derive(Clone, Copy, Debug)]
pub struct ObjectLevels<'a> {
    /// Its name, for messages.
    pub name: &'a str,
    /// Its mesh and the sequence of its levels.
    pub simplified: &'a Simplified,
    /// World units per mesh unit.
    pub scale: f64,
    /// An error in mesh units times the scale of any one placement times this, at least 1, bounds
    /// what that placement errs
    /// ([`MeasuredPlacements::unevenness`](lodc_scene::MeasuredPlacements::unevenness)).
    pub unevenness: f64,
    /// As [`Candidate::rounding`].
    pub rounding: f64,
}

impl<'a> ObjectLevels<'a> {
    /// The object as [`select`] takes it.
    #[must_use]
    pub fn candidate(&self) -> Candidate<'a> {
        Candidate {
            name: self.name,
            collapses: self.simplified.collapses(),
            scale: self.scale,
            diagonal: self.simplified.mesh().diagonal(),
            coarsest: self.simplified.coarsest(),
            rounding: self.rounding,
        }
    }
}

/// Objects to choose levels of detail for, and the scene that shows them.
#[derive(Debug)]
pub struct SceneLevels<'a> {
    objects: Vec<ObjectLevels<'a>>,
    scene: Arrangement,
    /// Made when it is first asked for, as are the next two.
    visibility: OnceLock<Visibility>,
    /// For each object the loss after each step.
    losses: OnceLock<Vec<Vec<f64>>>,
    /// For each object the visible area of each triangle.
    visible_areas: OnceLock<Vec<Vec<f64>>>,
}

impl<'a> SceneLevels<'a> {
    /// Objects, and the scene that shows them where they are largest. For a single object any scene
    /// will do: its losses do not depend on it.
    #[must_use]
    pub fn new(objects: Vec<ObjectLevels<'a>>, scene: Arrangement) -> Self {
        let (visibility, losses, visible_areas) = Default::default();
        Self { objects, scene, visibility, losses, visible_areas }
    }

    /// The objects.
    #[must_use]
    pub fn objects(&self) -> &[ObjectLevels<'a>] {
        &self.objects
    }

    /// The objects as [`select`] takes them.
    #[must_use]
    pub fn candidates(&self) -> Vec<Candidate<'a>> {
        self.objects.iter().map(ObjectLevels::candidate).collect()
    }

    /// Chooses from now on for a file that moves vertices, by quantising them: for each object by
    /// so many mesh units at most. What is chosen by errors meets them with that.
    pub fn set_rounding(&mut self, by_object: &[f64]) {
        self.objects.iter_mut().zip(by_object).for_each(|(o, &rounding)| o.rounding = rounding);
    }

    /// Returns the objects whose error or root mean square distance, given in mesh units for each,
    /// is larger than a target allows; none if it limits neither. `per_object` as for
    /// [`Self::select`].
    #[must_use]
    pub fn beyond(
        &self,
        target: Target,
        per_object: bool,
        distances: &[(f64, Option<f64>)],
    ) -> Vec<usize> {
        let candidates = self.candidates();
        let limits = limits(&candidates, target, per_object);
        let is_beyond = |&o: &usize| {
            let (error, rms) = distances[o];
            match limits[o] {
                Some(Limit::Error(most)) => is_above(error, most),
                Some(Limit::Rms(most)) => rms.is_some_and(|rms| is_above(rms, most)),
                None => false,
            }
        };
        (0..candidates.len().min(distances.len())).filter(is_beyond).collect()
    }

    /// For each object the visible area of each triangle, by pictures of the whole scene from all
    /// sides, in world units, instances together. An object that the scene does not show, and all
    /// of a scene too large for pictures, counts with its whole area.
    pub fn visible_areas(&self) -> &[Vec<f64>] {
        self.visible_areas.get_or_init(|| self.visibility().areas(&self.simplified()))
    }

    /// The visible areas from which losses and [`Self::visible_areas`] follow.
    fn visibility(&self) -> &Visibility {
        self.visibility.get_or_init(|| Visibility::new(&self.simplified(), &self.scene))
    }

    fn simplified(&self) -> Vec<&'a Simplified> {
        self.objects.iter().map(|o| o.simplified).collect()
    }

    /// World error and triangles of levels under one error, the finest first: each object has its
    /// coarsest level within it. Levels in which an object has vanished are left out.
    #[must_use]
    pub fn by_error(&self) -> Vec<(f64, u32)> {
        let mut steps: Vec<(f64, u32)> = Vec::new();
        let mut total = 0;
        for object in &self.objects {
            let collapses = object.simplified.collapses();
            let last = collapses.last_visible().min(object.simplified.coarsest());
            let mut previous = collapses.parts().triangles;
            total += previous;
            for step in (0..collapses.steps()).map(|i| collapses.step(i)) {
                if step.lod > last {
                    break;
                }
                steps.push((f64::from(step.error) * object.scale, previous - step.triangles));
                previous = step.triangles;
            }
        }
        // Stable: the steps of one object keep their order.
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let after_steps = steps.into_iter().scan(total, |remaining, (error, removed)| {
            *remaining -= removed;
            Some((error, *remaining))
        });
        std::iter::once((0.0, total)).chain(after_steps).collect()
    }

    /// Chooses one level of detail per object; what is asked for is of the scene as a whole.
    ///
    /// # Errors
    /// If a record number is asked of several objects at once, or a root mean square distance where
    /// none was measured.
    pub fn select(&self, target: Target) -> Result<Selection, SelectError> {
        self.select_by(target, false)
    }

    /// As [`Self::select`]; with `per_object` each object meets the target by itself.
    ///
    /// # Errors
    /// As [`Self::select`].
    pub fn select_by(&self, target: Target, per_object: bool) -> Result<Selection, SelectError> {
        self.check_measured(target)?;
        let losses = || self.losses.get_or_init(|| self.visibility().losses(&self.simplified()));
        Ok(select(&self.candidates(), target, per_object, losses)?)
    }

    /// Chooses as [`Self::select_by`] does, but no level coarser than `cap`, an error, allows.
    /// Objects for whose names `own_target` returns a target get the level that meets it.
    ///
    /// # Errors
    /// As [`Self::select`].
    pub fn select_capped(
        &self,
        target: Target,
        own_target: impl Fn(&str) -> Option<Target>,
        cap: Option<Target>,
        per_object: bool,
    ) -> Result<Selection, SelectError> {
        let mut chosen = self.select_by(target, per_object)?;
        let objects = self.objects.iter().enumerate();
        let own_targets: Vec<_> =
            objects.filter_map(|(i, o)| Some((i, own_target(o.name)?))).collect();
        if !own_targets.is_empty() {
            chosen.put(&self.candidates(), own_targets.into_iter());
        }
        if let Some(cap) = cap {
            chosen.cap(&self.candidates(), &self.select_by(cap, per_object)?);
        }
        Ok(chosen)
    }

    /// Refuses to choose by a distance that was not measured.
    fn check_measured(&self, target: Target) -> Result<(), SelectError> {
        let by_rms = matches!(target, Target::Rms(_) | Target::RmsShare(_));
        let is_estimate = |o: &&ObjectLevels<'_>| !o.simplified.collapses().is_measured();
        match self.objects.iter().find(|o| by_rms && is_estimate(o)) {
            Some(o) => Err(SelectError::NotMeasured { object: o.name.to_owned() }),
            None => Ok(()),
        }
    }
}

/// Returns whether a distance is above a limit, and not by what converting between units rounds.
fn is_above(distance: f64, limit: f64) -> bool {
    const ROUNDING: f64 = 1e-9;
    distance > limit * (1.0 + ROUNDING)
}
