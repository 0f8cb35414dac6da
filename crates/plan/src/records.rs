//! Vertices as a graphics device holds them: interleaved, one record of 32-bit words per vertex.

use crate::error::PlanError;
use lodc_mesh::{Attribute, Mesh, PositionIds};

/// All vertices of a mesh as records of equal length: the position (three words), then every
/// attribute stream, each filled up to whole words. Bytes are those of the mesh; nothing is
/// converted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VertexRecords {
    /// Words per vertex, at least 3.
    pub stride: usize,
    /// The word with the number of a vertex's position, if the mesh has vertices that lie together
    /// at rest and part in motion; else 0.
    pub place: usize,
    /// The records.
    pub words: Vec<u32>,
}

impl VertexRecords {
    /// Records of positions only: what Ripollés's thesis (2009) counts in chapters 3 and 5.
    #[must_use]
    pub fn positions(mesh: &Mesh) -> Self {
        let words = mesh.positions().iter().flatten().map(|c| c.to_bits()).collect();
        Self { stride: 3, place: 0, words }
    }

    /// Records of positions and all attributes, and the numbers of positions where coordinates do
    /// not tell them apart.
    ///
    /// # Errors
    /// If the words cannot be numbered with 32 bits.
    pub fn whole(mesh: &Mesh) -> Result<Self, PlanError> {
        let values = 3 + mesh.attributes().iter().map(|a| a.stride().div_ceil(4)).sum::<usize>();
        let places = parted(mesh);
        let (stride, place) = if places.is_some() { (values + 1, values) } else { (values, 0) };
        let count = (stride * mesh.vertex_count()) as u64;
        if count > u64::from(u32::MAX) / 4 {
            return Err(PlanError::TooLarge { what: "the vertex records", words: count });
        }
        let mut words = Vec::with_capacity(count as usize);
        for (v, position) in mesh.positions().iter().enumerate() {
            words.extend(position.map(f32::to_bits));
            for attribute in mesh.attributes() {
                words.extend(attribute.at(v as u32).chunks(4).map(|bytes| {
                    let mut word = [0; 4];
                    word[..bytes.len()].copy_from_slice(bytes);
                    u32::from_le_bytes(word)
                }));
            }
            words.extend(places.as_ref().map(|places| places.of_vertex[v]));
        }
        Ok(Self { stride, place, words })
    }

    /// The record of one vertex.
    #[must_use]
    pub fn at(&self, vertex: u32) -> &[u32] {
        &self.words[vertex as usize * self.stride..][..self.stride]
    }
}

/// The positions of a mesh if several of them lie together at rest; else none.
fn parted(mesh: &Mesh) -> Option<PositionIds> {
    let moves = mesh.attributes().iter().any(Attribute::moves);
    let positions = moves.then(|| mesh.position_ids())?;
    (positions.len() > PositionIds::new(mesh.positions()).len()).then_some(positions)
}
