//! The link condition (Dey et al. 1999): collapsing an edge keeps the surface's topology exactly if
//! the groups next to both ends are those opposite the edge, and no face would come to lie on
//! another.

use crate::working::{OPEN, WorkingMesh};

/// Marks of groups, used again without being cleared.
#[derive(Default)]
pub(crate) struct Marks {
    marks: Vec<u32>,
    epoch: u32,
}

impl Marks {
    /// Two fresh values that no group is marked with.
    fn fresh(&mut self, groups: usize) -> (u32, u32) {
        if self.marks.len() < groups {
            self.marks.resize(groups, 0);
        }
        if self.epoch > u32::MAX - 4 {
            self.marks.fill(0);
            self.epoch = 0;
        }
        self.epoch += 2;
        (self.epoch, self.epoch + 1)
    }
}

/// The neighbourhood that both ends of an edge share.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Link {
    /// Whether the condition holds.
    pub(crate) holds: bool,
    pub(crate) shared_faces: usize,
}

impl Link {
    pub(crate) fn new(mesh: &WorkingMesh, from: u32, to: u32, marks: &mut Marks) -> Self {
        if !mesh.has(from, OPEN) && !mesh.has(to, OPEN) && mesh.valence(from) > 3 {
            Self::closed(mesh, from, to, marks)
        } else {
            Self::general(mesh, from, to, marks)
        }
    }

    /// Between closed fans: the groups on both sides of the edge are common, and no others may be.
    /// With more than three neighbours they are not next to each other around `from`.
    fn closed(mesh: &WorkingMesh, from: u32, to: u32, marks: &mut Marks) -> Self {
        let (near, _) = marks.fresh(mesh.places.len());
        let marks = &mut marks.marks;
        let mut found = false;
        for corner in mesh.star(from) {
            marks[corner.ahead as usize] = near;
            found |= corner.ahead == to;
        }
        if !found {
            return Self { holds: false, shared_faces: 0 };
        }
        let common = mesh.star(to).iter().filter(|c| marks[c.ahead as usize] == near).count();
        Self { holds: common == 2, shared_faces: 2 }
    }

    /// Between any two stars.
    fn general(mesh: &WorkingMesh, from: u32, to: u32, marks: &mut Marks) -> Self {
        let (near, common) = marks.fresh(mesh.places.len());
        let marks = &mut marks.marks;
        let star = mesh.star(from);
        let others = |corner| mesh.others(corner);
        let mut shared_faces = 0;
        let (mut apexes, mut apex) = (0, [u32::MAX; 2]);
        for &corner in star {
            let [g, h] = others(corner);
            marks[g as usize] = near;
            marks[h as usize] = near;
            if g == to || h == to {
                shared_faces += 1;
                let opposite = if g == to { h } else { g };
                if !apex.contains(&opposite) {
                    apex[apexes.min(1)] = opposite;
                    apexes += 1;
                }
            }
        }
        let mut in_both = 0;
        let mut meet = |marks: &mut Vec<u32>, g: u32| {
            if marks[g as usize] == near {
                marks[g as usize] = common;
                in_both += 1;
            }
        };
        if mesh.valence(to) <= 64 + 8 * star.len() {
            mesh.each_neighbour(to, |g| meet(marks, g));
        } else {
            // A hub: asking the few neighbours of `from` is shorter than asking its many.
            for g in star.iter().flat_map(|&c| others(c)) {
                if g != to && mesh.star(g).iter().any(|&c| others(c).contains(&to)) {
                    meet(marks, g);
                }
            }
        }
        let manifold =
            (1..=2).contains(&shared_faces) && in_both == apexes && apexes == shared_faces;
        let vanishes = star.len() == shared_faces && mesh.valence(to) == shared_faces;
        let doubles = || {
            star.iter().any(|&corner| {
                let [g, h] = others(corner);
                marks[g as usize] == common
                    && marks[h as usize] == common
                    && mesh
                        .star(g)
                        .iter()
                        .any(|&c| others(c).contains(&h) && others(c).contains(&to))
            })
        };
        Self { holds: manifold && !vanishes && !doubles(), shared_faces }
    }
}
