//! Dropping what takes no part in any level of detail, and counting it.

use crate::{MeshParts, position_key};

/// Counts of what [`MeshParts::clean`] dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cleaning {
    /// Triangles with two corners at one position.
    pub degenerate_triangles: usize,
    /// Vertices that no remaining triangle uses.
    pub unreferenced_vertices: usize,
}

impl MeshParts {
    /// Drops what takes no part in a level of detail: triangles with two corners at one position,
    /// then vertices that no triangle uses. Says how many.
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there, a submesh a triangle that is not there, or a
    /// stream has too few bytes: whoever reads a file checks that first.
    pub fn clean(&mut self) -> Cleaning {
        clean(self)
    }
}

fn clean(parts: &mut MeshParts) -> Cleaning {
    let before = (parts.triangles.len(), parts.positions.len());
    let mut kept = Vec::with_capacity(parts.triangles.len());
    for submesh in &mut parts.submeshes {
        let first = kept.len();
        kept.extend(parts.triangles[submesh.triangles()].iter().copied().filter(|t| {
            let k = t.map(|v| position_key(parts.positions[v as usize]));
            k[0] != k[1] && k[1] != k[2] && k[2] != k[0]
        }));
        submesh.first_triangle = first as u32;
        submesh.triangle_count = (kept.len() - first) as u32;
    }
    parts.triangles = kept;

    let mut used = vec![false; parts.positions.len()];
    for t in &parts.triangles {
        for &v in t {
            used[v as usize] = true;
        }
    }
    let sources: Vec<u32> = (0..used.len() as u32).filter(|&v| used[v as usize]).collect();
    if sources.len() < used.len() {
        let mut new_index = vec![u32::MAX; used.len()];
        for (new, &old) in sources.iter().enumerate() {
            new_index[old as usize] = new as u32;
        }
        parts.positions = sources.iter().map(|&v| parts.positions[v as usize]).collect();
        parts.vertex_submesh = sources.iter().map(|&v| parts.vertex_submesh[v as usize]).collect();
        for a in &mut parts.attributes {
            *a = a.gathered(sources.iter().copied());
        }
        for t in &mut parts.triangles {
            *t = t.map(|v| new_index[v as usize]);
        }
    }
    Cleaning {
        degenerate_triangles: before.0 - parts.triangles.len(),
        unreferenced_vertices: before.1 - parts.positions.len(),
    }
}
