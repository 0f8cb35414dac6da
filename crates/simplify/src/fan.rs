//! A group's star gathered into small arrays, so that all its collapses are priced in one straight
//! loop.

use crate::neighborhood::{FeaturePlane, fold_plane};
use crate::working::{Working, next};
use glam::{DVec3, Vec3};

/// Stars with more faces than this are looked at the long way.
pub(crate) const MAX_FAN: usize = 16;

/// What a metric sees of a face.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facet {
    /// Unit normal; zero if the face has no area.
    pub(crate) normal: Vec3,
    pub(crate) area: f32,
}

/// Where collapses of a group lead, seen from it: one lane per target.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lanes {
    pub(crate) x: [f64; MAX_FAN],
    pub(crate) y: [f64; MAX_FAN],
    pub(crate) z: [f64; MAX_FAN],
    /// The target's [`arrival`](crate::working::Place::arrival).
    pub(crate) arrival: [f64; MAX_FAN],
}

/// A closed fan of at most [`MAX_FAN`] faces around a group. Neighbour `i` is the next corner of
/// face `i`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fan {
    pub(crate) len: usize,
    pub(crate) facets: [Facet; MAX_FAN],
    pub(crate) neighbours: [u32; MAX_FAN],
    pub(crate) lanes: Lanes,
    /// Room for what the lanes cost.
    pub(crate) costs: [f64; MAX_FAN],
}

impl Fan {
    /// Gathers a group's star, which must be a closed fan. False if it has too many faces.
    pub(crate) fn gather(&mut self, mesh: &Working, group: u32) -> bool {
        let star = mesh.star(group);
        if star.len() > MAX_FAN {
            return false;
        }
        self.len = star.len();
        let here = mesh.position(group);
        for (i, &corner) in star.iter().enumerate() {
            let f = &mesh.faces[corner.face() as usize];
            let neighbour = f.groups[next(corner.at())];
            let place = &mesh.places[neighbour as usize];
            let delta = place.position.as_dvec3() - here;
            self.facets[i] = Facet { normal: f.normal, area: f.area };
            self.neighbours[i] = neighbour;
            self.lanes.x[i] = delta.x;
            self.lanes.y[i] = delta.y;
            self.lanes.z[i] = delta.z;
            self.lanes.arrival[i] = f64::from(place.arrival);
        }
        true
    }

    /// The faces.
    pub(crate) fn facets(&self) -> &[Facet] {
        &self.facets[..self.len]
    }

    /// The planes along all folded edges.
    pub(crate) fn fold_planes(&self, mesh: &Working, group: u32, planes: &mut Vec<FeaturePlane>) {
        planes.clear();
        let facets = self.facets();
        // If all normals are within 45° of their mean, no two are more than 90° apart.
        let mean = facets.iter().map(|f| f.normal).sum::<Vec3>();
        let limit = std::f32::consts::FRAC_1_SQRT_2 * mean.length();
        if facets.iter().all(|f| f.normal.dot(mean) >= limit) {
            return;
        }
        let star = mesh.star(group);
        for (i, &neighbour) in self.neighbours[..self.len].iter().enumerate() {
            // The face on the other side of this spoke is the one for which the neighbour is the
            // corner before.
            let Some(j) = star.iter().position(|&c| mesh.others(c)[1] == neighbour) else {
                continue;
            };
            let edge = DVec3::new(self.lanes.x[i], self.lanes.y[i], self.lanes.z[i]);
            planes.extend(fold_plane(facets[i].normal, facets[j].normal, edge));
        }
    }
}
