//! The shapes in which a surface is seen, as its scene gives them.

use lodc_mesh::Mesh;

/// The shapes in which a surface is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenShapes {
    /// Positions at rest, one for each vertex. Empty: those of the mesh.
    pub at_rest: Vec<[f32; 3]>,
    /// Normals at rest, of any length, one for each vertex. Empty: those of the mesh.
    pub normals_at_rest: Vec<[f32; 3]>,
    /// Others, of which the first 128 count.
    pub others: Vec<SeenShape>,
    /// Joints move some of these. Then what differences of joints cost is seen there.
    pub joints_move: bool,
}

/// One shape besides that at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenShape {
    /// One for each vertex, in units of the mesh.
    pub positions: Vec<[f32; 3]>,
    /// One for each vertex, of any length. Empty: those at rest.
    pub normals: Vec<[f32; 3]>,
    /// The factor of costs in it.
    pub weight: f64,
}

impl SeenShapes {
    /// The positions at rest of a mesh.
    pub(crate) fn at_rest_of<'a>(&'a self, mesh: &'a Mesh) -> &'a [[f32; 3]] {
        if self.at_rest.is_empty() { mesh.positions() } else { &self.at_rest }
    }

    /// The shapes of some of the vertices.
    pub(crate) fn gathered(&self, vertices: &[u32]) -> Self {
        let gather = |positions: &[[f32; 3]]| match positions {
            [] => Vec::new(),
            _ => vertices.iter().map(|&v| positions[v as usize]).collect(),
        };
        let others = self.others.iter().map(|shape| SeenShape {
            positions: gather(&shape.positions),
            normals: gather(&shape.normals),
            weight: shape.weight,
        });
        Self {
            at_rest: gather(&self.at_rest),
            normals_at_rest: gather(&self.normals_at_rest),
            others: others.collect(),
            joints_move: self.joints_move,
        }
    }
}
