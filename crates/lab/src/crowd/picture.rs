//! A picture of a crowd in the middle of its time, coloured by level: by all levels, and beside it
//! by five (thesis fig. 4.12).

use super::figures::{Figure, ground_position, rotation};
use super::walk::WalkerPosition;
use lodc_measure::heat;
use lodc_measure::render::{BackFaces, Camera, Corner, Painter, Run, Style, Up, Viewpoint};
use lodc_mesh::Lod;
use lodc_report::Sheet;
use lodc_report::text::count;
use lodc_scene::{Image, Material, to_linear};

/// Pixels of each half, across and down. Chosen by hand.
const SIZE: [u32; 2] = [800, 640];
/// Degrees of view, from the upper to the lower edge. Chosen by hand.
pub(crate) const DEGREES: f64 = 30.0;

/// The camera behind and above the viewer, so far away that most of the crowd is seen; the shares
/// are chosen by hand.
fn behind(figures: &[Figure<'_>], positions: &[WalkerPosition]) -> Camera {
    let points = points(figures, positions.iter());
    let far = points.iter().flatten().fold(1.0, |a: f64, c| a.max(c.abs()));
    let (eye, target) = ([0.0, 0.16 * far, -0.5 * far], [0.0, 0.0, 0.2 * far]);
    let view = Viewpoint { eye, target, up: Up::Y, degrees: DEGREES, zoom: 1.0 };
    Camera::at(&points, &view, f64::from(SIZE[0]) / f64::from(SIZE[1]))
}

/// Corners of a box around each walker.
pub(crate) fn points<'a>(
    figures: &[Figure<'_>],
    positions: impl Iterator<Item = &'a WalkerPosition>,
) -> Vec<[f64; 3]> {
    let high = figures.iter().flat_map(|f| (0..f.phases()).flat_map(|p| f.parts(p)));
    let high = high.flat_map(|part| &part.positions).map(|p| f64::from(p[1])).fold(0.0, f64::max);
    let mut points = Vec::new();
    for walker in positions {
        let [x, _, z] = ground_position(walker);
        for (dx, dz) in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)] {
            points.extend([[x + dx, 0.0, z + dz], [x + dx, high, z + dz]]);
        }
    }
    points
}

/// Draws the frame `now` by each way to choose levels, side by side: from blue (every triangle) to
/// red (none).
pub(crate) fn picture(
    figures: &mut [Figure<'_>],
    positions: &[WalkerPosition],
    policies: &[(&str, Vec<Vec<Lod>>)],
    now: usize,
) -> Image {
    let camera = behind(figures, positions);
    let style = Style { size: SIZE, background: [1.0; 4], back_faces: BackFaces::Shown, wire: 0.0 };
    let matte = Material { double_sided: true, ..Material::default() };
    let painter = Painter::new(&[], vec![matte]);
    let (mut pictures, mut labels) = (Vec::new(), Vec::new());
    for (name, lods) in policies {
        let mut all = Vec::new();
        for (i, (walker, lods)) in positions.iter().zip(lods).enumerate() {
            let f = i % figures.len();
            let phase = figures[f].phase(i, now);
            all.extend(corners(&mut figures[f], phase, walker, lods, &camera));
        }
        let drawn = all.len() as u64 / 3;
        pictures.push(painter.draw(&camera, &style, &[Run { material: 0, corners: all }]));
        labels.push([(*name).to_owned(), count(drawn, "triangle")]);
    }
    let (pictures, labels) = (&pictures, &labels);
    let background = [255; 4];
    Sheet { pictures, columns: None, labels, background }.compose(None)
}

/// The triangles of a walker.
fn corners(
    figure: &mut Figure<'_>,
    phase: usize,
    walker: &WalkerPosition,
    lods: &[Lod],
    camera: &Camera,
) -> Vec<Corner> {
    let [cos, sin] = rotation(walker);
    let ground = ground_position(walker);
    let mut corners = Vec::new();
    for p in 0..figure.parts(phase).len() {
        let object = figure.parts(phase)[p].object;
        let whole = figure.level(object, Lod(0)).len().max(1) as f64;
        let triangles = figure.level(object, lods[object]).to_vec();
        let share = 1.0 - triangles.len() as f64 / whole;
        let [red, green, blue] = heat(share).map(|v| to_linear(f32::from(v) / 255.0));
        let part = &figure.parts(phase)[p];
        let vertex = |v: u32| -> [f32; 3] {
            let [x, y, z] = part.positions[v as usize];
            let rotated = [cos * x + sin * z, y, cos * z - sin * x];
            std::array::from_fn(|k| (ground[k] - camera.centre[k]) as f32 + rotated[k])
        };
        for [a, b, c] in triangles {
            let [p, q, s] = (if part.mirrored { [a, c, b] } else { [a, b, c] }).map(vertex);
            let [u, v]: [[f32; 3]; 2] = [q, s].map(|to| std::array::from_fn(|k| to[k] - p[k]));
            let normal = std::array::from_fn(|k| {
                u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]
            });
            let colour = [red, green, blue, 1.0];
            let corner = |position| Corner { position, normal, uv: [0.0; 2], colour };
            corners.extend([p, q, s].map(corner));
        }
    }
    corners
}
