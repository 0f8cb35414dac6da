//! The surface of a scene: the triangles of every object where the default scene places it, with
//! normals, texture coordinates, colours of vertices and materials.

use crate::picture::ShadingOptions;
use crate::surface::Surface;
use crate::texture::Pyramid;
use glam::Vec3;
use lodc_mesh::{Attribute, Mesh, Semantic};
use lodc_scene::{Appearance, Arrangement, Coordinates, Placement, Texture, posed, stream};
use std::sync::Arc;

/// A scene as one surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneSurface {
    /// The triangles of all placements, in their order.
    pub surface: Surface,
    /// True if every submesh has texture coordinates.
    pub all_textured: bool,
    /// True if a material has a texture, and a submesh coordinates to read it.
    has_textures: bool,
    /// True if two submeshes have materials of different colours.
    has_colours: bool,
}

impl SceneSurface {
    /// Places the objects of a scene, whose meshes at some level of detail are `meshes`. The
    /// surface has normals if every submesh has them, and colours of vertices and materials if one
    /// has them; texture coordinates are those that the submesh's texture reads, moved as it moves
    /// them.
    #[must_use]
    pub fn new(meshes: &[&Mesh], scene: &Arrangement, shading: &Appearance) -> Self {
        let images = shading.images.iter().map(Pyramid::new);
        Self::with_images(meshes, scene, shading, || images.collect())
    }

    /// As [`Self::new`], with the images of `shading` prepared: `images` is called only if they are
    /// needed.
    #[must_use]
    pub fn with_images(
        meshes: &[&Mesh],
        scene: &Arrangement,
        shading: &Appearance,
        images: impl FnOnce() -> Arc<[Pyramid]>,
    ) -> Self {
        let has = |o: usize, s: usize, semantic| stream(meshes[o], s, &semantic).is_some();
        let material = |o: usize, s: usize| {
            shading.of_submesh.get(o)?.get(s)?;
            Some(shading.material_of(o, s, has(o, s, Semantic::Color(0))))
        };
        let coordinates = |o: usize, s: usize| {
            material(o, s).map_or(Coordinates::PLAIN, |m| shading.materials[m].coordinates)
        };
        let submeshes = || {
            let placed = |p: &Placement| {
                let object = p.object;
                (0..meshes[object].submeshes().len()).map(move |s| (object, s))
            };
            scene.placements().iter().flat_map(placed)
        };
        let is_textured = |(o, s)| has(o, s, Semantic::TexCoord(coordinates(o, s).set));
        let with_normals = submeshes().all(|(o, s)| has(o, s, Semantic::Normal));
        let with_texture = submeshes().any(is_textured);
        let with_colours = submeshes().any(|(o, s)| has(o, s, Semantic::Color(0)));
        let mut surface = Surface::default();
        for placement in scene.placements() {
            let object = placement.object;
            let mesh = meshes[object];
            add(&mut surface, mesh, placement, with_normals);
            if with_texture {
                for (v, &s) in (0..).zip(mesh.vertex_submesh()) {
                    let read = coordinates(object, s as usize);
                    let set = stream(mesh, s as usize, &Semantic::TexCoord(read.set));
                    let uv = set.map_or([0.0; 2], |a| pair(a, v));
                    surface.texture.push(read.to_image(uv).into());
                }
            }
            if with_colours {
                for (v, &s) in (0..).zip(mesh.vertex_submesh()) {
                    let of_vertex = stream(mesh, s as usize, &Semantic::Color(0));
                    surface.colours.push(of_vertex.map_or(Vec3::ONE, |a| colour(a, v)));
                }
            }
            for (s, submesh) in mesh.submeshes().iter().enumerate() {
                let material = material(object, s).unwrap_or(0) as u32;
                surface.material_of.extend(submesh.triangles().map(|_| material));
            }
        }
        let has_textures = with_texture && shading.materials.iter().any(|m| m.texture.is_some());
        let colour_of = |(o, s)| material(o, s).map(|m| shading.materials[m].colour);
        let first = submeshes().next().and_then(colour_of);
        let has_colours = submeshes().any(|s| colour_of(s) != first);
        if has_textures || submeshes().any(|(o, s)| material(o, s).is_some_and(|m| m > 0)) {
            surface.materials.clone_from(&shading.materials);
            for material in &mut surface.materials {
                material.texture = material
                    .texture
                    .filter(|_| has_textures)
                    .map(|texture| Texture { transform: Texture::UNTRANSFORMED, ..texture });
            }
            if has_textures {
                surface.images = images();
            }
        } else {
            surface.material_of.clear();
        }
        let all_textured = with_texture && submeshes().all(is_textured);
        Self { surface, all_textured, has_textures, has_colours }
    }

    /// Everything that this surface and another can be shown with: colours of vertices, and
    /// materials or else a checkerboard where there are coordinates only.
    #[must_use]
    pub fn common_shading(&self, other: &Self) -> ShadingOptions {
        let both = |has: fn(&Self) -> bool| has(self) && has(other);
        let neither_textured = !self.has_textures && !other.has_textures;
        let materials = both(|s| s.has_textures)
            || (neither_textured
                && both(|s| !s.surface.materials.is_empty())
                && (self.has_colours || other.has_colours));
        ShadingOptions {
            own_normals: both(|s| !s.surface.normals.is_empty()),
            checkerboard: !materials && both(|s| s.all_textured),
            materials,
            vertex_colours: both(|s| !s.surface.colours.is_empty()),
        }
    }
}

/// Adds the triangles, positions and normals of a placement.
fn add(surface: &mut Surface, mesh: &Mesh, placement: &Placement, with_normals: bool) {
    let first = surface.positions.len() as u32;
    let posed = posed(mesh, placement);
    surface.positions.extend(posed.positions.iter().map(|p| p.as_vec3()));
    if with_normals {
        let unit = posed.normals.iter().map(|n| n.normalize_or_zero().as_vec3());
        surface.normals.extend(unit);
    }
    surface.triangles.extend(mesh.triangles().iter().map(|&[a, b, c]| {
        let outward = if posed.mirrored { [a, c, b] } else { [a, b, c] };
        outward.map(|v| first + v)
    }));
}

/// The colour of a vertex, without its opacity; white where it is no number.
fn colour(stream: &Attribute, v: u32) -> Vec3 {
    let component = |i: usize| {
        let value = if i < usize::from(stream.components) { stream.value(v, i) } else { 1.0 };
        if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 }
    };
    Vec3::from([0, 1, 2].map(component))
}

/// The texture coordinates of a vertex; zeros in place of components that are not there.
fn pair(stream: &Attribute, v: u32) -> [f32; 2] {
    let component = |i: usize| {
        if i < usize::from(stream.components) { stream.value(v, i) } else { 0.0 }
    };
    [component(0), component(1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_scene::{Graph, LocalTransform, Node, Pose};

    #[test]
    fn objects_stand_where_their_nodes_show_them() {
        let mesh = lodc_fixtures::named("cube").expect("a shape");
        let scale = |x: f64| LocalTransform::Trs {
            translation: [10.0, 0.0, 0.0],
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: [x, 1.0, 1.0],
        };
        let node = |local| Node { local, objects: vec![0], ..Node::default() };
        let graph = Graph {
            nodes: vec![node(LocalTransform::default()), node(scale(-2.0))],
            roots: vec![0, 1],
            skins: Vec::new(),
        };
        let pose: Pose = graph.rest_pose();
        let scene = Arrangement::new(&graph, &pose, 1);
        let shown = SceneSurface::new(&[&mesh], &scene, &Appearance::default()).surface;
        let n = mesh.triangles().len();
        assert_eq!(shown.triangles.len(), 2 * n);
        // Six times the volume of the tetrahedra below all faces: outward both times.
        let volume = |range: std::ops::Range<usize>| -> f64 {
            range.map(|t| shown.corners(t)).map(|[a, b, c]| a.dot(b.cross(c))).sum()
        };
        let (one, mirrored) = (volume(0..n), volume(n..2 * n));
        assert!(one > 0.0 && (mirrored - 2.0 * one).abs() < 1e-3 * one, "{one} {mirrored}");
        let first = Vec3::from(mesh.positions()[0]);
        let moved = first * Vec3::new(-2.0, 1.0, 1.0) + Vec3::new(10.0, 0.0, 0.0);
        assert_eq!(shown.positions[mesh.vertex_count()], moved);
    }
}
