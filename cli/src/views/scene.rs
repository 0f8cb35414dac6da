//! Objects of a scene with a level of detail for every part of their surfaces.

use super::ViewArgs;
use super::options::{CriterionName, Extent};
use crate::exit::{Failure, Outcome, Status};
use crate::selector::SelectorArgs;
use lodc::LodObject;
use lodc::SceneLevels;
use lodc_lod::interactive::view::{
    Family, LodRange, Selector, State, finest_within, kept, live_triangles, morphed_mesh,
};
#[cfg(feature = "gpu")]
use lodc_mesh::OrientedTriangle;
use lodc_mesh::{Lod, Mesh, PositionIds};
use lodc_scene::{Arrangement, Placement, placement_scales, posed};
use lodc_select::Target;
use rayon::prelude::*;

/// More vertices than this, instances counted, are not looked at.
const MAX_VERTICES: usize = 1 << 27;

/// An object where the scene shows it.
struct Surface<'a> {
    selector: Selector<'a>,
    family: Family,
}

/// The surfaces of a scene, and what may be shown of them.
pub(crate) struct SceneViews<'a> {
    args: &'a ViewArgs,
    name: CriterionName,
    levels: &'a SceneLevels<'a>,
    per_object: bool,
    ids: Vec<PositionIds>,
    /// Of each object where it is shown, at least one.
    surfaces: Vec<Vec<Surface<'a>>>,
}

/// A scene as a view shows it.
pub(crate) struct ShownScene {
    /// Of each object the state of every vertex.
    states: Vec<Vec<State>>,
    pub(crate) warnings: Vec<String>,
}

impl<'a> SceneViews<'a> {
    /// Looks at objects where a scene shows them; one that it does not show is as modelled.
    ///
    /// # Errors
    /// If instances have too many vertices.
    pub(crate) fn new(
        args: &'a ViewArgs,
        name: CriterionName,
        selector: &SelectorArgs,
        levels: &'a SceneLevels<'a>,
        scene: &Arrangement,
    ) -> Outcome<Self> {
        let objects = levels.objects();
        let modelled: Vec<Placement> = (0..objects.len()).map(Placement::as_modelled).collect();
        let places: Vec<Vec<(&Placement, f64)>> = (0..objects.len())
            .map(|o| match placement_scales(objects[o].simplified.mesh(), o, scene) {
                places if places.is_empty() => vec![(&modelled[o], 1.0)],
                places => places,
            })
            .collect();
        let vertices = |o: usize| objects[o].simplified.mesh().vertex_count() * places[o].len();
        if (0..objects.len()).map(vertices).sum::<usize>() > MAX_VERTICES {
            let message = format!("instances have more than {MAX_VERTICES} vertices in all");
            return Err(Failure::new(Status::Limit, message));
        }
        let shapes = shapes(objects, &places);
        let extent = extent(&shapes);
        let slope = selector.slope(selector.pixels().unwrap_or(1.0));
        let surface = |(o, (shape, &(_, scale))): (usize, (&Vec<[f32; 3]>, &(_, f64)))| Surface {
            selector: Selector::in_shape(&objects[o].simplified, shape),
            family: args.family(name, &extent, slope, if scale > 0.0 { scale } else { 1.0 }),
        };
        let surfaces = shapes.par_iter().zip(&places).enumerate().map(|(o, (shapes, places))| {
            shapes.par_iter().zip(places).map(|pair| surface((o, pair))).collect()
        });
        let ids = objects.par_iter().map(|o| PositionIds::new(o.simplified.mesh().positions()));
        let surfaces = surfaces.collect();
        let (ids, per_object) = (ids.collect(), selector.per_object());
        Ok(Self { args, name, levels, per_object, ids, surfaces })
    }

    /// Shows the criterion as it was given, or the finest that has at most `most` triangles.
    ///
    /// # Errors
    /// As [`SceneLevels::select`].
    pub(crate) fn show(&self, most: Option<u64>) -> Outcome<ShownScene> {
        let family = self.surfaces.iter().flatten().map(|s| s.family).next();
        let Some(family) = family else {
            return Ok(ShownScene { states: Vec::new(), warnings: Vec::new() });
        };
        let ranges = self.ranges(most)?;
        let setting = most.map_or_else(
            || family.given(),
            |most| {
                finest_within(most, family.coarsest(), |at| self.count(&self.states(at, &ranges)))
            },
        );
        let states = self.states(setting, &ranges);
        let triangles = self.count(&states);
        let above = most.filter(|&most| triangles > most);
        let warning =
            |most| format!("the coarsest view has {triangles} triangles, more than {most}");
        Ok(ShownScene { states, warnings: above.map(warning).into_iter().collect() })
    }

    /// Returns the number of triangles that a wish for triangles means.
    pub(crate) fn most(&self, wish: Option<Target>) -> Option<u64> {
        match wish? {
            Target::Triangles(most) => Some(most),
            Target::Ratio(share) => Some((share * self.all() as f64) as u64),
            _ => None,
        }
    }

    /// Returns the triangles of LOD 0.
    pub(crate) fn all(&self) -> u64 {
        let objects = self.levels.objects().iter();
        objects.map(|o| o.simplified.mesh().triangles().len() as u64).sum()
    }

    /// The states of all vertices; where an object is shown several times, each vertex as the
    /// finest of them needs it.
    fn states(&self, setting: u32, ranges: &[LodRange]) -> Vec<Vec<State>> {
        let object = |(surfaces, range): (&Vec<Surface<'_>>, &LodRange)| {
            let lods = surfaces
                .par_iter()
                .map(|s| s.selector.lods_at(&s.family, setting, range))
                .reduce_with(|a, b| a.iter().zip(&b).map(|(a, b)| *a.min(b)).collect());
            surfaces[0].selector.states(&lods.unwrap_or_default(), self.args.morph)
        };
        self.surfaces.par_iter().zip(ranges).map(object).collect()
    }

    /// The LODs of `--fine` and `--coarse`, and the coarsest with triangles, of each object.
    fn ranges(&self, most: Option<u64>) -> Outcome<Vec<LodRange>> {
        let all = self.all().max(1) as f64;
        let share = self.args.coarse_share(self.name, most.map(|most| most as f64 / all));
        let at = |share: f64| self.levels.select(Target::Ratio(share), self.per_object);
        let (fine, coarse) = (at(self.args.fine)?, at(share)?);
        let range = |((o, &fine), &coarse): ((&LodObject, &Lod), &Lod)| LodRange {
            fine: fine.min(coarse),
            coarse,
            last: o.simplified.collapses().last_visible().max(coarse),
        };
        Ok(self.levels.objects().iter().zip(&fine.lods).zip(&coarse.lods).map(range).collect())
    }

    fn count(&self, states: &[Vec<State>]) -> u64 {
        let objects = self.levels.objects();
        let of = |o: usize| kept(&objects[o].simplified, &self.ids[o], &states[o]);
        (0..objects.len()).into_par_iter().map(of).sum()
    }

    /// Returns the triangles of each object, corners as they are shown without morphing.
    #[cfg(feature = "gpu")]
    pub(crate) fn triangles(&self, shown: &ShownScene) -> Vec<Vec<OrientedTriangle>> {
        let of = |(o, states): (usize, &Vec<State>)| {
            live_triangles(&self.levels.objects()[o].simplified, &self.ids[o], states)
        };
        shown.states.par_iter().enumerate().map(of).collect()
    }

    /// Returns a mesh of each object that only this view has; with morphing its vertices are on
    /// their way.
    ///
    /// # Errors
    /// If one is no mesh: a bug.
    pub(crate) fn meshes(&self, shown: &ShownScene) -> Outcome<Vec<Mesh>> {
        let of = |(o, states): (usize, &Vec<State>)| {
            let object = &self.levels.objects()[o];
            let simplified = &object.simplified;
            let mesh = if self.args.morph {
                morphed_mesh(simplified, states)
            } else {
                simplified.mesh().extract(&live_triangles(simplified, &self.ids[o], states))
            };
            let name = &object.info.name;
            mesh.map_err(|e| Failure::new(Status::Bug, format!("{name}: a view is no mesh: {e}")))
        };
        shown.states.par_iter().enumerate().map(of).collect()
    }
}

/// The places of all vertices of each object, for each of its placements.
fn shapes(objects: &[LodObject], places: &[Vec<(&Placement, f64)>]) -> Vec<Vec<Vec<[f32; 3]>>> {
    let shape = |o: usize, placement: &Placement| {
        let posed = posed(objects[o].simplified.mesh(), placement).positions;
        posed.iter().map(|p| p.as_vec3().to_array()).collect()
    };
    let of = |(o, places): (usize, &Vec<(&Placement, f64)>)| {
        places.iter().map(|(placement, _)| shape(o, placement)).collect()
    };
    places.par_iter().enumerate().map(of).collect()
}

/// The box around all places that are finite.
fn extent(shapes: &[Vec<Vec<[f32; 3]>>]) -> Extent {
    let mut extent = Extent { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
    for p in shapes.iter().flatten().flatten().filter(|p| p.iter().all(|c| c.is_finite())) {
        let p = p.map(f64::from);
        extent.low = std::array::from_fn(|i| extent.low[i].min(p[i]));
        extent.high = std::array::from_fn(|i| extent.high[i].max(p[i]));
    }
    if extent.low[0] <= extent.high[0] { extent } else { Extent { low: [0.0; 3], high: [0.0; 3] } }
}
