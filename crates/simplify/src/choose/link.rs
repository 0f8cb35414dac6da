//! The link condition (Dey et al. 1999): collapsing an edge keeps the surface's topology exactly if
//! the only groups next to both ends are those opposite the edge, and no face would come to lie on
//! another. Where several films meet in one edge, they must not lose it: none of them may end
//! there, and no two points where such lines meet may become one.

use crate::cut::{HIGH_VALENCE, IS_HIGH_VALENCE, OPEN, WorkingMesh};
use lodc_mesh::NONE;

/// Groups that are compared at a time: two registers of four lanes. Groups have six neighbours on
/// average.
const BATCH: usize = 8;
/// Edges of more faces than this keep no topology. Chosen by hand: foams have three or four, panels
/// on beams a few more.
const MAX_FILMS: usize = 8;
/// Pairs of high-valence groups that are remembered as not neighbours; each question
/// about another pair takes a pass over a star. Chosen by hand: bipyramids and the like have a few.
const MAX_PAIRS: usize = 64;

/// Marks of groups, used again without being cleared.
#[derive(Default)]
pub(crate) struct Marks {
    /// By group.
    marks: Vec<u32>,
    /// The last values that groups were marked with: this and the next.
    epoch: u32,
    /// Pairs of high-valence groups that share no face.
    apart: Vec<[u32; 2]>,
    /// [`WorkingMesh::high_valence_epoch`] for which that holds.
    high_valence_epoch: u32,
}

impl Marks {
    /// Returns whether a group shares a face with a high-valence group. Two high-valence groups
    /// that do not are remembered, since finding out takes a pass over one of their stars.
    fn touches_high_valence(&mut self, mesh: &WorkingMesh, group: u32, large: u32) -> bool {
        if self.high_valence_epoch != mesh.high_valence_epoch {
            self.high_valence_epoch = mesh.high_valence_epoch;
            self.apart.clear();
        }
        if self.apart.contains(&[group, large]) {
            return false;
        }
        let touches = mesh.star(group).iter().any(|&c| mesh.others(c).contains(&large));
        if !touches && mesh.has(group, IS_HIGH_VALENCE) && self.apart.len() < MAX_PAIRS {
            self.apart.push([group, large]);
        }
        touches
    }

    /// Two values that no group is marked with yet.
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
    /// True if the link condition holds.
    pub(crate) holds: bool,
    /// Number of faces with a corner at both ends: those that the collapse removes.
    pub(super) shared_faces: usize,
    /// True if no face of either end is left.
    pub(super) vanishes: bool,
}

impl Link {
    pub(crate) fn new(mesh: &WorkingMesh, from: u32, to: u32, marks: &mut Marks) -> Self {
        if !mesh.has(from, OPEN) && !mesh.has(to, OPEN) && mesh.valence(from) > 3 {
            Self::closed(mesh, from, to)
        } else {
            Self::general(mesh, from, to, marks)
        }
    }

    /// Between closed fans: the two groups opposite the edge are common neighbours, and there may
    /// be no others. As `from` has more than three neighbours, those two share no face with it.
    fn closed(mesh: &WorkingMesh, from: u32, to: u32) -> Self {
        let mut near = [NONE; BATCH];
        let mut found = false;
        let mut common = 0;
        for ring in mesh.star(from).chunks(BATCH) {
            for (near, corner) in near.iter_mut().zip(ring) {
                *near = corner.ahead;
            }
            near[ring.len()..].fill(NONE);
            found |= near.contains(&to);
            let is_near = |group: u32| near.iter().fold(false, |any, &g| any | (g == group));
            common += mesh.star(to).iter().filter(|c| is_near(c.ahead)).count();
        }
        let shared_faces = if found { 2 } else { 0 };
        Self { holds: found && common == 2, shared_faces, vanishes: false }
    }

    /// Between any two stars. Neighbours of `from` are marked with `near`, those of both ends with
    /// `common`.
    fn general(mesh: &WorkingMesh, from: u32, to: u32, marks: &mut Marks) -> Self {
        let (near, common) = marks.fresh(mesh.group_positions.len());
        let star = mesh.star(from);
        let others = |corner| mesh.others(corner);
        let mut shared_faces = 0;
        let (mut apexes, mut apex) = (0, [NONE; MAX_FILMS]);
        for &corner in star {
            let [g, h] = others(corner);
            marks.marks[g as usize] = near;
            marks.marks[h as usize] = near;
            if g == to || h == to {
                shared_faces += 1;
                let opposite = if g == to { h } else { g };
                if !apex.contains(&opposite) {
                    apex[apexes.min(MAX_FILMS - 1)] = opposite;
                    apexes += 1;
                }
            }
        }
        let mut in_both = 0;
        let mut meet = |marks: &mut Marks, g: u32| {
            if marks.marks[g as usize] == near {
                marks.marks[g as usize] = common;
                in_both += 1;
            }
        };
        // The second way takes a pass over each neighbour's star, of about eight corners, and has
        // some cost of its own, set to 64 by hand.
        if mesh.valence(to) <= 64 + 8 * star.len() {
            mesh.each_neighbour(to, |g| meet(marks, g));
        } else {
            // `to` is a high-valence group: it has more neighbours than `from`.
            for g in star.iter().flat_map(|&c| others(c)).filter(|&g| g != to) {
                if marks.marks[g as usize] == near && marks.touches_high_valence(mesh, g, to) {
                    meet(marks, g);
                }
            }
        }
        let marks = &marks.marks;
        let is_plain = in_both == apexes && apexes == shared_faces;
        let keeps_lines = || match shared_faces {
            0 => false,
            1..=2 => true,
            3..=MAX_FILMS => keeps_lines(mesh, [from, to], &apex[..apexes]),
            _ => false,
        };
        let manifold = is_plain && keeps_lines();
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
        Self { holds: manifold && !vanishes && !doubles(), shared_faces, vanishes }
    }
}

/// Returns whether the lines in which films meet stay what they are when an edge of several films
/// collapses: no film has another side on such a line, and not both ends are points where lines
/// meet.
fn keeps_lines(mesh: &WorkingMesh, ends: [u32; 2], apexes: &[u32]) -> bool {
    let faces = |end: u32, other: u32| {
        mesh.star(end).iter().filter(|&&corner| mesh.others(corner).contains(&other)).count()
    };
    let is_line = |end: u32, other: u32| faces(end, other) != 2;
    !apexes.iter().any(|&apex| ends.iter().all(|&end| is_line(end, apex)))
        && !ends.iter().all(|&end| is_junction(mesh, end))
}

/// Returns whether other than two lines meet at a group. A high-valence group counts as one where
/// they do.
fn is_junction(mesh: &WorkingMesh, group: u32) -> bool {
    let mut ends = [NONE; 2 * HIGH_VALENCE];
    let Some(ends) = ends.get_mut(..2 * mesh.valence(group)) else { return true };
    let star = mesh.star(group).iter().flat_map(|&corner| mesh.others(corner));
    ends.iter_mut().zip(star).for_each(|(end, other)| *end = other);
    ends.sort_unstable();
    ends.chunk_by(|a, b| a == b).filter(|faces| faces.len() != 2).count() != 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::Region;
    use crate::number::Input;
    use lodc_mesh::{Mesh, MeshParts, Submesh};

    fn links(triangles: &[[u32; 3]], from: u32, to: u32) -> [Link; 2] {
        let count = triangles.iter().flatten().max().map_or(0, |&v| v + 1);
        let triangles = triangles.to_vec();
        let submeshes = vec![Submesh {
            first_triangle: 0,
            triangle_count: triangles.len() as u32,
            attributes: Vec::new(),
        }];
        let mesh = Mesh::try_from(MeshParts {
            positions: (0..count).map(|v| [v as f32, (v * v) as f32, 0.0]).collect(),
            vertex_submesh: vec![0; count as usize],
            triangles,
            submeshes,
            attributes: Vec::new(),
        })
        .expect("a mesh made by hand");
        let region = Region::whole(&Input::new(&mesh), true);
        let group = |v: u32| {
            let at = |g: &u32| region.mesh.group_positions[*g as usize].position.y;
            let mut groups: Vec<u32> = (0..count).collect();
            groups.sort_by(|a, b| at(a).total_cmp(&at(b)));
            groups[v as usize]
        };
        let (from, to) = (group(from), group(to));
        let mut marks = Marks::default();
        [
            Link::new(&region.mesh, from, to, &mut marks),
            Link::general(&region.mesh, from, to, &mut marks),
        ]
    }

    /// Two poles and a ring of six.
    fn bipyramid() -> Vec<[u32; 3]> {
        (0..6u32)
            .flat_map(|i| {
                let (a, b) = (2 + i, 2 + (i + 1) % 6);
                [[0, a, b], [1, b, a]]
            })
            .collect()
    }

    #[test]
    fn an_edge_of_a_closed_surface_may_collapse() {
        for link in links(&bipyramid(), 2, 3) {
            assert_eq!(link, Link { holds: true, shared_faces: 2, vanishes: false });
        }
    }

    #[test]
    fn a_common_neighbour_off_the_edge_forbids() {
        // Opposite groups of the ring are no neighbours; a chord makes a third common neighbour.
        let mut triangles = bipyramid();
        triangles.extend([[2, 4, 8], [4, 2, 9]]);
        for link in links(&triangles, 2, 3) {
            assert!(!link.holds && link.shared_faces == 2);
        }
    }

    #[test]
    fn a_tetrahedron_would_fold_onto_itself() {
        let tetrahedron = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        for link in links(&tetrahedron, 0, 1) {
            assert!(!link.holds && link.shared_faces == 2);
        }
    }

    #[test]
    fn a_single_triangle_would_vanish() {
        for link in links(&[[0, 1, 2]], 0, 1) {
            assert!(!link.holds && link.shared_faces == 1);
        }
    }

    /// Films with a line from 0 over 1 and 2 to 3 in common, and each with a point of its own.
    fn films(count: u32) -> Vec<[u32; 3]> {
        (4..4 + count).flat_map(|own| [[0, 1, own], [1, 2, own], [2, 3, own]]).collect()
    }

    #[test]
    fn a_line_of_several_films_may_be_shortened() {
        for count in [3, 4, 5, 8] {
            for link in links(&films(count), 1, 2) {
                let shared_faces = count as usize;
                assert_eq!(link, Link { holds: true, shared_faces, vanishes: false }, "{count}");
            }
        }
        assert!(links(&films(9), 1, 2).iter().all(|link| !link.holds), "more than are looked at");
    }

    #[test]
    fn a_film_between_lines_does_not_vanish() {
        // The first film ends at 2 and 4, and another one meets it along its third side.
        let mut triangles = films(3);
        triangles.retain(|&t| t != [2, 3, 4]);
        assert!(links(&triangles, 1, 2).iter().all(|link| link.holds));
        triangles.push([1, 4, 7]);
        assert!(links(&triangles, 1, 2).iter().all(|link| !link.holds));
    }

    #[test]
    fn points_where_lines_meet_stay_apart() {
        // Another line from one end of the edge, then from both.
        let line = |end: u32, other: u32| (1..4).map(move |film| [end, other, other + film]);
        let mut triangles = films(3);
        triangles.extend(line(1, 7));
        assert!(links(&triangles, 1, 2).iter().all(|link| link.holds));
        triangles.extend(line(2, 11));
        assert!(links(&triangles, 1, 2).iter().all(|link| !link.holds));
    }

    #[test]
    fn groups_without_a_common_face_share_none() {
        for link in links(&bipyramid(), 2, 5) {
            assert_eq!(link.shared_faces, 0);
        }
    }
}
