//! Options whose values are names from a library's list (models, metrics, strip generators): `clap`
//! takes values, help and default from the list itself. Also options beside them that several
//! commands have: the upward axis, the order of steps, poses.

use crate::exit::{Failure, Outcome};
use crate::help::{SIMPLIFIED, STORED};
use crate::numbers::whole;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use lodc::pipeline::DEFAULT_POSES;
use lodc_formats::lodc::{Layout, MAX_POSES};
use lodc_lod::ModelKind;
use lodc_simplify::MetricKind;
use lodc_strip::{Effort, StripKind, StripOptions};

/// A type whose values form a closed list, each with a name that an option takes.
pub(crate) trait Kind: Copy + Send + Sync + 'static {
    /// The whole list.
    const ALL: &'static [Self];

    /// The name in options.
    fn name(self) -> &'static str;

    /// One line of help.
    fn help(self) -> &'static str;
}

/// The upward axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum UpAxis {
    Y,
    Z,
}

/// Implements [`Kind`] by the list, the names and the help that a library's type has.
macro_rules! impl_kind {
    ($($kind:ty),*) => {$(
        impl Kind for $kind {
            const ALL: &'static [Self] = &Self::ALL;

            fn name(self) -> &'static str {
                self.name()
            }

            fn help(self) -> &'static str {
                self.help()
            }
        }
    )*};
}

impl_kind!(ModelKind, MetricKind, StripKind, Effort, Layout);

/// A value from a [`Kind`]'s list, or the one other word that an option also takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice<K> {
    /// A value from the list.
    Kind(K),
    /// The other word.
    Other,
}

impl<K> Choice<K> {
    /// The value from the list, if one was named.
    pub(crate) fn kind(self) -> Option<K> {
        match self {
            Self::Kind(kind) => Some(kind),
            Self::Other => None,
        }
    }
}

/// Reads the name of a kind.
pub(crate) fn parser<K: Kind>() -> impl TypedValueParser<Value = K> {
    PossibleValuesParser::new(values::<K>()).map(|name| find(&name).expect("a possible value"))
}

/// Reads the name of a kind, or one other word.
pub(crate) fn parser_with<K: Kind>(
    other: &'static str,
    help: &'static str,
) -> impl TypedValueParser<Value = Choice<K>> {
    let values = values::<K>().chain([PossibleValue::new(other).help(help)]);
    PossibleValuesParser::new(values).map(|name| find(&name).map_or(Choice::Other, Choice::Kind))
}

fn find<K: Kind>(name: &str) -> Option<K> {
    K::ALL.iter().copied().find(|kind| kind.name() == name)
}

fn values<K: Kind>() -> impl Iterator<Item = PossibleValue> {
    K::ALL.iter().map(|kind| PossibleValue::new(kind.name()).help(kind.help()))
}

/// The option of commands that simplify meshes.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct MetricArgs {
    /// Metric; hybrid may look better
    ///
    /// It takes 5 to 20 times as long. Once refitted, levels of single smooth or textured objects
    /// have a tenth less image error on average; those of scenes of several objects or layers have
    /// as much or more where half or a quarter of the triangles stay, and a little less from 10 %
    /// down. A .lodc file has its order of collapses already.
    #[arg(
        long,
        value_parser = parser::<MetricKind>(),
        default_value = MetricKind::default().name(),
        help_heading = SIMPLIFIED
    )]
    pub(crate) metric: MetricKind,
}

/// Orders that the steps of a file can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum StepOrder {
    #[default]
    Metric,
    Stream,
}

/// The option of the command that orders steps.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct StepOrderArgs {
    /// Order of the steps: by the metric, or as streams have them
    ///
    /// stream: `pack` keeps every level, and `unpack -o F.lodc` with the options of `build` gives
    /// the file again, byte for byte. Levels between the ends of batches, about fifty, lie a little
    /// farther from the input. Such a file does not say what it was made from: --if-changed always
    /// makes it anew.
    #[arg(long, value_enum, value_name = "ORDER", default_value = "metric", help_heading = STORED)]
    pub(crate) sequence: StepOrder,
}

/// The option of commands that measure errors.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct PosesArgs {
    /// Poses besides rest that errors hold in [default: 8]
    ///
    /// Those in which an object's shape differs most, if it has a skin or morph targets: moments of
    /// animations and single targets, at most 64. 0: errors are those at rest. A .lodc file has its
    /// errors already.
    #[arg(long, value_name = "N", help_heading = SIMPLIFIED, hide_short_help = true,
          value_parser = whole::<u8>(0..=MAX_POSES as i128))]
    poses: Option<u8>,
}

impl PosesArgs {
    /// How many poses errors hold in at most, besides rest.
    pub(crate) fn max_poses(self) -> usize {
        self.poses.map_or(DEFAULT_POSES, usize::from)
    }
}

/// Options of commands that write .lodc files.
#[derive(Args, Clone, Debug)]
pub(crate) struct ModelArgs {
    /// Models to store, separated by commas, for programs that change levels [default: all]
    ///
    /// Only programs that change levels while they run need any; they are 15 to 45 % of a file.
    /// interactive is for graphics devices, speed for processors, masking for processors with
    /// little memory.
    #[arg(long, value_delimiter = ',', value_name = "MODELS", value_parser = models(),
          help_heading = STORED)]
    models: Vec<Structures>,
    /// Width of the indices in the file; levels are the same
    #[arg(long, value_parser = parser::<Layout>(), default_value = Layout::default().name(),
          help_heading = STORED, hide_short_help = true)]
    layout: Layout,
}

impl ModelArgs {
    /// Returns whether an option differs from its default.
    pub(crate) fn is_given(&self) -> bool {
        !self.models.is_empty() || self.layout != Layout::default()
    }

    /// The layout of the file.
    pub(crate) fn layout(&self) -> Layout {
        self.layout
    }

    /// The structures to write, in the order of files.
    ///
    /// # Errors
    /// If `none` goes with another name.
    pub(crate) fn kinds(&self) -> Outcome<Vec<ModelKind>> {
        let named = &self.models;
        if !named.contains(&Structures::None) {
            let is_wanted = |kind: ModelKind| named.contains(&Structures::Of(kind));
            let all = named.is_empty() || named.contains(&Structures::All);
            return Ok(ModelKind::ALL.into_iter().filter(|&k| all || is_wanted(k)).collect());
        }
        match named.iter().all(|name| *name == Structures::None) {
            true => Ok(vec![]),
            false => Err(Failure::usage("--models none cannot be combined with other models")),
        }
    }
}

/// What a value of `--models` stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Structures {
    Of(ModelKind),
    All,
    None,
}

/// Reads the name of a model, `all` or `none`.
fn models() -> impl TypedValueParser<Value = Structures> {
    let all = PossibleValue::new("all").help("Each of them");
    let none = PossibleValue::new("none")
        .help("The collapse sequence alone: extract, chain, render and pack need no more");
    PossibleValuesParser::new(values::<ModelKind>().chain([all, none])).map(|name| {
        match name.as_str() {
            "all" => Structures::All,
            "none" => Structures::None,
            name => Structures::Of(find(name).expect("a possible value")),
        }
    })
}

/// The models that were named, in the order that files have them; all if none was named, or the
/// other word.
pub(crate) fn models_or_all(named: &[Choice<ModelKind>]) -> Vec<ModelKind> {
    let all = named.is_empty() || named.contains(&Choice::Other);
    let is_wanted = |kind: &ModelKind| all || named.contains(&Choice::Kind(*kind));
    ModelKind::ALL.into_iter().filter(is_wanted).collect()
}

/// Options of commands that make strips.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct StripArgs {
    #[arg(long, value_parser = parser::<StripKind>(), help = strips_help(),
          help_heading = STORED, hide_short_help = true)]
    strips: Option<StripKind>,
    /// Effort of the search for strips
    #[arg(long, value_parser = parser::<Effort>(), default_value = Effort::default().name(),
          help_heading = STORED, hide_short_help = true)]
    effort: Effort,
}

impl StripArgs {
    /// The options as the generators take them.
    pub(crate) fn options(self) -> StripOptions {
        StripOptions { kind: self.strips, effort: self.effort }
    }
}

/// Help of `--strips`, with the default of every model that is made of strips.
fn strips_help() -> String {
    let defaults = ModelKind::ALL
        .into_iter()
        .filter_map(|model| Some(format!("{} for {}", model.strips()?.name(), model.name())));
    let defaults: Vec<String> = defaults.collect();
    format!("Strips of all models made of strips [default: {}]", defaults.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Arg, Command};

    fn parsed<V: Clone + Send + Sync + 'static>(
        parser: impl TypedValueParser<Value = V>,
        name: &str,
    ) -> Option<V> {
        let command = Command::new("lodc").arg(Arg::new("kind").value_parser(parser));
        command.try_get_matches_from(["lodc", name]).ok()?.get_one::<V>("kind").cloned()
    }

    fn check<K: Kind + PartialEq + std::fmt::Debug>() {
        for &kind in K::ALL {
            assert_eq!(parsed(parser::<K>(), kind.name()), Some(kind));
            assert_eq!(parsed(parser_with::<K>("x", ""), kind.name()), Some(Choice::Kind(kind)));
            assert!(!kind.help().is_empty());
        }
        assert_eq!(parsed(parser_with::<K>("x", ""), "x"), Some(Choice::Other));
        assert_eq!(parsed(parser::<K>(), "x"), None);
    }

    #[test]
    fn every_value_of_a_list_can_be_named_and_nothing_else() {
        check::<ModelKind>();
        check::<MetricKind>();
        check::<StripKind>();
        check::<Effort>();
        check::<Layout>();
    }

    #[test]
    fn help_names_the_default_strips_of_every_model_that_has_some() {
        let help = strips_help();
        assert!(help.ends_with("[default: stripe for speed, cache for masking]"), "{help}");
    }
}
