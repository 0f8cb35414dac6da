//! Vertices as a graphics device holds them: interleaved, one record of 32-bit words per vertex.

use crate::error::PlanError;
use lodc_mesh::Mesh;

/// All vertices of a mesh as records of equal length: the position (three words), then every
/// attribute stream, each filled up to whole words. Bytes are those of the mesh; nothing is
/// converted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VertexRecords {
    /// Words per vertex, at least 3.
    pub stride: usize,
    /// The records.
    pub words: Vec<u32>,
}

impl VertexRecords {
    /// Records of positions only: what Ripollés's thesis (2009) counts in chapters 3 and 5.
    #[must_use]
    pub fn positions(mesh: &Mesh) -> Self {
        let words = mesh.positions().iter().flatten().map(|c| c.to_bits()).collect();
        Self { stride: 3, words }
    }

    /// Records of positions and all attributes.
    ///
    /// # Errors
    /// If the words cannot be numbered with 32 bits.
    pub fn whole(mesh: &Mesh) -> Result<Self, PlanError> {
        let stride = 3 + mesh.attributes().iter().map(|a| a.stride().div_ceil(4)).sum::<usize>();
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
        }
        Ok(Self { stride, words })
    }

    /// The record of one vertex.
    #[must_use]
    pub fn at(&self, vertex: u32) -> &[u32] {
        &self.words[vertex as usize * self.stride..][..self.stride]
    }
}
