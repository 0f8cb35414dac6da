//! From a mesh to the working mesh: groups along a space-filling curve, coordinates scaled, corners
//! classified.

use crate::neighborhood::Neighborhood;
use crate::wedges::Wedges;
use crate::working::{Face, OPEN, Place, SEAM, SHARED_POSITION, Working, next, previous};
use glam::Vec3;
use lodc_mesh::{Mesh, PositionIds, WedgeGroups};
use rayon::prelude::*;

/// A mesh ready to be simplified.
pub(crate) struct Built {
    pub(crate) working: Working,
    pub(crate) wedges: Wedges,
    /// The wedge of each vertex of the input.
    pub(crate) wedge_of: Vec<u32>,
    /// Working units per mesh unit: a power of two, so that scaling is exact.
    pub(crate) scale: f64,
    /// The diagonal in working units.
    pub(crate) size: f64,
}

pub(crate) fn build(mesh: &Mesh) -> Built {
    let positions = PositionIds::new(mesh.positions());
    let groups = WedgeGroups::new(mesh, &positions);
    let diagonal = mesh.diagonal();
    let scale = if diagonal > 0.0 { (-diagonal.log2().floor()).exp2() } else { 1.0 };
    let group_order = along_curve(mesh, &groups);

    // Wedges are numbered group by group.
    let mut group_rank = vec![0; groups.len()];
    for (rank, &g) in (0u32..).zip(&group_order) {
        group_rank[g as usize] = rank;
    }
    let mut bounds = vec![0u32; groups.len() + 1];
    for &g in &groups.of_vertex {
        bounds[group_rank[g as usize] as usize + 1] += 1;
    }
    for i in 1..bounds.len() {
        bounds[i] += bounds[i - 1];
    }
    let mut free = bounds.clone();
    let mut vertex_of = vec![0u32; mesh.vertex_count()];
    let mut wedge_of = vec![0u32; mesh.vertex_count()];
    for (v, &g) in (0u32..).zip(&groups.of_vertex) {
        let slot = &mut free[group_rank[g as usize] as usize];
        vertex_of[*slot as usize] = v;
        wedge_of[v as usize] = *slot;
        *slot += 1;
    }

    let first_vertex = group_order.iter().map(|&g| groups.first_vertex[g as usize]);
    let mut groups_at = vec![0u32; positions.len()];
    for &v in &groups.first_vertex {
        groups_at[positions.of_vertex[v as usize] as usize] += 1;
    }
    let position_id: Vec<u32> =
        first_vertex.clone().map(|v| positions.of_vertex[v as usize]).collect();
    let places = first_vertex
        .map(|v| Vec3::from(mesh.positions()[v as usize].map(|c| (f64::from(c) * scale) as f32)))
        .map(|position| Place { position, arrival: 0.0 })
        .collect();
    let flags = position_id
        .iter()
        .map(|&id| if groups_at[id as usize] > 1 { SHARED_POSITION } else { 0 })
        .collect();

    let group_of = |v: u32| group_rank[groups.of_vertex[v as usize] as usize];
    let order = faces_by_group(mesh, group_of);
    let triangle = |t: u32| mesh.triangles()[t as usize];
    let faces = order
        .iter()
        .map(|&t| Face {
            groups: triangle(t).map(group_of),
            normal: Vec3::ZERO,
            area: 0.0,
            triangle: t,
        })
        .collect();
    // With one vertex at each position no group ever gets a second wedge.
    let corners = if positions.len() == mesh.vertex_count() {
        Vec::new()
    } else {
        order.iter().map(|&t| triangle(t).map(|v| wedge_of[v as usize])).collect()
    };
    drop(order);
    let mut working = Working::new(places, flags, faces, corners, position_id);
    for f in 0..working.faces.len() as u32 {
        working.set_plane(f);
    }
    let wedges = Wedges::new(mesh, vertex_of, &bounds);
    classify(&mut working, &wedges);
    Built { working, wedges, wedge_of, scale, size: diagonal * scale }
}

/// Groups sorted along a Morton curve through the bounding box.
fn along_curve(mesh: &Mesh, groups: &WedgeGroups) -> Vec<u32> {
    let (lo, hi) = mesh.bounds();
    let extent = (0..3).map(|i| f64::from(hi[i]) - f64::from(lo[i])).fold(0.0, f64::max);
    let cells = if extent > 0.0 { f64::from((1 << 21) - 1) / extent } else { 0.0 };
    let code = |v: u32| {
        let p = mesh.positions()[v as usize];
        (0..3)
            .map(|i| spread(((f64::from(p[i]) - f64::from(lo[i])) * cells) as u64) << i)
            .fold(0, |a, b| a | b)
    };
    let mut keyed: Vec<(u64, u32)> = groups
        .first_vertex
        .par_iter()
        .zip(0..groups.len() as u32)
        .map(|(&v, g)| (code(v), g))
        .collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, g)| g).collect()
}

/// The low 21 bits with two zeros between any two.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// Triangles sorted by the least of their groups, so that faces that are neighbours in space are so
/// in memory.
fn faces_by_group(mesh: &Mesh, group_of: impl Fn(u32) -> u32) -> Vec<u32> {
    let least = |t: &[u32; 3]| t.map(&group_of).into_iter().min().unwrap_or(0) as usize;
    let mut start = vec![0u32; mesh.vertex_count() + 1];
    for t in mesh.triangles() {
        start[least(t) + 1] += 1;
    }
    for i in 1..start.len() {
        start[i] += start[i - 1];
    }
    let mut order = vec![0u32; mesh.triangles().len()];
    for (i, t) in (0u32..).zip(mesh.triangles()) {
        let slot = &mut start[least(t)];
        order[*slot as usize] = i;
        *slot += 1;
    }
    order
}

/// Flags groups whose star is not a closed fan, and groups on seams.
fn classify(working: &mut Working, wedges: &Wedges) {
    let seams_possible = wedges.class.len() > working.places.len();
    let this = &*working;
    let flags: Vec<u8> = (0..working.places.len() as u32)
        .into_par_iter()
        .with_min_len(1024)
        .map_init(<(Neighborhood, Vec<u32>, Vec<u32>)>::default, |(around, ahead, behind), g| {
            ahead.clear();
            behind.clear();
            for &corner in this.star(g) {
                let groups = &this.faces[corner.face() as usize].groups;
                ahead.push(groups[next(corner.at())]);
                behind.push(groups[previous(corner.at())]);
            }
            ahead.sort_unstable();
            behind.sort_unstable();
            let closed = ahead == behind && ahead.windows(2).all(|w| w[0] != w[1]);
            let mut flags = if closed { 0 } else { OPEN };
            if seams_possible || !closed {
                around.look(this, wedges, g);
                if around.seams > 0 {
                    flags |= SEAM;
                }
            }
            flags
        })
        .collect();
    for (old, new) in working.flags.iter_mut().zip(flags) {
        *old |= new;
    }
}
