//! Checks that no triangle of a shipped level is turned over, compared with its source.
//!
//! Edges of triangles, each in its direction, add up to the border of a surface: two faces that
//! face the same way cancel out at the edge between them. A level is its source with vertices
//! moved, so its border is the source's with vertices moved: nothing where the source has none. A
//! face that is turned over leaves its edges twice.

use glam::{DVec3, Vec3};
use lodc_measure::{Surface, TriangleTree};
use lodc_mesh::{Mesh, NONE, PositionIds, position_key};

/// A position, bit for bit; the sign of a zero has no part in it.
type Key = [u32; 3];

/// How the triangles of an object face.
pub(super) struct Facing {
    /// The positions on its border, rising; none if the object is closed.
    border: Vec<Key>,
    /// How often an edge is there more in one direction than in the other, at most; at least once.
    max_surplus: u32,
    /// Every triangle: its positions, rising, and whether an even permutation gives its own order.
    triangles: Vec<([Key; 3], bool)>,
    tree: TriangleTree,
}

/// How the vertices of a level came out of its source's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moved {
    /// To positions that the source has.
    ToPositions,
    /// Anywhere near the source.
    Freely,
    /// Into units of their own.
    IntoOtherUnits,
}

impl Facing {
    pub(super) fn of(mesh: &Mesh) -> Self {
        let key = |v: u32| key(mesh, v);
        let ids = PositionIds::new(mesh.positions());
        let edges = border(mesh, &ids);
        let max_surplus = edges.iter().map(|edge| edge.net.unsigned_abs()).max().unwrap_or(1);
        let mut border: Vec<Key> = edges
            .iter()
            .flat_map(|edge| edge.ends)
            .map(|id| key(ids.first_vertex[id as usize]))
            .collect();
        border.sort_unstable();
        border.dedup();
        let mut triangles: Vec<_> = mesh.triangles().iter().map(|t| sorted(t.map(key))).collect();
        triangles.sort_unstable();
        triangles.dedup();
        let positions = mesh.positions().iter().map(|&p| p.into()).collect();
        let surface =
            Surface { positions, triangles: mesh.triangles().to_vec(), ..Surface::default() };
        Self { border, max_surplus, triangles, tree: surface.tree() }
    }

    /// Returns whether no edge is on the border.
    pub(super) fn is_closed(&self) -> bool {
        self.border.is_empty()
    }

    /// Returns a triangle of a level that is turned over. A closed source decides it; of others,
    /// edges inside of the source and edges that are there more often in one direction than any of
    /// the source are doubted, and a face there has to look away from the source next to it.
    pub(super) fn turned_over(&self, level: &Mesh, moved: Moved) -> Option<usize> {
        if !self.is_closed() && moved == Moved::IntoOtherUnits {
            return None;
        }
        let ids = PositionIds::new(level.positions());
        let is_on_border = |id: u32| {
            let key = key(level, ids.first_vertex[id as usize]);
            moved != Moved::ToPositions || self.border.binary_search(&key).is_ok()
        };
        let mut doubtful = border(level, &ids);
        if !self.is_closed() {
            doubtful.retain(|edge| {
                edge.net.unsigned_abs() > self.max_surplus
                    || !edge.ends.iter().all(|&id| is_on_border(id))
            });
        }
        let doubtful_edges = |t: &[u32; 3]| {
            let ends = edges(t.map(|v| ids.of_vertex[v as usize])).map(|edge| edge.ends);
            ends.iter()
                .filter(|ends| doubtful.binary_search_by_key(*ends, |e| e.ends).is_ok())
                .count()
        };
        let is_turned = |&(t, doubtful_edges): &(usize, usize)| {
            doubtful_edges > 0 && (self.is_closed() || self.looks_away(level, t))
        };
        let triangles = level.triangles().iter().map(doubtful_edges).enumerate();
        let turned_over = triangles
            .filter(is_turned)
            .max_by_key(|&(t, doubtful_edges)| (doubtful_edges, usize::MAX - t));
        let of_source = || {
            let is_turned = |t: &[u32; 3]| {
                let (positions, is_even) = sorted(t.map(|v| key(level, v)));
                let has = |way| self.triangles.binary_search(&(positions, way)).is_ok();
                has(!is_even) && !has(is_even)
            };
            level.triangles().iter().position(is_turned)
        };
        let keeps_positions = moved == Moved::ToPositions && !self.is_closed();
        turned_over.map(|(t, _)| t).or_else(|| if keeps_positions { of_source() } else { None })
    }

    /// Returns whether a triangle looks another way than the source next to its middle.
    fn looks_away(&self, level: &Mesh, triangle: usize) -> bool {
        let position = |v: u32| Vec3::from(level.positions()[v as usize]).as_dvec3();
        let corners = level.triangles()[triangle].map(position);
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let nearest = self.tree.nearest_triangle(middle, NONE).triangle;
        nearest != NONE && normal(corners).dot(normal(self.tree.corners_of(nearest))) < 0.0
    }
}

/// An edge between two positions, and how often more in one direction than in the other.
struct Edge {
    /// Numbers of positions, rising.
    ends: [u32; 2],
    net: i32,
}

fn edges([a, b, c]: [u32; 3]) -> [Edge; 3] {
    [[a, b], [b, c], [c, a]].map(|[from, to]| match from < to {
        true => Edge { ends: [from, to], net: 1 },
        false => Edge { ends: [to, from], net: -1 },
    })
}

/// The edges of a mesh that do not cancel out, by their ends.
fn border(mesh: &Mesh, ids: &PositionIds) -> Vec<Edge> {
    let of = |t: &[u32; 3]| edges(t.map(|v| ids.of_vertex[v as usize]));
    let mut all: Vec<Edge> = mesh.triangles().iter().flat_map(of).collect();
    all.retain(|edge| edge.ends[0] != edge.ends[1]);
    all.sort_unstable_by_key(|edge| edge.ends);
    all.dedup_by(|next, edge| {
        let is_same = next.ends == edge.ends;
        edge.net += if is_same { next.net } else { 0 };
        is_same
    });
    all.retain(|edge| edge.net != 0);
    all
}

fn key(mesh: &Mesh, vertex: u32) -> Key {
    position_key(mesh.positions()[vertex as usize])
}

/// Sorts positions. Returns whether an even number of them changed places.
fn sorted(mut positions: [Key; 3]) -> ([Key; 3], bool) {
    let mut is_even = true;
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if positions[i] > positions[j] {
            positions.swap(i, j);
            is_even = !is_even;
        }
    }
    (positions, is_even)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::{Lod, Simplified};
    use lodc_simplify::{Options, simplify};

    /// Triangles of meshes whose every triangle is turned.
    const MOST: usize = 700;

    /// Where as few triangles were turned in all, most levels have but one or two.
    const FEW: usize = 20;

    fn level(simplified: &Simplified, lod: Lod) -> Mesh {
        let mut parts = simplified.mesh().clone().into_parts();
        let map = simplified.collapses().resolve_all(lod);
        parts.triangles.iter_mut().for_each(|t| *t = t.map(|v| map[v as usize]));
        parts.clean();
        Mesh::try_from(parts).expect("a level is a mesh")
    }

    fn turned_over(mesh: &Mesh, triangle: usize) -> Mesh {
        let mut parts = mesh.clone().into_parts();
        parts.triangles[triangle].swap(1, 2);
        Mesh::try_from(parts).expect("a mesh")
    }

    #[test]
    fn each_triangle_that_is_turned_over_is_found() {
        let shapes = lodc_fixtures::ALL.iter().map(|(name, make)| (name, make()));
        for (name, mesh) in shapes.filter(|(_, mesh)| mesh.triangles().len() <= MOST) {
            let simplified = simplify(&mesh, &Options::DEFAULT, &|_, _| {});
            let facing = Facing::of(&mesh);
            let (mut all, mut missed) = (0, 0);
            for share in [100, 50, 25, 10] {
                let wanted = mesh.triangles().len() as u32 * share / 100;
                let level = level(&simplified, simplified.collapses().lod_for_triangles(wanted));
                let found = facing.turned_over(&level, Moved::ToPositions);
                assert_eq!(found, None, "{name} at {share} %");
                assert_eq!(facing.turned_over(&level, Moved::Freely), None, "{name} at {share} %");
                for t in 0..level.triangles().len() {
                    let found = facing.turned_over(&turned_over(&level, t), Moved::ToPositions);
                    all += 1;
                    missed += usize::from(found.is_none());
                }
            }
            // Elsewhere edges tell nothing: one face is left, or the source itself is turned over
            // in places.
            if facing.is_closed() || facing.max_surplus == 1 && all > FEW {
                assert_eq!(missed, 0, "{name}: of {all}");
            }
        }
    }
}
