//! For the splits of high-valence vertices: the triangles that a new vertex takes
//! over from the star, found in linear time without visiting the whole star at each split.

/// The triangles that some vertices take over.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaceLists {
    /// The vertices, in falling order.
    vertices: Vec<u32>,
    /// For each of `vertices` the end of its triangles in `faces`.
    ends: Vec<u32>,
    /// Triangles by their numbers in the stream.
    faces: Vec<u32>,
}

/// The triangles of a mesh in stream order, as vertices take them over.
pub(crate) struct Transfers<'a> {
    /// The target of each vertex.
    pub(crate) targets: &'a [u32],
    /// For each vertex the first triangle that comes with it; last the number of triangles.
    pub(crate) first_triangle: &'a [u32],
    /// The vertex of LOD 0 at each corner (4 × triangle + 0, 1 or 2; the fourth is unused).
    pub(crate) final_vertices: &'a [u32],
}

impl Transfers<'_> {
    /// Collects what these vertices, in falling order, take over. Linear time: going backwards
    /// through the stream, every vertex has a ring of its corners, which is joined to that of its
    /// target when the vertex disappears. A ring holds corners and, behind their numbers, its
    /// vertex.
    pub(crate) fn face_lists(&self, vertices: Vec<u32>) -> FaceLists {
        let (mut ends, mut faces) = (Vec::with_capacity(vertices.len()), Vec::new());
        let mut wanted = vertices.iter().peekable();
        let mut rings = CircularLists::new(self.final_vertices.len() + self.targets.len());
        let ring_of = |vertex: u32| self.final_vertices.len() as u32 + vertex;
        for (corner, &vertex) in (0..).zip(self.final_vertices) {
            if corner & 3 < 3 {
                rings.join(ring_of(vertex), corner);
            }
        }
        for new in (0..self.targets.len() as u32).rev() {
            if wanted.peek().is_none() {
                break;
            }
            let [from, to] = [new, new + 1].map(|v| self.first_triangle[v as usize]);
            (4 * from..4 * to).for_each(|corner| rings.isolate(corner));
            let ring = ring_of(new);
            if wanted.next_if_eq(&&new).is_some() {
                faces.extend(rings.others(ring).map(|corner| corner >> 2));
                ends.push(faces.len() as u32);
            }
            rings.join(ring_of(self.targets[new as usize]), ring);
            rings.isolate(ring);
        }
        FaceLists { vertices, ends, faces }
    }
}

impl FaceLists {
    /// Returns the triangles of a vertex, if it is one of these.
    pub(crate) fn triangles(&self, vertex: u32) -> Option<&[u32]> {
        let index = self.vertices.binary_search_by(|v| vertex.cmp(v)).ok()?;
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        Some(&self.faces[start as usize..self.ends[index] as usize])
    }
}

/// Circular doubly linked lists of numbers; each number is in one of them.
struct CircularLists {
    next: Vec<u32>,
    previous: Vec<u32>,
}

impl CircularLists {
    /// Makes a ring of each number below `count`.
    fn new(count: usize) -> Self {
        let numbers: Vec<u32> = (0..count as u32).collect();
        Self { next: numbers.clone(), previous: numbers }
    }

    /// Joins the rings of two numbers, which are not in the same one.
    fn join(&mut self, a: u32, b: u32) {
        let [after_a, after_b] = [a, b].map(|i| self.next[i as usize]);
        self.link(a, after_b);
        self.link(b, after_a);
    }

    /// Takes a number out of its ring, into a ring of its own.
    fn isolate(&mut self, i: u32) {
        self.link(self.previous[i as usize], self.next[i as usize]);
        self.link(i, i);
    }

    /// Iterates over the other numbers in the ring of one.
    fn others(&self, i: u32) -> impl Iterator<Item = u32> + '_ {
        let next = |i: u32| self.next[i as usize];
        std::iter::successors(Some(next(i)), move |&i| Some(next(i))).take_while(move |&j| j != i)
    }

    fn link(&mut self, before: u32, after: u32) {
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
    }
}
