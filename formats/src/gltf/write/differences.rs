//! The values of a morph target that moves each vertex to where the next level has it: differences
//! of positions, normals, tangents, texture coordinates and colours.

use crate::gltf::semantic;
use lodc_mesh::{Attribute, Mesh, Semantic};

/// What a morph target to the next level moves besides positions and normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MovedStreams {
    /// Directions of tangents; their handedness stays.
    pub tangents: bool,
    /// Texture coordinates.
    pub texture_coordinates: bool,
    /// Colours.
    pub colours: bool,
    /// No target can move joints and weights: if this is true, a vertex is written with those of
    /// the vertex that it becomes, at the level where it moves.
    pub joints: bool,
}

impl MovedStreams {
    /// Number of components that move; none of a stream that stays.
    fn components(self, stream: &Attribute) -> Option<usize> {
        match stream.semantic {
            _ if stream.morph_target.is_some() => None,
            Semantic::Normal => Some(3),
            Semantic::Tangent if self.tangents => Some(3),
            Semantic::TexCoord(_) if self.texture_coordinates => Some(2),
            Semantic::Color(_) if self.colours => Some(usize::from(stream.components)),
            _ => None,
        }
    }
}

/// The streams of a submesh that change with a move to the next level.
pub(super) fn moved_streams(
    mesh: &Mesh,
    submesh: usize,
    moved: MovedStreams,
) -> impl Iterator<Item = &Attribute> {
    let streams = mesh.submeshes()[submesh].attributes.iter();
    let moves = move |a: &&Attribute| match a.semantic {
        Semantic::Position => a.morph_target.is_none(),
        Semantic::Joints(_) | Semantic::Weights(_) => moved.joints,
        _ => moved.components(a).is_some(),
    };
    streams.map(|&a| &mesh.attributes()[a as usize]).filter(moves)
}

/// The stream of a submesh with this meaning, at rest.
fn stream<'m>(mesh: &'m Mesh, submesh: usize, wanted: &Semantic) -> Option<&'m Attribute> {
    let streams = mesh.submeshes()[submesh].attributes.iter();
    let mut streams = streams.map(|&a| &mesh.attributes()[a as usize]);
    streams.find(|a| a.semantic == *wanted && a.morph_target.is_none())
}

/// How much a stream's values change.
pub(super) struct Deltas {
    /// The stream's name in glTF.
    pub(super) name: String,
    /// Components of a value.
    pub(super) components: usize,
    /// All components of all values; empty if nothing moves.
    pub(super) values: Vec<f32>,
}

/// The differences of a submesh's values between two meshes, for some vertices.
pub(super) fn differences(
    now: &Mesh,
    next: &Mesh,
    submesh: usize,
    vertices: &[u32],
    moves: MovedStreams,
) -> Vec<Deltas> {
    let position = Semantic::Position;
    let stored = [now, next].map(|mesh| stream(mesh, submesh, &position));
    let coordinate = |mesh: &Mesh, v: u32, c: usize| mesh.positions()[v as usize][c];
    let moved = |v: u32, c: usize| match stored {
        [Some(a), Some(b)] => difference(a.value(v, c), b.value(v, c)),
        _ => difference(coordinate(now, v, c), coordinate(next, v, c)),
    };
    let values = flat(vertices, 3, moved);
    let mut all = vec![Deltas { name: semantic::to_name(&position), components: 3, values }];
    for &a in &now.submeshes()[submesh].attributes {
        let a = &now.attributes()[a as usize];
        let Some(components) = moves.components(a) else { continue };
        let Some(b) = stream(next, submesh, &a.semantic) else { continue };
        let moved = |v: u32, c: usize| difference(a.value(v, c), b.value(v, c));
        let values = flat(vertices, components, moved);
        all.push(Deltas { name: semantic::to_name(&a.semantic), components, values });
    }
    all
}

fn flat(vertices: &[u32], components: usize, value: impl Fn(u32, usize) -> f32) -> Vec<f32> {
    vertices
        .iter()
        .flat_map(|&v| (0..components).map(move |c| (v, c)))
        .map(|(v, c)| value(v, c))
        .collect()
}

/// What has to be added to one number to get another; 0 if that is not a finite float.
fn difference(from: f32, to: f32) -> f32 {
    let difference = (f64::from(to) - f64::from(from)) as f32;
    // Adding zero turns −0 into 0.
    if difference.is_finite() { difference + 0.0 } else { 0.0 }
}
