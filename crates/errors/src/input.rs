//! The surface of LOD 0, its triangles and points numbered so that neighbours lie near in memory.

use glam::DVec3;
use lodc_mesh::{Csr, NONE, PositionIds, Simplified};
use lodc_nearest::{MovingTree, Triangles, morton_order};

/// LOD 0 and the moves that lead away from it.
///
/// A *point* is a pair of a position of the mesh and the place where the surface shows it: vertices
/// at one position may be shown at several places. Triangles die by positions, distances are
/// between places.
pub(crate) struct Input {
    /// The place of each point, moved towards the origin if it is far from there, and scaled by a
    /// power of two so that the diagonal of all is from 1 to 2. All bits are kept.
    pub(crate) places: Vec<[f32; 3]>,
    /// The position of each point.
    pub(crate) positions: Vec<u32>,
    /// The corners of each triangle, as points, along a Morton curve. Of triangles that lie on each
    /// other at every level there is one.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The point of each vertex.
    pub(crate) point_of: Vec<u32>,
    /// The triangles around each point.
    pub(crate) around: Csr,
    /// A tree over the triangles.
    pub(crate) tree: MovingTree,
    /// Mesh units for each unit of `places`.
    pub(crate) unit: f64,
    /// The diagonal of the bounding box of all triangles, in units of `places`.
    pub(crate) diagonal: f64,
}

impl Input {
    /// Numbers a mesh that is shown with its vertices at `shown`. Returns besides the corners of
    /// each triangle as vertices of the mesh.
    pub(crate) fn new(simplified: &Simplified, shown: &[[f32; 3]]) -> (Self, Vec<[u32; 3]>) {
        let mesh = simplified.mesh();
        let points = Points::new(mesh.positions(), shown);
        let raw = |t: u32| mesh.triangles()[t as usize].map(|v| shown[v as usize]);
        let Extent { origin, size, diagonal } =
            Extent::of(mesh.triangles().iter().flatten().map(|&v| shown[v as usize]));
        let scale = 1.0 / size;
        let place = |v: u32| {
            let p = shown[v as usize];
            std::array::from_fn(|k| (f64::from(p[k] - origin[k]) * scale) as f32)
        };

        let order = morton_order(0..mesh.triangles().len() as u32, raw);
        let all: Vec<[u32; 3]> = order.iter().map(|&t| mesh.triangles()[t as usize]).collect();
        let wedges = points.distinct(all);
        let mut numbers = vec![NONE; points.first_vertex.len()];
        let (mut places, mut positions) = (Vec::new(), Vec::new());
        let mut number = |v: u32| {
            let number = &mut numbers[points.of_vertex[v as usize] as usize];
            if *number == NONE {
                *number = places.len() as u32;
                places.push(place(v));
                positions.push(points.position_of_vertex[v as usize]);
            }
            *number
        };
        let triangles: Vec<[u32; 3]> = wedges.iter().map(|t| t.map(&mut number)).collect();
        let point_of: Vec<u32> = (0..mesh.vertex_count() as u32).map(&mut number).collect();

        let corners = |t: u32| triangles[t as usize].map(|p| places[p as usize]);
        let corner = (0..).zip(&triangles).flat_map(|(t, corners)| corners.map(|p| (p, t)));
        let (tree, around) = rayon::join(
            || MovingTree::of_all(triangles.len() as u32, corners),
            || Csr::new(places.len(), corner),
        );
        let diagonal = diagonal * scale;
        let unit = size;
        (Self { places, positions, triangles, point_of, around, tree, unit, diagonal }, wedges)
    }

    /// Returns the place of a point.
    #[inline]
    pub(crate) fn place(&self, point: u32) -> DVec3 {
        wide(self.places[point as usize])
    }

    /// Returns the places of three points.
    #[inline]
    pub(crate) fn at(&self, [a, b, c]: [u32; 3]) -> [DVec3; 3] {
        [self.place(a), self.place(b), self.place(c)]
    }
}

impl Triangles for Input {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.at(self.triangles[triangle as usize])
    }
    #[inline]
    fn is_live(&self, _: u32) -> bool {
        true
    }
}

/// Returns a place with the precision of computations.
#[inline]
pub(crate) fn wide([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), f64::from(z))
}

/// The extent of some points.
struct Extent {
    /// What may be taken off every point without rounding: its differences from points on the same
    /// side of 0, of which the farthest is at most twice as far, are exact (Sterbenz 1974). Points
    /// of samples, which are rounded, then lie on the surface however far it is from the origin.
    origin: [f32; 3],
    /// A power of two near the diagonal of the bounding box, and the diagonal; 1 and 0 without
    /// points.
    size: f64,
    diagonal: f64,
}

impl Extent {
    fn of(points: impl Iterator<Item = [f32; 3]>) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in points {
            low = std::array::from_fn(|k| low[k].min(p[k]));
            high = std::array::from_fn(|k| high[k].max(p[k]));
        }
        let origin = std::array::from_fn(|k| match (low[k], high[k]) {
            (low, high) if low > 0.0 && high <= 2.0 * low => low,
            (low, high) if high < 0.0 && low >= 2.0 * high => high,
            _ => 0.0,
        });
        let diagonal = (wide(high) - wide(low)).length();
        if diagonal > 0.0 && diagonal.is_finite() {
            // The exponent alone: a power of two.
            let size = f64::from_bits(diagonal.to_bits() >> 52 << 52);
            Self { origin, size, diagonal }
        } else {
            Self { origin, size: 1.0, diagonal: 0.0 }
        }
    }
}

/// The points of a mesh, numbered.
struct Points {
    of_vertex: Vec<u32>,
    first_vertex: Vec<u32>,
    position_of_vertex: Vec<u32>,
    /// Number of positions.
    positions: usize,
}

impl Points {
    fn new(positions: &[[f32; 3]], shown: &[[f32; 3]]) -> Self {
        if shown == positions {
            let PositionIds { of_vertex, first_vertex } = PositionIds::new(positions);
            let positions = first_vertex.len();
            return Self {
                position_of_vertex: of_vertex.clone(),
                of_vertex,
                first_vertex,
                positions,
            };
        }
        let (positions, places) = (PositionIds::new(positions), PositionIds::new(shown));
        let mut order: Vec<u32> = (0..shown.len() as u32).collect();
        let key = |v: u32| (positions.of_vertex[v as usize], places.of_vertex[v as usize]);
        order.sort_unstable_by_key(|&v| (key(v), v));
        let (mut of_vertex, mut first_vertex) = (vec![0; shown.len()], Vec::<u32>::new());
        for v in order {
            if first_vertex.last().is_none_or(|&first| key(first) != key(v)) {
                first_vertex.push(v);
            }
            of_vertex[v as usize] = first_vertex.len() as u32 - 1;
        }
        let PositionIds { of_vertex: position_of_vertex, first_vertex: firsts } = positions;
        Self { of_vertex, first_vertex, position_of_vertex, positions: firsts.len() }
    }

    /// Leaves out triangles whose points another one before them has, in any order: doubled faces
    /// and backs. A position moves as a whole, so they lie on each other at every level, as long as
    /// each position is shown at one place.
    fn distinct(&self, mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        if self.first_vertex.len() != self.positions {
            return triangles;
        }
        let points = |t: u32| {
            let mut points = triangles[t as usize].map(|v| self.of_vertex[v as usize]);
            points.sort_unstable();
            points
        };
        let firsts = (0..triangles.len() as u32).map(|t| (points(t)[0], t));
        let by_first = Csr::new(self.first_vertex.len(), firsts);
        let mut is_first = vec![true; triangles.len()];
        let mut row = Vec::new();
        for point in 0..by_first.rows() as u32 {
            row.clear();
            row.extend_from_slice(by_first.row(point));
            // Sorted, since all triangles of a fan may be in one row.
            row.sort_unstable_by_key(|&t| (points(t), t));
            for pair in row.windows(2) {
                is_first[pair[1] as usize] &= points(pair[0]) != points(pair[1]);
            }
        }
        let mut is_first = is_first.into_iter();
        triangles.retain(|_| is_first.next() == Some(true));
        triangles
    }
}
