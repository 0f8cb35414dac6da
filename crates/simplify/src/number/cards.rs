//! Cards: leaves, grass and hair as two faces each that share a rectangle of a texture.

use lodc_mesh::{Attribute, DisjointSets, Mesh, NONE, Semantic};

/// Marks the corners of cards, by group: see `Input::is_card`.
pub(super) fn cards(mesh: &Mesh, group_of: &[u32], groups: usize) -> Vec<bool> {
    let is_texture = |a: &&Attribute| a.semantic == Semantic::TexCoord(0) && a.components == 2;
    let textures: Vec<&Attribute> = mesh.attributes().iter().filter(is_texture).collect();
    let [texture] = textures[..] else { return Vec::new() };
    let mut components = DisjointSets::new(groups);
    let at = |t: &[u32; 3]| t.map(|v| group_of[v as usize]);
    for [a, b, c] in mesh.triangles().iter().map(at) {
        components.join(a, b);
        components.join(a, c);
    }
    // The first two faces of each component, and how many it has.
    let mut faces = vec![([NONE; 2], 0u32); groups];
    for (t, triangle) in (0..).zip(mesh.triangles()) {
        let (first, count) = &mut faces[components.find(at(triangle)[0]) as usize];
        if let Some(place) = first.get_mut(*count as usize) {
            *place = t;
        }
        *count += 1;
    }
    let mut card = vec![false; groups];
    for (two, _) in faces.iter().filter(|(_, count)| *count == 2) {
        let [a, b] = two.map(|t| mesh.triangles()[t as usize]);
        if shares_rectangle(texture, group_of, a, b) {
            a.iter().chain(&b).for_each(|&v| card[group_of[v as usize] as usize] = true);
        }
    }
    if card.contains(&true) { card } else { Vec::new() }
}

/// Returns whether two faces that share an edge cover a parallelogram of a texture together.
fn shares_rectangle(texture: &Attribute, group_of: &[u32], a: [u32; 3], b: [u32; 3]) -> bool {
    /// Share of the parallelogram's extent by which a corner may be off. Chosen by hand.
    const TOLERANCE: f64 = 1e-3;
    let group = |v: u32| group_of[v as usize];
    let alone = |face: [u32; 3], other: [u32; 3]| -> Option<usize> {
        let mut own = (0..3).filter(|&k| other.iter().all(|&v| group(v) != group(face[k])));
        own.next().filter(|_| own.next().is_none())
    };
    let (Some(i), Some(j)) = (alone(a, b), alone(b, a)) else { return false };
    let at = |v: u32| [0, 1].map(|k| f64::from(texture.value(v, k)));
    // Around the parallelogram: the corner of one face, an end of the edge, that of the other face.
    let [p, q, r] = [i, i + 1, i + 2].map(|k| at(a[k % 3]));
    let [s, t, u] = [j, j + 1, j + 2].map(|k| at(b[k % 3]));
    let extent = [q, r].map(|end| (0..2).map(|k| (end[k] - p[k]).abs()).fold(0.0, f64::max));
    let extent = extent[0].max(extent[1]);
    let near = |x: [f64; 2], y: [f64; 2]| (0..2).all(|k| (x[k] - y[k]).abs() <= TOLERANCE * extent);
    let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let opposite = [0, 1].map(|k| q[k] + r[k] - p[k]);
    area.abs() > TOLERANCE * extent * extent && near(s, opposite) && near(t, r) && near(u, q)
}
