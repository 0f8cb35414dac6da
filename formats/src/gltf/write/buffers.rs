//! Which vertices of a mesh's primitives go into one vertex buffer: what primitives of many
//! materials share is stored once, as exporters write it.

use super::differences::{MovedStreams, moved_streams};
use lodc_mesh::{DisjointSets, Mesh, NONE};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;

/// Share of a primitive's vertices that other primitives must have, too, for it to share a buffer
/// with them: those that just meet at a border keep small buffers of their own.
const MIN_SHARED: f64 = 0.1;

/// What a primitive draws.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawn {
    /// Its vertices, each once, in the order that a buffer of its own has.
    pub(super) vertices: Vec<u32>,
    /// Number of its indices.
    pub(super) indices: usize,
}

/// The vertex buffers of a mesh.
#[derive(Debug)]
pub(super) struct VertexBuffers {
    /// For each submesh its buffer.
    of_submesh: Vec<usize>,
    /// For each buffer its vertices; of those that are the same in all bytes the first one.
    vertices: Vec<Vec<u32>>,
    /// For each vertex its number in its buffer.
    numbers: Vec<u32>,
    /// For each buffer by level the run of vertices that move to the next level.
    runs: Vec<Vec<Range<usize>>>,
}

/// Where vertices move as coarser levels take over: what two primitives share has to move alike.
#[derive(Clone, Copy)]
pub(super) struct Ways<'a> {
    /// The vertices before, as they are stored.
    pub(super) mesh: &'a Mesh,
    /// Those that they become, as they are stored.
    pub(super) next: &'a Mesh,
    /// By level the vertices that move.
    pub(super) moving: &'a [Option<Range<u32>>],
    /// The streams that move besides positions and normals.
    pub(super) streams: MovedStreams,
}

impl Ways<'_> {
    fn moves(&self, vertex: u32) -> bool {
        self.moving.iter().flatten().any(|moving| moving.contains(&vertex))
    }

    /// Appends what a vertex of a submesh moves to, and returns whether it moves at all.
    fn append(&self, vertex: u32, submesh: usize, bytes: &mut Vec<u8>) -> bool {
        let start = bytes.len();
        self.append_of(self.mesh, vertex, submesh, bytes);
        let middle = bytes.len();
        self.append_of(self.next, vertex, submesh, bytes);
        let moves = self.moves(vertex) && bytes[start..middle] != bytes[middle..];
        bytes.drain(start..middle);
        moves
    }

    fn append_of(&self, mesh: &Mesh, vertex: u32, submesh: usize, bytes: &mut Vec<u8>) {
        let position = mesh.positions()[vertex as usize];
        position.iter().for_each(|c| bytes.extend_from_slice(&c.to_le_bytes()));
        let streams = moved_streams(mesh, submesh, self.streams);
        streams.for_each(|a| bytes.extend_from_slice(a.at(vertex)));
    }
}

impl VertexBuffers {
    /// The buffers of submeshes that draw this. In a buffer that several share, vertices that
    /// coarser levels draw come first; `last_level` is the coarsest that draws a vertex.
    pub(super) fn new(mesh: &Mesh, drawn: Vec<Drawn>, last_level: impl Fn(u32) -> u32) -> Self {
        Self::shared(mesh, drawn, &last_level, None)
    }

    /// As [`Self::new`], of submeshes whose vertices move from level to level.
    pub(super) fn morphing(
        drawn: Vec<Drawn>,
        last_level: impl Fn(u32) -> u32,
        ways: Ways<'_>,
    ) -> Self {
        Self::shared(ways.mesh, drawn, &last_level, Some(ways))
    }

    fn shared(
        mesh: &Mesh,
        drawn: Vec<Drawn>,
        last_level: &impl Fn(u32) -> u32,
        ways: Option<Ways<'_>>,
    ) -> Self {
        let mut buffers = Self::none(mesh, drawn.len());
        for submeshes in of_one_format(mesh, &drawn) {
            Classes::new(mesh, &drawn, &submeshes, last_level, ways).share(&mut buffers);
        }
        buffers.add(drawn, ways);
        buffers
    }

    /// A buffer for each submesh.
    pub(super) fn apart(mesh: &Mesh, drawn: Vec<Drawn>) -> Self {
        let mut buffers = Self::none(mesh, drawn.len());
        buffers.add(drawn, None);
        buffers
    }

    fn none(mesh: &Mesh, submeshes: usize) -> Self {
        Self {
            of_submesh: vec![usize::MAX; submeshes],
            vertices: Vec::new(),
            numbers: vec![NONE; mesh.vertex_count()],
            runs: Vec::new(),
        }
    }

    /// Adds the buffers of submeshes that have none. What moves is a run of a submesh's vertices,
    /// which then come in their order.
    fn add(&mut self, drawn: Vec<Drawn>, ways: Option<Ways<'_>>) {
        for (buffer, drawn) in self.of_submesh.iter_mut().zip(drawn) {
            if *buffer == usize::MAX {
                (0..).zip(&drawn.vertices).for_each(|(n, &v)| self.numbers[v as usize] = n);
                *buffer = self.vertices.len();
                let index_of = |v: u32| drawn.vertices.partition_point(|&w| w < v);
                let run = |moving: &Option<Range<u32>>| {
                    moving.as_ref().map_or(0..0, |m| index_of(m.start)..index_of(m.end))
                };
                let moving = ways.iter().flat_map(|ways| ways.moving);
                self.runs.push(moving.map(run).collect());
                self.vertices.push(drawn.vertices);
            }
        }
    }

    /// The number of a submesh's buffer.
    pub(super) fn of_submesh(&self, submesh: usize) -> usize {
        self.of_submesh[submesh]
    }

    /// The vertices of a submesh's buffer, in their order there.
    pub(super) fn vertices(&self, submesh: usize) -> &[u32] {
        &self.vertices[self.of_submesh[submesh]]
    }

    /// The run of a submesh's buffer that moves to the next level.
    pub(super) fn run(&self, submesh: usize, level: usize) -> Range<usize> {
        self.runs[self.of_submesh[submesh]][level].clone()
    }

    /// Corners of triangles as indices into their buffer.
    pub(super) fn indices(&self, corners: &[u32]) -> Vec<u32> {
        corners.iter().map(|&v| self.numbers[v as usize]).collect()
    }
}

/// Submeshes with vertices of the same streams, where there are several.
fn of_one_format(mesh: &Mesh, drawn: &[Drawn]) -> impl Iterator<Item = Vec<usize>> {
    let mut groups: BTreeMap<&[u32], Vec<usize>> = BTreeMap::new();
    for (s, submesh) in mesh.submeshes().iter().enumerate() {
        if !drawn[s].vertices.is_empty() {
            groups.entry(&submesh.attributes).or_default().push(s);
        }
    }
    groups.into_values().filter(|submeshes| submeshes.len() > 1)
}

/// The vertices of submeshes of one format, those that are the same in all bytes, and move alike,
/// as one class.
struct Classes<'a> {
    members: Vec<Member<'a>>,
    classes: Vec<Class>,
    /// Bytes of a vertex, and of what it moves to.
    stride: usize,
    /// Levels that move.
    levels: usize,
}

/// Vertices that are stored once.
#[derive(Clone, Copy)]
struct Class {
    /// One of them, that which moves if any does.
    vertex: u32,
    /// The coarsest level that draws one of them; if they move, at that level.
    last_level: u32,
    moves: bool,
}

/// A submesh, and for each of its vertices the class.
struct Member<'a> {
    submesh: usize,
    drawn: &'a Drawn,
    classes: Vec<u32>,
}

impl<'a> Classes<'a> {
    fn new(
        mesh: &Mesh,
        drawn: &'a [Drawn],
        submeshes: &[usize],
        last_level: &impl Fn(u32) -> u32,
        ways: Option<Ways<'_>>,
    ) -> Self {
        let streams = mesh.submeshes()[submeshes[0]].attributes.iter();
        let streams: Vec<_> = streams.map(|&a| &mesh.attributes()[a as usize]).collect();
        let (mut keys, mut goals, mut vertices) = (Vec::new(), Vec::new(), Vec::new());
        for &s in submeshes {
            for &v in &drawn[s].vertices {
                let position = mesh.positions()[v as usize];
                position.iter().for_each(|c| keys.extend_from_slice(&c.to_le_bytes()));
                streams.iter().for_each(|a| keys.extend_from_slice(a.at(v)));
                let moves = ways.is_some_and(|ways| ways.append(v, s, &mut goals));
                vertices.push(Class { vertex: v, last_level: last_level(v), moves });
            }
        }
        let stride = size_of::<[f32; 3]>() + streams.iter().map(|a| a.stride()).sum::<usize>();
        let goal_stride = goals.len() / vertices.len().max(1);
        let key = |i: u32| &keys[i as usize * stride..][..stride];
        let goal = |i: u32| &goals[i as usize * goal_stride..][..goal_stride];
        let of = |i: u32| vertices[i as usize];
        let mut sorted: Vec<u32> = (0..vertices.len() as u32).collect();
        sorted.sort_unstable_by_key(|&i| {
            let Class { last_level, moves, .. } = of(i);
            (key(i), Reverse(last_level), moves, if moves { goal(i) } else { &[] }, i)
        });
        let mut leader = vec![0; vertices.len()];
        for same in sorted.chunk_by(|&i, &j| key(i) == key(j)) {
            // A vertex that stays is stored as the one that the coarsest level draws, which moves
            // later if at all; one that moves, as the first that goes to the same place at its
            // level.
            let mut current = same[0];
            for &i in same {
                let alike = !of(i).moves
                    || of(i).last_level == of(current).last_level
                        && of(current).moves
                        && goal(i) == goal(current);
                if !alike {
                    current = i;
                }
                leader[i as usize] = if of(i).moves { current } else { same[0] };
            }
        }
        // Classes are numbered as their first vertices come.
        let (mut classes, mut number) = (Vec::new(), vec![NONE; vertices.len()]);
        let mut class_of = leader.into_iter().map(|leader: u32| {
            let number = &mut number[leader as usize];
            if *number == NONE {
                *number = classes.len() as u32;
                classes.push(of(leader));
            }
            *number
        });
        let member = |&submesh: &usize| Member {
            submesh,
            drawn: &drawn[submesh],
            classes: class_of.by_ref().take(drawn[submesh].vertices.len()).collect(),
        };
        let members = submeshes.iter().map(member).collect();
        let levels = ways.map_or(0, |ways| ways.moving.len());
        Self { members, classes, stride: stride + goal_stride, levels }
    }

    /// Adds the buffers that several submeshes share, where that saves bytes.
    fn share(&self, buffers: &mut VertexBuffers) {
        // Families have no class in common.
        let mut number = vec![NONE; self.classes.len()];
        for family in self.families() {
            let members = || family.iter().map(|&m| &self.members[m]);
            // The classes of the family in the order of their first use.
            let mut used: Vec<u32> = Vec::new();
            for &class in members().flat_map(|member| &member.classes) {
                let number = &mut number[class as usize];
                if *number == NONE {
                    *number = used.len() as u32;
                    used.push(class);
                }
            }
            if !self.saves_bytes(&family, used.len()) {
                continue;
            }
            let class = |number: &u32| self.classes[*number as usize];
            used.sort_by_key(|c| (Reverse(class(c).last_level), class(c).moves));
            (0..).zip(&used).for_each(|(n, &class)| number[class as usize] = n);
            for member in members() {
                for (&class, &v) in member.classes.iter().zip(&member.drawn.vertices) {
                    buffers.numbers[v as usize] = number[class as usize];
                }
                buffers.of_submesh[member.submesh] = buffers.vertices.len();
            }
            let run = |level: usize| {
                let level = level as u32;
                let before = |c: &u32| {
                    let Class { last_level, moves, .. } = class(c);
                    last_level > level || last_level == level && !moves
                };
                used.partition_point(before)..used.partition_point(|c| class(c).last_level >= level)
            };
            buffers.runs.push((0..self.levels).map(run).collect());
            buffers.vertices.push(used.iter().map(|c| class(c).vertex).collect());
        }
    }

    /// Members that share enough vertices with each other, directly or by others.
    fn families(&self) -> impl Iterator<Item = Vec<usize>> {
        let mut user = vec![NONE; self.classes.len()];
        let mut is_shared = vec![false; self.classes.len()];
        for (m, member) in (0..).zip(&self.members) {
            for &class in &member.classes {
                let user = &mut user[class as usize];
                is_shared[class as usize] |= *user != NONE && *user != m;
                *user = m;
            }
        }
        let shares_enough = |member: &Member<'_>| {
            let shared = member.classes.iter().filter(|&&class| is_shared[class as usize]).count();
            shared as f64 >= MIN_SHARED * member.classes.len() as f64
        };
        let mut sets = DisjointSets::new(self.members.len());
        user.fill(NONE);
        let sharing = (0..).zip(&self.members).filter(|(_, member)| shares_enough(member));
        for (m, member) in sharing {
            for &class in &member.classes {
                let user = &mut user[class as usize];
                if *user != NONE {
                    sets.join(*user, m);
                }
                *user = m;
            }
        }
        let mut families: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for m in 0..self.members.len() {
            families.entry(sets.find(m as u32)).or_default().push(m);
        }
        families.into_values().filter(|members| members.len() > 1)
    }

    /// Returns whether one buffer of `count` vertices takes fewer bytes than one for each member.
    /// Indices into it may be wider.
    fn saves_bytes(&self, family: &[usize], count: usize) -> bool {
        let bytes = |vertices: usize, indices: usize| {
            let wide = u16::try_from(vertices).is_err();
            vertices * self.stride + indices * if wide { 4 } else { 2 }
        };
        let drawn = || family.iter().map(|&m| self.members[m].drawn);
        let apart: usize = drawn().map(|d| bytes(d.vertices.len(), d.indices)).sum();
        bytes(count, drawn().map(|d| d.indices).sum()) < apart
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::{MeshParts, Submesh};

    /// A grid of `side`² quads whose triangles belong to the submesh that `submesh` says, with
    /// vertices of its own for each.
    fn grid(side: u32, submeshes: u32, submesh: impl Fn(u32) -> u32) -> Mesh {
        let corner = |x: u32, y: u32| y * (side + 1) + x;
        let quads = (0..side * side).map(|q| (q % side, q / side));
        let triangles: Vec<[u32; 3]> = quads
            .flat_map(|(x, y)| {
                let [a, b] = [corner(x, y), corner(x + 1, y)];
                let [c, d] = [corner(x, y + 1), corner(x + 1, y + 1)];
                [[a, b, d], [a, d, c]]
            })
            .collect();
        let mut parts = MeshParts::default();
        for s in 0..submeshes {
            let mut number = BTreeMap::new();
            let first_triangle = parts.triangles.len() as u32;
            for (_, t) in (0..).zip(&triangles).filter(|(i, _)| submesh(*i) == s) {
                parts.triangles.push(t.map(|v| {
                    *number.entry(v).or_insert_with(|| {
                        let [x, y] = [v % (side + 1), v / (side + 1)].map(|c| c as f32);
                        parts.positions.push([x, y, 0.0]);
                        parts.vertex_submesh.push(s);
                        parts.positions.len() as u32 - 1
                    })
                }));
            }
            parts.submeshes.push(Submesh {
                first_triangle,
                triangle_count: parts.triangles.len() as u32 - first_triangle,
                attributes: vec![],
            });
        }
        Mesh::try_from(parts).expect("a mesh")
    }

    fn buffers(mesh: &Mesh) -> VertexBuffers {
        VertexBuffers::new(mesh, super::super::drawn(mesh), |_| 0)
    }

    /// Every triangle has the corners that it had.
    fn check(mesh: &Mesh, buffers: &VertexBuffers) {
        for (s, submesh) in mesh.submeshes().iter().enumerate() {
            let corners = mesh.triangles()[submesh.triangles()].as_flattened();
            for (&v, i) in corners.iter().zip(buffers.indices(corners)) {
                let written = buffers.vertices(s)[i as usize];
                assert_eq!(mesh.positions()[written as usize], mesh.positions()[v as usize]);
            }
        }
    }

    #[test]
    fn scattered_materials_share_one_buffer() {
        let mesh = grid(16, 4, |t| t * 7 % 4);
        let buffers = buffers(&mesh);
        check(&mesh, &buffers);
        assert_eq!(buffers.vertices.len(), 1);
        assert_eq!(buffers.vertices(0).len(), 17 * 17);
    }

    #[test]
    fn what_meets_at_a_border_alone_has_buffers_of_its_own() {
        let mesh = grid(32, 2, |t| t / (32 * 32));
        let buffers = buffers(&mesh);
        check(&mesh, &buffers);
        assert_eq!(buffers.vertices.len(), 2);
    }

    #[test]
    fn families_share_apart_from_each_other() {
        // Two materials scattered below, two above, and a wide band of a fifth between them.
        let mesh = grid(32, 5, |t| match t / 64 {
            0..4 => t % 2,
            4..28 => 4,
            _ => 2 + t % 2,
        });
        let buffers = buffers(&mesh);
        check(&mesh, &buffers);
        assert_eq!(buffers.of_submesh(0), buffers.of_submesh(1));
        assert_eq!(buffers.of_submesh(2), buffers.of_submesh(3));
        assert_eq!(buffers.vertices.len(), 3);
    }

    #[test]
    fn one_buffer_that_needs_wide_indices_has_to_save_more_than_it_costs() {
        // Two halves that fit 16 bits each, an eighth of their vertices shared.
        let striped = |side: u32| grid(side, 2, move |t| (t / 2 % side) / 16 % 2);
        let small = buffers(&striped(128));
        assert_eq!(small.vertices.len(), 1);
        let large = striped(320);
        let buffers = buffers(&large);
        check(&large, &buffers);
        assert_eq!(buffers.vertices.len(), 2);
    }

    #[test]
    fn what_coarse_levels_draw_comes_first() {
        let mesh = grid(8, 2, |t| t % 2);
        let level = |v: u32| v % 3;
        let buffers = VertexBuffers::new(&mesh, super::super::drawn(&mesh), level);
        check(&mesh, &buffers);
        let mut last = BTreeMap::new();
        for v in 0..mesh.vertex_count() as u32 {
            let key = mesh.positions()[v as usize].map(f32::to_bits);
            let last = last.entry(key).or_insert(0);
            *last = level(v).max(*last);
        }
        let order: Vec<u32> = buffers
            .vertices(0)
            .iter()
            .map(|&v| last[&mesh.positions()[v as usize].map(f32::to_bits)])
            .collect();
        assert!(order.is_sorted_by(|a, b| a >= b), "{order:?}");
    }

    #[test]
    fn what_moves_alike_is_shared_and_a_run() {
        let mesh = grid(8, 2, |t| t % 2);
        let level = |v: u32| mesh.positions()[v as usize][0] as u32 % 3;
        // Vertices of the two finest levels move down, of the second submesh some move further.
        let mut parts = mesh.clone().into_parts();
        for (position, submesh) in parts.positions.iter_mut().zip(&parts.vertex_submesh) {
            if position[0] as u32 % 3 < 2 {
                position[2] = if *submesh == 1 && position[1] == 4.0 { 2.0 } else { 1.0 };
            }
        }
        let next = Mesh::try_from(parts).expect("a mesh");
        let all = 0..mesh.vertex_count() as u32;
        let moving = vec![Some(all.clone()), Some(all.clone()), None];
        let streams = MovedStreams::default();
        let ways = Ways { mesh: &mesh, next: &next, moving: &moving, streams };
        let drawn = super::super::drawn(&mesh);
        let buffers = VertexBuffers::morphing(drawn, level, ways);
        check(&mesh, &buffers);
        assert_eq!(buffers.vertices.len(), 1);
        // Of a row of nine the six that move are there twice.
        assert_eq!(buffers.vertices(0).len(), 9 * 9 + 6);
        for v in all {
            let submesh = mesh.vertex_submesh()[v as usize] as usize;
            let number = buffers.indices(&[v])[0] as usize;
            let written = buffers.vertices(submesh)[number];
            assert_eq!(next.positions()[written as usize], next.positions()[v as usize]);
            for moved in 0..2 {
                let run = buffers.run(submesh, moved);
                assert_eq!(run.contains(&number), level(v) as usize == moved, "{v} {run:?}");
            }
            assert!(buffers.run(submesh, 2).is_empty());
        }
    }
}
