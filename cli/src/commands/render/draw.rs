//! Draws each tile, and joins the pictures to a contact sheet.

use super::RenderArgs;
use super::heat::Heat;
use super::options::{BackFaceMode, ColorMode, Shading, View};
use super::scene::DrawableScene;
use super::tiles::Tile;
use crate::exit::{Failure, Outcome, Status};
use crate::kinds::UpAxis;
use lodc_measure::render::{
    BackFaces, Camera, Colours, DrawnMesh, Framing, Lens, Scene, Style, Subdivision, Up, Viewpoint,
};
use lodc_measure::{distinct, heat as heat_colour};
use lodc_report::text::distance;
use lodc_report::{Legend, Sheet};
use lodc_scene::{Image, posed, to_linear};

/// The linear colour of surfaces without a colour of their own.
const PLAIN_GREY: [f32; 3] = [0.52, 0.51, 0.49];
/// Pixels of a contact sheet at most. Chosen by hand: bounds the memory.
const MAX_PIXELS: u64 = 1 << 28;

/// Draws one picture of every tile, all from the same camera.
pub(super) fn pictures(
    args: &RenderArgs,
    drawable: &DrawableScene,
    tiles: &[Tile],
    heat: Option<&Heat>,
) -> Vec<Image> {
    let size =
        args.size.unwrap_or(if args.contact_sheet.is_empty() { [1024, 768] } else { [480, 360] });
    let camera = camera(args, drawable, f64::from(size[0]) / f64::from(size[1]));
    let style = Style {
        size,
        background: args.background.map(|c| f32::from(c) / 255.0),
        back_faces: match args.back_faces {
            BackFaceMode::Material => BackFaces::AsMaterial,
            BackFaceMode::Show => BackFaces::Shown,
            BackFaceMode::Hide => BackFaces::Hidden,
            BackFaceMode::Mark => BackFaces::Marked,
        },
        wire: if args.wireframe { 1.0 } else { 0.0 },
    };
    let objects = drawable.objects.len();
    let submeshes = |o: usize| drawable.objects.mesh(o).submeshes().len();
    let of_submesh = |object: usize, submesh: usize| match args.color {
        ColorMode::Submesh => {
            colour_of(((0..object).map(submeshes).sum::<usize>() + submesh) as u32)
        }
        _ => PLAIN_GREY,
    };
    let scene = Scene {
        arrangement: &drawable.arrangement,
        colours: match args.color {
            ColorMode::Material => Colours::Materials(&drawable.appearance),
            _ => Colours::Submeshes(&of_submesh),
        },
        smooth: args.shading == Shading::Smooth,
    };
    let level = |tile: usize, object: usize| DrawnMesh {
        mesh: tiles[tile].mesh(drawable, object),
        triangles: &tiles[tile].triangles[object],
        colours: tiles[tile]
            .strips
            .get(object)
            .map_or_else(Vec::new, |strips| strips.iter().map(|&strip| colour_of(strip)).collect()),
        subdivision: heat.map(|heat| -> Box<Subdivision<'_>> {
            Box::new(move |t, corners| heat.divide(tile, object, t, corners))
        }),
    };
    let painter = scene.painter();
    let draw_tile = |tile| {
        let levels: Vec<DrawnMesh<'_>> = (0..objects).map(|o| level(tile, o)).collect();
        scene.draw(&painter, &camera, &style, &levels)
    };
    (0..tiles.len()).map(draw_tile).collect()
}

/// Vertical field of view, in degrees, of a picture from a side: narrow, so that shapes look little
/// distorted.
const SIDE_FIELD_OF_VIEW: f64 = 30.0;

/// The camera that frames the input: the same for all levels.
fn camera(args: &RenderArgs, drawable: &DrawableScene, aspect: f64) -> Camera {
    let mut points: Vec<[f64; 3]> = Vec::new();
    for placement in drawable.arrangement.placements() {
        let posed = posed(drawable.objects.mesh(placement.object), placement);
        points.extend(posed.positions.iter().map(|p| p.to_array()));
    }
    let up = match args.up {
        UpAxis::Y => Up::Y,
        UpAxis::Z => Up::Z,
    };
    if let Some(eye) = args.eye_of_picture() {
        let middle = Camera::middle(&points);
        let target = args.views.at.target.unwrap_or(middle);
        let degrees = args.selector.field_of_view_of_eye();
        let view = Viewpoint { eye, target, up, degrees, zoom: args.zoom };
        return Camera::at(&points, &view, aspect);
    }
    let (azimuth, elevation) = args.view.unwrap_or(View::ThreeQuarter).angles();
    let is_turned = args.azimuth.is_some() || args.elevation.is_some();
    let framing = Framing {
        up,
        azimuth: args.azimuth.unwrap_or(if is_turned { 0.0 } else { azimuth }),
        elevation: args.elevation.unwrap_or(if is_turned { 0.0 } else { elevation }),
        lens: if args.orthographic {
            Lens::Orthographic
        } else {
            Lens::Perspective(args.selector.field_of_view().unwrap_or(SIDE_FIELD_OF_VIEW))
        },
        zoom: args.zoom,
    };
    Camera::around(&points, &framing, aspect)
}

/// The linear colour of a submesh or strip, by its number.
fn colour_of(number: u32) -> [f32; 3] {
    distinct(number).map(|v| to_linear(f32::from(v) / 255.0))
}

/// Puts pictures of one size into rows, each with its label below unless there are none.
///
/// # Errors
/// If that is more than a picture may hold.
pub(super) fn sheet(
    args: &RenderArgs,
    tiles: &[Tile],
    heat: Option<&Heat>,
    pictures: &[Image],
) -> Outcome<Image> {
    let labels: Vec<[String; 2]> = tiles.iter().map(Tile::label).collect();
    let sheet = Sheet {
        pictures,
        columns: args.columns.map(|c| c as usize),
        labels: if args.no_labels { &[] } else { &labels },
        background: args.background,
    };
    let [across, down] = sheet.size(heat.is_some());
    if (across as u64) * (down as u64) > MAX_PIXELS {
        let message = format!(
            "a contact sheet of {across} x {down} pixels is too large: use a smaller --size"
        );
        return Err(Failure::new(Status::Limit, message));
    }
    let text = heat.map(|heat| {
        let share = if heat.diagonal > 0.0 { heat.largest / heat.diagonal * 100.0 } else { 0.0 };
        format!("distance 0 to {} ({share:.3} % of the diagonal)", distance(heat.largest))
    });
    Ok(sheet.compose(text.as_deref().map(|text| Legend { colour: heat_colour, text })))
}
