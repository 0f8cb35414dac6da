//! `lodc render`: pictures of a mesh, or of levels of detail.

#[cfg(feature = "gpu")]
mod cells;
#[cfg(feature = "gpu")]
mod draw;
#[cfg(feature = "gpu")]
mod heat;
mod options;
#[cfg(feature = "gpu")]
mod scene;

use crate::exit::{Failure, Outcome};
use crate::gpu::{self, Device};
use crate::limits::ImportArgs;
use crate::output::{self, Target};
use crate::pose::PoseArgs;
use crate::selector::{SelectorArgs, share};
use crate::views::ViewArgs;
use clap::Args;
use options::{Backs, Colouring, Shading, UpAxis, View};
use std::path::PathBuf;

/// Options of `render`.
#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    /// The mesh (OBJ, glTF, GLB) or .lodc file to show; `-` for standard input
    input: PathBuf,
    /// Output PNG; a folder; `-` for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    selector: SelectorArgs,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    pose: PoseArgs,
    /// Several levels of detail side by side, each a share of the triangles, 0 to 1
    #[arg(
        long,
        value_name = "SHARES",
        value_delimiter = ',',
        value_parser = share,
        conflicts_with = "TargetArgs"
    )]
    contact_sheet: Vec<f64>,
    /// Pictures in a row of a contact sheet [default: up to 4]
    #[arg(
        long,
        value_name = "N",
        requires = "contact_sheet",
        value_parser = clap::value_parser!(u32).range(1..=64)
    )]
    columns: Option<u32>,
    /// Leave out the text below the pictures of a contact sheet, and the meaning of error colours
    #[arg(long)]
    no_labels: bool,
    /// Pixels of each picture [default: 1024x768, in a contact sheet 480x360]
    #[arg(long, value_name = "WxH", value_parser = options::size)]
    size: Option<[u32; 2]>,
    /// The side to show [default: three-quarter; with --eye what it sees, --fovy degrees high]
    #[arg(long, value_enum, conflicts_with_all = ["azimuth", "elevation"])]
    view: Option<View>,
    /// Degrees around the upward axis: 0 is the front, 90 the side to the right of who looks at it
    #[arg(
        long,
        value_name = "DEGREES",
        allow_negative_numbers = true,
        value_parser = options::degrees
    )]
    azimuth: Option<f64>,
    /// Degrees above the horizon, -90 to 90
    #[arg(
        long,
        value_name = "DEGREES",
        allow_negative_numbers = true,
        value_parser = options::elevation
    )]
    elevation: Option<f64>,
    /// The axis that points up in the file
    #[arg(long, value_enum, default_value = "y")]
    up: UpAxis,
    /// Zoom: 1 just fits; 0.01 to 1000
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = options::zoom)]
    zoom: f64,
    /// Degrees between the upper and the lower edge of the picture, 1 to 150
    #[arg(
        long,
        value_name = "DEGREES",
        default_value = "30",
        value_parser = options::field_of_view
    )]
    fov: f64,
    /// No perspective
    #[arg(long, conflicts_with = "fov")]
    orthographic: bool,
    /// Normals of the file (rounded ones where it has none), or one for each triangle
    #[arg(long, value_enum, default_value = "smooth")]
    shading: Shading,
    /// Meaning of colours
    #[arg(long, value_enum, default_value = "material")]
    color: Colouring,
    /// Draw the edges of triangles
    #[arg(long)]
    wireframe: bool,
    /// Behind everything: a colour as #rrggbb or #rrggbbaa, white, black, grey or transparent
    #[arg(long, value_name = "COLOR", default_value = "white", value_parser = options::colour)]
    background: [u8; 4],
    /// Triangles seen from behind: as their material says, shown, hidden, or in a warning colour
    #[arg(long, value_enum, default_value = "material")]
    back_faces: Backs,
    /// The folder in which the file's textures are looked for [default: where the file lies]
    #[arg(long, value_name = "DIR")]
    textures: Option<PathBuf>,
    /// The GPU to use, by a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    #[command(flatten)]
    import: ImportArgs,
}

pub(crate) fn run(args: &RenderArgs) -> Outcome<()> {
    let folder = output::is_folder(&args.output);
    let target = output::target(&args.input, Some(&args.output), "png")?;
    output::prepare([&target], folder)?;
    if args.wireframe && args.color == Colouring::Error {
        return Err(Failure::usage("--color error divides triangles: leave --wireframe out"));
    }
    check_view(args)?;
    let device = gpu::open(args.adapter.as_deref()).map_err(|failure| {
        let message = format!("{}: {failure}; nothing was drawn", args.input.display());
        Failure { message, ..failure }
    })?;
    picture(args, &target, &device)
}

/// Refuses options of views that do not fit together.
fn check_view(args: &RenderArgs) -> Outcome<()> {
    if args.views.check(&args.selector)?.is_some() && args.color == Colouring::Strips {
        return Err(Failure::usage(
            "--color strips shows one level of each object, no --criterion",
        ));
    }
    if args.orthographic && args.eye_of_picture().is_some() {
        return Err(Failure::usage(
            "an eye sees with perspective: leave --orthographic out, or say --view",
        ));
    }
    Ok(())
}

impl RenderArgs {
    /// Returns the eye that the picture is seen from, if it is not seen from a side.
    fn eye_of_picture(&self) -> Option<[f32; 3]> {
        let side = self.view.is_some() || self.azimuth.is_some() || self.elevation.is_some();
        self.views.at.eye.filter(|_| !side)
    }
}

#[cfg(not(feature = "gpu"))]
fn picture(_: &RenderArgs, _: &Target, device: &Device) -> Outcome<()> {
    match *device {}
}

#[cfg(feature = "gpu")]
fn picture(args: &RenderArgs, target: &Target, device: &Device) -> Outcome<()> {
    use crate::console::{note, warning};
    use crate::stages::Stages;

    let name = args.input.display().to_string();
    let mut stages = Stages::default();
    let shown = scene::read(args, &mut stages)?;
    let chosen = cells::chosen(args, &shown)?;
    for what in shown
        .appearance
        .warnings
        .iter()
        .chain(&shown.warnings)
        .chain(chosen.iter().flat_map(|c| &c.warnings))
    {
        warning(&name, what);
    }
    let heat = (args.color == Colouring::Error)
        .then(|| stages.run("measure", || heat::measure(&shown, &chosen)));
    let pictures =
        stages.run("draw", || draw::pictures(args, &shown, &chosen, heat.as_ref(), device))?;
    let picture = if args.contact_sheet.is_empty() && heat.is_none() {
        pictures.into_iter().next().expect("there is always one")
    } else {
        draw::sheet(args, &chosen, heat.as_ref(), &pictures)?
    };
    let size = format!("{} x {} pixels", picture.width, picture.height);
    let bytes = stages.run("encode", || lodc_formats::images::png(&picture));
    stages.run("write", || output::write(target, bytes))?;
    let where_to =
        if *target == Target::Stdout { "standard output".to_owned() } else { target.name() };
    let lods: Vec<String> = chosen.iter().map(cells::Cell::sentence).collect();
    note(&format!("{where_to}: {size}, {}; {}", lods.join(", "), device.adapter()));
    Ok(())
}
