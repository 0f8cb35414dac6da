//! Options of view-dependent levels: the criterion (silhouette, pixels, sphere, box, frustum) and
//! the eye that it needs.

use crate::exit::{Failure, Outcome};
use crate::help::SEEN;
use crate::selector::{SelectorArgs, positive, share};
use clap::{Args, ValueEnum};
use lodc::LodObject;
use lodc_lod::{AnyModel, ModelKind};
use lodc_model::Model;
use lodc_scene::Arrangement;
use lodc_select::{Criterion, SceneLevels, SceneViews, ViewOptions};
use std::path::Path;

/// Criteria that can be named.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CriterionName {
    /// Fine where the surface is seen edge-on, coarse where it faces the eye
    Silhouette,
    /// An error of at most --pixels on the screen, from near to far
    Pixels,
    /// Fine within --radius of --target, coarse outside
    Sphere,
    /// Fine in --box, coarse outside
    Box,
    /// Fine on the screen, coarse behind --eye and beside the screen
    Frustum,
}

impl CriterionName {
    /// Returns the name as it is typed.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Silhouette => "silhouette",
            Self::Pixels => "pixels",
            Self::Sphere => "sphere",
            Self::Box => "box",
            Self::Frustum => "frustum",
        }
    }
}

/// The eye.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = SEEN)]
pub(crate) struct EyeArgs {
    /// Place of the eye, in the scene's units
    ///
    /// The criteria silhouette, pixels and frustum need it.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true,
          hide_short_help = true)]
    pub(crate) eye: Option<[f64; 3]>,
    /// Point looked at; middle of a sphere or box [default: that of the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true,
          hide_short_help = true)]
    pub(crate) target: Option<[f64; 3]>,
}

/// The rule by which every part of a surface gets a level of its own.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = SEEN)]
pub(crate) struct ViewArgs {
    /// Give every part of the surface a level of its own
    ///
    /// With --triangles or --ratio the criterion is scaled by bisection until the view just has as
    /// few: what is coarse goes from --fine to --coarse, detail along outlines narrows to a line,
    /// what is fine follows, then everything goes on to the last level with a triangle; pixels
    /// allows more pixels. Needs a mesh, or a .lodc file with the model interactive or with none.
    #[arg(long, value_enum, conflicts_with_all = ["lod", "error", "rms", "distance"],
          hide_short_help = true)]
    pub(crate) criterion: Option<CriterionName>,
    #[command(flatten)]
    pub(crate) at: EyeArgs,
    /// Radius of the sphere [default: a quarter of the scene's diagonal]
    #[arg(long, value_name = "R", value_parser = positive, requires = "criterion",
          hide_short_help = true)]
    radius: Option<f64>,
    /// Lowest and highest corner of the box [default: around --target]
    ///
    /// The default is a cube whose side is half the scene's diagonal.
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", value_parser = corners,
          allow_hyphen_values = true, requires = "criterion", hide_short_help = true)]
    corners: Option<[f64; 6]>,
    /// Width of the screen by its height, for --criterion frustum [default: 16:9]
    ///
    /// --fovy is its angle upwards, --target its middle.
    #[arg(long, value_name = "R", value_parser = aspect, requires = "criterion",
          hide_short_help = true)]
    aspect: Option<f64>,
    /// Share of the triangles where detail is wanted
    ///
    /// For silhouette, sphere, box and frustum.
    #[arg(long, value_name = "R", value_parser = share, default_value = "100%",
          requires = "criterion", hide_short_help = true)]
    fine: f64,
    /// Share of the triangles elsewhere [default: 1%]
    ///
    /// Beside outlines (silhouette), with --triangles or --ratio, the default is 0.4 of what these
    /// ask for.
    #[arg(long, value_name = "R", value_parser = share, requires = "criterion",
          hide_short_help = true)]
    coarse: Option<f64>,
    /// Move vertices smoothly between levels (geomorphing)
    ///
    /// A vertex sets out n/8 records before the step that takes it away, n vertices staying longer,
    /// and arrives at that step where its target is by then. The triangles are those without
    /// --morph.
    #[arg(long, requires = "criterion", hide_short_help = true)]
    pub(crate) morph: bool,
}

impl ViewArgs {
    /// Refuses options that do not fit together. Returns the criterion if there is one.
    ///
    /// # Errors
    /// If a criterion lacks its eye, or has what belongs to another.
    pub(crate) fn check(&self, selector: &SelectorArgs) -> Outcome<Option<CriterionName>> {
        let Some(name) = self.criterion else {
            selector.check_distance()?;
            return Ok(None);
        };
        let refused = |what: String| Err(Failure::usage(what));
        let typed = name.name();
        let from_eye = [CriterionName::Silhouette, CriterionName::Pixels, CriterionName::Frustum];
        if from_eye.contains(&name) && self.at.eye.is_none() {
            return refused(format!("--criterion {typed} needs --eye X,Y,Z"));
        }
        for (option, given, owner) in [
            ("--radius", self.radius.is_some(), CriterionName::Sphere),
            ("--box", self.corners.is_some(), CriterionName::Box),
            ("--aspect", self.aspect.is_some(), CriterionName::Frustum),
            ("--pixels", selector.pixels().is_some(), CriterionName::Pixels),
        ] {
            if given && name != owner {
                return refused(format!(
                    "{option} belongs to --criterion {}, not {typed}",
                    owner.name()
                ));
            }
        }
        if self.coarse.is_some_and(|coarse| coarse > self.fine) {
            return refused("--coarse keeps more triangles than --fine".to_owned());
        }
        Ok(Some(name))
    }

    /// Refuses files whose models leave out the one that views are made of.
    ///
    /// # Errors
    /// If there are models and none is an Interactive Mesh.
    pub(crate) fn check_models(&self, input: &Path, objects: &[LodObject]) -> Outcome<()> {
        let lacks = |o: &&LodObject| {
            !o.models.is_empty() && o.models.iter().all(|m| m.kind() != ModelKind::Interactive)
        };
        let Some(object) = objects.iter().find(lacks) else { return Ok(()) };
        let has: Vec<_> = object.models.iter().map(AnyModel::name).collect();
        Err(Failure::usage(format!(
            "{}: --criterion needs the model interactive (it has: {})",
            input.display(),
            has.join(", ")
        )))
    }

    /// The views of a scene by a criterion.
    ///
    /// # Errors
    /// As [`SceneViews::new`].
    pub(crate) fn of_scene<'a>(
        &self,
        name: CriterionName,
        selector: &SelectorArgs,
        levels: &'a SceneLevels<'a>,
        scene: &Arrangement,
    ) -> Outcome<SceneViews<'a>> {
        Ok(SceneViews::new(self.options(name, selector), levels, scene)?)
    }

    /// The options of a criterion's view.
    fn options(&self, name: CriterionName, selector: &SelectorArgs) -> ViewOptions {
        let criterion = match name {
            CriterionName::Silhouette => Criterion::Silhouette,
            CriterionName::Pixels => {
                Criterion::Pixels { slope: selector.slope(selector.pixels().unwrap_or(1.0)) }
            }
            CriterionName::Sphere => Criterion::Sphere { radius: self.radius },
            CriterionName::Box => Criterion::Box {
                corners: self.corners.map(|[a, b, c, x, y, z]| [[a, b, c], [x, y, z]]),
            },
            CriterionName::Frustum => {
                let upwards = selector.tangent();
                Criterion::Frustum {
                    tangents: [self.aspect.unwrap_or(16.0 / 9.0) * upwards, upwards],
                }
            }
        };
        let Self { at: EyeArgs { eye, target }, fine, coarse, morph, .. } = *self;
        let per_object = selector.per_object();
        ViewOptions { criterion, eye, target, fine, coarse, morph, per_object }
    }
}

/// Reads a width by a height: `16:9`, or the number that it is.
fn aspect(text: &str) -> Result<f64, String> {
    let (width, height) = text.split_once(':').unwrap_or((text, "1"));
    let quotient = positive(width).and_then(|width| Ok(width / positive(height)?));
    let quotient = quotient.ok().filter(|quotient| quotient.is_finite() && *quotient > 0.0);
    quotient
        .ok_or_else(|| "must be two numbers above 0, such as 16:9, or one, such as 1.5".to_owned())
}

/// Reads a point, `X,Y,Z`.
pub(crate) fn point(text: &str) -> Result<[f64; 3], String> {
    numbers(text).ok_or_else(|| "three numbers X,Y,Z".to_owned())
}

/// Reads the lowest and the highest corner of a box, `X,Y,Z,X,Y,Z`.
fn corners(text: &str) -> Result<[f64; 6], String> {
    numbers(text)
        .filter(|c: &[f64; 6]| (0..3).all(|i| c[i] <= c[i + 3]))
        .ok_or_else(|| "the lowest and the highest corner as six numbers X,Y,Z,X,Y,Z".to_owned())
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let numbers = <[f64; N]>::try_from(numbers.ok()?).ok()?;
    numbers.iter().all(|c| c.is_finite()).then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_boxes_are_read_and_nonsense_is_refused() {
        assert_eq!(point("1,-2.5, 3e2"), Ok([1.0, -2.5, 300.0]));
        assert_eq!(corners("0,0,0,1,2,3"), Ok([0.0, 0.0, 0.0, 1.0, 2.0, 3.0]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "NaN,0,0"] {
            assert!(point(wrong).is_err(), "{wrong}");
        }
        for wrong in ["1,2,3", "0,0,0,1,1,-1"] {
            assert!(corners(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_screen_is_two_numbers_or_one() {
        assert_eq!((aspect("16:9"), aspect("1.5")), (Ok(16.0 / 9.0), Ok(1.5)));
        for wrong in
            ["", ":", "16:", ":9", "16:0", "-16:9", "16:9:1", "16/9", "inf", "1e300:1e-300"]
        {
            assert!(aspect(wrong).is_err(), "{wrong}");
        }
    }
}
