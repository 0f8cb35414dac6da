//! The price of attributes: every wedge's gradients, and what moving along an edge would
//! cost them.

use crate::attributes::{Attributes, Gradient};
use crate::neighborhood::{IncidentEdge, Neighborhood};
use crate::wedges::Wedges;
use crate::working::WorkingMesh;

/// The attributes of the wedges of one region.
#[derive(Clone, Copy)]
pub(crate) struct WedgeAttributes<'a> {
    pub(crate) mesh: &'a WorkingMesh,
    pub(crate) wedges: &'a Wedges,
    pub(crate) attributes: &'a Attributes,
}

impl WedgeAttributes<'_> {
    /// Fits the attributes around every wedge of a group.
    pub(crate) fn fit_gradients(&self, from: u32, gradients: &mut Vec<(u32, Gradient)>) {
        let mut used = 0;
        for &corner in self.mesh.star(from) {
            let face = corner.face();
            let wedges = self.mesh.wedges(face);
            let wedge = wedges[corner.at()];
            let i = gradients[..used].iter().rposition(|g| g.0 == wedge).unwrap_or_else(|| {
                if used == gradients.len() {
                    gradients.push((wedge, Gradient::new(self.attributes.width)));
                }
                gradients[used].0 = wedge;
                gradients[used].1.clear();
                used += 1;
                used - 1
            });
            let rows =
                wedges.map(|w| self.attributes.row(self.wedges.attribute_source[w as usize]));
            gradients[i].1.add_face(self.mesh, face, corner.at(), rows);
        }
        gradients.truncate(used);
    }

    /// Error of the attributes around a group if it moved along an edge. Scaled units
    /// to the fourth power.
    pub(crate) fn cost(
        &self,
        from: u32,
        edge: &IncidentEdge,
        around: &Neighborhood,
        gradients: &[(u32, Gradient)],
    ) -> f64 {
        let delta = self.mesh.position(edge.group) - self.mesh.position(from);
        let mut cost = 0.0;
        for (wedge, gradient) in gradients {
            let target = around.target(self.wedges, edge, *wedge).unwrap_or(*wedge);
            let [here, there] = [*wedge, target].map(|w| self.wedges.attribute_source[w as usize]);
            cost += gradient.at(delta, self.attributes.row(here), self.attributes.row(there));
            let [here, there] = [*wedge, target].map(|w| self.wedges.position_source[w as usize]);
            cost += gradient.weight() * self.attributes.joint_distance_squared(here, there);
        }
        cost
    }
}
