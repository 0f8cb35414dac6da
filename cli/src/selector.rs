//! From what a person asks for (a record, a share, a count, an error) to one LOD per object.

use crate::exit::{Failure, Outcome};
use clap::{ArgMatches, Args, Command, FromArgMatches};
use lodc_formats::lodc::LodObject;
use lodc_formats::{Document, Limits, ObjectInfo, scene_graph};
use lodc_mesh::Simplified;
use lodc_scene::{Arrangement, Graph};
use lodc_select::{Candidate, Selection, Target, losses, select};
use std::sync::OnceLock;

/// Exactly one of these says which level of detail is wanted.
#[derive(Args, Clone, Debug)]
pub(crate) struct SelectorArgs {
    #[command(flatten)]
    target: TargetArgs,
    /// Apply the selection to each object by itself instead of to the scene as a whole
    #[arg(long)]
    per_object: bool,
}

#[derive(Args, Clone, Debug)]
#[group(required = true, multiple = false)]
struct TargetArgs {
    /// The LOD after N records, rounded down to a step (0: the input; larger is coarser)
    #[arg(long, value_name = "N")]
    lod: Option<u32>,
    /// At most floor(R x input triangles), 0 to 1
    #[arg(long, value_name = "R", value_parser = ratio)]
    ratio: Option<f64>,
    /// The finest LOD with at most N triangles
    #[arg(long, value_name = "N")]
    triangles: Option<u64>,
    /// The coarsest LOD whose error is at most E, in the mesh's units (E%: of the bounding box's
    /// diagonal)
    #[arg(long, value_name = "E", value_parser = bound)]
    error: Option<Target>,
    /// The coarsest LOD whose root mean square distance from the input is at most E (or E%, as
    /// above)
    #[arg(long, value_name = "E", value_parser = rms_bound)]
    rms: Option<Target>,
}

/// The same, and none of them has to be there.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "what it is for needs a device"))]
pub(crate) struct OptionalSelector {
    target: TargetArgs,
    per_object: bool,
}

#[cfg(feature = "gpu")]
impl OptionalSelector {
    pub(crate) fn per_object(&self) -> bool {
        self.per_object
    }
    /// Returns the level asked for, if any.
    pub(crate) fn target(&self) -> Option<Target> {
        self.target.chosen()
    }
}

impl FromArgMatches for OptionalSelector {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self {
            target: TargetArgs::from_arg_matches(matches)?,
            per_object: matches.get_flag("per_object"),
        })
    }
    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for OptionalSelector {
    fn augment_args(command: Command) -> Command {
        SelectorArgs::augment_args(command).mut_group("TargetArgs", |group| group.required(false))
    }
    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl TargetArgs {
    fn chosen(&self) -> Option<Target> {
        let chosen = self.lod.map(Target::Lod).or(self.ratio.map(Target::Ratio));
        chosen.or(self.triangles.map(Target::Triangles)).or(self.error).or(self.rms)
    }
}

impl SelectorArgs {
    pub(crate) fn per_object(&self) -> bool {
        self.per_object
    }
    /// Returns the level asked for.
    pub(crate) fn target(&self) -> Target {
        self.target.chosen().expect("clap demands exactly one of the group")
    }
}

/// Objects to choose levels of detail for, and the scene that shows them.
pub(crate) struct SceneLevels<'a> {
    objects: &'a [LodObject],
    scene: Arrangement,
    losses: OnceLock<Vec<Vec<f64>>>,
}

impl<'a> SceneLevels<'a> {
    /// # Errors
    /// If the stored document is damaged.
    pub(crate) fn new(
        objects: &'a [LodObject],
        document: &Document,
        limits: &Limits,
    ) -> Outcome<Self> {
        let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
        let graph = match objects {
            // Only what several objects lose depends on where they stand.
            [] | [_] => Graph::of_objects(objects.len() as u32),
            _ => scene_graph(document, &infos, limits)?,
        };
        let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
        Ok(Self { objects, scene, losses: OnceLock::new() })
    }

    /// Objects as they are selected from.
    pub(crate) fn candidates(&self) -> Vec<Candidate<'a>> {
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
    pub(crate) fn select(&self, target: Target, per_object: bool) -> Outcome<Selection> {
        self.check_measured(target)?;
        let losses = || {
            self.losses.get_or_init(|| {
                let objects: Vec<&Simplified> =
                    self.objects.iter().map(|o| &*o.simplified).collect();
                losses(&objects, &self.scene)
            })
        };
        select(&self.candidates(), target, per_object, losses).map_err(|e| {
            Failure::usage(format!(
                "--lod counts the records of one object, and there are {}: add --per-object, or \
                 use --ratio, --triangles or --error",
                e.objects
            ))
        })
    }

    /// Refuses to choose by a distance that was not measured.
    fn check_measured(&self, target: Target) -> Outcome<()> {
        let by_rms = matches!(target, Target::Rms(_) | Target::RmsShare(_));
        let estimate = |o: &&LodObject| !o.simplified.collapses().is_measured();
        match self.objects.iter().find(|o| by_rms && estimate(o)) {
            Some(o) => Err(Failure::usage(format!(
                "{}: has errors that are estimates, and no root mean square distances: build it \
                 again for --rms, or use --error",
                o.info.name
            ))),
            None => Ok(()),
        }
    }
}

/// A share from 0 to 1.
pub(crate) fn ratio(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if (0.0..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err("a share from 0 to 1, for example 0.25".to_owned())
    }
}

fn bound(text: &str) -> Result<Target, String> {
    let (number, percent) = text.strip_suffix('%').map_or((text, false), |number| (number, true));
    let value: f64 = number.trim().parse().map_err(|e| format!("{e}"))?;
    if !value.is_finite() || value < 0.0 {
        return Err("a distance of at least 0, or a percentage such as 0.5%".to_owned());
    }
    Ok(if percent { Target::ErrorShare(value / 100.0) } else { Target::Error(value) })
}

/// A bound of the root mean square distance.
fn rms_bound(text: &str) -> Result<Target, String> {
    Ok(match bound(text)? {
        Target::ErrorShare(share) => Target::RmsShare(share),
        Target::Error(rms) => Target::Rms(rms),
        other => other,
    })
}

#[cfg(test)]
#[path = "selector_tests.rs"]
mod tests;
