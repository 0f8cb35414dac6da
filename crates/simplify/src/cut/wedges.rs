//! The wedges (vertices) of every group in flat arrays: their submesh, the input vertices that
//! position and attributes come from, and which wedges have equal attributes.

use crate::number::{Input, Wedge, same_attributes};
use lodc_mesh::{Mesh, NONE};

/// Where the data of a fake come from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FakeSource {
    /// The input vertex whose position, joints, weights and morph position deltas it has.
    pub(crate) position: u32,
    /// The input vertex whose other attributes it has.
    pub(crate) attributes: u32,
    pub(crate) submesh: u32,
}

/// The wedges of one region, originals first, fakes after them. A fake has the position of one
/// vertex of the input and the attributes of another.
///
/// If every group has one wedge and nothing is compared, all lists are empty: wedge and group
/// have the same number.
#[derive(Default)]
pub(crate) struct Wedges {
    /// The number of each wedge in the whole mesh; a fake gets its own after a round.
    pub(crate) ids: Vec<u32>,
    /// The input vertex whose position, joints, weights and morph position deltas the wedge has.
    pub(crate) position_source: Vec<u32>,
    /// The input vertex whose other attributes it has.
    pub(crate) attribute_source: Vec<u32>,
    submesh: Vec<u32>,
    /// Equal for the wedges of a group with the same attributes.
    class: Vec<u32>,
    /// Equal for those between which there is no seam; empty if these are the same.
    seam_class: Vec<u32>,
    /// The first wedge of each group; `NONE` for none.
    first: Vec<u32>,
    /// The next wedge of the same group; `NONE` at the end.
    next: Vec<u32>,
    /// Number of wedges that are no fakes of this round.
    numbered: usize,
}

impl Wedges {
    /// Empties all lists, which keep their capacity.
    pub(super) fn clear(&mut self) {
        let Self { ids, position_source, attribute_source, submesh, class, .. } = self;
        for list in [ids, position_source, attribute_source, submesh, class] {
            list.clear();
        }
        for list in [&mut self.seam_class, &mut self.first, &mut self.next] {
            list.clear();
        }
        self.numbered = 0;
    }

    /// Returns whether each wedge is a group, with the same number, and the lists are empty.
    pub(crate) fn is_bare(&self) -> bool {
        self.ids.is_empty()
    }

    /// Returns the data of a wedge. Not for bare lists.
    pub(crate) fn wedge(&self, w: u32) -> Wedge {
        let w = w as usize;
        Wedge {
            id: self.ids[w],
            position_source: self.position_source[w],
            attribute_source: self.attribute_source[w],
            submesh: self.submesh[w],
            class: self.class[w],
            seam_class: self.seam_class(w as u32),
        }
    }

    /// Adds a wedge that belongs to no group yet.
    pub(super) fn push(&mut self, wedge: Wedge) -> u32 {
        self.ids.push(wedge.id);
        self.position_source.push(wedge.position_source);
        self.attribute_source.push(wedge.attribute_source);
        self.submesh.push(wedge.submesh);
        if self.seam_class.is_empty() && wedge.seam_class != wedge.class {
            self.seam_class.clone_from(&self.class);
        }
        if !self.seam_class.is_empty() || wedge.seam_class != wedge.class {
            self.seam_class.push(wedge.seam_class);
        }
        self.class.push(wedge.class);
        self.next.push(NONE);
        self.numbered = self.ids.len();
        self.numbered as u32 - 1
    }

    /// Makes consecutive wedges those of the next group.
    pub(super) fn push_group(&mut self, wedges: std::ops::Range<u32>) {
        self.first.push(if wedges.is_empty() { NONE } else { wedges.start });
        for w in wedges.skip(1) {
            self.next[w as usize - 1] = w;
        }
    }

    /// Equal for the wedges of a group with the same attributes.
    #[inline]
    pub(crate) fn class(&self, w: u32) -> u32 {
        self.class.get(w as usize).copied().unwrap_or(w)
    }

    /// Equal for the wedges of a group between which there is no seam.
    #[inline]
    pub(crate) fn seam_class(&self, w: u32) -> u32 {
        self.seam_class.get(w as usize).copied().unwrap_or_else(|| self.class(w))
    }

    #[inline]
    pub(crate) fn submesh(&self, w: u32) -> u32 {
        self.submesh.get(w as usize).copied().unwrap_or(0)
    }

    /// The wedges of a group.
    pub(crate) fn of_group(&self, group: u32) -> impl Iterator<Item = u32> + '_ {
        let start = if self.is_bare() { group } else { self.first[group as usize] };
        std::iter::successors((start != NONE).then_some(start), |&w| {
            let next = self.next.get(w as usize).copied().unwrap_or(NONE);
            (next != NONE).then_some(next)
        })
    }

    /// Returns whether a group has one wedge only.
    pub(crate) fn is_single(&self, group: u32) -> bool {
        if self.is_bare() {
            return true;
        }
        let first = self.first[group as usize];
        first != NONE && self.next[first as usize] == NONE
    }

    /// Makes a fake at `group` in the submesh of `wedge`, with the position of one wedge and the
    /// attributes of another.
    pub(crate) fn add_fake(
        &mut self,
        input: &Input<'_>,
        group: u32,
        wedge: u32,
        [position_wedge, attribute_wedge]: [u32; 2],
    ) -> u32 {
        let w = self.ids.len() as u32;
        if input.ignores_attributes() {
            if self.seam_class.is_empty() {
                self.seam_class.clone_from(&self.class);
            }
            let class = self.meets_smoothly(input, wedge, group);
            self.seam_class.push(class.map_or(NONE - w, |same| self.seam_class(same)));
        }
        self.ids.push(NONE);
        self.position_source.push(self.position_source[position_wedge as usize]);
        self.attribute_source.push(self.attribute_source[attribute_wedge as usize]);
        self.submesh.push(self.submesh[wedge as usize]);
        // A class of its own until `number_fakes`: counted down from the greatest number, where no
        // wedge of the whole mesh has one.
        self.class.push(NONE - w);
        self.next.push(self.first[group as usize]);
        self.first[group as usize] = w;
        w
    }

    /// Returns the number of fakes since the last numbering.
    pub(crate) fn new_fakes(&self) -> usize {
        self.ids.len() - self.numbered
    }

    /// Numbers the new fakes from `first` on and returns where their data come from.
    pub(crate) fn number_fakes(&mut self, first: u32) -> impl Iterator<Item = FakeSource> + '_ {
        let start = std::mem::replace(&mut self.numbered, self.ids.len());
        for (w, id) in (start..self.ids.len()).zip(first..) {
            self.ids[w] = id;
            if self.seam_class.get(w) == Some(&(NONE - w as u32)) {
                self.seam_class[w] = id;
            }
            self.class[w] = id;
        }
        let numbered = start..self.ids.len();
        numbered.map(|w| FakeSource {
            position: self.position_source[w],
            attributes: self.attribute_source[w],
            submesh: self.submesh[w],
        })
    }

    /// Makes `from`'s wedges wedges of `to`.
    pub(crate) fn merge_groups(&mut self, from: u32, to: u32) {
        let Some(last) = self.of_group(from).last() else { return };
        self.next[last as usize] = self.first[to as usize];
        self.first[to as usize] = std::mem::replace(&mut self.first[from as usize], NONE);
    }

    /// A wedge at a group between which and another wedge there would be no seam.
    pub(crate) fn meets_smoothly(&self, input: &Input<'_>, wedge: u32, group: u32) -> Option<u32> {
        let source = |w: u32| self.attribute_source[w as usize];
        // Bounded as elsewhere: real meshes have a handful of wedges at a position.
        self.of_group(group).take(64).find(|&t| {
            self.submesh(t) == self.submesh(wedge) && input.meets_smoothly(source(t), source(wedge))
        })
    }

    /// Leaves `group` without wedges.
    pub(crate) fn clear_group(&mut self, group: u32) {
        if let Some(first) = self.first.get_mut(group as usize) {
            *first = NONE;
        }
    }

    /// Returns whether two wedges of submeshes with the same streams have, bit for bit, the same
    /// attributes, spatial ones left aside.
    pub(crate) fn alike_across(&self, input: &Input<'_>, a: u32, b: u32) -> bool {
        let source = |w: u32| self.attribute_source[w as usize];
        let submeshes = input.mesh.submeshes();
        let streams = |w: u32| &submeshes[self.submesh(w) as usize].attributes;
        streams(a) == streams(b) && same_attributes(input.mesh, source(a), source(b))
    }

    /// Returns whether two wedges have the same submesh and, bit for bit, the same attributes,
    /// spatial ones left aside.
    pub(crate) fn alike(&self, mesh: &Mesh, a: u32, b: u32) -> bool {
        let source = |w: u32| self.attribute_source[w as usize];
        self.submesh(a) == self.submesh(b) && same_attributes(mesh, source(a), source(b))
    }
}
