//! The levels that `render` draws: a tile of the contact sheet for each, or one.

use super::RenderArgs;
use super::options::ColorMode;
use super::scene::DrawableScene;
use crate::commands::input::Objects;
use crate::exit::{Failure, Outcome};
use crate::views::CriterionName;
use lodc::{LodObject, SceneLevels, levels, scene_levels};
use lodc_lod::AnyModel;
use lodc_mesh::{Lod, Mesh, OrientedTriangle};
use lodc_report::text::{count, distance};
use lodc_select::Target;
use lodc_strip::{Effort, StripKind, Strips};
use rayon::prelude::*;

/// What one picture shows.
pub(super) struct Tile {
    /// By object.
    pub(super) triangles: Vec<Vec<OrientedTriangle>>,
    /// The meshes that these triangles belong to, if vertices have moved; else empty, and they
    /// belong to those of the input.
    meshes: Vec<Mesh>,
    /// By object and triangle, the number of its strip, counted over all objects; empty unless
    /// colours show strips.
    pub(super) strips: Vec<Vec<u32>>,
    /// Triangles of all objects.
    pub(super) triangle_count: u64,
    /// Share of the input's triangles.
    pub(super) share: f64,
    pub(super) error: Option<f64>,
    pub(super) warnings: Vec<String>,
}

impl Tile {
    /// Returns the mesh of an object's triangles.
    pub(super) fn mesh<'a>(&'a self, drawable: &'a DrawableScene, object: usize) -> &'a Mesh {
        self.meshes.get(object).unwrap_or_else(|| drawable.objects.mesh(object))
    }
    /// `1,000 triangles (10.0 %)`.
    pub(super) fn sentence(&self) -> String {
        let share =
            if self.share < 1.0 { format!(" ({})", percent(self.share)) } else { String::new() };
        format!("{}{share}", count(self.triangle_count, "triangle"))
    }
    /// Two lines under the picture.
    pub(super) fn label(&self) -> [String; 2] {
        let error = self.error.map(|e| format!("  error {}", distance(e))).unwrap_or_default();
        [count(self.triangle_count, "triangle"), format!("{}{error}", percent(self.share))]
    }
}

/// At least three significant digits.
fn percent(share: f64) -> String {
    let percent = share * 100.0;
    match percent {
        100.0 => "100 %".to_owned(),
        10.0.. => format!("{percent:.1} %"),
        1.0.. => format!("{percent:.2} %"),
        _ => format!("{percent:.3} %"),
    }
}

/// The tiles that are asked for: one, or those of a contact sheet.
///
/// # Errors
/// If there is no such level or view.
pub(super) fn choose(args: &RenderArgs, drawable: &DrawableScene) -> Outcome<Vec<Tile>> {
    let objects = match &drawable.objects {
        Objects::Simplified(objects) => objects,
        Objects::Meshes(meshes) => {
            let triangles: Vec<_> = meshes.iter().map(|o| all_triangles(&o.mesh)).collect();
            return Ok(vec![Tile {
                triangle_count: sum(&triangles),
                triangles,
                meshes: Vec::new(),
                strips: Vec::new(),
                share: 1.0,
                error: None,
                warnings: Vec::new(),
            }]);
        }
    };
    let levels = scene_levels(objects, &drawable.document, &args.import.options().limits)?;
    if let Some(name) = args.views.criterion {
        args.views.check_models(&args.input, objects)?;
        return view_tiles(args, name, drawable, &levels);
    }
    let wanted: Vec<Target> = if args.contact_sheet.is_empty() {
        vec![args.selector.target().unwrap_or(Target::Ratio(1.0))]
    } else {
        args.contact_sheet.iter().map(|&share| Target::Ratio(share)).collect()
    };
    let strips: Option<Vec<Strips>> =
        (args.color == ColorMode::Strips).then(|| objects.par_iter().map(strips).collect());
    let input_triangles: u64 =
        objects.iter().map(|o| o.simplified.mesh().triangles().len() as u64).sum();
    let tile = |&target: &Target| {
        let selection = levels.select_by(target, args.selector.per_object())?;
        let (triangles, ids): (Vec<_>, Vec<_>) = match &strips {
            Some(strips) => remains_of_strips(objects, strips, &selection.lods),
            None => {
                let model = |o: &LodObject| o.models.first().map(AnyModel::kind);
                let triangles_of =
                    |(o, &lod): (&LodObject, &Lod)| levels::triangles(o, model(o), lod);
                (objects.par_iter().zip(&selection.lods).map(triangles_of).collect(), Vec::new())
            }
        };
        let live = sum(&triangles);
        Ok(Tile {
            triangles,
            meshes: Vec::new(),
            strips: ids,
            triangle_count: live,
            share: if input_triangles == 0 { 1.0 } else { live as f64 / input_triangles as f64 },
            error: Some(selection.error),
            warnings: selection.warnings,
        })
    };
    wanted.iter().map(tile).collect()
}

/// The tiles of a view: with the levels that the criterion gives, or with the numbers of triangles
/// that are asked for.
fn view_tiles(
    args: &RenderArgs,
    name: CriterionName,
    drawable: &DrawableScene,
    levels: &SceneLevels<'_>,
) -> Outcome<Vec<Tile>> {
    let views = args.views.of_scene(name, &args.selector, levels, &drawable.arrangement);
    let views =
        views.map_err(|f| Failure { message: format!("{}: {f}", args.input.display()), ..f })?;
    let sheet = args.contact_sheet.iter().map(|&share| Some(Target::Ratio(share)));
    let wanted: Vec<Option<Target>> =
        if sheet.len() > 0 { sheet.collect() } else { vec![args.selector.target()] };
    let tile = |target: Option<Target>| {
        let view = views.show(views.max_triangles(target))?;
        let meshes = if args.views.morph { views.meshes(&view)? } else { Vec::new() };
        let triangles: Vec<_> = match meshes[..] {
            [] => views.triangles(&view),
            _ => meshes.iter().map(all_triangles).collect(),
        };
        let live = sum(&triangles);
        Ok(Tile {
            triangles,
            meshes,
            strips: Vec::new(),
            triangle_count: live,
            share: if views.all() == 0 { 1.0 } else { live as f64 / views.all() as f64 },
            error: None,
            warnings: view.warnings,
        })
    };
    wanted.into_iter().map(tile).collect()
}

/// The number of the triangles of all objects.
fn sum(triangles: &[Vec<OrientedTriangle>]) -> u64 {
    triangles.iter().map(|of_object| of_object.len() as u64).sum()
}

/// All triangles of a mesh.
pub(super) fn all_triangles(mesh: &Mesh) -> Vec<OrientedTriangle> {
    let submeshes = (0..).zip(mesh.submeshes());
    submeshes
        .flat_map(|(i, s)| {
            mesh.triangles()[s.triangles()].iter().map(move |&t| OrientedTriangle::new(i, t))
        })
        .collect()
}

/// The strips of the first model that is made of strips; without one, long strips made for the
/// picture.
fn strips(object: &LodObject) -> Strips {
    let stored = object.models.iter().find_map(AnyModel::strips).cloned();
    stored.unwrap_or_else(|| {
        Strips::generate(&object.simplified, StripKind::LONGEST, Effort::Default)
    })
}

/// By object, the triangles of strips that remain at a LOD, and the strip of each, counted over all
/// objects.
fn remains_of_strips(
    objects: &[LodObject],
    strips: &[Strips],
    lods: &[Lod],
) -> (Vec<Vec<OrientedTriangle>>, Vec<Vec<u32>>) {
    let mut first = 0;
    let one = |((object, strips), &lod): ((&LodObject, &Strips), &Lod)| {
        let (triangles, mut ids) = strips.remains(&object.simplified, lod);
        ids.iter_mut().for_each(|id| *id += first);
        first += strips.len() as u32;
        (triangles, ids)
    };
    objects.iter().zip(strips).zip(lods).map(one).unzip()
}
