//! What must hold of any view: it shows the right triangles, and it does not tear.

use super::{Shown, View, Views};
use crate::Failure;
use crate::first_difference;
use lodc_mesh::{Lod, OrientedTriangle, PositionIds, position_key};

/// Three coordinates as bits.
type Key = [u32; 3];

/// Both ends, the smaller first; whether they were in this order; the vertices.
type Edge = (Key, Key, bool, [u32; 2]);

impl Views<'_> {
    /// The first thing that is wrong with what a view shows: without morphing, each triangle of LOD
    /// 0 with every corner resolved at its own LOD by the plain sequence (and at one LOD
    /// everywhere, the reference itself); always, that no edge lies open that the input's border
    /// does not explain.
    pub(super) fn judge(
        &self,
        view: &View,
        shown: &Shown,
        indices: &[u32],
        positions: &PositionIds,
    ) -> Option<Failure> {
        let (mesh, collapses) = (self.simplified.mesh(), self.simplified.collapses());
        let corners =
            || mesh.triangles().as_flattened().iter().map(|&v| shown.states[v as usize].lod);
        let coarsest = collapses.floor(Lod(corners().max().unwrap_or(0)));
        if !view.morph {
            let drawn = self.drawn(indices, shown);
            let mut truth = Vec::with_capacity(drawn.len());
            for (s, submesh) in mesh.submeshes().iter().enumerate() {
                for t in &mesh.triangles()[submesh.triangles()] {
                    let corners = t.map(|v| {
                        let lod = collapses.floor(Lod(shown.states[v as usize].lod));
                        collapses.resolve(v, lod)
                    });
                    let [a, b, c] = corners.map(|v| positions.of_vertex[v as usize]);
                    if a != b && b != c && c != a {
                        truth.push(OrientedTriangle::new(s as u32, corners));
                    }
                }
            }
            let same = corners().all(|lod| collapses.floor(Lod(lod)) == coarsest);
            if same
                && let Some(failure) = first_difference(
                    coarsest,
                    self.simplified.triangles_at_with(coarsest, positions),
                    drawn.clone(),
                )
            {
                return Some(failure);
            }
            if let Some(failure) = first_difference(coarsest, truth, drawn) {
                return Some(failure);
            }
        }
        self.torn(shown, indices).map(|(edge, surplus)| Failure::Torn {
            lod: coarsest,
            edge,
            surplus,
        })
    }

    fn drawn(&self, indices: &[u32], shown: &Shown) -> Vec<OrientedTriangle> {
        let submesh = self.simplified.mesh().vertex_submesh();
        let triangle = |t: &[u32]| {
            OrientedTriangle::new(
                submesh[t[0] as usize],
                [t[0], t[1], t[2]].map(|v| shown.states[v as usize].entry),
            )
        };
        indices.chunks_exact(3).map(triangle).collect()
    }

    /// An edge that is used more often in one direction than in the other, and not because the
    /// input has a border there.
    pub(super) fn torn(&self, shown: &Shown, indices: &[u32]) -> Option<([[f32; 3]; 2], i64)> {
        let stride = self.records.stride;
        let at = |words: &[u32], v: u32| -> Key {
            let at = v as usize * stride;
            position_key([words[at], words[at + 1], words[at + 2]].map(f32::from_bits))
        };
        let mesh = self.simplified.mesh();
        // Every edge of LOD 0 counts once with its place in the view, every edge drawn counts once
        // the other way.
        let mut edges: Vec<(Key, Key, i64)> = Vec::new();
        let mut add = |a: Key, b: Key, sign: i64| match a.cmp(&b) {
            std::cmp::Ordering::Less => edges.push((a, b, sign)),
            std::cmp::Ordering::Greater => edges.push((b, a, -sign)),
            std::cmp::Ordering::Equal => {}
        };
        for t in border(mesh.triangles(), |v| at(&self.records.words, v)) {
            add(at(&shown.vertices, t[0]), at(&shown.vertices, t[1]), -1);
        }
        for t in indices.chunks_exact(3) {
            for i in 0..3 {
                add(at(&shown.vertices, t[i]), at(&shown.vertices, t[(i + 1) % 3]), 1);
            }
        }
        surplus(&mut edges)
            .first()
            .map(|&(a, b, n)| ([a.map(f32::from_bits), b.map(f32::from_bits)], n))
    }
}

/// Directed edges of triangles that no edge in the opposite direction answers, as pairs of
/// vertices.
fn border(triangles: &[[u32; 3]], key: impl Fn(u32) -> Key) -> Vec<[u32; 2]> {
    let mut edges: Vec<Edge> = Vec::with_capacity(3 * triangles.len());
    for t in triangles {
        for i in 0..3 {
            let [a, b] = [t[i], t[(i + 1) % 3]];
            let (ka, kb) = (key(a), key(b));
            edges.push((ka.min(kb), ka.max(kb), ka < kb, [a, b]));
        }
    }
    edges.sort_unstable();
    let mut open = Vec::new();
    for same in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let (there, back): (Vec<&Edge>, Vec<&Edge>) = same.iter().partition(|e| e.2);
        let (more, fewer) =
            if there.len() > back.len() { (there, back.len()) } else { (back, there.len()) };
        open.extend(more.into_iter().skip(fewer).map(|e| e.3));
    }
    open
}

/// Edges whose signs do not add up to 0.
fn surplus(edges: &mut [(Key, Key, i64)]) -> Vec<(Key, Key, i64)> {
    edges.sort_unstable();
    let sums = edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
    sums.map(|same| (same[0].0, same[0].1, same.iter().map(|e| e.2).sum()))
        .filter(|e| e.2 != 0)
        .collect()
}
