//! Vertex attributes as they came in: raw bytes with a meaning, given back bit for bit.

/// Meaning of a stream of vertex data.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Semantic {
    /// The position in its source format, present only where that is not three `f32` (quantised
    /// meshes).
    Position,
    /// Surface normal.
    Normal,
    /// Tangent, with handedness in the fourth component.
    Tangent,
    /// Texture coordinates, by set.
    TexCoord(u32),
    /// Vertex colour, by set.
    Color(u32),
    /// Joint indices for skinning, by set.
    Joints(u32),
    /// Joint weights for skinning, by set.
    Weights(u32),
    /// Application-specific data, by its name in the source file.
    Custom(String),
}

/// The type of one component of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Component {
    /// Signed 8-bit integer.
    I8,
    /// Unsigned 8-bit integer.
    U8,
    /// Signed 16-bit integer, little-endian.
    I16,
    /// Unsigned 16-bit integer, little-endian.
    U16,
    /// Unsigned 32-bit integer, little-endian.
    U32,
    /// IEEE 754 binary32, little-endian.
    F32,
}

impl Component {
    /// Bytes of one component.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// One stream: `stride()` bytes for every vertex of the mesh, tightly packed. Vertices of submeshes
/// that do not use the stream hold zeros.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// Meaning of the stream.
    pub semantic: Semantic,
    /// `Some(t)`: the stream holds the deltas of morph target `t` for this semantic (`Position`
    /// included).
    pub morph_target: Option<u32>,
    /// Type of the components.
    pub component: Component,
    /// Components per vertex, 1 to 16.
    pub components: u8,
    /// True if integers stand for fractions (glTF 2.0, 3.6.2.2).
    pub normalized: bool,
    /// The bytes, `stride() * vertices` of them.
    pub bytes: Vec<u8>,
}

impl Attribute {
    /// Bytes per vertex.
    #[must_use]
    pub fn stride(&self) -> usize {
        self.component.size() * usize::from(self.components)
    }

    /// Returns whether the stream decides the position of a vertex, at rest or moved by joints and
    /// morph targets. A vertex that moves to another's position takes these streams from it.
    #[must_use]
    pub fn is_spatial(&self) -> bool {
        matches!(self.semantic, Semantic::Position | Semantic::Joints(_) | Semantic::Weights(_))
    }

    /// Returns whether the stream moves vertices by themselves: joints, their weights, and deltas
    /// of positions.
    #[must_use]
    pub fn moves(&self) -> bool {
        match self.semantic {
            Semantic::Position => self.morph_target.is_some(),
            Semantic::Joints(_) | Semantic::Weights(_) => self.morph_target.is_none(),
            _ => false,
        }
    }

    /// The bytes of one vertex.
    #[must_use]
    pub fn at(&self, vertex: u32) -> &[u8] {
        let stride = self.stride();
        &self.bytes[vertex as usize * stride..][..stride]
    }

    /// One component as a number: fractions where `normalized`, the integer's value otherwise.
    #[must_use]
    pub fn value(&self, vertex: u32, component: usize) -> f32 {
        let size = self.component.size();
        let b = &self.at(vertex)[component * size..][..size];
        let unit = |v: f32, max: f32| if self.normalized { (v / max).max(-1.0) } else { v };
        match self.component {
            Component::I8 => unit(f32::from(i8::from_le_bytes([b[0]])), 127.0),
            Component::U8 => unit(f32::from(b[0]), 255.0),
            Component::I16 => unit(f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Component::U16 => unit(f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            #[expect(
                clippy::cast_precision_loss,
                reason = "an attribute as a number is approximate by nature"
            )]
            Component::U32 => {
                unit(u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, u32::MAX as f32)
            }
            Component::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }

    /// A stream of `N` floats for every vertex, `N` from 1 to 16.
    #[must_use]
    pub fn of_floats<const N: usize>(semantic: Semantic, values: &[[f32; N]]) -> Self {
        Self {
            semantic,
            morph_target: None,
            component: Component::F32,
            components: N as u8,
            normalized: false,
            bytes: values.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }

    /// All vertices as `N` numbers each, as [`Self::value`] has them; none if the stream has
    /// another number of components.
    #[must_use]
    pub fn floats<const N: usize>(&self) -> Option<Vec<[f32; N]>> {
        if usize::from(self.components) != N {
            return None;
        }
        let vertices = (self.bytes.len() / self.stride().max(1)) as u32;
        Some((0..vertices).map(|v| std::array::from_fn(|i| self.value(v, i))).collect())
    }

    /// The same stream with vertex `i` taken from `sources[i]`.
    #[must_use]
    pub fn gathered(&self, sources: impl ExactSizeIterator<Item = u32>) -> Self {
        let mut bytes = Vec::with_capacity(sources.len() * self.stride());
        for source in sources {
            bytes.extend_from_slice(self.at(source));
        }
        Self { bytes, ..self.described() }
    }

    /// The stream's description without its bytes.
    #[must_use]
    pub fn described(&self) -> Self {
        Self {
            semantic: self.semantic.clone(),
            morph_target: self.morph_target,
            component: self.component,
            components: self.components,
            normalized: self.normalized,
            bytes: Vec::new(),
        }
    }
}
