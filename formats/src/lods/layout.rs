//! What a vertex of an object is made of: streams, their channels, and the numbers that stand for
//! bytes.

use super::numbers::System;
use super::values::{Prediction, Stream};
use lodc_mesh::{Attribute, Component, Mesh, Semantic, Simplified};

/// The systems of numbers of an object's streams: positions first, then its attributes. One for
/// each channel.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) systems: Vec<System>,
    pub(super) streams: Vec<Stream>,
}

impl Layout {
    /// Streams of a mesh with such attributes, their channels numbered; systems are still to be
    /// chosen.
    pub(super) fn streams(attributes: &[Attribute]) -> Vec<Stream> {
        let mut first = 3;
        let mut streams = vec![Stream { first: 0, channels: 3, prediction: Prediction::Smooth }];
        for a in attributes {
            let channels = usize::from(a.components);
            let prediction = match (&a.semantic, a.morph_target) {
                (Semantic::Normal | Semantic::Tangent, None)
                    if a.component == Component::F32 && channels >= 3 =>
                {
                    Prediction::Direction
                }
                (Semantic::Joints(_) | Semantic::Weights(_) | Semantic::Custom(_), _) => {
                    Prediction::Survivor
                }
                _ => Prediction::Smooth,
            };
            streams.push(Stream { first, channels, prediction });
            first += channels;
        }
        streams
    }

    /// Chooses for every stream the system in which it is told most briefly.
    pub(super) fn choose(simplified: &Simplified) -> Self {
        let mesh = simplified.mesh();
        let streams = Self::streams(mesh.attributes());
        let positions = |v: u32, c: usize| mesh.positions()[v as usize][c];
        let mut systems = vec![best(simplified, 3, positions); 3];
        for a in mesh.attributes() {
            let channels = usize::from(a.components);
            let system = match a.component {
                Component::F32 => best(simplified, channels, |v, c| float(a, v, c)),
                _ => System::Integer,
            };
            systems.extend(std::iter::repeat_n(system, channels));
        }
        Self { systems, streams }
    }

    /// The numbers of all vertices, by arrival: the last vertex first.
    pub(super) fn index(&self, mesh: &Mesh) -> Vec<i32> {
        let vertices = mesh.vertex_count();
        let mut index = Vec::with_capacity(vertices * self.systems.len());
        for v in (0..vertices as u32).rev() {
            let position = mesh.positions()[v as usize];
            index.extend(position.iter().zip(&self.systems).map(|(&p, s)| s.index(p)));
            for (a, stream) in mesh.attributes().iter().zip(&self.streams[1..]) {
                for c in 0..stream.channels {
                    index.push(match a.component {
                        Component::F32 => self.systems[stream.first + c].index(float(a, v, c)),
                        _ => integer(a, v, c),
                    });
                }
            }
        }
        index
    }

    /// Appends the bytes that a channel's number stands for.
    pub(super) fn put(
        &self,
        component: Component,
        channel: usize,
        index: i32,
        bytes: &mut Vec<u8>,
    ) {
        match component {
            Component::F32 => bytes.extend(self.systems[channel].value(index).to_le_bytes()),
            _ => bytes.extend_from_slice(&index.to_le_bytes()[..component.size()]),
        }
    }
}

fn float(a: &Attribute, vertex: u32, channel: usize) -> f32 {
    let b = &a.at(vertex)[4 * channel..][..4];
    f32::from_le_bytes([b[0], b[1], b[2], b[3]])
}

fn integer(a: &Attribute, vertex: u32, channel: usize) -> i32 {
    let size = a.component.size();
    let b = &a.at(vertex)[size * channel..][..size];
    match a.component {
        Component::I8 => i32::from(b[0].cast_signed()),
        Component::U8 => i32::from(b[0]),
        Component::I16 => i32::from(i16::from_le_bytes([b[0], b[1]])),
        Component::U16 => i32::from(u16::from_le_bytes([b[0], b[1]])),
        Component::U32 | Component::F32 => i32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    }
}

/// The system that has all numbers of a stream and in which neighbours lie closest together.
fn best(
    simplified: &Simplified,
    channels: usize,
    value: impl Fn(u32, usize) -> f32 + Copy,
) -> System {
    let vertices = simplified.mesh().vertex_count() as u32;
    let values = (0..vertices).flat_map(move |v| (0..channels).map(move |c| value(v, c)));
    let targets = simplified.collapses().targets();
    let bits = |system: &System| -> u64 {
        let pairs = (0..).zip(targets);
        let far = |(v, &t): (u32, &u32)| {
            let far = |c| {
                u64::from(
                    33 - system
                        .index(value(v, c))
                        .abs_diff(system.index(value(t, c)))
                        .leading_zeros(),
                )
            };
            (0..channels).map(far).sum::<u64>()
        };
        pairs.map(far).sum()
    };
    System::candidates(&values).into_iter().min_by_key(bits).unwrap_or(System::Float)
}
