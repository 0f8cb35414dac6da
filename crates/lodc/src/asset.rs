//! An asset whose levels can be taken out: the one way from a scene to levels.
//!
//! ```text
//! scene ── sequences ──► an asset ── measured ──► every level's error ── with_models ──► a file
//!                            │
//!                            └─ with_poses ──► errors of the levels that are taken out
//! ```
//!
//! `simplified` is `sequences`, then one of `measured` and `with_poses`.

#[cfg(feature = "export")]
use crate::LevelOf;
use crate::pipeline::{
    Growth, Importance, LevelDistance, MetricColours, SceneColours, SceneContext, Tick, Watch,
    build_models, check_models, choose_poses, measure_all, measure_levels, read_colours,
    simplify_all,
};
use crate::{Error, LodFile, LodObject};
use lodc_formats::import::ImportOptions;
use lodc_formats::lodc::{Layout, MadeFrom};
use lodc_formats::{Document, Limits, ObjectInfo, RequestedFiles, Scene, Source};
use lodc_lod::ModelKind;
use lodc_mesh::{Lod, Simplified};
use lodc_select::Target;
use lodc_simplify::Options;
use lodc_strip::StripOptions;
use std::path::Path;
use std::sync::Arc;

/// A scene whose objects have a collapse sequence each.
#[derive(Debug)]
pub struct Asset {
    /// Where it came from.
    pub source: Source,
    /// Its objects, with the models that were made or read.
    pub objects: Vec<LodObject>,
    /// Everything of it that is not a triangle mesh.
    pub document: Document,
    /// Whether the geometry of the input was compressed.
    pub compressed: bool,
    /// Whether the sequences were made now, not read.
    pub simplified: bool,
    /// Every file that was looked for.
    pub files: RequestedFiles,
    /// One line for each thing that was repaired, dropped or left out while reading.
    pub warnings: Vec<String>,
    /// The levels whose errors its sequences state.
    errors: Errors,
    /// The colours of the scene, if the metric used them.
    colours: Option<Arc<SceneColours>>,
    limits: Limits,
}

/// The levels whose errors are measured: measuring all takes longer than simplifying does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Errors {
    /// Every level.
    Curve,
    /// Only the levels that are written, once they are chosen: by [`Asset::distances`].
    OfResult,
}

impl Errors {
    /// The errors that are needed to choose levels by these targets.
    #[must_use]
    pub fn to_choose(targets: impl IntoIterator<Item = Target>) -> Self {
        let needs_no_error =
            |t| matches!(t, Target::Lod(_) | Target::Ratio(_) | Target::Triangles(_));
        if targets.into_iter().all(needs_no_error) { Self::OfResult } else { Self::Curve }
    }
}

impl From<Errors> for Growth {
    /// A level that was chosen by its error keeps it.
    fn from(errors: Errors) -> Self {
        match errors {
            Errors::Curve => Self::None,
            Errors::OfResult => Self::Little,
        }
    }
}

/// How a scene is simplified.
#[derive(Clone, Copy)]
pub struct Simplify<'a> {
    /// Options of every object.
    pub options: &'a [Options],
    /// Vertices that stay, weights of materials, and what is painted.
    pub importance: &'a Importance,
    /// How many poses of animations collapses are priced in, and errors measured in, at most.
    pub poses: usize,
}

impl Asset {
    /// A level of all its objects, to be written; `lod` is that of all of them, if they have one.
    #[cfg(feature = "export")]
    #[must_use]
    pub fn level_of(&self, lod: Option<Lod>) -> LevelOf<'_> {
        let source = self.source.content_hash;
        LevelOf { objects: &self.objects, document: &self.document, source, lod }
    }

    /// Simplifies the objects of a scene, and measures the `errors` that are asked for; of several
    /// objects those of every level, since they share out triangles by errors. `path` is the
    /// scene's file, beside which images are looked for.
    ///
    /// # Errors
    /// If the document is damaged, or a picture is beyond the limits.
    pub fn simplified(
        path: &Path,
        scene: Scene,
        import: &ImportOptions,
        how: &Simplify<'_>,
        errors: Errors,
        watch: &dyn Watch,
    ) -> Result<Self, Error> {
        let sequences = Self::sequences(path, scene, import, how, watch)?;
        match errors {
            Errors::OfResult if sequences.objects.len() <= 1 => sequences.with_poses(how.poses),
            _ => sequences.measured(how.poses, watch),
        }
    }

    /// Simplifies the objects of a scene; no level is measured.
    ///
    /// # Errors
    /// As [`Self::simplified`].
    pub fn sequences(
        path: &Path,
        scene: Scene,
        import: &ImportOptions,
        how: &Simplify<'_>,
        watch: &dyn Watch,
    ) -> Result<Self, Error> {
        let colours = MetricColours::read(path, import, &scene, how.options)?;
        let Scene { source, document, objects, mut warnings, mut files, compressed, .. } = scene;
        let context = SceneContext {
            colours: colours.scene_colours(),
            importance: how.importance,
            document: &document,
            poses: how.poses,
            limits: import.limits,
        };
        let simplified = simplify_all(objects, how.options, context, watch)?;
        warnings.extend(colours.warnings);
        files.extend(&colours.files);
        files.extend(&how.importance.painted.files);
        let colours = colours.colours;
        let made = Self::of_sequences(source, document, simplified, import.limits);
        Ok(Self { compressed, simplified: true, files, warnings, colours, ..made })
    }

    /// An asset of sequences that are known; no level is measured.
    #[must_use]
    pub fn of_sequences(
        source: Source,
        document: Document,
        simplified: Vec<(ObjectInfo, Arc<Simplified>)>,
        limits: Limits,
    ) -> Self {
        let object = |(info, simplified)| LodObject { info, simplified, models: Vec::new() };
        Self {
            source,
            objects: simplified.into_iter().map(object).collect(),
            document,
            compressed: false,
            simplified: false,
            files: RequestedFiles::default(),
            warnings: Vec::new(),
            errors: Errors::OfResult,
            colours: None,
            limits,
        }
    }

    /// An asset of a file that was read from `path`.
    #[must_use]
    pub fn of_file(file: LodFile, path: &Path, limits: Limits) -> Self {
        Self {
            source: file.source,
            objects: file.objects,
            document: file.document,
            compressed: false,
            simplified: false,
            files: RequestedFiles::from_path(path),
            warnings: file.left_out,
            errors: Errors::Curve,
            colours: None,
            limits,
        }
    }

    /// Chooses the poses that errors of single levels are measured in, up to `poses`.
    ///
    /// # Errors
    /// If the document is damaged.
    pub fn with_poses(mut self, poses: usize) -> Result<Self, Error> {
        choose_poses(&mut self.objects, &self.document, &self.limits, poses)?;
        Ok(self)
    }

    /// Measures every level, in up to `poses` poses besides the one at rest.
    ///
    /// # Errors
    /// If the document is damaged.
    pub fn measured(self, poses: usize, watch: &dyn Watch) -> Result<Self, Error> {
        let objects = measure_all(self.objects, &self.document, &self.limits, poses, watch)?;
        Ok(Self { objects, errors: Errors::Curve, ..self })
    }

    /// Makes models of some kinds for every object, and compares them with the reference.
    ///
    /// # Errors
    /// If one cannot be made, or differs: a bug.
    pub fn with_models(
        self,
        kinds: &[ModelKind],
        strips: StripOptions,
        watch: &dyn Watch,
    ) -> Result<Self, Error> {
        let objects = build_models(self.objects, kinds, strips, watch)?;
        check_models(&objects, watch)?;
        Ok(Self { objects, ..self })
    }

    /// The content of a `.lodc` file. `made_from` is what `build --if-changed` compares.
    #[must_use]
    pub fn into_file(self, layout: Layout, made_from: Option<MadeFrom>) -> LodFile {
        let Self { source, document, objects, .. } = self;
        LodFile { source, document, objects, layout, made_from, left_out: Vec::new() }
    }

    /// The distances of `levels`, fine to coarse, each with a LOD for every object; by level and
    /// object. Those that the sequences state, or measured if they state none.
    ///
    /// # Errors
    /// If the document is damaged.
    pub fn distances(
        &self,
        levels: &[&[Lod]],
        tick: &Tick<'_>,
    ) -> Result<Vec<Vec<LevelDistance>>, Error> {
        if self.errors == Errors::OfResult {
            let Self { objects, document, limits, .. } = self;
            return Ok(measure_levels(objects, levels, document, limits, tick)?);
        }
        let stated = |(object, &lod): (&LodObject, &Lod)| LevelDistance::stated(object, lod);
        let of_level = |lods: &&[Lod]| self.objects.iter().zip(*lods).map(stated).collect();
        Ok(levels.iter().map(of_level).collect())
    }

    /// The colours of the scene, read now unless the metric used them. Images that cannot be read
    /// are left out, with a line among the warnings of the appearance.
    ///
    /// # Errors
    /// If the document is damaged.
    pub fn colours(&self, path: &Path, import: &ImportOptions) -> Result<Arc<SceneColours>, Error> {
        if let Some(colours) = &self.colours {
            return Ok(Arc::clone(colours));
        }
        let infos: Vec<&ObjectInfo> = self.objects.iter().map(|o| &o.info).collect();
        Ok(read_colours(path, import, &self.document, &infos)?.0)
    }
}
