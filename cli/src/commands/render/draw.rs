//! Triangles to corners to pixels.

use super::RenderArgs;
use super::cells::Cell;
use super::colours::distinct;
use super::heat::Heat;
use super::normals::{flat, smooth};
use super::options::{Backs, Colouring, Shading, UpAxis};
use super::placed::{Placed, placed, stream};
use super::scene::Shown;
use crate::exit::Outcome;
use crate::gpu::{Device, failure};
use lodc_formats::appearance::{Material, Opacity, Placement, TextureUse, Wrap};
use lodc_formats::picture::Picture;
use lodc_gpu::picture as gpu;
use lodc_gpu::picture::{
    BackFaces, Camera, Corner, Frame, Framing, Lens, Paint, Painter, Sampling, Style, Texture, Up,
};
use lodc_mesh::{Attribute, Mesh, OrientedTriangle, PositionIds, Semantic};
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
) -> Outcome<Vec<Picture>> {
    let (paints, textures) = paints(args, shown);
    let painter = Painter::new(device, textures, &paints).map_err(|e| failure(&e))?;
    let size =
        args.size.unwrap_or(if args.contact_sheet.is_empty() { [1024, 768] } else { [480, 360] });
    let points: Vec<PositionIds> = (0..shown.objects.len())
        .into_par_iter()
        .map(|o| PositionIds::new(shown.objects.mesh(o).positions()))
        .collect();
    let camera = camera(args, shown, f64::from(size[0]) / f64::from(size[1]));
    let style = Style {
        size,
        background: args.background.map(|c| f32::from(c) / 255.0),
        back_faces: match args.back_faces {
            Backs::Material => BackFaces::AsPainted,
            Backs::Show => BackFaces::Shown,
            Backs::Hide => BackFaces::Hidden,
            Backs::Mark => BackFaces::Marked,
        },
        wire: if args.wireframe { 1.0 } else { 0.0 },
    };
    let one = |(number, cell): (usize, &Cell)| {
        let mut frame = Frame::new(&painter, &camera, &style)?;
        let mut blended: Vec<(f32, usize, [Corner; 3])> = Vec::new();
        for placement in &shown.appearance.placements {
            let o = placement.object;
            let heat = heat.map(|heat| (heat, number));
            let part =
                Part { args, shown, placement, cell, heat, points: &points[o], camera: &camera };
            for (paint, corners) in part.corners(paints.len() - 1) {
                if paints[paint].blended {
                    let triples = corners.as_chunks::<3>().0;
                    blended.extend(triples.iter().map(|&t| (depth(&camera, &t), paint, t)));
                } else {
                    frame.draw(paint, false, &corners)?;
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
    let drawn: Result<Vec<gpu::Pixels>, _> = cells.iter().enumerate().map(one).collect();
    let pictures = drawn.map_err(|e| failure(&e))?.into_iter();
    Ok(pictures.map(|p| Picture { width: p.width, height: p.height, bytes: p.bytes }).collect())
}

fn depth(camera: &Camera, t: &[Corner; 3]) -> f32 {
    t.iter().map(|c| camera.distance(c.position)).sum()
}

/// All materials as paints, and one more for colours that stand for something.
fn paints(args: &RenderArgs, shown: &Shown) -> (Vec<Paint>, Vec<Texture>) {
    let looks = &shown.appearance;
    if args.color != Colouring::Material {
        return (vec![Paint::default()], Vec::new());
    }
    // A texture on the device is a picture with one way to read it.
    let mut uses: Vec<TextureUse> = Vec::new();
    let mut paint = |material: &Material| {
        let texture = material.texture.map(|wanted| {
            let same = |u: &TextureUse| {
                (u.picture, u.wrap, u.nearest) == (wanted.picture, wanted.wrap, wanted.nearest)
            };
            uses.iter().position(same).unwrap_or_else(|| {
                uses.push(wanted);
                uses.len() - 1
            })
        });
        Paint {
            colour: material.colour,
            texture,
            uv: material.texture.map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], |t| t.transform),
            double_sided: material.double_sided,
            cut_off: match material.opacity {
                Opacity::CutOff(at) => Some(at),
                _ => None,
            },
            blended: material.opacity == Opacity::Blended,
            unlit: material.unlit,
        }
    };
    let mut paints: Vec<Paint> = looks.materials.iter().map(&mut paint).collect();
    paints.push(Paint::default());
    let texture = |u: &TextureUse| {
        let Picture { width, height, bytes } = looks.pictures[u.picture].clone();
        let wrap = u.wrap.map(|w| match w {
            Wrap::Repeat => gpu::Wrap::Repeat,
            Wrap::Mirror => gpu::Wrap::Mirror,
            Wrap::Clamp => gpu::Wrap::Clamp,
        });
        Texture { width, height, bytes, sampling: Sampling { wrap, nearest: u.nearest } }
    };
    let textures = uses.iter().map(texture).collect();
    (paints, textures)
}

/// The camera that frames the input, whatever level of detail is shown.
fn camera(args: &RenderArgs, shown: &Shown, aspect: f64) -> Camera {
    let mut points: Vec<[f64; 3]> = Vec::new();
    for placement in &shown.appearance.placements {
        points.extend(placed(shown.objects.mesh(placement.object), placement, false).positions);
    }
    let (azimuth, elevation) = args.view.angles();
    let any = args.azimuth.is_some() || args.elevation.is_some();
    let framing = Framing {
        up: match args.up {
            UpAxis::Y => Up::Y,
            UpAxis::Z => Up::Z,
        },
        azimuth: args.azimuth.unwrap_or(if any { 0.0 } else { azimuth }),
        elevation: args.elevation.unwrap_or(if any { 0.0 } else { elevation }),
        lens: if args.orthographic { Lens::Orthographic } else { Lens::Perspective(args.fov) },
        zoom: args.zoom,
    };
    Camera::around(&points, &framing, aspect)
}

/// An object where it is shown, at the level of detail of a cell.
struct Part<'a> {
    args: &'a RenderArgs,
    shown: &'a Shown,
    placement: &'a Placement,
    cell: &'a Cell,
    /// Where distances are what colours mean, those of this cell.
    heat: Option<(&'a Heat, usize)>,
    points: &'a PositionIds,
    camera: &'a Camera,
}

/// What a submesh gives its corners.
struct Look<'a> {
    paint: usize,
    normals: bool,
    uv: Option<&'a Attribute>,
    colour: Option<&'a Attribute>,
    /// What all of it is coloured with, where colours stand for something.
    fixed: Option<[f32; 3]>,
}

impl Part<'_> {
    /// Runs of triangles with one paint.
    fn corners(&self, matte: usize) -> Vec<(usize, Vec<Corner>)> {
        let object = self.placement.object;
        let mesh = self.shown.objects.mesh(object);
        let triangles = &self.cell.objects[object];
        let smooth_shading = self.args.shading == Shading::Smooth;
        let placed = placed(mesh, self.placement, smooth_shading);
        let looks: Vec<Look<'_>> =
            (0..mesh.submeshes().len()).map(|s| self.look(mesh, s, matte)).collect();
        let made: Vec<[[f64; 3]; 3]> = if smooth_shading {
            smooth(triangles, &placed.positions, self.points)
        } else {
            flat(triangles, &placed.positions).into_iter().map(|n| [n; 3]).collect()
        };
        let strips = self.cell.strips.get(object);
        let triangle = |(t, tri): (usize, &OrientedTriangle)| {
            let look = &looks[tri.submesh as usize];
            let fixed = strips.map(|ids| distinct(ids[t])).or(look.fixed);
            let corners: [Corner; 3] = std::array::from_fn(|k| {
                self.corner(&placed, look, fixed, tri.corners[k], made[t][k])
            });
            let mut corners = match self.heat {
                Some((heat, cell)) => heat.parts(cell, object, t, &corners),
                None => corners.to_vec(),
            };
            if placed.mirrored {
                corners.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.swap(1, 2));
            }
            corners
        };
        let mut runs: Vec<(usize, Vec<Corner>)> = Vec::new();
        let mut first = 0;
        for run in triangles
            .chunk_by(|a, b| looks[a.submesh as usize].paint == looks[b.submesh as usize].paint)
        {
            let corners = run.par_iter().enumerate().map(|(i, tri)| triangle((first + i, tri)));
            runs.push((looks[run[0].submesh as usize].paint, corners.flatten_iter().collect()));
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
                Colouring::Submesh => distinct((before + submesh) as u32),
                _ => PLAIN,
            };
            return Look { paint: matte, normals, uv: None, colour: None, fixed: Some(fixed) };
        }
        let paint = self.shown.appearance.of_submesh[object][submesh];
        let set = self.shown.appearance.materials[paint].texture.map(|t| t.set);
        let uv = set.and_then(|set| stream(mesh, submesh, &Semantic::TexCoord(set)));
        let colour = stream(mesh, submesh, &Semantic::Color(0));
        Look { paint, normals, uv, colour, fixed: None }
    }

    fn corner(
        &self,
        placed: &Placed,
        look: &Look<'_>,
        fixed: Option<[f32; 3]>,
        v: u32,
        made: [f64; 3],
    ) -> Corner {
        let p = placed.positions[v as usize];
        let own = placed.normals[v as usize];
        let usable =
            look.normals && own.iter().all(|c| c.is_finite()) && own.iter().any(|c| c.abs() > 1e-6);
        let smooth_shading = self.args.shading == Shading::Smooth;
        let normal = if smooth_shading && usable { own } else { made.map(|c| c as f32) };
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
