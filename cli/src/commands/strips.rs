//! `lodc strips`: the strip generators by themselves, for study and comparison.

use crate::console::{note, warning};
use crate::estimate::Size;
use crate::exit::{Failure, Outcome, Status};
use crate::help::{BECOMES, LIMITS, MORE, OUTPUT};
use crate::kinds::{Choice, parser, parser_with};
use crate::limits::ImportArgs;
use crate::output::{self, Target};
use crate::stages::Stages;
use crate::text::count;
use clap::Args;
use clap::builder::TypedValueParser;
use lodc_formats::import;
use lodc_mesh::Mesh;
use lodc_strip::{CacheModel, CacheOptions, Effort, StripKind, measure, order};
use rayon::ThreadPoolBuilder;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// Options of `strips`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct StripsArgs {
    /// A mesh (.obj, .gltf, .glb); - for standard input
    input: PathBuf,
    /// Strips to make, or a triangle list in their place
    #[arg(long, value_parser = generators(), default_value = StripKind::LONGEST.name(),
          help_heading = BECOMES)]
    strips: Choice<StripKind>,
    /// Effort of the search for strips
    #[arg(long, value_parser = parser::<Effort>(), default_value = Effort::default().name(),
          help_heading = BECOMES)]
    effort: Effort,
    /// Vertices in the cache that cache and list are made for, 4 to 64
    #[arg(long, value_name = "N", default_value = "16",
          value_parser = clap::value_parser!(u32).range(4..=64), help_heading = BECOMES)]
    cache_size: u32,
    /// Fetched vertices that an index is worth to cache, 0 to 100
    ///
    /// More makes fewer indices, less fewer misses.
    #[arg(long, value_name = "PRICE", default_value = "1", value_parser = price,
          help_heading = BECOMES)]
    index_price: f32,
    /// Text file; - for standard output
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    output: PathBuf,
    #[command(flatten)]
    import: ImportArgs,
    /// Threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", help_heading = LIMITS, hide_short_help = true)]
    jobs: Option<NonZeroUsize>,
}

const EXAMPLES: &str = "\
Every line of the output is `s` and the vertices of a strip, or `l` and the vertices of a triangle \
list; vertices are numbered from 0: for an OBJ in the order of its `v` lines, for glTF as loaded, one \
mesh after the other.

Examples:
  lodc strips chair.obj -o chair.strips
  lodc strips chair.obj -o - --strips list --cache-size 32";

/// The names of all that can make the output.
fn generators() -> impl TypedValueParser<Value = Choice<StripKind>> {
    parser_with("list", "No strips: a triangle list that reuses a vertex cache")
}

fn price(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(price) if (0.0..=100.0).contains(&price) => Ok(price),
        _ => Err("not a number from 0 to 100".to_owned()),
    }
}

/// The sums over all objects, for the note at the end.
#[derive(Default)]
struct Totals {
    triangles: u64,
    strips: u64,
    indices: u64,
    misses: u64,
}

pub(crate) fn run(args: &StripsArgs) -> Outcome<()> {
    let target = output::target(&args.input, Some(&args.output), "strips")?;
    output::prepare([&target], output::is_folder(&args.output))?;
    let threads = args.jobs.map_or(0, |n| n.get().min(super::build::MOST_THREADS));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool =
        pool.map_err(|e| Failure::new(Status::Limit, format!("no threads to work with: {e}")))?;
    pool.install(|| make(args, &target))
}

fn make(args: &StripsArgs, target: &Target) -> Outcome<()> {
    let mut stages = Stages::default();
    let scene = stages.run("import", || import::import(&args.input, &args.import.options()))?;
    for what in &scene.warnings {
        warning(&args.input.display().to_string(), what);
    }
    let size = Size::of_objects(&scene.objects);
    let triangles = size.triangles;
    let name = args.input.display().to_string();
    args.import.limits().check_memory(&name, size, &[size.strips()])?;
    let mut text = String::new();
    let mut totals = Totals { triangles, ..Totals::default() };
    let options = CacheOptions {
        cache_size: args.cache_size,
        index_price: args.index_price,
        effort: args.effort,
    };
    // The vertices of an object start where those of the object before end.
    let mut base = 0;
    for object in &scene.objects {
        let mesh = &object.mesh;
        let number = |v: u32| {
            object.source_positions.get(v as usize).map_or(base + u64::from(v), |&p| u64::from(p))
        };
        let Some(kind) = args.strips.kind() else {
            let list = stages.run("strips", || order(mesh, args.cache_size));
            totals.add(mesh, args.cache_size, list.as_flattened());
            // One line per submesh: lines are no longer than a part that is drawn at once.
            for submesh in mesh.submeshes() {
                line(&mut text, 'l', number, list[submesh.triangles()].as_flattened());
            }
            base += mesh.vertex_count() as u64;
            continue;
        };
        let strips = stages.run("strips", || kind.generate(mesh, &options));
        totals.strips += strips.len() as u64;
        totals.add(mesh, args.cache_size, strips.indices());
        for strip in strips.iter() {
            line(&mut text, 's', number, strip);
        }
        base += mesh.vertex_count() as u64;
    }
    stages.run("write", || output::write(target, text.into_bytes()))?;
    note(&totals.text(&args.input.display().to_string()));
    Ok(())
}

impl Totals {
    fn add(&mut self, mesh: &Mesh, size: u32, indices: &[u32]) {
        self.indices += indices.len() as u64;
        self.misses += measure(
            indices.iter().copied(),
            mesh.vertex_count(),
            CacheModel { size, ..CacheModel::default() },
        )
        .misses;
    }
    fn text(&self, input: &str) -> String {
        let per = |n: u64| n as f64 / self.triangles.max(1) as f64;
        format!(
            "{input}: {}, {}, {:.3} indices and {:.3} cache misses per triangle",
            count(self.triangles, "triangle"),
            count(self.strips, "strip"),
            per(self.indices),
            per(self.misses)
        )
    }
}

/// Appends a line of vertex numbers, if there are any.
fn line(text: &mut String, kind: char, number: impl Fn(u32) -> u64, vertices: &[u32]) {
    use std::fmt::Write;
    if vertices.is_empty() {
        return;
    }
    text.push(kind);
    for v in vertices {
        // Writing to a string cannot fail.
        let _ = write!(text, " {}", number(*v));
    }
    text.push('\n');
}
