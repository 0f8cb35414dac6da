//! Triangles to corners to pixels.

use super::RenderArgs;
use super::cells::Cell;
use super::heat::Heat;
use super::options::{Backs, Colouring, Shading, UpAxis, View};
use super::scene::Shown;
use crate::colours::distinct;
use crate::exit::Outcome;
use crate::gpu::{Device, failure};
use lodc_gpu::picture::{
    BackFaces, Camera, Corner, Frame, Framing, Lens, Painter, Style, Up, Viewpoint,
};
use lodc_mesh::{Attribute, Mesh, OrientedTriangle, PositionIds, Semantic};
use lodc_scene::{
    AlphaMode, Image, Material, Placement, PosedVertices, flat_normals, posed, smooth_normals,
    stream, to_linear,
};
use rayon::prelude::*;

/// Linear grey of what has no colour of its own.
const PLAIN: [f32; 3] = [0.52, 0.51, 0.49];

/// One picture for every cell, all by the same camera.
///
/// # Errors
/// If the device allows less than is needed, or fails.
pub(super) fn pictures(
    args: &RenderArgs,
    shown: &Shown,
    cells: &[Cell],
    heat: Option<&Heat>,
    device: &Device,
) -> Outcome<Vec<Image>> {
    let (materials, images) = materials(args, shown);
    let painter = Painter::new(device, images, &materials).map_err(|e| failure(&e))?;
    let size =
        args.size.unwrap_or(if args.contact_sheet.is_empty() { [1024, 768] } else { [480, 360] });
    let ids = |cell: &Cell| -> Vec<PositionIds> {
        let of = |o| PositionIds::new(cell.mesh(shown, o).positions());
        (0..shown.objects.len()).into_par_iter().map(of).collect()
    };
    let camera = camera(args, shown, f64::from(size[0]) / f64::from(size[1]));
    let style = Style {
        size,
        background: args.background.map(|c| f32::from(c) / 255.0),
        back_faces: match args.back_faces {
            Backs::Material => BackFaces::AsMaterial,
            Backs::Show => BackFaces::Shown,
            Backs::Hide => BackFaces::Hidden,
            Backs::Mark => BackFaces::Marked,
        },
        wire: if args.wireframe { 1.0 } else { 0.0 },
    };
    let one = |(number, cell): (usize, &Cell)| {
        let mut frame = Frame::new(&painter, &camera, &style)?;
        let points = ids(cell);
        let mut blended: Vec<(f32, usize, [Corner; 3])> = Vec::new();
        for placement in shown.arrangement.placements() {
            let o = placement.object;
            let heat = heat.map(|heat| (heat, number));
            let part =
                Part { args, shown, placement, cell, heat, points: &points[o], camera: &camera };
            for (material, corners) in part.corners(materials.len() - 1) {
                if materials[material].alpha == AlphaMode::Blend {
                    let triples = corners.as_chunks::<3>().0;
                    blended.extend(triples.iter().map(|&t| (depth(&camera, &t), material, t)));
                } else {
                    frame.draw(material, false, &corners)?;
                }
            }
        }
        // Far ones first; the sort is stable, so that equal ones keep the order of the file.
        blended.sort_by(|a, b| b.0.total_cmp(&a.0));
        for run in blended.chunk_by(|a, b| a.1 == b.1) {
            let corners: Vec<Corner> = run.iter().flat_map(|(_, _, t)| *t).collect();
            frame.draw(run[0].1, true, &corners)?;
        }
        frame.finish()
    };
    let drawn: Result<Vec<Image>, _> = cells.iter().enumerate().map(one).collect();
    drawn.map_err(|e| failure(&e))
}

fn depth(camera: &Camera, t: &[Corner; 3]) -> f32 {
    t.iter().map(|c| camera.distance(c.position)).sum()
}

/// All materials, and one more for colours that stand for something; with the images of the first.
fn materials<'a>(args: &RenderArgs, shown: &'a Shown) -> (Vec<Material>, &'a [Image]) {
    let matte = Material { double_sided: true, ..Material::default() };
    if args.color != Colouring::Material {
        return (vec![matte], &[]);
    }
    let looks = &shown.appearance;
    (looks.materials.iter().copied().chain([matte]).collect(), &looks.images)
}

/// Degrees between the upper and the lower edge of a picture from a side.
const FROM_A_SIDE: f64 = 30.0;

/// The camera that frames the input, whatever level of detail is shown.
fn camera(args: &RenderArgs, shown: &Shown, aspect: f64) -> Camera {
    let mut points: Vec<[f64; 3]> = Vec::new();
    for placement in shown.arrangement.placements() {
        let posed = posed(shown.objects.mesh(placement.object), placement);
        points.extend(posed.positions.iter().map(|p| p.to_array()));
    }
    let up = match args.up {
        UpAxis::Y => Up::Y,
        UpAxis::Z => Up::Z,
    };
    if let Some(eye) = args.eye_of_picture() {
        let middle = Camera::middle(&points);
        let target = args.views.at.target.map_or(middle, |target| target.map(f64::from));
        let (eye, degrees) = (eye.map(f64::from), args.selector.field_of_view_of_eye());
        let view = Viewpoint { eye, target, up, degrees, zoom: args.zoom };
        return Camera::at(&points, &view, aspect);
    }
    let (azimuth, elevation) = args.view.unwrap_or(View::ThreeQuarter).angles();
    let any = args.azimuth.is_some() || args.elevation.is_some();
    let framing = Framing {
        up,
        azimuth: args.azimuth.unwrap_or(if any { 0.0 } else { azimuth }),
        elevation: args.elevation.unwrap_or(if any { 0.0 } else { elevation }),
        lens: if args.orthographic {
            Lens::Orthographic
        } else {
            Lens::Perspective(args.selector.field_of_view().unwrap_or(FROM_A_SIDE))
        },
        zoom: args.zoom,
    };
    Camera::around(&points, &framing, aspect)
}

/// The linear colour that stands for a number.
fn colour_of(number: u32) -> [f32; 3] {
    distinct(number).map(|v| to_linear(f32::from(v) / 255.0))
}

/// An object where it is shown, at the level of detail of a cell.
struct Part<'a> {
    args: &'a RenderArgs,
    shown: &'a Shown,
    placement: &'a Placement,
    cell: &'a Cell,
    /// The distances of this cell, if colours mean distances.
    heat: Option<(&'a Heat, usize)>,
    points: &'a PositionIds,
    camera: &'a Camera,
}

/// The looks that a submesh gives its corners.
struct Look<'a> {
    material: usize,
    normals: bool,
    uv: Option<&'a Attribute>,
    colour: Option<&'a Attribute>,
    /// The one colour of all of it, if colours stand for something.
    fixed: Option<[f32; 3]>,
}

impl Part<'_> {
    /// Runs of triangles with one material.
    fn corners(&self, matte: usize) -> Vec<(usize, Vec<Corner>)> {
        let object = self.placement.object;
        let mesh = self.cell.mesh(self.shown, object);
        let triangles = &self.cell.objects[object];
        let smooth_shading = self.args.shading == Shading::Smooth;
        let posed = posed(mesh, self.placement);
        let indices: Vec<[u32; 3]> = triangles.iter().map(|t| t.corners).collect();
        let looks: Vec<Look<'_>> =
            (0..mesh.submeshes().len()).map(|s| self.look(mesh, s, matte)).collect();
        let made: Vec<[[f32; 3]; 3]> = if smooth_shading {
            let smooth = smooth_normals(&indices, &posed.positions, self.points);
            smooth.into_iter().map(|t| t.map(Into::into)).collect()
        } else {
            let flat = flat_normals(&indices, &posed.positions);
            flat.into_iter().map(|n| [n.into(); 3]).collect()
        };
        let strips = self.cell.strips.get(object);
        let triangle = |(t, tri): (usize, &OrientedTriangle)| {
            let look = &looks[tri.submesh as usize];
            let fixed = strips.map(|ids| colour_of(ids[t])).or(look.fixed);
            let corners: [Corner; 3] = std::array::from_fn(|k| {
                self.corner(&posed, look, fixed, tri.corners[k], made[t][k])
            });
            let mut corners = match self.heat {
                Some((heat, cell)) => heat.parts(cell, object, t, &corners),
                None => corners.to_vec(),
            };
            if posed.mirrored {
                corners.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.swap(1, 2));
            }
            corners
        };
        let mut runs: Vec<(usize, Vec<Corner>)> = Vec::new();
        let mut first = 0;
        for run in triangles.chunk_by(|a, b| {
            looks[a.submesh as usize].material == looks[b.submesh as usize].material
        }) {
            let corners = run.par_iter().enumerate().map(|(i, tri)| triangle((first + i, tri)));
            runs.push((looks[run[0].submesh as usize].material, corners.flatten_iter().collect()));
            first += run.len();
        }
        runs
    }

    fn look<'a>(&self, mesh: &'a Mesh, submesh: usize, matte: usize) -> Look<'a> {
        let object = self.placement.object;
        let normals = stream(mesh, submesh, &Semantic::Normal).is_some();
        if self.args.color != Colouring::Material {
            let before: usize =
                (0..object).map(|o| self.shown.objects.mesh(o).submeshes().len()).sum();
            let fixed = match self.args.color {
                Colouring::Submesh => colour_of((before + submesh) as u32),
                _ => PLAIN,
            };
            return Look { material: matte, normals, uv: None, colour: None, fixed: Some(fixed) };
        }
        let material = self.shown.appearance.of_submesh[object][submesh];
        let set = self.shown.appearance.materials[material].texture.map(|t| t.set);
        let uv = set.and_then(|set| stream(mesh, submesh, &Semantic::TexCoord(set)));
        let colour = stream(mesh, submesh, &Semantic::Color(0));
        Look { material, normals, uv, colour, fixed: None }
    }

    fn corner(
        &self,
        posed: &PosedVertices,
        look: &Look<'_>,
        fixed: Option<[f32; 3]>,
        v: u32,
        made: [f32; 3],
    ) -> Corner {
        let p = posed.positions[v as usize];
        let own = posed.normals[v as usize].as_vec3().to_array();
        let usable =
            look.normals && own.iter().all(|c| c.is_finite()) && own.iter().any(|c| c.abs() > 1e-6);
        let smooth_shading = self.args.shading == Shading::Smooth;
        let normal = if smooth_shading && usable { own } else { made };
        let component = |a: &Attribute, i: usize, default: f32| {
            let value = if i < usize::from(a.components) { a.value(v, i) } else { default };
            if value.is_finite() { value } else { default }
        };
        let colour = match (fixed, look.colour) {
            (Some([r, g, b]), _) => [r, g, b, 1.0],
            (None, Some(stream)) => {
                std::array::from_fn(|i| component(stream, i, 1.0).clamp(0.0, 1.0))
            }
            (None, None) => [1.0; 4],
        };
        Corner {
            position: std::array::from_fn(|i| (p[i] - self.camera.centre[i]) as f32),
            normal,
            uv: look
                .uv
                .map_or([0.0; 2], |stream| std::array::from_fn(|i| component(stream, i, 0.0))),
            colour,
        }
    }
}
