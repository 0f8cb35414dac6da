//! The input mesh with its groups and wedges numbered along a space-filling curve.

use super::cards::cards;
use super::curve::Curve;
use super::flat::{flat_vertices, normals};
use super::loose;
use super::shapes::GroupShapes;
use crate::{SeenShapes, importance};
use glam::{DVec3, Vec3};
use lodc_mesh::{Attribute, Csr, Mesh, PositionIds, Semantic, WedgeGroups};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// A mesh ready to be cut into regions.
pub(crate) struct Input<'a> {
    pub(crate) mesh: &'a Mesh,
    /// Working units per mesh unit: a power of two, so that scaling is exact, and such that the
    /// diagonal of the largest shape is from one to two.
    pub(crate) scale: f64,
    /// The diagonal at rest in working units.
    pub(crate) size: f64,
    /// The group of each vertex.
    pub(crate) group_of: Vec<u32>,
    /// The first vertex of each group.
    first_vertex: Vec<u32>,
    /// The number of each group's position; empty if no two groups share one.
    pub(crate) position_id: Vec<u32>,
    /// For each position: true if several groups are there.
    shared: Vec<bool>,
    /// For each group: true if it stays until the terminal phase; empty if none does.
    locked: Vec<bool>,
    /// By group: by how much costs are multiplied; empty if by nothing.
    importance: Vec<f64>,
    /// Where groups are in motion.
    pub(crate) shapes: GroupShapes,
    /// Positions at rest, by vertex.
    at_rest: &'a [[f32; 3]],
    /// Planes besides those of the faces, by group.
    pub(crate) planes: Vec<FollowerPlane>,
    /// None if every group has one wedge, with the group's number.
    lists: Option<WedgeLists>,
    /// What of a vertex counts at seams; none if all does.
    counting: Option<Counting>,
    /// By vertex: whether all its faces are flat, that is have one normal at all three corners.
    /// Empty if there is no such vertex.
    flat: Vec<bool>,
    /// By group: whether it is a corner of a card. Empty if there is none.
    card: Vec<bool>,
    /// By group: by how much the price of its loose part's going is multiplied. Empty if there is
    /// none.
    loose: Vec<f32>,
    has_formats_in_common: bool,
}

/// Which attributes count at seams, by submesh and attribute.
struct Counting(Vec<Vec<bool>>);

/// A plane besides those of the mesh's faces, at a corner of a face: of one that follows them, or
/// of one that others follow, so that it counts less.
pub(crate) struct FollowerPlane {
    pub(crate) group: u32,
    pub(crate) unit_normal: DVec3,
    /// In squared working units; negative for a face that counts less.
    pub(crate) area: f64,
}

/// Wedges numbered group by group.
struct WedgeLists {
    /// The wedge of each vertex.
    of_vertex: Vec<u32>,
    /// The vertex of each wedge.
    vertex: Vec<u32>,
    /// The wedges of a group are `bounds[g]..bounds[g + 1]`.
    bounds: Vec<u32>,
    /// For each wedge the first one of its group with the same attributes.
    class: Vec<u32>,
    /// The same of the attributes that count; empty if all do.
    seam_class: Vec<u32>,
}

/// The data of one wedge.
#[derive(Clone, Copy)]
pub(crate) struct Wedge {
    /// Its number in the whole mesh.
    pub(crate) id: u32,
    /// The vertex of the input that its position and other spatial data come from.
    pub(crate) position_source: u32,
    /// The vertex of the input that its other attributes come from.
    pub(crate) attribute_source: u32,
    pub(crate) submesh: u32,
    /// Equal for the wedges of a group with the same attributes.
    pub(crate) class: u32,
    /// Equal for those between which there is no seam.
    pub(crate) seam_class: u32,
}

impl<'a> Input<'a> {
    /// The input of a mesh that has one shape only.
    #[cfg(test)]
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        Self::with_positions(mesh, &mesh.position_ids(), Box::leak(Box::default()))
    }

    /// The input of a mesh whose positions are numbered, in the shapes in which it is seen.
    pub(crate) fn with_positions(
        mesh: &'a Mesh,
        positions: &PositionIds,
        seen: &'a SeenShapes,
    ) -> Self {
        let groups = WedgeGroups::new(mesh, positions);
        let at_rest = seen.at_rest_of(mesh);
        let (lo, hi) = bounds(at_rest);
        let diagonal = diagonal(at_rest);
        let others = seen.others.iter().map(|shape| self::diagonal(&shape.positions));
        let largest = others.fold(diagonal, f64::max);
        let scale = if largest > 0.0 { (-largest.log2().floor()).exp2() } else { 1.0 };
        let order = Curve::new(lo, hi, 0.0)
            .order(groups.len(), |g| at_rest[groups.first_vertex[g] as usize]);
        let mut rank = vec![0u32; groups.len()];
        for (i, &g) in (0..).zip(&order) {
            rank[g as usize] = i;
        }
        let first_vertex: Vec<u32> =
            order.iter().map(|&g| groups.first_vertex[g as usize]).collect();
        let group_of: Vec<u32> = groups.of_vertex.par_iter().map(|&g| rank[g as usize]).collect();
        let (mut position_id, mut shared) = (Vec::new(), Vec::new());
        if groups.len() > positions.len() {
            position_id = first_vertex.iter().map(|&v| positions.of_vertex[v as usize]).collect();
            let mut group_counts = vec![0u32; positions.len()];
            for &p in &position_id {
                group_counts[p as usize] += 1;
            }
            shared = group_counts.into_iter().map(|n| n > 1).collect();
        }
        let one_wedge_each = positions.len() == mesh.vertex_count();
        let lists = (!one_wedge_each).then(|| WedgeLists::new(mesh, &group_of, order.len()));
        let size = diagonal * scale;
        let (locked, importance, planes) = (Vec::new(), Vec::new(), Vec::new());
        let vertices = first_vertex.iter().copied();
        let shapes = GroupShapes::new(seen, at_rest, vertices, scale);
        let card = cards(mesh, &group_of, order.len());
        let position = |g: usize| at_rest[first_vertex[g] as usize].into();
        let triangles = mesh.triangles().iter().map(|t| t.map(|v| group_of[v as usize]));
        let loose = loose::factors(order.len(), position, triangles);
        Self {
            mesh,
            shapes,
            at_rest,
            scale,
            size,
            group_of,
            first_vertex,
            position_id,
            shared,
            locked,
            importance,
            planes,
            lists,
            counting: None,
            flat: flat_vertices(mesh),
            card,
            loose,
            has_formats_in_common: has_formats_in_common(mesh),
        }
    }

    /// Returns whether several submeshes have the same attribute streams.
    pub(crate) const fn has_formats_in_common(&self) -> bool {
        self.has_formats_in_common
    }

    /// Makes seams only where attributes differ that count in their submesh, as `counts` says.
    pub(crate) fn set_counting(&mut self, counts: impl Fn(u32, &Attribute) -> bool) {
        let of_submesh = |s: u32| self.mesh.attributes().iter().map(|a| counts(s, a)).collect();
        let by_submesh: Vec<Vec<bool>> =
            (0..self.mesh.submeshes().len() as u32).map(of_submesh).collect();
        if by_submesh.iter().flatten().all(|&counts| counts) {
            return;
        }
        self.counting = Some(Counting(by_submesh));
        if let Some(mut lists) = self.lists.take() {
            lists.seam_class = lists.classes(self.mesh, |a, b| self.meets_smoothly(a, b));
            self.lists = Some(lists);
        }
    }

    /// Returns whether two vertices of one submesh have the same attributes, but for those that do
    /// not count.
    pub(crate) fn meets_smoothly(&self, a: u32, b: u32) -> bool {
        let Some(Counting(by_submesh)) = &self.counting else {
            return same_attributes(self.mesh, a, b);
        };
        let counts = &by_submesh[self.mesh.vertex_submesh()[a as usize] as usize];
        let counting = self.mesh.attributes().iter().zip(counts).filter(|(_, counts)| **counts);
        let mut compared = counting.map(|(s, _)| s).filter(|s| is_compared(s));
        a == b || compared.all(|s| s.at(a) == s.at(b))
    }

    /// Returns whether attributes that differ may make no seam.
    pub(crate) fn ignores_attributes(&self) -> bool {
        self.counting.is_some()
    }

    /// Returns whether a vertex that takes over faces of another spoils none of them: one that had
    /// one normal at all corners still has it.
    pub(crate) fn keeps_flat(&self, from: u32, to: u32) -> bool {
        if self.flat.is_empty() || !self.flat[from as usize] {
            return true;
        }
        let submesh = self.mesh.vertex_submesh()[from as usize];
        let mut normals = normals(self.mesh, &self.mesh.submeshes()[submesh as usize]);
        normals.all(|a| a.at(from) == a.at(to))
    }

    /// Locks the groups of some vertices: they stay until the terminal phase. No list means none.
    pub(crate) fn lock(&mut self, vertices: &[bool]) {
        self.locked = locked_groups(vertices, &self.group_of, self.groups());
    }

    /// Multiplies costs by what the importance of vertices, equal at one position, says. No list
    /// means by nothing.
    pub(crate) fn weigh(&mut self, painted: &[f32]) {
        if painted.is_empty() {
            return;
        }
        let factor = |&vertex: &u32| importance::factor(painted[vertex as usize]);
        self.importance = self.first_vertex.iter().map(factor).collect();
    }

    /// By how much the cost of moving a group is multiplied.
    #[inline]
    pub(crate) fn importance(&self, group: u32) -> f64 {
        self.importance.get(group as usize).copied().unwrap_or(1.0)
    }

    /// Returns whether a group stays until the terminal phase.
    #[inline]
    pub(crate) fn is_locked(&self, group: u32) -> bool {
        !self.locked.is_empty() && self.locked[group as usize]
    }

    /// Returns whether a group is a corner of a card: two faces by themselves that share an edge
    /// and a rectangle of the texture.
    #[inline]
    pub(crate) fn is_card(&self, group: u32) -> bool {
        !self.card.is_empty() && self.card[group as usize]
    }

    /// By how much the price of going is multiplied for the loose part that a group is of, at least
    /// 1: the parts around it may have gone before.
    #[inline]
    pub(crate) fn loose_factor(&self, group: u32) -> f64 {
        self.loose.get(group as usize).copied().map_or(1.0, f64::from)
    }

    /// Number of groups.
    pub(crate) fn groups(&self) -> usize {
        self.first_vertex.len()
    }

    /// Number of wedges.
    pub(crate) fn wedges(&self) -> usize {
        self.mesh.vertex_count()
    }

    /// Returns whether every group has one wedge, with the group's number.
    pub(crate) fn one_wedge_each(&self) -> bool {
        self.lists.is_none()
    }

    /// Returns whether some group has several wedges.
    pub(crate) fn may_have_seams(&self) -> bool {
        self.wedges() > self.groups()
    }

    /// The wedge of each vertex.
    pub(crate) fn wedge_of(&self) -> &[u32] {
        self.lists.as_ref().map_or(&self.group_of, |l| &l.of_vertex)
    }

    /// The vertex of each wedge.
    pub(crate) fn vertex_of(&self) -> &[u32] {
        self.lists.as_ref().map_or(&self.first_vertex, |l| &l.vertex)
    }

    /// The wedges of consecutive groups.
    pub(crate) fn wedges_of(&self, groups: Range<u32>) -> Range<u32> {
        match &self.lists {
            Some(l) => l.bounds[groups.start as usize]..l.bounds[groups.end as usize],
            None => groups,
        }
    }

    /// Returns the data of a wedge.
    pub(crate) fn wedge(&self, id: u32) -> Wedge {
        let vertex = self.vertex_of()[id as usize];
        Wedge {
            id,
            position_source: vertex,
            attribute_source: vertex,
            submesh: self.mesh.vertex_submesh()[vertex as usize],
            class: self.lists.as_ref().map_or(id, |l| l.class[id as usize]),
            seam_class: self.lists.as_ref().map_or(id, |l| l.seam_class(id)),
        }
    }

    /// Position of a group in working units.
    pub(crate) fn group_position(&self, group: u32) -> Vec3 {
        let p = self.position(group as usize);
        Vec3::from(p.map(|c| (f64::from(c) * self.scale) as f32))
    }

    /// Position of a group in the mesh's units.
    pub(crate) fn position(&self, group: usize) -> [f32; 3] {
        self.at_rest[self.first_vertex[group] as usize]
    }

    /// Corners of the bounding box at rest, in the mesh's units.
    pub(crate) fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        bounds(self.at_rest)
    }

    /// Returns whether another group starts at the same position.
    pub(crate) fn shares_position(&self, group: u32) -> bool {
        self.position_id.get(group as usize).is_some_and(|&p| self.shared[p as usize])
    }
}

/// Returns whether several submeshes have the same attribute streams.
fn has_formats_in_common(mesh: &Mesh) -> bool {
    let mut formats = BTreeSet::new();
    mesh.submeshes().iter().any(|submesh| !formats.insert(&submesh.attributes))
}

/// Smallest and largest coordinates; zeros without positions.
fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let mut positions = positions.iter();
    let Some(&first) = positions.next() else { return ([0.0; 3], [0.0; 3]) };
    positions.fold((first, first), |(lo, hi), p| {
        (std::array::from_fn(|i| lo[i].min(p[i])), std::array::from_fn(|i| hi[i].max(p[i])))
    })
}

/// Length of the bounding box's diagonal.
fn diagonal(positions: &[[f32; 3]]) -> f64 {
    let (lo, hi) = bounds(positions);
    (0..3).map(|i| (f64::from(hi[i]) - f64::from(lo[i])).powi(2)).sum::<f64>().sqrt()
}

/// For each group: true if one of its vertices is locked; empty if none is.
fn locked_groups(vertices: &[bool], group_of: &[u32], groups: usize) -> Vec<bool> {
    if !vertices.contains(&true) {
        return Vec::new();
    }
    let mut locked = vec![false; groups];
    for (&group, _) in group_of.iter().zip(vertices).filter(|(_, locked)| **locked) {
        locked[group as usize] = true;
    }
    locked
}

impl WedgeLists {
    fn new(mesh: &Mesh, group_of: &[u32], groups: usize) -> Self {
        let csr = Csr::new(groups, group_of.iter().copied().zip(0..));
        let (bounds, vertex) = (csr.offsets, csr.values);
        let mut of_vertex = vec![0u32; vertex.len()];
        for (wedge, &v) in (0..).zip(&vertex) {
            of_vertex[v as usize] = wedge;
        }
        let (class, seam_class) = Default::default();
        let lists = Self { of_vertex, vertex, bounds, class, seam_class };
        let class = lists.classes(mesh, |a, b| same_attributes(mesh, a, b));
        Self { class, ..lists }
    }

    /// For each wedge the first one of its group and submesh that is `alike`, two vertices given.
    fn classes(&self, mesh: &Mesh, alike: impl Fn(u32, u32) -> bool + Sync) -> Vec<u32> {
        let groups = self.bounds.len() - 1;
        let of_group =
            |g: usize| classes(mesh, &self.vertex, self.bounds[g]..self.bounds[g + 1], &alike);
        (0..groups).into_par_iter().with_min_len(1024).flat_map_iter(of_group).collect()
    }

    fn seam_class(&self, wedge: u32) -> u32 {
        let list = if self.seam_class.is_empty() { &self.class } else { &self.seam_class };
        list[wedge as usize]
    }
}

/// For each wedge of a group the first one that is alike, which may be itself.
fn classes(
    mesh: &Mesh,
    vertex: &[u32],
    wedges: Range<u32>,
    is_alike: &impl Fn(u32, u32) -> bool,
) -> Vec<u32> {
    let submesh = |w: u32| mesh.vertex_submesh()[vertex[w as usize] as usize];
    let mut class: Vec<u32> = wedges.clone().collect();
    for w in wedges.clone() {
        // Pairs are compared, so their number is bounded: 64, chosen by hand; real meshes have a
        // handful of wedges at a position.
        let alike = (wedges.start..w).take(64).find(|&u| {
            class[(u - wedges.start) as usize] == u
                && submesh(u) == submesh(w)
                && is_alike(vertex[u as usize], vertex[w as usize])
        });
        if let Some(u) = alike {
            class[(w - wedges.start) as usize] = u;
        }
    }
    class
}

/// Compares two vertices' attributes. Tangents do not count: they follow from normals and texture
/// coordinates, and exporters make them anew for each face.
pub(crate) fn same_attributes(mesh: &Mesh, a: u32, b: u32) -> bool {
    let mut compared = mesh.attributes().iter().filter(|s| is_compared(s));
    a == b || compared.all(|s| s.at(a) == s.at(b))
}

fn is_compared(attribute: &Attribute) -> bool {
    !attribute.is_spatial() && attribute.semantic != Semantic::Tangent
}
