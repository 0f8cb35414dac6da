//! Explicit face lists: of the star of a high-valence vertex, only the triangles that are
//! transferred are coded, by their numbers.
//!
//! A high-valence vertex may hand over a few triangles at each of thousands of splits. If every
//! triangle of its star had a bit, the whole star would be visited each time. So the split is coded
//! as if the named triangles were the whole star: new triangles are coded in their link, and all
//! are transferred.
//!
//! ```text
//!     \   |   /                        named: t, u
//!   --- center --- p                    link of the explicit face list: p q r
//!     /   | \ t \
//!    /    |u  \  q                     left apex r and right apex p are the first and the last
//!         r                            of it, however many triangles the high-valence vertex has
//! ```

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::coder::Coder;
use crate::entropy::integer_codes::GammaCode;
use crate::invalid::InvalidStream;
use crate::partial_mesh::mesh::PartialMesh;
use crate::partial_mesh::star::{StarFace, arrange_in_fans};
use crate::source::split_source::SplitSource;
use crate::vertex_split::neighbourhood::SplitNeighbourhood;

/// Contexts of explicit face lists.
#[derive(Clone, Debug)]
pub(crate) struct FaceListContexts {
    /// An explicit face list follows.
    pub(crate) is_named: AdaptiveBit,
    /// The number of triangles that are named.
    pub(crate) size: GammaCode,
}

impl FaceListContexts {
    pub(crate) const NEW: Self = Self { is_named: AdaptiveBit::NEW, size: GammaCode::NEW };
}

impl SplitNeighbourhood {
    /// Collects the star of the parent. One of more than `large_star` triangles may be named: then
    /// only its named triangles are coded and collected.
    #[inline]
    pub(crate) fn code_star<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut FaceListContexts,
        mesh: &PartialMesh,
        large_star: u32,
    ) -> Result<(), InvalidStream> {
        if mesh.corners.count(self.parent) > large_star {
            let wanted = source.face_list(self.new);
            if coder.bit(&mut contexts.is_named, wanted.is_some()) {
                return self.code_named_star(coder, contexts, mesh, wanted.unwrap_or_default());
            }
        }
        self.collect_star(mesh);
        Ok(())
    }

    #[cold]
    fn code_named_star<C: Coder>(
        &mut self,
        coder: &mut C,
        contexts: &mut FaceListContexts,
        mesh: &PartialMesh,
        wanted: &[u32],
    ) -> Result<(), InvalidStream> {
        let face_at = |face: u32| mesh.star_face(face, self.parent);
        let mut wanted: Vec<StarFace> = wanted.iter().filter_map(|&face| face_at(face)).collect();
        arrange_in_fans(&mut wanted);
        let size = contexts.size.code(coder, wanted.len() as u32);
        if size > mesh.corners.count(self.parent) {
            return Err(InvalidStream("names more triangles than a star has"));
        }
        self.star.clear();
        for i in 0..size as usize {
            let face = wanted.get(i).map_or(0, |face| face.face());
            let face = face_at(coder.uniform(mesh.face_count(), face));
            self.star.push(face.ok_or(InvalidStream("names a triangle of another star"))?);
        }
        if !C::ENCODES && !are_different(&self.star) {
            return Err(InvalidStream("names a triangle twice"));
        }
        self.finish_named_star();
        Ok(())
    }
}

/// Returns whether all triangles are different.
fn are_different(star: &[StarFace]) -> bool {
    let mut corners: Vec<u32> = star.iter().map(|face| face.corner).collect();
    corners.sort_unstable();
    corners.windows(2).all(|pair| pair[0] != pair[1])
}
