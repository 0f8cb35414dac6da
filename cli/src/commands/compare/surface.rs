//! The triangles that `compare` measures: scenes or levels of them in world space, as their default
//! scenes show them.

use super::CompareArgs;
use crate::commands::asset;
use crate::commands::input::Objects;
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::progress::Progress;
use crate::stages::Stages;
use lodc::pipeline::{SceneColours, read_colours};
use lodc::{Errors, Input, level_mesh, read_input, scene_levels};
use lodc_formats::{Document, scene_graph};
use lodc_measure::SceneSurface;
use lodc_mesh::{Lod, Mesh};
use lodc_scene::{Arrangement, centre};
use lodc_select::Target;
use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

/// Triangles of a scene, with all instances, that are compared at most. Chosen by hand: bounds the
/// memory.
const MAX_TRIANGLES: usize = 1 << 28;

/// The level of a scene that is compared.
#[derive(Clone, Copy)]
pub(super) struct LevelChoice {
    /// None for the whole scene.
    pub(super) target: Option<Target>,
    pub(super) per_object: bool,
}

/// A scene that was read, to be compared as a whole or by its levels.
pub(super) struct ComparedScene {
    name: String,
    document: Document,
    objects: Objects,
    colours: Arc<SceneColours>,
}

impl ComparedScene {
    /// Reads a scene. A mesh is simplified only if levels of it are asked for: `levels` are the
    /// errors that choosing them needs.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn read(
        path: &Path,
        levels: Option<Errors>,
        args: &CompareArgs,
        stages: &mut Stages,
        progress: &Progress,
    ) -> Outcome<Self> {
        let options = args.import.options();
        let name = path.display().to_string();
        let needs_colours = !args.no_attributes && args.views > 0;
        let mut colours = None;
        let (document, objects, warnings) = if let Some(errors) = levels {
            let (import, simplify) = (&args.import, &args.simplify);
            let asset = asset::read_showing(progress, path, import, simplify, errors, stages)?;
            colours = needs_colours.then(|| asset.colours(path, &options)).transpose()?;
            (asset.document, Objects::Simplified(asset.objects), asset.warnings)
        } else {
            match stages.run("import", || read_input(path, &options))? {
                Input::Scene(scene) => {
                    (scene.document, Objects::Meshes(scene.objects), scene.warnings)
                }
                Input::Lodc(file) => {
                    (file.document, Objects::Simplified(file.objects), file.left_out)
                }
            }
        };
        let colours = match colours {
            Some(colours) => colours,
            None if needs_colours => read_colours(path, &options, &document, &objects.infos())?.0,
            None => Arc::default(),
        };
        console::warnings(&name, &[&warnings[..], &colours.appearance().warnings].concat());
        Ok(Self { name, document, objects, colours })
    }

    /// Returns where the scene shows its objects.
    fn arrangement(&self, args: &CompareArgs) -> Outcome<Arrangement> {
        let (name, limits) = (&self.name, args.import.options().limits);
        let infos = self.objects.infos();
        let graph = scene_graph(&self.document, &infos, &limits).map_err(|e| e.in_file(name))?;
        let pose = args.pose.of(Path::new(name), &self.document, &graph, &limits)?;
        Ok(Arrangement::new(&graph, &pose, infos.len()))
    }

    /// Returns the point about which this scene and others are compared: far from the origin single
    /// precision needs one.
    ///
    /// # Errors
    /// If the document is damaged, or lacks the pose.
    pub(super) fn centre(&self, args: &CompareArgs) -> Outcome<[f64; 3]> {
        Ok(centre(&self.arrangement(args)?, |object| self.objects.mesh(object)))
    }

    /// Returns the surface of the scene, or of a level of it, about `centre`.
    ///
    /// # Errors
    /// If it has no such level, no triangles or too many.
    pub(super) fn surface(
        &self,
        choice: LevelChoice,
        centre: [f64; 3],
        args: &CompareArgs,
    ) -> Outcome<SceneSurface> {
        let name = &self.name;
        let mut arrangement = self.arrangement(args)?;
        if centre != [0.0; 3] {
            arrangement = arrangement.moved(centre.map(|c| -c));
        }
        let meshes = self.meshes(choice, args)?;
        let meshes: Vec<&Mesh> = meshes.iter().map(AsRef::as_ref).collect();
        let triangles = arrangement.triangles(|object| meshes[object].triangles().len());
        if triangles == 0 {
            let message = format!("{name}: has no triangles: there is nothing to compare");
            return Err(Failure::new(Status::Input, message));
        }
        if triangles > MAX_TRIANGLES {
            let message = format!("{name}: its instances have more than {MAX_TRIANGLES} triangles");
            return Err(Failure::new(Status::Limit, message));
        }
        let colours = &self.colours;
        Ok(SceneSurface::with_images(&meshes, &arrangement, colours.appearance(), || {
            colours.images()
        }))
    }

    /// The meshes of the scene, or of a level of it.
    fn meshes(&self, choice: LevelChoice, args: &CompareArgs) -> Outcome<Vec<Cow<'_, Mesh>>> {
        let objects = match &self.objects {
            Objects::Meshes(objects) => {
                return Ok(objects.iter().map(|o| Cow::Borrowed(&o.mesh)).collect());
            }
            Objects::Simplified(objects) => objects,
        };
        let lods = match choice.target {
            Some(target) => {
                let limits = args.import.limits().limits();
                let levels = scene_levels(objects, &self.document, &limits)?;
                let chosen = levels.select_by(target, choice.per_object)?;
                for warning in &chosen.warnings {
                    console::warning(&self.name, warning);
                }
                chosen.lods
            }
            None => vec![Lod(0); objects.len()],
        };
        let meshes = level_mesh::reference_meshes(objects, &lods)?;
        Ok(meshes.into_iter().map(Cow::Owned).collect())
    }
}
