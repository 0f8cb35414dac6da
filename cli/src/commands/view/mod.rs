//! `lodc view`: one offline page that shows every level of an asset in a browser, or the levels
//! that a file holds.

mod page;

use super::asset::{self, SimplifyArgs};
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome};
use crate::help::{BECOMES, OUTPUT, SEEN};
use crate::kinds::UpAxis;
use crate::limits::ImportArgs;
use crate::mesh_output;
use crate::output::{self, DependencyRule, Target};
use crate::stages::Stages;
use clap::Args;
use lodc::Asset;
use lodc::LodObject;
use lodc_formats::images::Textures;
use lodc_formats::import::{as_plain_glb, import_levels, states_levels};
use lodc_formats::{Assets, ExportedLevels, OutputFile, RequestedFiles};
use lodc_lod::AnyModel;
use lodc_report::text::{count, size};
use lodc_strip::Strips;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Options of commands that make a page: `view` and `report`.
#[derive(Args, Debug)]
pub(crate) struct PageArgs {
    /// A mesh (.glb, .gltf, .obj, .ply, .stl), a .lodc file, or levels of chain or extract; - for
    /// standard input
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
    /// Open the page in the browser
    #[arg(long, help_heading = OUTPUT)]
    pub(super) open: bool,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, hide_short_help = true)]
    pub(super) depfile: Option<PathBuf>,
    #[command(flatten)]
    pub(super) import: ImportArgs,
}

/// Options of `view`.
#[derive(Args, Debug)]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    page: PageArgs,
    /// Upward axis
    ///
    /// As the file has it; U on the page turns it.
    #[arg(long, value_enum, default_value = "y", help_heading = SEEN)]
    up: UpAxis,
}

/// Examples in the help.
pub(crate) const EXAMPLES: &str = "\
Examples:
  lodc view chair.glb -o chair.html --open
  lodc view chair.lodc -o chair.html --title 'Chair, oak'
  lodc view levels.glb -o levels.html";

/// A page that was made.
pub(super) struct Page {
    pub(super) text: String,
    /// A line each, besides those of the asset.
    pub(super) warnings: Vec<String>,
    /// What the final message says of it before its size, and after it.
    pub(super) before_size: String,
    pub(super) after_size: String,
}

/// What a page is made of, once it has been read.
pub(super) struct PageInput {
    /// Where the page is written.
    target: Target,
    pub(super) asset: Asset,
    /// The files that the asset refers to.
    pub(super) assets: Assets,
    pub(super) title: String,
    pub(super) stages: Stages,
}

impl PageInput {
    /// Reads the input, after a look at whether its page can be written.
    ///
    /// # Errors
    /// If the input cannot be read, or the page not be written.
    pub(super) fn read(args: &PageArgs) -> Outcome<Self> {
        let target = target(args)?;
        let mut stages = Stages::new(args.import.clock(&args.input));
        let asset = asset::read(&args.input, &args.import, &args.simplify, &mut stages)?;
        let assets = args.import.assets(&args.input, args.textures.as_ref());
        Ok(Self { target, asset, assets, title: title(args), stages })
    }

    /// Writes the page and prints a message.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn finish(self, args: &PageArgs, mut page: Page) -> Outcome<()> {
        let Self { target, asset, assets, mut stages, .. } = self;
        page.warnings.splice(0..0, asset.warnings);
        let mut files = asset.files;
        files.extend(assets.files());
        write_page(args, &target, page, &files, &mut stages)
    }
}

pub(crate) fn run(args: &ViewArgs) -> Outcome<()> {
    let ViewArgs { page: args, up } = args;
    let options = args.import.options();
    // The input is read for each of these two questions, and again for its page.
    if !output::is_standard_stream(&args.input) && states_levels(&args.input, &options) {
        let ExportedLevels { levels, morphs, .. } = import_levels(&args.input, &options)?;
        // A single level is shown like any mesh.
        if levels.len() > 1 || !morphs.is_empty() {
            return run_exported(args, *up, levels.len());
        }
    }
    let mut input = PageInput::read(args)?;
    let PageInput { asset, assets, title, stages, .. } = &mut input;
    let (glb, warnings) = stages.run("export", || glb_with_levels(args, asset, assets))?;
    let text = stages.run("page", || page::page(title, *up, &glb));
    let triangles = asset.objects.iter().map(|o| o.simplified.mesh().triangles().len() as u64);
    let before_size = format!("{}, ", count(triangles.sum(), "triangle"));
    input.finish(args, Page { text, warnings, before_size, after_size: String::new() })
}

/// Makes the page of levels that `chain` or `extract` wrote into a glTF.
fn run_exported(args: &PageArgs, up: UpAxis, levels: usize) -> Outcome<()> {
    let target = target(args)?;
    let mut stages = Stages::new(args.import.clock(&args.input));
    let mut assets = args.import.assets(&args.input, args.textures.as_ref());
    let options = args.import.options();
    let (glb, warnings) = stages.run("export", || as_plain_glb(&mut assets, &options))?;
    let text = stages.run("page", || page::page(&title(args), up, &glb));
    let before_size = format!("{} as exported, ", count(levels as u64, "level"));
    let page = Page { text, warnings, before_size, after_size: String::new() };
    write_page(args, &target, page, assets.files(), &mut stages)
}

/// Writes a page and its dependency file, and prints a message.
fn write_page(
    args: &PageArgs,
    target: &Target,
    page: Page,
    files: &RequestedFiles,
    stages: &mut Stages,
) -> Outcome<()> {
    let Page { text, warnings, before_size, after_size } = page;
    let (length, path) = (text.len() as u64, PathBuf::from(target.name()));
    let file = OutputFile { path: path.clone(), bytes: text.into_bytes() };
    output::refuse_replacing([path.as_path()], files)?;
    stages.run("write", || mesh_output::write(target, vec![file]))?;
    if let Some(depfile) = &args.depfile {
        output::write_depfile(depfile, &[DependencyRule::new(&path, files)])?;
    }
    let name = args.input.display().to_string();
    console::warnings(&name, &warnings);
    let next = match args.open.then(|| open_in_browser(&path)) {
        None => "open it in a browser".to_owned(),
        Some(Ok(())) => "opened in the browser".to_owned(),
        Some(Err(e)) => format!("no browser was opened ({BROWSER}: {e})"),
    };
    if wants(Loudness::Normal) {
        let page = format!("{before_size}{}{after_size}", size(length));
        note(&format!("{}: {page}; {next}", target.name()));
    }
    Ok(())
}

/// The program of a system that opens a file in what is meant for it.
const BROWSER: &str = if cfg!(target_os = "macos") {
    "open"
} else if cfg!(windows) {
    "explorer"
} else {
    "xdg-open"
};

/// Opens a page in the browser, and does not wait for it.
fn open_in_browser(page: &Path) -> std::io::Result<()> {
    let page = page.canonicalize()?;
    let mut command = Command::new(BROWSER);
    command.arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().map(drop)
}

/// Where the page is written. Makes sure that it and the dependency file can be.
fn target(args: &PageArgs) -> Outcome<Target> {
    if output::is_standard_stream(&args.output) && args.depfile.is_some() {
        return Err(Failure::usage("a dependency file needs an output file, not standard output"));
    }
    if output::is_standard_stream(&args.output) && args.open {
        return Err(Failure::usage("--open needs an output file, not standard output"));
    }
    let target = output::single_target(&args.input, Some(&args.output), "html")?;
    output::prepare_targets([&target], output::is_folder(&args.output))?;
    if let Some(depfile) = &args.depfile {
        output::prepare_targets(&[Target::File(depfile.clone())], false)?;
    }
    Ok(target)
}

/// The name that was asked for, or the file name of the input.
fn title(args: &PageArgs) -> String {
    let PageArgs { input, title, .. } = args;
    let name = if output::is_standard_stream(input) { None } else { input.file_name() };
    let name = || name.map_or("standard input".into(), |name| name.to_string_lossy().into_owned());
    title.clone().unwrap_or_else(name)
}

/// The asset as a GLB with all levels, and warnings about its textures.
fn glb_with_levels(
    args: &PageArgs,
    asset: &Asset,
    assets: &mut Assets,
) -> Outcome<(Vec<u8>, Vec<String>)> {
    let textures = Textures::read(&asset.document, assets)?;
    let limits = args.import.limits().limits();
    let (path, objects) = (&args.output, &asset.objects);
    let (file, warnings) =
        lodc_web::levels(path, &asset.document, objects, strips_by_triangle, textures, &limits)?;
    Ok((file.bytes, warnings))
}

/// The strip of each triangle in the first model that is made of strips, if there is one.
fn strips_by_triangle(object: &LodObject) -> Option<Vec<u32>> {
    let strips: &Strips = object.models.iter().find_map(AnyModel::strips)?;
    Some(strips.of_triangles(object.simplified.mesh()))
}
