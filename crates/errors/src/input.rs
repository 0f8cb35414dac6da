//! The surface of LOD 0, its triangles and points numbered so that neighbours are near in memory.

use glam::DVec3;
use lodc_mesh::{CollapseSequence, Csr, Mesh, NONE, PositionIds, Simplified};
use lodc_nearest::{MovingTree, Triangles, morton_order};

/// LOD 0 in one shape.
///
/// A *point* is a pair of a position of the mesh, in all shapes ([`Mesh::position_ids`]), and the
/// coordinates that this shape gives it. Positions decide which triangles are degenerate,
/// coordinates how far surfaces are from each other: a triangle may be a point in one shape.
pub(crate) struct Input {
    /// The coordinates of each point: those of the shape, moved towards the origin if that is far
    /// away, and scaled by a power of two so that the diagonal of all is from 1 to 2. No bit is
    /// lost.
    pub(crate) coordinates: Vec<[f32; 3]>,
    /// The number of each point's position in the mesh.
    pub(crate) position_ids: Vec<u32>,
    /// The corners of each triangle, as points, along a Morton curve. Of triangles that coincide at
    /// every level there is one.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The point of each vertex.
    pub(crate) point_of_vertex: Vec<u32>,
    /// The triangles around each point.
    pub(crate) triangles_around: Csr,
    /// A tree over the triangles.
    pub(crate) tree: MovingTree,
    /// Mesh units per unit of `coordinates`.
    pub(crate) mesh_scale: f64,
    /// The diagonal of the bounding box of all triangles, in units of `coordinates`.
    pub(crate) diagonal: f64,
}

impl Input {
    /// Numbers a mesh in a shape: `posed` has a position for each of its vertices. Returns besides
    /// the corners of each triangle of the input as vertices of the mesh.
    pub(crate) fn new(simplified: &Simplified, posed: &[[f32; 3]]) -> (Self, Vec<[u32; 3]>) {
        let mesh = simplified.mesh();
        let points = Points::new(mesh, posed);
        let posed_corners = |t: u32| mesh.triangles()[t as usize].map(|v| posed[v as usize]);
        let Extent { origin, power_of_two: mesh_scale, diagonal } =
            Extent::of(mesh.triangles().iter().flatten().map(|&v| posed[v as usize]));
        let scale = 1.0 / mesh_scale;
        let normalised = |v: u32| {
            let p = posed[v as usize];
            std::array::from_fn(|k| (f64::from(p[k] - origin[k]) * scale) as f32)
        };

        let order = morton_order(0..mesh.triangles().len() as u32, posed_corners);
        let all_triangles: Vec<[u32; 3]> =
            order.iter().map(|&t| mesh.triangles()[t as usize]).collect();
        let corner_vertices = points.without_doubles(all_triangles, simplified.collapses());
        // Points are numbered again, in the order in which triangles use them.
        let mut numbers = vec![NONE; points.first_vertex.len()];
        let (mut coordinates, mut position_ids) = (Vec::new(), Vec::new());
        let mut number = |v: u32| {
            let number = &mut numbers[points.of_vertex[v as usize] as usize];
            if *number == NONE {
                *number = coordinates.len() as u32;
                coordinates.push(normalised(v));
                position_ids.push(points.position_of_vertex[v as usize]);
            }
            *number
        };
        let triangles: Vec<[u32; 3]> = corner_vertices.iter().map(|t| t.map(&mut number)).collect();
        let point_of_vertex: Vec<u32> = (0..mesh.vertex_count() as u32).map(&mut number).collect();

        let corners = |t: u32| triangles[t as usize].map(|p| coordinates[p as usize]);
        let uses = (0..).zip(&triangles).flat_map(|(t, points)| points.map(|p| (p, t)));
        let (tree, triangles_around) = rayon::join(
            || MovingTree::of_all(triangles.len() as u32, corners),
            || Csr::new(coordinates.len(), uses),
        );
        let input = Self {
            coordinates,
            position_ids,
            triangles,
            point_of_vertex,
            triangles_around,
            tree,
            mesh_scale,
            diagonal: diagonal * scale,
        };
        (input, corner_vertices)
    }

    /// Returns the coordinates of a point.
    #[inline]
    pub(crate) fn point(&self, point: u32) -> DVec3 {
        to_dvec3(self.coordinates[point as usize])
    }

    /// Returns the coordinates of the corners of a face, given as points.
    #[inline]
    pub(crate) fn corners_of(&self, [a, b, c]: [u32; 3]) -> [DVec3; 3] {
        [self.point(a), self.point(b), self.point(c)]
    }
}

impl Triangles for Input {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.corners_of(self.triangles[triangle as usize])
    }
    #[inline]
    fn is_live(&self, _: u32) -> bool {
        true
    }
}

#[inline]
pub(crate) fn to_dvec3([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), f64::from(z))
}

/// The extent of some points.
struct Extent {
    /// What is subtracted from every point without rounding: on each axis the coordinate nearest to
    /// 0, if all are on one side of 0 and at most twice as far from it, so that differences are
    /// exact (Sterbenz 1974); else 0. Rounded positions of samples are then on the surface however
    /// far that is from the origin.
    origin: [f32; 3],
    /// The largest power of two up to the diagonal of the bounding box, and the diagonal; 1 and 0
    /// without points.
    power_of_two: f64,
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
        let diagonal = (to_dvec3(high) - to_dvec3(low)).length();
        if diagonal > 0.0 && diagonal.is_finite() {
            // The exponent alone: a power of two.
            let power_of_two = f64::from_bits(diagonal.to_bits() >> 52 << 52);
            Self { origin, power_of_two, diagonal }
        } else {
            Self { origin, power_of_two: 1.0, diagonal: 0.0 }
        }
    }
}

/// The points of a mesh, numbered by position, then coordinates.
struct Points {
    of_vertex: Vec<u32>,
    /// The first vertex of each point.
    first_vertex: Vec<u32>,
    position_of_vertex: Vec<u32>,
    position_count: usize,
}

impl Points {
    fn new(mesh: &Mesh, posed: &[[f32; 3]]) -> Self {
        let positions = mesh.position_ids();
        if posed == mesh.positions() {
            let PositionIds { of_vertex, first_vertex } = positions;
            return Self {
                position_count: first_vertex.len(),
                position_of_vertex: of_vertex.clone(),
                of_vertex,
                first_vertex,
            };
        }
        let posed_ids = PositionIds::new(posed);
        let mut order: Vec<u32> = (0..posed.len() as u32).collect();
        let key = |v: u32| (positions.of_vertex[v as usize], posed_ids.of_vertex[v as usize]);
        order.sort_unstable_by_key(|&v| (key(v), v));
        let (mut of_vertex, mut first_vertex) = (vec![0; posed.len()], Vec::<u32>::new());
        for v in order {
            if first_vertex.last().is_none_or(|&first| key(first) != key(v)) {
                first_vertex.push(v);
            }
            of_vertex[v as usize] = first_vertex.len() as u32 - 1;
        }
        let PositionIds { of_vertex: position_of_vertex, first_vertex: firsts } = positions;
        Self { of_vertex, first_vertex, position_of_vertex, position_count: firsts.len() }
    }

    /// Leaves out triangles whose points another one before them has, in any order: doubled faces
    /// and backs. They coincide at every level if all vertices of a position move together, as in
    /// the sequences of every simplifier, and have the same coordinates.
    fn without_doubles(
        &self,
        mut triangles: Vec<[u32; 3]>,
        collapses: &CollapseSequence,
    ) -> Vec<[u32; 3]> {
        if self.first_vertex.len() != self.position_count
            || !self.positions_move_together(collapses)
        {
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

    /// Returns whether every step moves all vertices of a position to one other position.
    fn positions_move_together(&self, collapses: &CollapseSequence) -> bool {
        let mut vertex_counts = vec![0u32; self.position_count];
        self.position_of_vertex.iter().for_each(|&p| vertex_counts[p as usize] += 1);
        let mut first = 0;
        collapses.parts().step_ends.iter().all(|&end| {
            let records = std::mem::replace(&mut first, end)..end;
            let count = records.end - records.start;
            let mut moves = records.map(|k| {
                [k, collapses.targets()[k as usize]].map(|v| self.position_of_vertex[v as usize])
            });
            let Some(first_move) = moves.next() else { return true };
            vertex_counts[first_move[0] as usize] == count && moves.all(|m| m == first_move)
        })
    }
}
