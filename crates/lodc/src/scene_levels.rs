//! One level of detail for each object of a file, by what a person asks for.

use crate::{Error, LodObject};
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_graph};
use lodc_mesh::Simplified;
use lodc_scene::{Arrangement, Graph};
use lodc_select::{Candidate, Selection, Target, losses, select};
use std::sync::OnceLock;

/// Objects to choose levels of detail for, and the scene that shows them.
pub struct SceneLevels<'a> {
    objects: &'a [LodObject],
    scene: Arrangement,
    losses: OnceLock<Vec<Vec<f64>>>,
}

impl<'a> SceneLevels<'a> {
    /// # Errors
    /// If the stored document is damaged.
    pub fn new(
        objects: &'a [LodObject],
        document: &Document,
        limits: &Limits,
    ) -> Result<Self, FormatError> {
        let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
        let graph = match objects {
            // Only what several objects lose depends on where they stand.
            [] | [_] => Graph::of_objects(objects.len() as u32),
            _ => scene_graph(document, &infos, limits)?,
        };
        let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
        Ok(Self { objects, scene, losses: OnceLock::new() })
    }

    /// Returns the objects.
    pub fn objects(&self) -> &'a [LodObject] {
        self.objects
    }

    /// Objects as they are selected from.
    pub fn candidates(&self) -> Vec<Candidate<'a>> {
        let candidate = |o: &'a LodObject| Candidate {
            name: &o.info.name,
            collapses: o.simplified.collapses(),
            scale: o.info.world_scale,
            diagonal: o.simplified.mesh().diagonal(),
        };
        self.objects.iter().map(candidate).collect()
    }

    /// Chooses one level of detail per object.
    ///
    /// # Errors
    /// If a record number is asked of several objects at once, or a root mean square distance where
    /// none was measured.
    pub fn select(&self, target: Target, per_object: bool) -> Result<Selection, Error> {
        self.check_measured(target)?;
        let losses = || {
            self.losses.get_or_init(|| {
                let objects: Vec<&Simplified> =
                    self.objects.iter().map(|o| &*o.simplified).collect();
                losses(&objects, &self.scene)
            })
        };
        select(&self.candidates(), target, per_object, losses).map_err(|e| {
            Error::Request(format!(
                "--lod counts the records of one object, and there are {}: add --per-object, or \
                 use --ratio, --triangles or --error",
                e.objects
            ))
        })
    }

    /// Chooses as [`Self::select`] does, but no level coarser than `cap`, an error, allows. Objects
    /// for which `own` has a target by their name have their level by themselves.
    ///
    /// # Errors
    /// As [`Self::select`].
    pub fn select_capped(
        &self,
        target: Target,
        own: impl Fn(&str) -> Option<Target>,
        cap: Option<Target>,
        per_object: bool,
    ) -> Result<Selection, Error> {
        let mut chosen = self.select(target, per_object)?;
        let objects = self.objects.iter().enumerate();
        let own: Vec<_> = objects.filter_map(|(i, o)| Some((i, own(&o.info.name)?))).collect();
        if !own.is_empty() {
            chosen.put(&self.candidates(), own.into_iter());
        }
        if let Some(cap) = cap {
            chosen.cap(&self.candidates(), &self.select(cap, per_object)?);
        }
        Ok(chosen)
    }

    /// Refuses to choose by a distance that was not measured.
    fn check_measured(&self, target: Target) -> Result<(), Error> {
        let by_rms = matches!(target, Target::Rms(_) | Target::RmsShare(_));
        let estimate = |o: &&LodObject| !o.simplified.collapses().is_measured();
        match self.objects.iter().find(|o| by_rms && estimate(o)) {
            Some(o) => Err(Error::Request(format!(
                "{}: has errors that are estimates, and no root mean square distances: build it \
                 again for --rms, or use --error",
                o.info.name
            ))),
            None => Ok(()),
        }
    }
}
