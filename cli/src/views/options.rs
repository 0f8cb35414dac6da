//! Options of view-dependent levels.

use crate::exit::{Failure, Outcome};
use crate::selector::{SelectorArgs, positive, share};
use clap::{Args, ValueEnum};
use lodc::LodObject;
use lodc_lod::{AnyModel, ModelKind};
use lodc_model::Model;
use lodc_select::{Criterion, ViewOptions};
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
}

impl CriterionName {
    /// Returns the name as it is typed.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Silhouette => "silhouette",
            Self::Pixels => "pixels",
            Self::Sphere => "sphere",
            Self::Box => "box",
        }
    }
}

/// The eye.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct EyeArgs {
    /// Place of the eye, in the scene's units
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) eye: Option<[f32; 3]>,
    /// Point that the eye looks at, and centre of a sphere or box of detail [default: the middle of
    /// the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) target: Option<[f32; 3]>,
}

/// The rule by which every part of a surface gets a level of its own.
#[derive(Args, Clone, Debug)]
pub(crate) struct ViewArgs {
    /// Give every part of the surface a level of its own. With --triangles or --ratio the criterion
    /// is scaled by bisection until it just has as few: outlines first narrow, then grow coarser
    #[arg(
        long,
        value_enum,
        conflicts_with_all = ["lod", "error", "rms", "distance"]
    )]
    pub(crate) criterion: Option<CriterionName>,
    #[command(flatten)]
    pub(crate) at: EyeArgs,
    /// Radius of the sphere around --target [default: a quarter of the scene's diagonal]
    #[arg(long, value_name = "R", value_parser = positive, requires = "criterion")]
    radius: Option<f64>,
    /// Lowest and highest corner of the box [default: a cube around --target, its side half the
    /// scene's diagonal]
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", value_parser = corners,
          allow_hyphen_values = true, requires = "criterion")]
    corners: Option<[f32; 6]>,
    /// Share of the triangles where detail is wanted (silhouette, sphere, box)
    #[arg(long, value_name = "R", value_parser = share, default_value = "100%",
          requires = "criterion")]
    fine: f64,
    /// Share of the triangles elsewhere [default: 1%; of a silhouette with --triangles or --ratio
    /// 0.4 of what these ask for]
    #[arg(long, value_name = "R", value_parser = share, requires = "criterion")]
    coarse: Option<f64>,
    /// Move vertices smoothly between levels (geomorphing)
    #[arg(long, requires = "criterion")]
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
        let wrong = |what: String| Err(Failure::usage(what));
        let named = name.name();
        if matches!(name, CriterionName::Silhouette | CriterionName::Pixels)
            && self.at.eye.is_none()
        {
            return wrong(format!("--criterion {named} needs --eye X,Y,Z"));
        }
        for (option, given, belongs) in [
            ("--radius", self.radius.is_some(), CriterionName::Sphere),
            ("--box", self.corners.is_some(), CriterionName::Box),
            ("--pixels", selector.pixels().is_some(), CriterionName::Pixels),
        ] {
            if given && name != belongs {
                return wrong(format!(
                    "{option} belongs to --criterion {}, not {named}",
                    belongs.name()
                ));
            }
        }
        if self.coarse.is_some_and(|coarse| coarse > self.fine) {
            return wrong("--coarse keeps more triangles than --fine".to_owned());
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

    /// The view of a criterion.
    pub(super) fn options(&self, name: CriterionName, selector: &SelectorArgs) -> ViewOptions {
        let criterion = match name {
            CriterionName::Silhouette => Criterion::Silhouette,
            CriterionName::Pixels => {
                Criterion::Pixels { slope: selector.slope(selector.pixels().unwrap_or(1.0)) }
            }
            CriterionName::Sphere => Criterion::Sphere { radius: self.radius },
            CriterionName::Box => Criterion::Box {
                corners: self.corners.map(|[a, b, c, x, y, z]| [[a, b, c], [x, y, z]]),
            },
        };
        let Self { at: EyeArgs { eye, target }, fine, coarse, morph, .. } = *self;
        let per_object = selector.per_object();
        ViewOptions { criterion, eye, target, fine, coarse, morph, per_object }
    }
}

/// A place: `X,Y,Z`.
pub(crate) fn point(text: &str) -> Result<[f32; 3], String> {
    numbers(text).ok_or_else(|| "three numbers X,Y,Z".to_owned())
}

/// Two corners of a box.
fn corners(text: &str) -> Result<[f32; 6], String> {
    numbers(text)
        .filter(|c: &[f32; 6]| (0..3).all(|i| c[i] <= c[i + 3]))
        .ok_or_else(|| "the lowest and the highest corner as six numbers X,Y,Z,X,Y,Z".to_owned())
}

fn numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let numbers = <[f32; N]>::try_from(numbers.ok()?).ok()?;
    numbers.iter().all(|c| c.is_finite()).then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_boxes_are_read_and_nonsense_is_refused() {
        assert_eq!(point("1,-2.5, 3e2"), Ok([1.0, -2.5, 300.0]));
        assert_eq!(corners("0,0,0,1,2,3"), Ok([0.0, 0.0, 0.0, 1.0, 2.0, 3.0]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "NaN,0,0"] {
            assert!(point(wrong).is_err(), "{wrong}");
        }
        for wrong in ["1,2,3", "0,0,0,1,1,-1"] {
            assert!(corners(wrong).is_err(), "{wrong}");
        }
    }
}
