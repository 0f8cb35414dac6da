//! `lodc render`: pictures of a mesh, or of levels of detail.

mod draw;
mod heat;
mod options;
mod scene;
mod tiles;

use crate::console::{self, note};
use crate::exit::{Failure, Outcome};
use crate::help::{BECOMES, LEVEL, MORE, OUTPUT, SEEN};
use crate::kinds::UpAxis;
use crate::limits::ImportArgs;
use crate::numbers::whole;
use crate::output::{self, Target};
use crate::pose::PoseArgs;
use crate::selector::{SelectorArgs, share};
use crate::stages::Stages;
use crate::views::ViewArgs;
use clap::{Arg, Args};
use options::{BackFaceMode, ColorMode, Shading, View};
use std::path::PathBuf;

/// Options of `render`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES, mut_arg("fovy", with_help_for_pictures))]
pub(crate) struct RenderArgs {
    /// A mesh or a .lodc file; - for standard input
    input: PathBuf,
    #[command(flatten)]
    selector: SelectorArgs,
    /// Levels side by side, each a share of triangles
    ///
    /// Shares from 0 to 1.
    #[arg(long, value_name = "SHARES", value_delimiter = ',', value_parser = share,
          conflicts_with = "TargetArgs", help_heading = LEVEL)]
    contact_sheet: Vec<f64>,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    pose: PoseArgs,
    /// Side to show [default: three-quarter; with --eye what it sees]
    #[arg(long, value_enum, conflicts_with_all = ["azimuth", "elevation"], help_heading = SEEN)]
    view: Option<View>,
    /// Degrees around the upward axis; 0 is the front
    ///
    /// 90 is its right, of who looks at the front; -360 to 360.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true,
          value_parser = options::degrees, help_heading = SEEN)]
    azimuth: Option<f64>,
    /// Degrees above the horizon, -90 to 90
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true,
          value_parser = options::elevation, help_heading = SEEN)]
    elevation: Option<f64>,
    /// Upward axis
    ///
    /// As the file has it.
    #[arg(long, value_enum, default_value = "y", help_heading = SEEN)]
    up: UpAxis,
    /// Size in the picture, 0.01 to 1000; 1 just fits
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = options::zoom,
          help_heading = SEEN, hide_short_help = true)]
    zoom: f64,
    /// No perspective
    #[arg(long, help_heading = SEEN, hide_short_help = true)]
    orthographic: bool,
    /// Folder to look for image files in [default: that of the input]
    #[arg(long, value_name = "DIR", help_heading = BECOMES, hide_short_help = true)]
    textures: Option<PathBuf>,
    /// Meaning of colours
    #[arg(long, value_enum, default_value = "material", help_heading = BECOMES)]
    color: ColorMode,
    /// Normals of the file, or one for each triangle
    ///
    /// Rounded ones, with sharp edges kept, where the file has none.
    #[arg(long, value_enum, default_value = "smooth", help_heading = BECOMES)]
    shading: Shading,
    /// Draw the edges of triangles
    #[arg(long, help_heading = BECOMES)]
    wireframe: bool,
    /// Colour behind it: #rrggbb or a name
    ///
    /// Also #rrggbbaa; names are white, black, grey or transparent.
    #[arg(long, value_name = "COLOR", default_value = "white", value_parser = options::colour,
          help_heading = BECOMES)]
    background: [u8; 4],
    /// Triangles seen from behind
    ///
    /// As their material says (those of an OBJ are shown), shown, hidden, or in a warning colour.
    #[arg(long, value_enum, default_value = "material", help_heading = BECOMES,
          hide_short_help = true)]
    back_faces: BackFaceMode,
    /// Picture size [default: 1024x768, in sheets 480x360]
    ///
    /// In pixels, of each picture of a contact sheet too.
    #[arg(long, value_name = "WxH", value_parser = options::size, help_heading = BECOMES)]
    size: Option<[u32; 2]>,
    /// Pictures in a row of a contact sheet, 1 to 64 [default: up to 4]
    #[arg(long, value_name = "N", requires = "contact_sheet",
          value_parser = whole::<u32>(1..=64), help_heading = BECOMES,
          hide_short_help = true)]
    columns: Option<u32>,
    /// Pictures alone: no text below them, no meaning of error colours
    #[arg(long, help_heading = BECOMES, hide_short_help = true)]
    no_labels: bool,
    /// PNG file, or folder; - for standard output
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    output: PathBuf,
    #[command(flatten)]
    import: ImportArgs,
}

/// Replaces the help of `--fovy`: here it is that of an eye, and that of a picture from a side.
fn with_help_for_pictures(fovy: Arg) -> Arg {
    fovy.help("Vertical field of view in degrees, below 180 [default: 60 with --eye, else 30]")
}

const EXAMPLES: &str = "\
Examples:
  lodc render chair.glb -o chair.png
  lodc render chair.lodc --contact-sheet 1,0.5,0.25,0.1 --wireframe -o levels.png
  lodc render chair.lodc --ratio 10% --color error --view front -o error.png";

pub(crate) fn run(args: &RenderArgs) -> Outcome<()> {
    let folder = output::is_folder(&args.output);
    let target = output::single_target(&args.input, Some(&args.output), "png")?;
    output::prepare_targets([&target], folder)?;
    if args.wireframe && args.color == ColorMode::Error {
        return Err(Failure::usage("--color error cannot be combined with --wireframe"));
    }
    check_view(args)?;
    picture(args, &target)
}

/// Refuses options of views that do not fit together.
fn check_view(args: &RenderArgs) -> Outcome<()> {
    if args.views.check(&args.selector)?.is_some() && args.color == ColorMode::Strips {
        return Err(Failure::usage(
            "--color strips shows one level of each object, no --criterion",
        ));
    }
    let is_for_a_level = args.selector.pixels().is_some();
    if args.orthographic && args.selector.field_of_view().is_some() && !is_for_a_level {
        return Err(Failure::usage("--fovy cannot be combined with --orthographic"));
    }
    if args.orthographic && args.eye_of_picture().is_some() {
        return Err(Failure::usage(
            "--eye needs perspective: leave --orthographic out, or use --view",
        ));
    }
    Ok(())
}

impl RenderArgs {
    /// Returns the eye that the picture is seen from; none if it is seen from a side.
    fn eye_of_picture(&self) -> Option<[f64; 3]> {
        let side = self.view.is_some() || self.azimuth.is_some() || self.elevation.is_some();
        self.views.at.eye.filter(|_| !side)
    }
}

fn picture(args: &RenderArgs, target: &Target) -> Outcome<()> {
    let name = args.input.display().to_string();
    let mut stages = Stages::new(args.import.clock(&args.input));
    let drawable = scene::read(args, target, &mut stages)?;
    let chosen_tiles = tiles::choose(args, &drawable)?;
    let mut warnings = [&drawable.appearance.warnings[..], &drawable.warnings].concat();
    warnings.extend(chosen_tiles.iter().flat_map(|c| c.warnings.iter().cloned()));
    console::warnings(&name, &warnings);
    let heat = (args.color == ColorMode::Error)
        .then(|| stages.run("measure", || heat::measure(&drawable, &chosen_tiles)));
    let pictures =
        stages.run("draw", || draw::pictures(args, &drawable, &chosen_tiles, heat.as_ref()));
    let picture = if args.contact_sheet.is_empty() && heat.is_none() {
        pictures.into_iter().next().expect("there is always one")
    } else {
        draw::sheet(args, &chosen_tiles, heat.as_ref(), &pictures)?
    };
    let size = format!("{} x {} pixels", picture.width, picture.height);
    let bytes = stages.run("encode", || lodc_formats::images::png(&picture));
    stages.run("write", || output::write(target, bytes))?;
    let destination =
        if *target == Target::Stdout { "standard output".to_owned() } else { target.name() };
    let lods: Vec<String> = chosen_tiles.iter().map(tiles::Tile::sentence).collect();
    note(&format!("{destination}: {size}, {}", lods.join(", ")));
    Ok(())
}
