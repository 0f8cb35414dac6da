//! `lodc strips`: writes the strips of a generator as text, for study and comparison.

use crate::console::{self, note};
use crate::exit::Outcome;
use crate::help::{BECOMES, MORE, OUTPUT};
use crate::kinds::{Choice, parser, parser_with};
use crate::limits::ImportArgs;
use crate::numbers::whole;
use crate::output;
use crate::stages::Stages;
use clap::Args;
use clap::builder::TypedValueParser;
use lodc::pipeline::Size;
use lodc_formats::import;
use lodc_lab::StripText;
use lodc_report::text::count;
use lodc_strip::{CacheOptions, Effort, StripKind};
use std::path::PathBuf;

/// Options of `strips`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct StripsArgs {
    /// A mesh (.glb, .gltf, .obj, .ply, .stl); - for standard input
    input: PathBuf,
    /// Strips to make, or a triangle list in their place
    #[arg(long, value_parser = generators(), default_value = StripKind::LONGEST.name(),
          help_heading = BECOMES)]
    strips: Choice<StripKind>,
    /// Effort of the search for strips
    #[arg(long, value_parser = parser::<Effort>(), default_value = Effort::default().name(),
          help_heading = BECOMES)]
    effort: Effort,
    /// Size of the vertex cache for --strips cache and list, 4 to 64
    #[arg(long, value_name = "N", default_value = "16",
          value_parser = whole::<u32>(4..=64), help_heading = BECOMES)]
    cache_size: u32,
    /// Text file; - for standard output
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    output: PathBuf,
    #[command(flatten)]
    import: ImportArgs,
}

const EXAMPLES: &str = "\
Every line of the output is `s` and the vertices of a strip, or `l` and the vertices of a triangle \
list; vertices are numbered from 0: for an OBJ in the order of its `v` lines, for glTF as \
loaded, one mesh after the other.

Examples:
  lodc strips chair.obj -o chair.strips
  lodc strips chair.obj -o - --strips list --cache-size 32";

/// Reads the name of a generator, or `list`.
fn generators() -> impl TypedValueParser<Value = Choice<StripKind>> {
    parser_with("list", "No strips: a triangle list that reuses a vertex cache")
}

pub(crate) fn run(args: &StripsArgs) -> Outcome<()> {
    let target = output::single_target(&args.input, Some(&args.output), "strips")?;
    output::prepare_targets([&target], output::is_folder(&args.output))?;
    let mut stages = Stages::new(args.import.clock(&args.input));
    let scene = stages.run("import", || import::import(&args.input, &args.import.options()))?;
    let name = args.input.display().to_string();
    console::warnings(&name, &scene.warnings);
    let size = Size::of_objects(&scene.objects);
    args.import.limits().check_memory(&name, size, &[size.strips()])?;
    let options = CacheOptions { cache_size: args.cache_size, effort: args.effort };
    let mut made = StripText::default();
    // `None`: a triangle list.
    let kind = args.strips.kind();
    for object in &scene.objects {
        stages.run("strips", || made.add(object, kind, &options));
    }
    let per_triangle = |n: u64| n as f64 / size.triangles.max(1) as f64;
    let summary = format!(
        "{name}: {}, {}, {:.3} indices and {:.3} cache misses per triangle",
        count(size.triangles, "triangle"),
        count(made.strips, "strip"),
        per_triangle(made.indices),
        per_triangle(made.misses)
    );
    stages.run("write", || output::write(&target, made.text.into_bytes()))?;
    note(&summary);
    Ok(())
}
