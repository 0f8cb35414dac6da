//! What surrounds a group: its spokes (edges to other groups), and which of them are borders or seams.

use crate::wedges::Wedges;
use crate::working::{Corner, Working, next, previous};
use glam::{DVec3, Vec3};


/// Weight of the plane along a border edge, times its squared length.
pub(crate) const BORDER_WEIGHT: f64 = 10.0;
/// Weight of the planes along an edge between two submeshes, times its squared length.
const MATERIAL_WEIGHT: f64 = 10.0;
/// Weight of the planes along an edge where attributes differ, times its squared length.
const SEAM_WEIGHT: f64 = 1.0;

/// Weight of the plane along an edge whose faces fold back on each other, times its squared length.
const FOLD_WEIGHT: f64 = 1.0;

/// An edge from the group to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spoke {
    pub(crate) group: u32,
    pub(crate) kind: SpokeKind,
    /// Its entries, as a range.
    pub(crate) entries: (u32, u32),
}

/// What kind of edge a spoke is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SpokeKind {
    /// Two faces that continue each other.
    Smooth,
    /// Two faces with different attributes or submeshes, or more than two faces.
    Seam,
    /// One face only.
    Border,
}

/// One face at a spoke: the wedges at both ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Entry {
    pub(crate) group: u32,
    pub(crate) here: u32,
    pub(crate) there: u32,
    face: u32,
}

/// A plane through the group that collapses should stay on.
pub(crate) struct FeaturePlane {
    pub(crate) normal: DVec3,
    pub(crate) weight: f64,
}

/// The surroundings of one group; its buffers are used again for the next.
#[derive(Default)]
pub(crate) struct Neighborhood {
    pub(crate) spokes: Vec<Spoke>,
    pub(crate) entries: Vec<Entry>,
    pub(crate) planes: Vec<FeaturePlane>,
    pub(crate) borders: u32,
    pub(crate) seams: u32,
}

impl Neighborhood {
    /// Looks around `group`.
    pub(crate) fn look(&mut self, mesh: &Working, wedges: &Wedges, group: u32) {
        self.spokes.clear();
        self.entries.clear();
        self.planes.clear();
        (self.borders, self.seams) = (0, 0);
        for &corner in mesh.star(group) {
            let (face, at) = (corner.face(), corner.at());
            let (groups, corners) = (&mesh.faces[face as usize].groups, mesh.wedges(face));
            for end in [next(at), previous(at)] {
                self.entries.push(Entry { group: groups[end], here: corners[at], there: corners[end], face });
            }
        }
        self.entries.sort_unstable();
        let mut start = 0;
        while start < self.entries.len() {
            let first = self.entries[start];
            let run = self.entries[start..].iter().take_while(|e| e.group == first.group).count();
            let faces = &self.entries[start..start + run];
            let class = |e: &Entry| (wedges.class[e.here as usize], wedges.class[e.there as usize]);
            let kind = match run {
                1 => SpokeKind::Border,
                2 if class(&faces[0]) == class(&faces[1]) => SpokeKind::Smooth,
                _ => SpokeKind::Seam,
            };
            let weight = match kind {
                SpokeKind::Smooth => {
                    self.planes.extend(fold_plane(mesh, group, first.group, [faces[0].face, faces[1].face]));
                    0.0
                }
                SpokeKind::Border => {
                    self.borders += 1;
                    BORDER_WEIGHT
                }
                SpokeKind::Seam => {
                    self.seams += 1;
                    let submesh = |e: &Entry| mesh.faces[e.face as usize].submesh;
                    if faces.iter().all(|e| submesh(e) == submesh(&first)) { SEAM_WEIGHT } else { MATERIAL_WEIGHT }
                }
            };
            if weight > 0.0 {
                let edge = mesh.position(first.group) - mesh.position(group);
                for e in faces {
                    let normal = mesh.faces[e.face as usize].normal.as_dvec3().cross(edge);
                    let length = normal.length();
                    if length > 0.0 {
                        let weight = weight * edge.length_squared();
                        self.planes.push(FeaturePlane { normal: normal / length, weight });
                    }
                }
            }
            let entries = (start as u32, (start + run) as u32);
            self.spokes.push(Spoke { group: first.group, kind, entries });
            start += run;
        }
    }

    /// The wedge that `wedge` becomes if the group moves along `spoke`: the one it shares a face with there, or the one
    /// that a wedge with the same attributes shares a face with.
    pub(crate) fn target(&self, wedges: &Wedges, spoke: &Spoke, wedge: u32) -> Option<u32> {
        let faces = &self.entries[spoke.entries.0 as usize..spoke.entries.1 as usize];
        let class = wedges.class[wedge as usize];
        let same = faces.iter().find(|e| e.here == wedge);
        same.or_else(|| faces.iter().find(|e| wedges.class[e.here as usize] == class)).map(|e| e.there)
    }
}

/// The planes along all folded edges at a group whose star is a closed fan.
pub(crate) fn fold_planes(mesh: &Working, group: u32, planes: &mut Vec<FeaturePlane>) {
    planes.clear();
    let star = mesh.star(group);
    let normal = |corner: Corner| mesh.faces[corner.face() as usize].normal;
    // If all normals are within 45° of their mean, no two are more than 90° apart.
    let mean = star.iter().map(|&c| normal(c)).sum::<Vec3>();
    let limit = std::f32::consts::FRAC_1_SQRT_2 * mean.length();
    if !star.iter().any(|&c| normal(c).dot(mean) < limit) {
        return;
    }
    for &corner in star {
        let end = mesh.others(corner)[0];
        let other = star.iter().find(|&&c| mesh.others(c)[1] == end);
        planes.extend(other.and_then(|&other| fold_plane(mesh, group, end, [corner.face(), other.face()])));
    }
}

/// The plane along an edge whose two faces fold back on each other. The rim of a thin shape (an ear, a horn, a blade)
/// is like a border: moving inwards stays near the planes of both sides, but eats the shape.
fn fold_plane(mesh: &Working, group: u32, end: u32, faces: [u32; 2]) -> Option<FeaturePlane> {
    let [m, n] = faces.map(|f| mesh.faces[f as usize].normal.as_dvec3());
    let fold = -m.dot(n);
    (fold > 0.0).then(|| {
        let edge = mesh.position(end) - mesh.position(group);
        // Outwards is between the normals; where they cancel, along the sheet.
        let normal = (m + n).try_normalize().unwrap_or_else(|| m.cross(edge).normalize_or_zero());
        FeaturePlane { normal, weight: FOLD_WEIGHT * fold * edge.length_squared() }
    })
}
