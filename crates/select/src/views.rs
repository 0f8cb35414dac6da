//! View-dependent levels: a level of detail for every part of a scene's surfaces, by criteria such
//! as outlines or the error on the screen.

use crate::levels::{ObjectLevels, SceneLevels, SelectError};
use crate::selection::Target;
use glam::DVec3;
use lodc_lod::interactive::view::{
    Family, LodRange, Selector, State, drawn_triangles, finest_within, live_triangles,
    morphed_mesh, view_mesh,
};
use lodc_mesh::{Lod, Mesh, OrientedTriangle, PositionIds};
use lodc_scene::{Arrangement, Placement, centre, placement_scales, posed_positions};
use rayon::prelude::*;

/// Largest number of vertices, instances counted, for which views are made. Chosen by hand.
const MAX_VERTICES: usize = 1 << 27;

/// Share of the triangles where no detail is wanted. Chosen by hand.
const COARSE_SHARE: f64 = 0.01;
/// Share of the wanted triangles that is used beside outlines. With fewer, facets beside outlines
/// become visible; with more, outlines get too few (measured on the bunny at 25, 10 and 5 %, by
/// the pixels of its outline).
const SHARE_BESIDE_OUTLINES: f64 = 0.4;

/// The rule by which every part of a surface gets a level of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// Fine where the surface is seen edge-on, coarse where it faces the eye.
    Silhouette,
    /// An error of at most `slope` times the distance from the eye.
    Pixels {
        /// Error per distance.
        slope: f64,
    },
    /// Fine in a sphere around the target, coarse outside.
    Sphere {
        /// In the scene's units; none: a quarter of its diagonal.
        radius: Option<f64>,
    },
    /// Fine in a box, coarse outside.
    Box {
        /// Its lowest and its highest corner; none: a cube around the target, its side half the
        /// scene's diagonal.
        corners: Option<[[f64; 3]; 2]>,
    },
    /// Fine on the screen, coarse behind the eye and beside the screen. The target is its middle.
    Frustum {
        /// Tangents of half the angles that it shows, across and upwards.
        tangents: [f64; 2],
    },
}

/// A view of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewOptions {
    /// The rule.
    pub criterion: Criterion,
    /// Position of the eye, in the scene's units; none: that of the target.
    pub eye: Option<[f64; 3]>,
    /// The point looked at; none: the middle of the scene.
    pub target: Option<[f64; 3]>,
    /// Share of the triangles where detail is wanted.
    pub fine: f64,
    /// Share of the triangles elsewhere; none: a hundredth or, beside outlines, a part of what is
    /// asked for.
    pub coarse: Option<f64>,
    /// Vertices are interpolated between levels (geomorphing).
    pub morph: bool,
    /// Shares are those of each object, not of the scene.
    pub per_object: bool,
}

impl ViewOptions {
    /// The share of triangles that is kept where no detail is wanted, `wanted` being the share of
    /// all that is asked for.
    fn coarse_share(&self, wanted: Option<f64>) -> f64 {
        let beside_outlines = wanted.filter(|_| self.criterion == Criterion::Silhouette);
        let default = beside_outlines.map_or(COARSE_SHARE, |share| share * SHARE_BESIDE_OUTLINES);
        self.coarse.unwrap_or(default).min(self.fine)
    }

    /// The criteria of a scene of this extent for an object that errs by at most `error_scale`
    /// world units for each mesh unit of its levels' errors.
    fn family(&self, scene: &Extent, error_scale: f64) -> Family {
        let target = self.target.unwrap_or_else(|| scene.middle());
        let quarter = scene.diagonal() / 4.0;
        let eye = scene.local(self.eye.unwrap_or(target));
        let centre = scene.local(target);
        match self.criterion {
            Criterion::Silhouette => Family::Silhouette { eye },
            Criterion::Pixels { slope } => {
                Family::ScreenError { eye, slope: slope as f32, unit: (1.0 / error_scale) as f32 }
            }
            Criterion::Sphere { radius } => {
                Family::Sphere { centre, radius: radius.unwrap_or(quarter) as f32 }
            }
            Criterion::Box { corners } => {
                let around = |sign: f32| centre.map(|c| c + sign * quarter as f32);
                let given = corners.map(|corners| corners.map(|corner| scene.local(corner)));
                let [low, high] = given.unwrap_or_else(|| [around(-1.0), around(1.0)]);
                Family::Region { low, high }
            }
            Criterion::Frustum { tangents } => {
                Family::Frustum { eye, target: centre, tangents: tangents.map(|t| t as f32) }
            }
        }
    }
}

/// The box of a scene.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: [f64; 3],
    high: [f64; 3],
    /// The point about which positions are in single precision: [`centre`].
    centre: [f64; 3],
}

impl Extent {
    fn middle(&self) -> [f64; 3] {
        std::array::from_fn(|i| f64::midpoint(self.low[i], self.high[i]))
    }
    /// A point about the centre.
    fn local(&self, point: [f64; 3]) -> [f32; 3] {
        std::array::from_fn(|i| (point[i] - self.centre[i]) as f32)
    }
    fn diagonal(&self) -> f64 {
        (0..3).map(|i| (self.high[i] - self.low[i]).powi(2)).sum::<f64>().sqrt()
    }
}

/// An object in one of its placements.
struct Surface<'a> {
    selector: Selector<'a>,
    family: Family,
}

/// The surfaces of a scene, for which it makes views.
pub struct SceneViews<'a> {
    options: ViewOptions,
    levels: &'a SceneLevels<'a>,
    ids: Vec<PositionIds>,
    /// For each object its placements, at least one.
    surfaces: Vec<Vec<Surface<'a>>>,
}

/// A scene as a view shows it.
#[derive(Debug)]
pub struct ShownScene {
    /// For each object the state of every vertex.
    states: Vec<Vec<State>>,
    /// Targets that could not be met in full: one line each.
    pub warnings: Vec<String>,
}

impl<'a> SceneViews<'a> {
    /// Prepares objects where a scene shows them; one that it does not show is as modelled.
    ///
    /// # Errors
    /// If instances have too many vertices.
    pub fn new(
        options: ViewOptions,
        levels: &'a SceneLevels<'a>,
        scene: &Arrangement,
    ) -> Result<Self, SelectError> {
        let objects = levels.objects();
        let modelled: Vec<Placement> = (0..objects.len()).map(Placement::as_modelled).collect();
        let placements: Vec<Vec<(&Placement, f64)>> = (0..objects.len())
            .map(|o| match placement_scales(objects[o].simplified.mesh(), o, scene) {
                placements if placements.is_empty() => vec![(&modelled[o], 1.0)],
                placements => placements,
            })
            .collect();
        let vertices = |o: usize| objects[o].simplified.mesh().vertex_count() * placements[o].len();
        if (0..objects.len()).map(vertices).sum::<usize>() > MAX_VERTICES {
            return Err(SelectError::TooManyVertices { limit: MAX_VERTICES });
        }
        let centre = centre(scene, |o| objects[o].simplified.mesh());
        let shapes = shapes(objects, &placements, centre);
        let extent = extent(&shapes, centre);
        let surface = |(o, (shape, &(_, scale))): (usize, (&Vec<[f32; 3]>, &(_, f64)))| {
            // What a placement errs is at most this for each mesh unit of the object's error. (A
            // pose may show it larger than the scene does at any moment that was measured.)
            let ObjectLevels { simplified, unevenness, .. } = objects[o];
            let error_scale = if scale > 0.0 { scale * unevenness } else { 1.0 };
            let selector = Selector::in_shape(simplified, shape);
            Surface { selector, family: options.family(&extent, error_scale) }
        };
        let surfaces =
            shapes.par_iter().zip(&placements).enumerate().map(|(o, (shapes, placements))| {
                shapes.par_iter().zip(placements).map(|pair| surface((o, pair))).collect()
            });
        let ids = objects.par_iter().map(|o| o.simplified.mesh().position_ids());
        let surfaces = surfaces.collect();
        Ok(Self { options, levels, ids: ids.collect(), surfaces })
    }

    /// Shows the criterion as it was given, or the finest that has at most `max_triangles`
    /// triangles.
    ///
    /// # Errors
    /// As [`SceneLevels::select`].
    pub fn show(&self, max_triangles: Option<u64>) -> Result<ShownScene, SelectError> {
        let family = self.surfaces.iter().flatten().map(|s| s.family).next();
        let Some(family) = family else {
            return Ok(ShownScene { states: Vec::new(), warnings: Vec::new() });
        };
        let ranges = self.ranges(max_triangles)?;
        let setting = max_triangles.map_or_else(
            || family.given_setting(),
            |max_triangles| {
                finest_within(max_triangles, family.coarsest(), |setting| {
                    self.count(&self.states(setting, &ranges))
                })
            },
        );
        let states = self.states(setting, &ranges);
        let triangles = self.count(&states);
        let too_many = max_triangles.filter(|&max_triangles| triangles > max_triangles);
        let warning = |max_triangles| {
            format!("the coarsest view has {triangles} triangles, more than {max_triangles}")
        };
        Ok(ShownScene { states, warnings: too_many.map(warning).into_iter().collect() })
    }

    /// Returns the largest number of triangles that a target allows; none if it limits errors.
    #[must_use]
    pub fn max_triangles(&self, target: Option<Target>) -> Option<u64> {
        match target? {
            Target::Triangles(count) => Some(count),
            Target::Ratio(share) => Some((share * self.all() as f64) as u64),
            _ => None,
        }
    }

    /// Returns the number of triangles at LOD 0.
    #[must_use]
    pub fn all(&self) -> u64 {
        let objects = self.levels.objects().iter();
        objects.map(|o| o.simplified.mesh().triangles().len() as u64).sum()
    }

    /// The states of all vertices; where an object is shown several times, each vertex as the
    /// finest of them needs it.
    fn states(&self, setting: u32, ranges: &[LodRange]) -> Vec<Vec<State>> {
        let object = |((surfaces, range), ids): ((&Vec<Surface<'_>>, &LodRange), &PositionIds)| {
            let lods = surfaces
                .par_iter()
                .map(|s| s.selector.lods_at(&s.family, setting, range))
                .reduce_with(|a, b| a.iter().zip(&b).map(|(a, b)| *a.min(b)).collect());
            let mut lods: Vec<u32> = lods.unwrap_or_default();
            surfaces[0].selector.unfold(&mut lods, ids);
            surfaces[0].selector.states(&lods, self.options.morph)
        };
        self.surfaces.par_iter().zip(ranges).zip(&self.ids).map(object).collect()
    }

    /// The LODs of `--fine` and `--coarse`, and the coarsest with triangles, of each object.
    fn ranges(&self, max_triangles: Option<u64>) -> Result<Vec<LodRange>, SelectError> {
        let all = self.all().max(1) as f64;
        let share = self
            .options
            .coarse_share(max_triangles.map(|max_triangles| max_triangles as f64 / all));
        let at = |share: f64| self.levels.select_by(Target::Ratio(share), self.options.per_object);
        let (fine, coarse) = (at(self.options.fine)?, at(share)?);
        let range = |((o, &fine), &coarse): ((&ObjectLevels<'_>, &Lod), &Lod)| LodRange {
            fine: fine.min(coarse),
            coarse,
            last: o.simplified.collapses().last_visible().min(o.simplified.coarsest()).max(coarse),
        };
        Ok(self.levels.objects().iter().zip(&fine.lods).zip(&coarse.lods).map(range).collect())
    }

    /// The number of triangles that are drawn.
    fn count(&self, states: &[Vec<State>]) -> u64 {
        let objects = self.levels.objects();
        let drawn = |o: usize| drawn_triangles(objects[o].simplified, &self.ids[o], &states[o]);
        (0..objects.len()).into_par_iter().map(drawn).sum()
    }

    /// Returns the triangles of each object, corners as they are shown without morphing.
    #[must_use]
    pub fn triangles(&self, shown: &ShownScene) -> Vec<Vec<OrientedTriangle>> {
        let live = |(o, states): (usize, &Vec<State>)| {
            live_triangles(self.levels.objects()[o].simplified, &self.ids[o], states)
        };
        shown.states.par_iter().enumerate().map(live).collect()
    }

    /// Returns a mesh of each object as the view shows it; with morphing its vertices are
    /// interpolated between levels.
    ///
    /// # Errors
    /// If one is no mesh: a bug.
    pub fn meshes(&self, shown: &ShownScene) -> Result<Vec<Mesh>, SelectError> {
        let mesh = |(o, states): (usize, &Vec<State>)| {
            let ObjectLevels { name, simplified, .. } = self.levels.objects()[o];
            let mesh = if self.options.morph {
                morphed_mesh(simplified, states)
            } else {
                view_mesh(simplified, &self.ids[o], states)
            };
            let failed = |what| SelectError::NoMesh { object: name.to_owned(), what };
            mesh.map_err(|e| failed(e.to_string()))
        };
        shown.states.par_iter().enumerate().map(mesh).collect()
    }
}

/// The positions of all vertices of each object about `centre`, for each of its placements.
fn shapes(
    objects: &[ObjectLevels<'_>],
    placements: &[Vec<(&Placement, f64)>],
    centre: [f64; 3],
) -> Vec<Vec<Vec<[f32; 3]>>> {
    let posed = |o: usize, placement: &Placement| {
        let posed = posed_positions(objects[o].simplified.mesh(), placement);
        posed.iter().map(|p| (*p - DVec3::from(centre)).as_vec3().to_array()).collect()
    };
    let shapes = |(o, placements): (usize, &Vec<(&Placement, f64)>)| {
        placements.iter().map(|(placement, _)| posed(o, placement)).collect()
    };
    placements.par_iter().enumerate().map(shapes).collect()
}

/// The box around all positions that are finite; these are about `centre`.
fn extent(shapes: &[Vec<Vec<[f32; 3]>>], centre: [f64; 3]) -> Extent {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in shapes.iter().flatten().flatten().filter(|p| p.iter().all(|c| c.is_finite())) {
        let p: [f64; 3] = std::array::from_fn(|i| f64::from(p[i]) + centre[i]);
        low = std::array::from_fn(|i| low[i].min(p[i]));
        high = std::array::from_fn(|i| high[i].max(p[i]));
    }
    if low[0] > high[0] {
        (low, high) = ([0.0; 3], [0.0; 3]);
    }
    Extent { low, high, centre }
}
