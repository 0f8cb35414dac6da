//! `lodc view`: one offline page that shows every level of an asset in a browser.

mod page;

use super::asset::{self, Asset, SimplifyArgs};
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome};
use crate::help::{BECOMES, OUTPUT};
use crate::limits::ImportArgs;
use crate::mesh_output;
use crate::output::{self, Rule, Target};
use crate::stages::Stages;
use crate::text::{count, size};
use clap::Args;
use lodc_formats::export::{LevelsObject, export_levels};
use lodc_formats::lodc::LodObject;
use lodc_formats::{Assets, OutputFile};
use lodc_lod::AnyModel;
use lodc_strip::Strips;
use std::path::{Path, PathBuf};

/// Options of commands that make a page: `view` and `report`.
#[derive(Args, Debug)]
pub(crate) struct PageArgs {
    /// A mesh (.obj, .gltf, .glb) or a .lodc file; - for standard input
    pub(super) input: PathBuf,
    #[command(flatten)]
    pub(super) simplify: SimplifyArgs,
    /// Name on the page [default: name of the input]
    #[arg(long, value_name = "TEXT", help_heading = BECOMES)]
    pub(super) title: Option<String>,
    /// Folder to look for image files in [default: that of the input]
    #[arg(long, value_name = "DIR", help_heading = BECOMES)]
    pub(super) textures: Option<PathBuf>,
    /// Page, an .html file, or folder; - for standard output
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    pub(super) output: PathBuf,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, hide_short_help = true)]
    pub(super) depfile: Option<PathBuf>,
    #[command(flatten)]
    pub(super) import: ImportArgs,
}

/// Examples in the help.
pub(crate) const EXAMPLES: &str = "\
Examples:
  lodc view chair.glb -o chair.html
  lodc view chair.lodc -o chair.html --title 'Chair, oak'";

pub(crate) fn run(args: &PageArgs) -> Outcome<()> {
    let target = target(args)?;
    let mut stages = Stages::default();
    let asset = asset::read(&args.input, &args.import, &args.simplify, &mut stages)?;
    let name = args.input.display().to_string();
    let (glb, warnings) = stages.run("export", || model(args, &asset))?;
    let title = args.title.clone().unwrap_or_else(|| title(&args.input));
    let bytes = stages.run("page", || page::page(&title, &glb)).into_bytes();
    let length = bytes.len() as u64;
    let path = PathBuf::from(target.name());
    stages.run("write", || {
        mesh_output::write(&target, vec![OutputFile { path: path.clone(), bytes }])
    })?;
    if let Some(depfile) = &args.depfile {
        let mut inputs = asset.files_read.clone();
        inputs.dedup();
        output::write_depfile(depfile, &[Rule { output: path, inputs }])?;
    }
    for warning in asset.warnings.iter().chain(&warnings) {
        console::warning(&name, warning);
    }
    if wants(Loudness::Normal) {
        let triangles = asset.objects.iter().map(|o| o.simplified.mesh().triangles().len() as u64);
        let shown = count(triangles.sum(), "triangle");
        note(&format!("{}: {shown}, {}; open it in a browser", target.name(), size(length)));
    }
    Ok(())
}

/// The page's target, ready to be written.
///
/// # Errors
/// If it, or the dependency file, cannot be written.
pub(super) fn target(args: &PageArgs) -> Outcome<Target> {
    if output::is_stream(&args.output) && args.depfile.is_some() {
        return Err(Failure::usage("a dependency file needs an output file, not standard output"));
    }
    let target = output::target(&args.input, Some(&args.output), "html")?;
    output::prepare([&target], output::is_folder(&args.output))?;
    if let Some(depfile) = &args.depfile {
        output::prepare(&[Target::File(depfile.clone())], false)?;
    }
    Ok(target)
}

/// The file name of the input.
pub(super) fn title(input: &Path) -> String {
    let name = if output::is_stream(input) { None } else { input.file_name() };
    name.map_or_else(|| "standard input".to_owned(), |n| n.to_string_lossy().into_owned())
}

/// The asset as a GLB with all levels, and warnings about its textures.
fn model(args: &PageArgs, asset: &Asset) -> Outcome<(Vec<u8>, Vec<String>)> {
    let options = args.import.options();
    // Only the folder of that path counts: textures are looked for there.
    let beside =
        args.textures.as_ref().map_or_else(|| args.input.clone(), |folder| folder.join("-"));
    let mut assets = Assets::new(&beside, &options.allowed, options.limits);
    let strips: Vec<Option<Vec<u32>>> = asset.objects.iter().map(strips_by_triangle).collect();
    let objects: Vec<LevelsObject<'_>> = (asset.objects.iter().zip(&strips))
        .map(|(object, strips)| LevelsObject {
            info: &object.info,
            simplified: &object.simplified,
            strips: strips.as_deref(),
        })
        .collect();
    let (file, warnings) = export_levels(&args.output, &asset.document, &objects, &mut assets)?;
    Ok((file.bytes, warnings))
}

/// The strip of each triangle in the first model that is made of strips, if there is one.
fn strips_by_triangle(object: &LodObject) -> Option<Vec<u32>> {
    let strips: &Strips = object.models.iter().find_map(AnyModel::strips)?;
    let mut known: Vec<([u32; 3], u32)> = Vec::new();
    for (number, strip) in (0..).zip(strips.iter()) {
        known.extend(strip.windows(3).map(|w| (sorted([w[0], w[1], w[2]]), number)));
    }
    known.sort_unstable();
    let of = |t: &[u32; 3]| {
        let at = known.partition_point(|(corners, _)| *corners < sorted(*t));
        known.get(at).map_or(0, |&(_, number)| number)
    };
    Some(object.simplified.mesh().triangles().iter().map(of).collect())
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}
