//! Finds coincident faces: layers that lie on each other.
//!
//! Two faces lie on each other if their corners are at the same three positions, whichever way they
//! turn. Two pairs of faces do if they divide a flat quadrilateral along its two diagonals: the
//! back of a sheet is often triangulated the other way. Either is a *cell* with several *sides*, of
//! which one is chosen for the shell and the others follow it. The choice spreads from face to face
//! over common edges, so that the shell is a whole layer, not patches of front and back.

use glam::DVec3;
use lodc_mesh::{Csr, Mesh, NONE, PositionIds};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Rows longer than this are not searched for quadrilaterals, which takes time with the square of
/// their length. Chosen by hand.
const MAX_SEARCHED: usize = 64;
/// The choice does not spread over edges with more faces of cells than this. Chosen by hand, as a
/// bound on the time.
const MAX_AT_EDGE: usize = 32;
/// Two pairs of faces over the same quadrilateral lie on each other if the cosines between all
/// their normals, turned the same way, are above this (60°); else they enclose a volume. Chosen by
/// hand.
const FLAT: f64 = 0.5;

/// Faces that lie on each other.
struct Cell {
    /// Each side has one face, or two that share a diagonal.
    sides: Vec<[u32; 2]>,
}

/// A face, and the weight of its plane beyond that of a face of the shell, which may be negative.
pub(super) type WeightedFace = (u32, f64);

/// For each triangle: true if it lies on a triangle of the shell and follows it. Then the triangles
/// that divide quadrilaterals, with weights by which all sides of a quadrilateral count alike, and
/// together once. None if no triangle lies on another.
pub(super) fn followers(
    mesh: &Mesh,
    positions: &PositionIds,
) -> Option<(Vec<bool>, Vec<WeightedFace>)> {
    let faces = Faces::new(mesh, positions);
    let cells = faces.cells();
    if cells.is_empty() {
        return None;
    }
    let chosen = Choosing::new(&faces, &cells).run();
    let mut follows = vec![false; mesh.triangles().len()];
    let mut on_pairs = Vec::new();
    for (cell, &chosen) in cells.iter().zip(&chosen) {
        let share = 1.0 / cell.sides.len() as f64;
        for (side, &[face, second]) in (0..).zip(&cell.sides) {
            let is_follower = side != chosen;
            follows[face as usize] = is_follower;
            if second != NONE {
                follows[second as usize] = is_follower;
                let weight = if is_follower { share } else { share - 1.0 };
                on_pairs.extend([(face, weight), (second, weight)]);
            }
        }
    }
    Some((follows, on_pairs))
}

/// The faces of a mesh by the positions of their corners.
struct Faces<'a> {
    mesh: &'a Mesh,
    positions: &'a PositionIds,
    /// For each position the faces at it whose other two positions have greater numbers: its row.
    rows: Csr,
}

/// A face of a row: its other two positions, the smaller first, and its number.
type Entry = (u32, u32, u32);

impl<'a> Faces<'a> {
    fn new(mesh: &'a Mesh, positions: &'a PositionIds) -> Self {
        let least = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions.of_vertex[v as usize]);
            a.min(b).min(c)
        };
        let rows = Csr::new(positions.len(), mesh.triangles().iter().map(least).zip(0..));
        Self { mesh, positions, rows }
    }

    /// The positions of a face's corners.
    fn positions_of(&self, face: u32) -> [u32; 3] {
        self.mesh.triangles()[face as usize].map(|v| self.positions.of_vertex[v as usize])
    }

    /// The faces of a row, sorted.
    fn row(&self, position: u32, entries: &mut Vec<Entry>) {
        entries.clear();
        entries.extend(self.rows.row(position).iter().map(|&face| {
            let mut positions = self.positions_of(face);
            positions.sort_unstable();
            (positions[1], positions[2], face)
        }));
        entries.sort_unstable();
    }

    /// All cells, by their first faces. A face belongs to one at most.
    fn cells(&self) -> Vec<Cell> {
        let cells_found: Vec<Cell> = (0..self.positions.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map_init(Vec::new, |entries, position| {
                let mut cells_found = Vec::new();
                if self.rows.row(position).len() > 1 {
                    self.row(position, entries);
                    stacks(entries, &mut cells_found);
                    self.quads(position, entries, &mut cells_found);
                }
                cells_found
            })
            .flatten_iter()
            .collect();
        if cells_found.is_empty() {
            return cells_found;
        }
        let mut is_taken = vec![false; self.mesh.triangles().len()];
        let (stacks, quads): (Vec<Cell>, Vec<Cell>) =
            cells_found.into_iter().partition(|cell| cell.sides[0][1] == NONE);
        let mut cells: Vec<Cell> = stacks
            .into_iter()
            .chain(quads)
            .filter(|cell| {
                let faces = || cell.sides.as_flattened().iter().filter(|&&face| face != NONE);
                let is_free = faces().all(|&face| !is_taken[face as usize]);
                if is_free {
                    faces().for_each(|&face| is_taken[face as usize] = true);
                }
                is_free
            })
            .collect();
        cells.sort_by_key(|cell| cell.sides[0][0]);
        cells
    }

    /// Finds pairs of faces that divide a flat quadrilateral with this smallest position along
    /// different diagonals. Three of the four faces are in its row.
    fn quads(&self, position: u32, entries: &[Entry], cells_found: &mut Vec<Cell>) {
        if !(3..=MAX_SEARCHED).contains(&entries.len()) {
            return;
        }
        let at = |a: u32, b: u32| {
            let first = entries.partition_point(|e| (e.0, e.1) < (a, b));
            entries.get(first).filter(|e| (e.0, e.1) == (a, b)).map(|e| e.2)
        };
        for (i, &(x, y, xy)) in entries.iter().enumerate() {
            for &(_, z, xz) in entries[i + 1..].iter().take_while(|e| e.0 == x) {
                let Some(yz) = at(y, z).filter(|_| y < z) else { continue };
                let fourth = self.rows.row(x).iter().copied().find(|&face| {
                    let mut positions = self.positions_of(face);
                    positions.sort_unstable();
                    positions == [x, y, z]
                });
                let Some(xyz) = fourth else { continue };
                // The diagonal from this position goes to one of the other three.
                let pairs = [
                    ([xy, yz], [xz, xyz], [position, y], [x, z]),
                    ([xy, xz], [yz, xyz], [position, x], [y, z]),
                    ([xz, yz], [xy, xyz], [position, z], [x, y]),
                ];
                let flat = pairs
                    .into_iter()
                    .filter_map(|(p, q, d, e)| Some((self.flatness(p, q, d, e)?, p, q)))
                    .max_by(|a, b| a.0.total_cmp(&b.0));
                if let Some((_, mut p, mut q)) = flat {
                    p.sort_unstable();
                    q.sort_unstable();
                    cells_found.push(Cell { sides: vec![p.min(q), p.max(q)] });
                }
            }
        }
    }

    /// How flat two pairs of faces are, `p` divided along the diagonal `d`, and `q` along `e`: the
    /// least cosine between normals, whichever way the pairs turn. None if they enclose a volume,
    /// or a pair is folded.
    fn flatness(&self, p: [u32; 2], q: [u32; 2], d: [u32; 2], e: [u32; 2]) -> Option<f64> {
        let continues = |[a, b]: [u32; 2], diagonal: [u32; 2]| {
            self.runs_along(a, diagonal) != self.runs_along(b, diagonal)
        };
        if !continues(p, d) || !continues(q, e) {
            return None;
        }
        let [p, q] = [p, q].map(|pair| pair.map(|face| self.normal(face)));
        let across = p.iter().flat_map(|m| q.iter().map(move |n| m.dot(*n)));
        let (least, most) =
            across.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), c| (lo.min(c), hi.max(c)));
        let within = p[0].dot(p[1]).min(q[0].dot(q[1]));
        let flatness = within.min(least.max(-most));
        (flatness > FLAT).then_some(flatness)
    }

    /// Returns whether a face has an edge from one position to another, in this direction.
    fn runs_along(&self, face: u32, [from, to]: [u32; 2]) -> bool {
        let positions = self.positions_of(face);
        (0..3).any(|c| positions[c] == from && positions[(c + 1) % 3] == to)
    }

    /// Unit normal of a face; zero if it has no area.
    fn normal(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.mesh.triangles()[face as usize]
            .map(|v| DVec3::from(self.mesh.positions()[v as usize].map(f64::from)));
        (b - a).cross(c - a).normalize_or_zero()
    }
}

/// Finds the faces at the same three positions.
fn stacks(entries: &[Entry], cells_found: &mut Vec<Cell>) {
    for stack in entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|s| s.len() > 1) {
        cells_found.push(Cell { sides: stack.iter().map(|e| [e.2, NONE]).collect() });
    }
}

/// An edge of a face.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    /// The positions at its ends, the smaller first.
    ends: [u32; 2],
    /// The face runs along it from the smaller to the greater.
    is_rising: bool,
    face: u32,
    /// The index of the face's cell; of a face that lies on no other, a number that no cell has.
    cell: u32,
    /// The index of the face's side in its cell.
    side: u32,
    /// The vertices at its ends, in that order.
    vertices: [u32; 2],
}

impl Edge {
    /// The three edges of a face.
    fn of(faces: &Faces<'_>, face: u32, cell: u32, side: u32) -> [Self; 3] {
        let positions = faces.positions_of(face);
        let corners = faces.mesh.triangles()[face as usize];
        [[0, 1], [1, 2], [2, 0]].map(|[a, b]| {
            let is_rising = positions[a] < positions[b];
            let [a, b] = if is_rising { [a, b] } else { [b, a] };
            let (ends, vertices) = ([positions[a], positions[b]], [corners[a], corners[b]]);
            Self { ends, is_rising, face, cell, side, vertices }
        })
    }
}

/// The choice of one side for each cell.
struct Choosing<'a> {
    faces: &'a Faces<'a>,
    cells: &'a [Cell],
    /// All edges of faces of cells, and of others along the same positions, sorted.
    edges: Vec<Edge>,
    /// The side of each cell; `NONE` until it is chosen.
    chosen: Vec<u32>,
    /// Edges of the shell's faces over which the choice has yet to spread.
    queue: VecDeque<Edge>,
}

impl<'a> Choosing<'a> {
    fn new(faces: &'a Faces<'a>, cells: &'a [Cell]) -> Self {
        let mut edges = Vec::new();
        let mut is_lone = vec![true; faces.mesh.triangles().len()];
        for (number, cell) in (0..).zip(cells) {
            for (side, pair) in (0..).zip(&cell.sides) {
                for &face in pair.iter().filter(|&&face| face != NONE) {
                    edges.extend(Edge::of(faces, face, number, side));
                    is_lone[face as usize] = false;
                }
            }
        }
        edges.par_sort_unstable();
        let meets = |edge: &Edge| {
            let first = edges.partition_point(|e| e.ends < edge.ends);
            edges.get(first).is_some_and(|e| e.ends == edge.ends)
        };
        let lone: Vec<Edge> = (0..is_lone.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .filter(|&face| is_lone[face as usize])
            .flat_map_iter(|face| Edge::of(faces, face, cells.len() as u32 + face, 0))
            .filter(meets)
            .collect();
        edges.extend(&lone);
        edges.par_sort_unstable();
        // Faces that lie on no other are in the shell whatever is chosen.
        Self { faces, cells, edges, chosen: vec![NONE; cells.len()], queue: lone.into() }
    }

    fn run(mut self) -> Vec<u32> {
        self.spread();
        for cell in 0..self.cells.len() as u32 {
            if self.chosen[cell as usize] == NONE {
                self.choose(cell, 0);
                self.spread();
            }
        }
        self.chosen
    }

    fn choose(&mut self, cell: u32, side: u32) {
        self.chosen[cell as usize] = side;
        for face in self.cells[cell as usize].sides[side as usize] {
            if face != NONE {
                self.queue.extend(Edge::of(self.faces, face, cell, side));
            }
        }
    }

    /// Chooses the sides of cells that continue what is chosen.
    fn spread(&mut self) {
        while let Some(edge) = self.queue.pop_front() {
            self.cross(&edge);
        }
    }

    /// Chooses the sides that continue a face beyond its edge, if their cells have no side yet. A
    /// side continues it if it has the same vertices there, or if there is only one cell beyond the
    /// edge: where more than two surfaces meet, it is not clear which continues which.
    fn cross(&mut self, edge: &Edge) {
        let first = self.edges.partition_point(|e| e.ends < edge.ends);
        let same_ends = self.edges[first..].iter().take_while(|e| e.ends == edge.ends);
        let end = first + same_ends.take(MAX_AT_EDGE + 1).count();
        if end - first > MAX_AT_EDGE {
            return;
        }
        let others = || self.edges[first..end].iter().map(|e| e.cell).filter(|&c| c != edge.cell);
        let is_only_cell = others().all(|cell| others().next() == Some(cell));
        for i in first..end {
            let cell = self.edges[i].cell;
            if self.chosen.get(cell as usize) != Some(&NONE) {
                continue;
            }
            let continues = |e: &&Edge| e.cell == cell && e.is_rising != edge.is_rising;
            let sides = self.edges[i..end].iter().filter(continues);
            let best = sides.min_by_key(|e| (e.vertices != edge.vertices, e.face));
            let is_continuation = |e: &&Edge| is_only_cell || e.vertices == edge.vertices;
            if let Some(&Edge { side, .. }) = best.filter(is_continuation) {
                self.choose(cell, side);
            }
        }
    }
}
