//! A scene at some levels of detail as drawable triangles: corners with positions, normals and
//! colours, in the order in which they are drawn.

use super::{Camera, Corner, Painter, Run, Style};
use lodc_mesh::{Attribute, Mesh, OrientedTriangle, PositionIds, Semantic};
use lodc_scene::{
    AlphaMode, Appearance, Arrangement, Image, Material, Placement, PosedVertices, flat_normals,
    posed, smooth_normals, stream,
};
use rayon::prelude::*;

/// The looks of a scene's surfaces.
#[derive(Clone, Copy)]
pub enum Colours<'a> {
    /// Materials, textures and vertex colours.
    Materials(&'a Appearance),
    /// Colours with a meaning: the linear one of a submesh, by object and submesh.
    Submeshes(&'a (dyn Fn(usize, usize) -> [f32; 3] + Sync)),
}

/// Divides a triangle, given by its number and its corners, into triangles of other colours.
pub type Subdivision<'a> = dyn Fn(usize, &[Corner; 3]) -> Vec<Corner> + Sync + 'a;

/// An object at a level of detail.
pub struct DrawnMesh<'a> {
    /// The vertices.
    pub mesh: &'a Mesh,
    /// The triangles, in the order in which they are drawn.
    pub triangles: &'a [OrientedTriangle],
    /// The linear colour of each triangle, instead of that of its submesh; else empty.
    pub colours: Vec<[f32; 3]>,
    /// Triangles that are drawn in parts.
    pub subdivision: Option<Box<Subdivision<'a>>>,
}

/// A scene to be drawn.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// Where its objects are shown.
    pub arrangement: &'a Arrangement,
    /// Its appearance.
    pub colours: Colours<'a>,
    /// Normals of the file, rounded ones where it has none; else one for each triangle.
    pub smooth: bool,
}

impl Scene<'_> {
    /// Prepares drawing its materials.
    #[must_use]
    pub fn painter(&self) -> Painter {
        let images = match self.colours {
            Colours::Materials(appearance) => &appearance.images[..],
            Colours::Submeshes(_) => &[],
        };
        Painter::new(images, self.materials())
    }

    /// All materials, and one more for colours with a meaning.
    fn materials(&self) -> Vec<Material> {
        let matte = Material { double_sided: true, ..Material::default() };
        match self.colours {
            Colours::Materials(appearance) => {
                appearance.materials.iter().copied().chain([matte]).collect()
            }
            Colours::Submeshes(_) => vec![matte],
        }
    }

    /// Draws every object where the scene shows it, what is blended last and from far to near.
    /// `painter` is the scene's own.
    #[must_use]
    pub fn draw(
        &self,
        painter: &Painter,
        camera: &Camera,
        style: &Style,
        levels: &[DrawnMesh<'_>],
    ) -> Image {
        let materials = painter.materials();
        let points: Vec<PositionIds> =
            levels.par_iter().map(|level| PositionIds::new(level.mesh.positions())).collect();
        let mut runs: Vec<Run> = Vec::new();
        // The depth, the material and the corners of each blended triangle.
        let mut blended: Vec<(f32, usize, [Corner; 3])> = Vec::new();
        for placement in self.arrangement.placements() {
            let (level, points) = (&levels[placement.object], &points[placement.object]);
            let part = Part { scene: self, placement, level, points, camera };
            for run in part.corners(materials.len() - 1) {
                if materials[run.material].alpha == AlphaMode::Blend {
                    let triples = run.corners.as_chunks::<3>().0;
                    blended.extend(triples.iter().map(|&t| (depth(camera, &t), run.material, t)));
                } else {
                    runs.push(run);
                }
            }
        }
        // Far ones first; the sort is stable, so that equal ones keep the order of the file.
        blended.sort_by(|a, b| b.0.total_cmp(&a.0));
        for run in blended.chunk_by(|a, b| a.1 == b.1) {
            let corners = run.iter().flat_map(|(_, _, t)| *t).collect();
            runs.push(Run { material: run[0].1, corners });
        }
        painter.draw(camera, style, &runs)
    }
}

/// The depth of a triangle, for sorting.
fn depth(camera: &Camera, t: &[Corner; 3]) -> f32 {
    t.iter().map(|c| camera.distance(c.position)).sum()
}

/// An object where it is shown.
struct Part<'a> {
    scene: &'a Scene<'a>,
    placement: &'a Placement,
    level: &'a DrawnMesh<'a>,
    points: &'a PositionIds,
    camera: &'a Camera,
}

/// The looks that a submesh gives its corners.
struct SubmeshStyle<'a> {
    material: usize,
    /// True if the file has normals.
    normals: bool,
    uv: Option<&'a Attribute>,
    colour: Option<&'a Attribute>,
    /// The one colour of all of it, if colours have a meaning.
    fixed: Option<[f32; 3]>,
}

impl Part<'_> {
    /// Runs of triangles with one material.
    fn corners(&self, matte: usize) -> Vec<Run> {
        let DrawnMesh { mesh, triangles, ref colours, ref subdivision } = *self.level;
        let posed = posed(mesh, self.placement);
        let indices: Vec<[u32; 3]> = triangles.iter().map(|t| t.corners).collect();
        let styles: Vec<SubmeshStyle<'_>> =
            (0..mesh.submeshes().len()).map(|s| self.submesh_style(mesh, s, matte)).collect();
        let computed: Vec<[[f32; 3]; 3]> = if self.scene.smooth {
            let smooth = smooth_normals(&indices, &posed.positions, self.points);
            smooth.into_iter().map(|t| t.map(Into::into)).collect()
        } else {
            let flat = flat_normals(&indices, &posed.positions);
            flat.into_iter().map(|n| [n.into(); 3]).collect()
        };
        let triangle = |(t, tri): (usize, &OrientedTriangle)| {
            let style = &styles[tri.submesh as usize];
            let fixed = colours.get(t).copied().or(style.fixed);
            let corners: [Corner; 3] = std::array::from_fn(|k| {
                self.corner(&posed, style, fixed, tri.corners[k], computed[t][k])
            });
            let mut corners = match subdivision {
                Some(divide) => divide(t, &corners),
                None => corners.to_vec(),
            };
            if posed.mirrored {
                corners.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.swap(1, 2));
            }
            corners
        };
        let mut runs = Vec::new();
        let mut first = 0;
        let material = |t: &OrientedTriangle| styles[t.submesh as usize].material;
        for run in triangles.chunk_by(|a, b| material(a) == material(b)) {
            let corners = run.par_iter().enumerate().map(|(i, tri)| triangle((first + i, tri)));
            let corners = corners.flatten_iter().collect();
            runs.push(Run { material: material(&run[0]), corners });
            first += run.len();
        }
        runs
    }

    /// How the corners of a submesh look.
    fn submesh_style<'a>(&self, mesh: &'a Mesh, submesh: usize, matte: usize) -> SubmeshStyle<'a> {
        let object = self.placement.object;
        let normals = stream(mesh, submesh, &Semantic::Normal).is_some();
        let appearance = match self.scene.colours {
            Colours::Materials(appearance) => appearance,
            Colours::Submeshes(colour) => {
                let fixed = Some(colour(object, submesh));
                return SubmeshStyle { material: matte, normals, uv: None, colour: None, fixed };
            }
        };
        let colour = stream(mesh, submesh, &Semantic::Color(0));
        let material = appearance.material_of(object, submesh, colour.is_some());
        let set = appearance.materials[material].texture.map(|t| t.set);
        let uv = set.and_then(|set| stream(mesh, submesh, &Semantic::TexCoord(set)));
        SubmeshStyle { material, normals, uv, colour, fixed: None }
    }

    /// A corner at vertex `v`. `fixed` is a colour instead of that of the mesh, `computed` a normal
    /// for where the file has none.
    fn corner(
        &self,
        posed: &PosedVertices,
        style: &SubmeshStyle<'_>,
        fixed: Option<[f32; 3]>,
        v: u32,
        computed: [f32; 3],
    ) -> Corner {
        let p = posed.positions[v as usize];
        let file_normal = posed.normals[v as usize].as_vec3().to_array();
        let usable = style.normals
            && file_normal.iter().all(|c| c.is_finite())
            && file_normal.iter().any(|c| c.abs() > 1e-6);
        let normal = if self.scene.smooth && usable { file_normal } else { computed };
        let component = |a: &Attribute, i: usize, default: f32| {
            let value = if i < usize::from(a.components) { a.value(v, i) } else { default };
            if value.is_finite() { value } else { default }
        };
        let colour = match (fixed, style.colour) {
            (Some([r, g, b]), _) => [r, g, b, 1.0],
            (None, Some(stream)) => {
                std::array::from_fn(|i| component(stream, i, 1.0).clamp(0.0, 1.0))
            }
            (None, None) => [1.0; 4],
        };
        Corner {
            position: std::array::from_fn(|i| (p[i] - self.camera.centre[i]) as f32),
            normal,
            uv: style
                .uv
                .map_or([0.0; 2], |stream| std::array::from_fn(|i| component(stream, i, 0.0))),
            colour,
        }
    }
}
