//! The wedges of every group: which vertices are there, where their data comes from, and which are
//! alike.

use lodc_mesh::{Mesh, Semantic};

pub(crate) const NONE: u32 = u32::MAX;

/// All wedges, originals first, fakes after them. A fake is where one vertex's position data meets
/// another's attributes, so two numbers say all about it.
pub(crate) struct Wedges {
    /// The input vertex whose position, joints, weights and morph position deltas the wedge has.
    pub(crate) place_of: Vec<u32>,
    /// The input vertex whose other attributes it has.
    pub(crate) attributes_of: Vec<u32>,
    pub(crate) submesh: Vec<u32>,
    /// The first wedge of its group with the same attributes, which may be itself.
    pub(crate) class: Vec<u32>,
    first: Vec<u32>,
    next: Vec<u32>,
}

impl Wedges {
    /// `vertex_of` names the input vertex of each wedge; wedges of a group are consecutive:
    /// `bounds[g]..bounds[g + 1]`.
    pub(crate) fn new(mesh: &Mesh, vertex_of: Vec<u32>, bounds: &[u32]) -> Self {
        let submesh: Vec<u32> =
            vertex_of.iter().map(|&v| mesh.vertex_submesh()[v as usize]).collect();
        let mut class: Vec<u32> = (0..vertex_of.len() as u32).collect();
        let mut next = vec![NONE; vertex_of.len()];
        let mut first = vec![NONE; bounds.len() - 1];
        for (g, range) in bounds.windows(2).enumerate() {
            if range[0] < range[1] {
                first[g] = range[0];
            }
            for w in range[0]..range[1] {
                if w + 1 < range[1] {
                    next[w as usize] = w + 1;
                }
                // Beyond a few dozen wedges in one place nobody gains from finding the like ones.
                let alike = (range[0]..w).take(64).find(|&u| {
                    class[u as usize] == u
                        && submesh[u as usize] == submesh[w as usize]
                        && same_attributes(mesh, vertex_of[u as usize], vertex_of[w as usize])
                });
                if let Some(u) = alike {
                    class[w as usize] = u;
                }
            }
        }
        Self { place_of: vertex_of.clone(), attributes_of: vertex_of, submesh, class, first, next }
    }

    /// The wedges of a group.
    pub(crate) fn of_group(&self, group: u32) -> impl Iterator<Item = u32> + '_ {
        let start = self.first[group as usize];
        std::iter::successors((start != NONE).then_some(start), |&w| {
            let next = self.next[w as usize];
            (next != NONE).then_some(next)
        })
    }

    /// Whether a group has one wedge only.
    pub(crate) fn is_single(&self, group: u32) -> bool {
        let first = self.first[group as usize];
        first != NONE && self.next[first as usize] == NONE
    }

    /// Makes a fake at `group`: where `place` is, looking as `attributes` does.
    pub(crate) fn add_fake(&mut self, group: u32, place: u32, attributes: u32) -> u32 {
        let w = self.submesh.len() as u32;
        self.place_of.push(self.place_of[place as usize]);
        self.attributes_of.push(self.attributes_of[attributes as usize]);
        self.submesh.push(self.submesh[attributes as usize]);
        self.class.push(w);
        self.next.push(self.first[group as usize]);
        self.first[group as usize] = w;
        w
    }

    /// `from`'s wedges have become wedges of `to`.
    pub(crate) fn merge_groups(&mut self, from: u32, to: u32) {
        let Some(last) = self.of_group(from).last() else { return };
        self.next[last as usize] = self.first[to as usize];
        self.first[to as usize] = std::mem::replace(&mut self.first[from as usize], NONE);
    }

    /// `group`'s wedges are gone.
    pub(crate) fn clear_group(&mut self, group: u32) {
        self.first[group as usize] = NONE;
    }

    /// Whether two wedges have the same attributes, bit for bit, besides those that say where they
    /// are.
    pub(crate) fn alike(&self, mesh: &Mesh, a: u32, b: u32) -> bool {
        self.submesh[a as usize] == self.submesh[b as usize]
            && same_attributes(mesh, self.attributes_of[a as usize], self.attributes_of[b as usize])
    }
}

/// Tangents do not count: they follow from normals and texture coordinates, and exporters make them
/// anew for each face.
fn same_attributes(mesh: &Mesh, a: u32, b: u32) -> bool {
    let compared =
        mesh.attributes().iter().filter(|s| !s.is_spatial() && s.semantic != Semantic::Tangent);
    a == b || compared.into_iter().all(|s| s.at(a) == s.at(b))
}
