//! Checks that no triangle of an exported level is turned over, compared with its source.
//!
//! The directed edges of triangles add up to the border of a surface: two faces that face the same
//! way cancel out at the edge between them. A level is its source with vertices moved, so its
//! border is the source's with vertices moved: nothing if the source is closed. A face that is
//! turned over adds its edges twice.

use glam::{DVec3, Vec3};
use lodc_measure::{Surface, TriangleTree, distance_squared};
use lodc_mesh::{Mesh, NONE, PositionIds, is_degenerate, position_key};

/// A face is on the sheet of a source that is not manifold whose distance from its middle is no
/// more than this share of its edges. Chosen by hand.
const SHEET_SHARE: f64 = 0.05;

/// A sheet faces as a face does if the cosine between their normals is more than this. Chosen by
/// hand.
const MIN_COSINE: f64 = 0.7;

/// Corners that are off a line by no more than this share of the largest coordinate may be on it:
/// some times the rounding of floats. Chosen by hand.
const LINE_SHARE: f64 = 1e-6;

/// Triangles at most that look turned over and are compared with all of an open source. Chosen by
/// hand: bounds the time.
const MAX_COMPARED: usize = 64;

/// The bits of a position; the same for both signs of zero.
type Key = [u32; 3];

/// How the triangles of an object face.
pub(super) struct Facing {
    /// The positions on its border, rising; none if the object is closed.
    border: Vec<Key>,
    /// The largest number of times that an edge is there more often in one direction than in the
    /// other; at least 1.
    max_surplus: u32,
    /// Whether no edge has more than two faces.
    is_manifold: bool,
    /// Every triangle: its positions, rising, and whether an even permutation gives their order in
    /// the triangle.
    triangles: Vec<([Key; 3], bool)>,
    tree: TriangleTree,
    triangle_count: u32,
}

/// Where the vertices of a level may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moved {
    /// At positions of the source's vertices.
    ToPositions,
    /// Anywhere near the source.
    Freely,
    /// Anywhere: positions are in units of their own.
    IntoOtherUnits,
}

impl Facing {
    pub(super) fn of(mesh: &Mesh) -> Self {
        let key = |v: u32| key(mesh, v);
        let ids = mesh.position_ids();
        let mut edges = distinct_edges(mesh, &ids);
        let is_manifold = edges.iter().all(|edge| edge.faces <= 2);
        edges.retain(|edge| edge.net != 0);
        let max_surplus = edges.iter().map(|edge| edge.net.unsigned_abs()).max().unwrap_or(1);
        let mut border: Vec<Key> = edges
            .iter()
            .flat_map(|edge| edge.ends)
            .map(|id| key(ids.first_vertex[id as usize]))
            .collect();
        border.sort_unstable();
        border.dedup();
        let triangles = sorted_triangles(mesh);
        let positions = mesh.positions().iter().map(|&p| p.into()).collect();
        let surface =
            Surface { positions, triangles: mesh.triangles().to_vec(), ..Surface::default() };
        let triangle_count = mesh.triangles().len() as u32;
        let tree = surface.tree();
        Self { border, max_surplus, is_manifold, triangles, tree, triangle_count }
    }

    /// Returns whether no edge is on the border.
    pub(super) fn is_closed(&self) -> bool {
        self.border.is_empty()
    }

    /// Returns a triangle of a level that is turned over: one with a doubtful edge. If the source
    /// is closed, each edge of the level's border is doubtful. Otherwise those are that have an end
    /// inside of the source, or a larger surplus than any of the source; and the triangle has to
    /// face away from the source next to it.
    pub(super) fn turned_over(&self, level: &Mesh, moved: Moved) -> Option<usize> {
        // Where more than two faces meet at edges, such edges become one, and faces of one sheet
        // lie on others.
        let tells_nothing = match moved {
            Moved::ToPositions => false,
            Moved::Freely => !self.is_manifold,
            Moved::IntoOtherUnits => true,
        };
        if !self.is_closed() && tells_nothing {
            return None;
        }
        let ids = level.position_ids();
        let is_on_border = |id: u32| {
            let key = key(level, ids.first_vertex[id as usize]);
            moved != Moved::ToPositions || self.border.binary_search(&key).is_ok()
        };
        let mut doubtful = distinct_edges(level, &ids);
        doubtful.retain(|edge| edge.net != 0);
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
            doubtful_edges > 0
                && !Face::of(level, t).is_line()
                && (self.is_closed() || self.faces_away(level, t))
        };
        let triangles = level.triangles().iter().map(doubtful_edges).enumerate();
        let mut turned: Vec<(usize, usize)> = triangles.filter(is_turned).collect();
        turned.sort_by_key(|&(t, doubtful_edges)| (std::cmp::Reverse(doubtful_edges), t));
        let own = sorted_triangles(level);
        let backs = |t: &[u32; 3]| {
            let (positions, is_even) = sorted(t.map(|v| key(level, v)));
            count(&own, (positions, !is_even))
        };
        let is_of_a_sheet = |t: usize| {
            let face = Face::of(level, t);
            // Of a sheet of two sides one may end elsewhere than in the source, about an edge off.
            let has_back = backs(&level.triangles()[t]) > 0;
            self.has_sheet_near(&face, if has_back { face.longest } else { face.reach })
        };
        let turned_over =
            turned.iter().take(MAX_COMPARED).find(|&&(t, _)| self.is_closed() || !is_of_a_sheet(t));
        if turned_over.is_some() || self.is_closed() || moved != Moved::ToPositions {
            return turned_over.map(|&(t, _)| t);
        }
        // A triangle that the source has the other way round alone, and more often than the level:
        // else it is of a sheet that lies on the back of another.
        let is_reversed = |t: &[u32; 3]| {
            let keys = t.map(|v| key(level, v));
            let (positions, is_even) = sorted(keys);
            let in_source = |is_even| count(&self.triangles, (positions, is_even));
            !is_degenerate(keys) && in_source(is_even) == 0 && in_source(!is_even) > backs(t)
        };
        let mut all = level.triangles().iter().enumerate();
        all.position(|(number, t)| is_reversed(t) && !Face::of(level, number).is_line())
    }

    /// Returns whether a triangle faces away from where the source next to its middle faces.
    fn faces_away(&self, level: &Mesh, triangle: usize) -> bool {
        let face = Face::of(level, triangle);
        let nearest = self.tree.nearest_triangle(face.middle, NONE);
        // Where sheets meet, the nearest one is that of the face only if it is very near.
        nearest.triangle != NONE
            && (self.is_manifold || nearest.squared <= face.reach * face.reach)
            && face.normal.dot(normal(self.tree.corners_of(nearest.triangle))) < 0.0
    }

    /// Returns whether a sheet of the source that faces as a triangle of a level is within `reach`
    /// of its middle: of a thin plate one side may collapse onto the other.
    fn has_sheet_near(&self, face: &Face, reach: f64) -> bool {
        (0..self.triangle_count).any(|t| {
            let corners = self.tree.corners_of(t);
            let cosine = face.normal.dot(normal(corners).normalize_or_zero());
            cosine > MIN_COSINE * face.normal.length()
                && distance_squared(face.middle, corners) <= reach * reach
        })
    }
}

/// A triangle of a level.
struct Face {
    middle: DVec3,
    /// Twice its area long.
    normal: DVec3,
    /// Sheets within this of its middle are very near.
    reach: f64,
    /// The length of its longest edge.
    longest: f64,
    /// The largest coordinate of a corner.
    size: f64,
}

impl Face {
    fn of(level: &Mesh, triangle: usize) -> Self {
        let position = |v: u32| Vec3::from(level.positions()[v as usize]).as_dvec3();
        let corners = level.triangles()[triangle].map(position);
        let [a, b, c] = corners;
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        Self {
            middle: corners.iter().sum::<DVec3>() / 3.0,
            normal: normal(corners),
            reach: SHEET_SHARE * longest,
            longest,
            size: corners.iter().fold(0.0, |most, corner| most.max(corner.abs().max_element())),
        }
    }

    /// Returns whether the corners are on a line, up to rounding: it faces nowhere.
    fn is_line(&self) -> bool {
        self.normal.length() <= LINE_SHARE * self.size * self.longest
    }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// An edge between two positions, and how often more in one direction than in the other.
struct Edge {
    /// Numbers of positions, rising.
    ends: [u32; 2],
    /// Faces beside it.
    faces: u32,
    /// Times that it leads from the lower to the higher number minus times that it leads back.
    net: i32,
}

fn edges([a, b, c]: [u32; 3]) -> [Edge; 3] {
    [[a, b], [b, c], [c, a]].map(|[from, to]| match from < to {
        true => Edge { ends: [from, to], faces: 1, net: 1 },
        false => Edge { ends: [to, from], faces: 1, net: -1 },
    })
}

/// The edges of a mesh by their ends.
fn distinct_edges(mesh: &Mesh, ids: &PositionIds) -> Vec<Edge> {
    let position_edges = |t: &[u32; 3]| edges(t.map(|v| ids.of_vertex[v as usize]));
    let mut all: Vec<Edge> = mesh.triangles().iter().flat_map(position_edges).collect();
    all.retain(|edge| edge.ends[0] != edge.ends[1]);
    all.sort_unstable_by_key(|edge| edge.ends);
    all.dedup_by(|next, edge| {
        let is_same = next.ends == edge.ends;
        if is_same {
            edge.net += next.net;
            edge.faces += next.faces;
        }
        is_same
    });
    all
}

/// The triangles of a mesh as in [`Facing::triangles`], rising. At rest one may be a point or a
/// line, which faces nowhere.
fn sorted_triangles(mesh: &Mesh) -> Vec<([Key; 3], bool)> {
    let corners = mesh.triangles().iter().map(|t| t.map(|v| key(mesh, v)));
    let mut triangles: Vec<_> = corners.filter(|keys| !is_degenerate(*keys)).map(sorted).collect();
    triangles.sort_unstable();
    triangles
}

/// How often a triangle is among sorted ones.
fn count(all: &[([Key; 3], bool)], triangle: ([Key; 3], bool)) -> usize {
    all.partition_point(|t| *t <= triangle) - all.partition_point(|t| *t < triangle)
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
    use lodc_mesh::{Lod, MeshParts, Simplified, Submesh};
    use lodc_simplify::{Options, simplify};

    /// Largest number of triangles of a mesh, each of which is turned over in its turn.
    const MAX_TRIANGLES: usize = 700;

    /// If no more triangles than this were turned in all, most levels have only one or two.
    const MIN_TURNED: usize = 20;

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
        for (name, mesh) in shapes.filter(|(_, mesh)| mesh.triangles().len() <= MAX_TRIANGLES) {
            let simplified = simplify(&mesh, &Options::DEFAULT, &|_, _| {});
            let facing = Facing::of(&mesh);
            let (mut all, mut missed) = (0, 0);
            for share in [100, 50, 25, 10] {
                let wanted = mesh.triangles().len() as u32 * share / 100;
                let level = level(&simplified, simplified.collapses().lod_for_triangles(wanted));
                let found = facing.turned_over(&level, Moved::ToPositions);
                assert_eq!(found, None, "{name} at {share} %");
                assert_eq!(facing.turned_over(&level, Moved::Freely), None, "{name} at {share} %");
                let faces = |t: &usize| !Face::of(&level, *t).is_line();
                for t in (0..level.triangles().len()).filter(faces) {
                    let found = facing.turned_over(&turned_over(&level, t), Moved::ToPositions);
                    all += 1;
                    missed += usize::from(found.is_none());
                }
            }
            // Elsewhere edges tell nothing: one face is left, or the source itself is turned over
            // in places.
            if facing.is_closed() || facing.max_surplus == 1 && all > MIN_TURNED {
                assert_eq!(missed, 0, "{name}: of {all}");
            }
        }
    }

    fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
        Mesh::try_from(MeshParts {
            vertex_submesh: vec![0; positions.len()],
            submeshes: vec![Submesh {
                first_triangle: 0,
                triangle_count: triangles.len() as u32,
                attributes: vec![],
            }],
            positions,
            triangles,
            ..MeshParts::default()
        })
        .expect("a mesh")
    }

    /// Levels of a mesh face as it does.
    fn none_is_turned(mesh: &Mesh, what: &str) {
        let simplified = simplify(mesh, &Options::DEFAULT, &|_, _| {});
        let facing = Facing::of(mesh);
        for share in [80, 60, 50, 40, 30, 20, 10] {
            let wanted = mesh.triangles().len() as u32 * share / 100;
            let level = level(&simplified, simplified.collapses().lod_for_triangles(wanted));
            let found = facing.turned_over(&level, Moved::ToPositions);
            assert_eq!(found, None, "{what} at {share} %");
        }
    }

    #[test]
    fn faces_that_lie_on_each_other_face_both_ways() {
        let sphere = lodc_fixtures::named("uv_sphere").expect("a shape");
        let mut triangles = sphere.triangles().to_vec();
        let patch = triangles.len() / 4..triangles.len() / 2;
        let reversed: Vec<[u32; 3]> = triangles[patch].iter().map(|&[a, b, c]| [a, c, b]).collect();
        triangles.extend(reversed);
        none_is_turned(&mesh(sphere.positions().to_vec(), triangles), "a patch of two sides");
    }

    #[test]
    fn triangles_on_a_line_face_nowhere() {
        let sphere = lodc_fixtures::named("uv_sphere").expect("a shape");
        for direction in [[1.0, 0.0, 0.0], [1.0, 2.0, 0.5], [0.3, -0.7, 0.1]] {
            let on_line = |p: &[f32; 3]| direction.map(|d: f32| d * p[0]);
            let positions: Vec<[f32; 3]> = sphere.positions().iter().map(on_line).collect();
            let mut triangles = sphere.triangles().to_vec();
            triangles.retain(|t| !is_degenerate(t.map(|v| position_key(positions[v as usize]))));
            none_is_turned(&mesh(positions, triangles), "a line");
        }
    }

    #[test]
    fn one_side_of_a_thin_plate_may_lie_on_the_other() {
        // Two open squares, one above the other, that face away from each other.
        let plate = |thickness: f32| {
            let at = |v: u32| {
                let side = if v < 4 { 0.5 } else { -0.5 };
                [(v & 1) as f32, (v >> 1 & 1) as f32, side * thickness]
            };
            MeshParts {
                positions: (0..8).map(at).collect(),
                triangles: vec![[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7]],
                vertex_submesh: vec![0; 8],
                submeshes: vec![Submesh {
                    first_triangle: 0,
                    triangle_count: 4,
                    attributes: vec![],
                }],
                ..MeshParts::default()
            }
        };
        for (thickness, is_found) in [(0.01, false), (0.5, true)] {
            let source = Mesh::try_from(plate(thickness)).expect("a mesh");
            let mut parts = plate(thickness);
            parts.triangles[0].swap(1, 2);
            let level = Mesh::try_from(parts).expect("a mesh");
            let found = Facing::of(&source).turned_over(&level, Moved::Freely);
            assert_eq!(found.is_some(), is_found, "{thickness}");
        }
    }
}
