//! Charts: regions of a surface over which attributes are continuous, and the curves between them.

use lodc_mesh::{Mesh, NONE, PositionIds, Semantic};

/// Streams that have to agree at a position for two triangles to be of one chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Continuity {
    /// Texture coordinates and colours: what would show as a seam.
    Texture,
    /// Normals as well: a crease ends a chart.
    Shading,
}

impl Continuity {
    fn counts(self, semantic: &Semantic) -> bool {
        match semantic {
            Semantic::TexCoord(_) | Semantic::Color(_) => true,
            Semantic::Normal => self == Self::Shading,
            _ => false,
        }
    }
}

/// Returns the chart of each triangle: triangles of one submesh hang together at vertices whose
/// position and streams are bit for bit the same.
pub(crate) fn charts(mesh: &Mesh, continuity: Continuity) -> Vec<u32> {
    let class = classes(mesh, continuity);
    let mut parent: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    for t in mesh.triangles() {
        let roots = t.map(|v| find(&mut parent, class[v as usize]));
        let least = roots[0].min(roots[1]).min(roots[2]);
        for root in roots {
            parent[root as usize] = least;
        }
    }
    mesh.triangles().iter().map(|t| find(&mut parent, class[t[0] as usize])).collect()
}

/// For each vertex the first vertex that it is equal to.
fn classes(mesh: &Mesh, continuity: Continuity) -> Vec<u32> {
    let positions = PositionIds::new(mesh.positions());
    let streams: Vec<_> = mesh
        .attributes()
        .iter()
        .filter(|a| a.morph_target.is_none() && continuity.counts(&a.semantic))
        .collect();
    let key = |v: u32| (mesh.vertex_submesh()[v as usize], positions.of_vertex[v as usize]);
    let mut order: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    order.sort_unstable_by(|&a, &b| {
        let mut by = key(a).cmp(&key(b));
        for stream in &streams {
            by = by.then_with(|| stream.at(a).cmp(stream.at(b)));
        }
        by.then(a.cmp(&b))
    });
    let alike = |a: u32, b: u32| key(a) == key(b) && streams.iter().all(|s| s.at(a) == s.at(b));
    let mut class = vec![NONE; mesh.vertex_count()];
    for run in order.chunk_by(|&a, &b| alike(a, b)) {
        run.iter().for_each(|&v| class[v as usize] = run[0]);
    }
    class
}

fn find(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

/// Returns the curves of a surface as `3 * face + corner` of one side each: edges that one face has
/// alone, that more than two share, or where charts meet. Faces are given by positions.
pub(crate) fn curves(faces: &[[u32; 3]], chart: &[u32]) -> Vec<u32> {
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * faces.len());
    for (i, f) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], (3 * i + k) as u32));
        }
    }
    sides.sort_unstable();
    let inner = |run: &[([u32; 2], u32)]| {
        run.len() == 2 && chart[run[0].1 as usize / 3] == chart[run[1].1 as usize / 3]
    };
    let mut curves: Vec<u32> =
        sides.chunk_by(|a, b| a.0 == b.0).filter(|run| !inner(run)).map(|run| run[0].1).collect();
    curves.sort_unstable();
    curves
}
