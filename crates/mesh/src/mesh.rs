//! A triangle mesh with submeshes, valid by construction.

use crate::motion::MotionStreams;
use crate::{Attribute, Csr, PositionIds, Submesh, position_key};

/// Parts of a mesh before they are known to be valid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshParts {
    /// One per vertex.
    pub positions: Vec<[f32; 3]>,
    /// The submesh of each vertex. A vertex belongs to one submesh only.
    pub vertex_submesh: Vec<u32>,
    /// Streams over all vertices.
    pub attributes: Vec<Attribute>,
    /// Vertices of each triangle, counter-clockwise from outside; submesh by submesh.
    pub triangles: Vec<[u32; 3]>,
    /// Consecutive runs that cover all triangles, in order.
    pub submeshes: Vec<Submesh>,
}

impl MeshParts {
    /// The streams by which the vertices move.
    pub(crate) fn motion(&self) -> MotionStreams<'_> {
        MotionStreams::of(&self.attributes, &self.submeshes, &self.vertex_submesh)
    }

    /// Numbers the positions of the vertices, as [`Mesh::position_ids`] does.
    #[must_use]
    pub fn position_ids(&self) -> PositionIds {
        PositionIds::in_motion(&self.positions, &self.motion())
    }
}

/// A valid triangle mesh: positions are finite, indices are in range, no triangle has two corners
/// at one position at rest and in motion ([`Mesh::position_ids`]), every vertex belongs to one
/// submesh, and every stream has bytes for every vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh(MeshParts);

impl Mesh {
    /// Number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.0.positions.len()
    }
    /// Positions, one per vertex.
    #[must_use]
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.0.positions
    }
    /// Attribute streams.
    #[must_use]
    pub fn attributes(&self) -> &[Attribute] {
        &self.0.attributes
    }
    /// Triangles, submesh by submesh.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.0.triangles
    }
    /// Submeshes, covering all triangles in order.
    #[must_use]
    pub fn submeshes(&self) -> &[Submesh] {
        &self.0.submeshes
    }
    /// The submesh of each vertex.
    #[must_use]
    pub fn vertex_submesh(&self) -> &[u32] {
        &self.0.vertex_submesh
    }
    /// Numbers the positions of its vertices, at rest and in motion: what is at one position in all
    /// shapes that morph targets and joints can give the mesh has one number.
    #[must_use]
    pub fn position_ids(&self) -> PositionIds {
        self.0.position_ids()
    }
    /// Returns for each attribute stream the submeshes that have it: row `i` holds those of stream
    /// `i`, rising.
    #[must_use]
    pub fn users_of_streams(&self) -> Csr {
        let numbered = self.submeshes().iter().zip(0..);
        let uses = numbered.flat_map(|(s, number)| s.attributes.iter().map(move |&a| (a, number)));
        Csr::new(self.attributes().len(), uses)
    }
    /// The parts, for changing them.
    #[must_use]
    pub fn into_parts(self) -> MeshParts {
        self.0
    }
    /// Corners of the bounding box: smallest and largest coordinates (zeros without vertices).
    #[must_use]
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let mut positions = self.0.positions.iter();
        let Some(&first) = positions.next() else { return ([0.0; 3], [0.0; 3]) };
        positions.fold((first, first), |(lo, hi), p| {
            (std::array::from_fn(|i| lo[i].min(p[i])), std::array::from_fn(|i| hi[i].max(p[i])))
        })
    }
    /// Length of the bounding box's diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        let (lo, hi) = self.bounds();
        (0..3).map(|i| (f64::from(hi[i]) - f64::from(lo[i])).powi(2)).sum::<f64>().sqrt()
    }
}

impl MeshParts {
    /// One submesh of all triangles, whose vertices have all attributes.
    #[must_use]
    pub fn of_arrays(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        attributes: Vec<Attribute>,
    ) -> Self {
        let submesh = Submesh {
            first_triangle: 0,
            triangle_count: triangles.len() as u32,
            attributes: (0..attributes.len() as u32).collect(),
        };
        let vertex_submesh = vec![0; positions.len()];
        Self { positions, vertex_submesh, attributes, triangles, submeshes: vec![submesh] }
    }

    /// Checks everything that a [`Mesh`] promises, but that no triangle is degenerate.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), MeshError> {
        let without_degenerate = false;
        check(self, without_degenerate)
    }
}

impl TryFrom<MeshParts> for Mesh {
    type Error = MeshError;

    fn try_from(parts: MeshParts) -> Result<Self, MeshError> {
        let without_degenerate = true;
        check(&parts, without_degenerate)?;
        Ok(Self(parts))
    }
}

fn check(parts: &MeshParts, without_degenerate: bool) -> Result<(), MeshError> {
    let vertices = parts.positions.len();
    // Four times an index must fit a `u32`: corners are numbered 4 × triangle + corner.
    let limit = u32::MAX as usize / 4;
    if vertices > limit || parts.triangles.len() > limit {
        return Err(MeshError::TooLarge { vertices, triangles: parts.triangles.len() });
    }
    if let Some(vertex) = parts.positions.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(MeshError::NotFinite { vertex });
    }
    if parts.vertex_submesh.len() != vertices {
        return Err(MeshError::VertexSubmesh { vertex: parts.vertex_submesh.len().min(vertices) });
    }
    if let Some(vertex) =
        parts.vertex_submesh.iter().position(|&s| s as usize >= parts.submeshes.len())
    {
        return Err(MeshError::VertexSubmesh { vertex });
    }
    for (attribute, a) in parts.attributes.iter().enumerate() {
        if !(1..=16).contains(&a.components) || a.bytes.len() != vertices * a.stride() {
            return Err(MeshError::AttributeLength { attribute, bytes: a.bytes.len(), vertices });
        }
    }
    let motion = parts.motion();
    let mut next = 0;
    for (submesh, s) in parts.submeshes.iter().enumerate() {
        let end = u64::from(s.first_triangle) + u64::from(s.triangle_count);
        if s.first_triangle as usize != next || end > parts.triangles.len() as u64 {
            return Err(MeshError::SubmeshRange { submesh });
        }
        if s.attributes.iter().any(|&a| a as usize >= parts.attributes.len()) {
            return Err(MeshError::SubmeshAttribute { submesh });
        }
        next = s.triangles().end;
        for (i, t) in parts.triangles[s.triangles()].iter().enumerate() {
            let triangle = s.first_triangle as usize + i;
            if t.iter().any(|&v| v as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle });
            }
            if t.iter().any(|&v| parts.vertex_submesh[v as usize] as usize != submesh) {
                return Err(MeshError::SharedVertex { triangle });
            }
            let key = t.map(|v| position_key(parts.positions[v as usize]));
            let meet = |[i, j]: [usize; 2]| key[i] == key[j] && motion.move_alike(t[i], t[j]);
            if without_degenerate && [[0, 1], [1, 2], [2, 0]].into_iter().any(meet) {
                return Err(MeshError::Degenerate { triangle });
            }
        }
    }
    if next != parts.triangles.len() {
        return Err(MeshError::SubmeshRange { submesh: parts.submeshes.len() });
    }
    Ok(())
}

/// Why parts are not a mesh. Each variant names the first offender.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// More vertices or triangles than `u32` arithmetic allows.
    #[error("{vertices} vertices and {triangles} triangles are more than 2^30")]
    TooLarge {
        /// Vertices given.
        vertices: usize,
        /// Triangles given.
        triangles: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// A vertex has no submesh, or one that does not exist.
    #[error("vertex {vertex} has no valid submesh")]
    VertexSubmesh {
        /// The vertex.
        vertex: usize,
    },
    /// A stream's bytes do not match the number of vertices.
    #[error("attribute {attribute} has {bytes} bytes, which do not fit {vertices} vertices")]
    AttributeLength {
        /// The stream.
        attribute: usize,
        /// Its bytes.
        bytes: usize,
        /// The mesh's vertices.
        vertices: usize,
    },
    /// Submeshes do not cover the triangles one after another.
    #[error("submesh {submesh} does not follow the one before it")]
    SubmeshRange {
        /// The submesh.
        submesh: usize,
    },
    /// A submesh names a stream that does not exist.
    #[error("submesh {submesh} names an attribute that is not there")]
    SubmeshAttribute {
        /// The submesh.
        submesh: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names a vertex that is not there")]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
    },
    /// A triangle uses a vertex of another submesh.
    #[error("triangle {triangle} uses a vertex of another submesh")]
    SharedVertex {
        /// The triangle.
        triangle: usize,
    },
    /// A triangle has two corners at one position.
    #[error("triangle {triangle} has two corners at one position")]
    Degenerate {
        /// The triangle.
        triangle: usize,
    },
}
