//! The layout of a vertex's values in a stream: positions and attributes as streams of channels,
//! the number system of each channel, and how each stream is predicted.

use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::octahedral::Octahedral;
use lodc_mesh::{Attribute, Component, Mesh, Semantic, Simplified};

/// The prediction of the channels of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// By the mean over the link, the vertices around the new one.
    Smooth,
    /// Like [`Self::Smooth`], for unit vectors: the length 1 predicts the third channel from the
    /// first two.
    Direction,
    /// By a linear function of the position, fitted to the link.
    Fit,
    /// The first two channels are a direction on an octahedron, predicted as a direction; they
    /// stand for three components of the attribute. Further channels like [`Self::Smooth`].
    Octahedral(Octahedral),
    /// By the parent's value.
    Parent,
}

/// A stream of a vertex: its position or one of its attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AttributeStream {
    /// First of its channels among all channels of a vertex.
    pub first_channel: usize,
    /// Number of its channels.
    pub channels: usize,
    /// Their prediction.
    pub prediction: Prediction,
}

/// The streams of an object's vertices, positions first, and the number system of each channel.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexLayout {
    /// One for each channel of a vertex.
    pub systems: Vec<NumberSystem>,
    /// Positions, then the attributes in their order.
    pub streams: Vec<AttributeStream>,
}

impl VertexLayout {
    /// Returns the streams of a mesh with these attributes. `octahedral` has the grid of each
    /// attribute that is stored as a direction on an octahedron; it may be shorter.
    #[must_use]
    pub fn streams(
        attributes: &[Attribute],
        octahedral: &[Option<Octahedral>],
    ) -> Vec<AttributeStream> {
        let mut first_channel = 3;
        let position =
            AttributeStream { first_channel: 0, channels: 3, prediction: Prediction::Smooth };
        let mut streams = vec![position];
        for (i, a) in attributes.iter().enumerate() {
            let mut channels = usize::from(a.components);
            let prediction = match (&a.semantic, a.morph_target) {
                _ if let Some(Some(octahedral)) = octahedral.get(i) => {
                    channels -= 1;
                    Prediction::Octahedral(*octahedral)
                }
                (Semantic::TexCoord(_), None) => Prediction::Fit,
                (Semantic::Normal | Semantic::Tangent, None)
                    if a.component == Component::F32 && channels >= 3 =>
                {
                    Prediction::Direction
                }
                (Semantic::Joints(_) | Semantic::Weights(_) | Semantic::Custom(_), _) => {
                    Prediction::Parent
                }
                _ => Prediction::Smooth,
            };
            streams.push(AttributeStream { first_channel, channels, prediction });
            first_channel += channels;
        }
        streams
    }

    /// Chooses for every stream a number system that holds all its values, by the length of
    /// residuals.
    #[must_use]
    pub fn choose(simplified: &Simplified) -> Self {
        let mesh = simplified.mesh();
        let streams = Self::streams(mesh.attributes(), &[]);
        let positions = |v: u32, c: usize| mesh.positions()[v as usize][c];
        let mut systems = vec![best_system(simplified, 3, positions); 3];
        for a in mesh.attributes() {
            let channels = usize::from(a.components);
            let system = match a.component {
                Component::F32 => {
                    best_system(simplified, channels, |v, c| float_component(a, v, c))
                }
                _ => NumberSystem::Integer,
            };
            systems.extend(std::iter::repeat_n(system, channels));
        }
        Self { systems, streams }
    }

    /// Returns the indices of all channels of all vertices, in stream order: the last vertex of the
    /// collapse order first.
    pub(crate) fn indices(&self, mesh: &Mesh) -> Vec<i32> {
        let vertices = mesh.vertex_count();
        let mut indices = Vec::with_capacity(vertices * self.systems.len());
        for v in (0..vertices as u32).rev() {
            let position = mesh.positions()[v as usize];
            indices.extend(position.iter().zip(&self.systems).map(|(&p, s)| s.index(p)));
            for (a, stream) in mesh.attributes().iter().zip(&self.streams[1..]) {
                let mut components = 0..usize::from(a.components);
                if let Prediction::Octahedral(octahedral) = stream.prediction {
                    let direction = [0, 1, 2].map(|c| f64::from(float_component(a, v, c)));
                    indices.extend(octahedral.indices(direction));
                    components.start = 3;
                }
                let channel =
                    |c: usize| stream.first_channel + stream.channels - components.end + c;
                for (c, channel) in components.clone().map(|c| (c, channel(c))) {
                    indices.push(match a.component {
                        Component::F32 => self.systems[channel].index(float_component(a, v, c)),
                        _ => integer_component(a, v, c),
                    });
                }
            }
        }
        indices
    }

    /// Appends the bytes of an attribute whose stream has these indices.
    pub(crate) fn append_bytes(
        &self,
        component: Component,
        stream: &AttributeStream,
        indices: &[i32],
        bytes: &mut Vec<u8>,
    ) {
        let mut channels = 0..indices.len();
        if let Prediction::Octahedral(octahedral) = stream.prediction {
            let direction = octahedral.direction([indices[0], indices[1]]);
            direction.iter().for_each(|&c| bytes.extend((c as f32).to_le_bytes()));
            channels.start = 2;
        }
        for channel in channels {
            let (system, index) = (self.systems[stream.first_channel + channel], indices[channel]);
            match component {
                Component::F32 => bytes.extend(system.value(index).to_le_bytes()),
                _ => bytes.extend_from_slice(&index.to_le_bytes()[..component.size()]),
            }
        }
    }

    /// Stores some attributes as directions on an octahedron: those that have a grid in
    /// `octahedral`.
    pub(crate) fn set_octahedral(
        &mut self,
        attributes: &[Attribute],
        octahedral: &[Option<Octahedral>],
    ) {
        let streams = Self::streams(attributes, octahedral);
        let mut systems = Vec::new();
        for (old, new) in self.streams.iter().zip(&streams) {
            let mut of_stream = self.systems[old.first_channel..][..old.channels].to_vec();
            if old.channels > new.channels {
                of_stream.splice(..3, [NumberSystem::Integer; 2]);
            }
            systems.extend(of_stream);
        }
        (self.systems, self.streams) = (systems, streams);
    }
}

fn float_component(a: &Attribute, vertex: u32, component: usize) -> f32 {
    let b = &a.at(vertex)[4 * component..][..4];
    f32::from_le_bytes([b[0], b[1], b[2], b[3]])
}

fn integer_component(a: &Attribute, vertex: u32, component: usize) -> i32 {
    let size = a.component.size();
    let b = &a.at(vertex)[size * component..][..size];
    match a.component {
        Component::I8 => i32::from(b[0].cast_signed()),
        Component::U8 => i32::from(b[0]),
        Component::I16 => i32::from(i16::from_le_bytes([b[0], b[1]])),
        Component::U16 => i32::from(u16::from_le_bytes([b[0], b[1]])),
        Component::U32 | Component::F32 => i32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    }
}

/// Returns the number system that holds all values of a stream and in which vertices are closest to
/// those that they collapse onto, by the sum of the bit lengths of their distances.
fn best_system(
    simplified: &Simplified,
    channels: usize,
    value: impl Fn(u32, usize) -> f32 + Copy,
) -> NumberSystem {
    let vertices = simplified.mesh().vertex_count() as u32;
    let values = (0..vertices).flat_map(move |v| (0..channels).map(move |c| value(v, c)));
    let targets = simplified.collapses().targets();
    // A bit length and a sign for each channel of each collapse.
    let total_bits = |system: &NumberSystem| -> u64 {
        let collapses = (0..).zip(targets);
        let bits = |(v, &target): (u32, &u32)| {
            let index = |v, c| system.index(value(v, c));
            let distance = |c| index(v, c).abs_diff(index(target, c));
            (0..channels).map(|c| u64::from(33 - distance(c).leading_zeros())).sum::<u64>()
        };
        collapses.map(bits).sum()
    };
    let candidates = NumberSystem::candidates(&values);
    candidates.into_iter().min_by_key(total_bits).unwrap_or(NumberSystem::Float)
}
