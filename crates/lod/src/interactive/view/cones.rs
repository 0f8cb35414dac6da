//! For every wedge group a cone of normals that bounds those of all faces around it and around
//! whatever collapses into it: silhouettes are found by it.
//!
//! All wedges of a position take their LOD from one cone, so they move together and the surface
//! does not tear. (The thesis takes each vertex's own normal, and wedges have different ones.)

use lodc_mesh::{CollapseSequence, Mesh, NONE, WedgeGroups};

/// Directions within an angle of less than 90° of an axis; or all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Of unit length.
    pub axis: [f64; 3],
    /// Cosine of half the opening angle, in (0, 1]; 0 stands for all directions.
    pub cos: f64,
}

impl Cone {
    /// All directions.
    pub const OPEN: Self = Self { axis: [0.0, 0.0, 1.0], cos: 0.0 };

    /// Sine of half the opening angle.
    #[must_use]
    pub fn sin(&self) -> f64 {
        (1.0 - self.cos * self.cos).max(0.0).sqrt()
    }

    /// Returns whether it has a unit vector, give or take rounding.
    #[must_use]
    pub fn contains(&self, direction: [f64; 3]) -> bool {
        self.cos <= 0.0 || dot(self.axis, direction) >= self.cos - 1e-9
    }

    /// Returns the cosine of the largest angle between an axis and a direction of the cone;
    /// negative if that is more than 90°.
    fn cos_to_farthest(&self, axis: [f64; 3]) -> f64 {
        let cos = dot(axis, self.axis).clamp(-1.0, 1.0);
        if cos <= 0.0 { -1.0 } else { cos * self.cos - (1.0 - cos * cos).sqrt() * self.sin() }
    }

    /// Returns the narrowest cone around both, but for rounding.
    fn around(self, other: Self) -> Self {
        if self.cos <= 0.0 || other.cos <= 0.0 {
            return Self::OPEN;
        }
        if other.cos_to_farthest(self.axis) >= self.cos {
            return self;
        }
        if self.cos_to_farthest(other.axis) >= other.cos {
            return other;
        }
        // The directions of each that are farthest from the other; the axis is half way between.
        let farthest_from = |a: Self, b: Self| {
            let cosine = dot(a.axis, b.axis);
            let perpendicular = normalised(std::array::from_fn(|i| a.axis[i] * cosine - b.axis[i]));
            perpendicular.map(|perpendicular| {
                std::array::from_fn::<f64, 3, _>(|i| a.axis[i] * a.cos + perpendicular[i] * a.sin())
            })
        };
        let axis = match (farthest_from(self, other), farthest_from(other, self)) {
            (Some(a), Some(b)) => normalised(std::array::from_fn(|i| a[i] + b[i])),
            _ => Some(self.axis),
        };
        axis.map_or(Self::OPEN, |axis| Self {
            axis,
            cos: self.cos_to_farthest(axis).min(other.cos_to_farthest(axis)).max(0.0),
        })
    }
}

/// The group of each vertex that a triangle of LOD 0 uses, numbered densely, and a cone for each
/// group.
#[derive(Clone, Debug)]
pub struct Cones {
    /// The group of each vertex; [`NONE`] for fake vertices. Those are no corners of LOD 0: the
    /// simplifier adds them where a vertex of a seam becomes one at a position at which its side of
    /// the seam had none.
    pub of_vertex: Vec<u32>,
    /// A cone for each group.
    pub cones: Vec<Cone>,
}

impl Cones {
    /// Finds groups, and cones of the faces with every vertex at its position in `shape`, in
    /// near-linear time.
    #[must_use]
    pub fn new(mesh: &Mesh, collapses: &CollapseSequence, shape: &[[f32; 3]]) -> Self {
        let groups = WedgeGroups::new(mesh, &mesh.position_ids());
        let mut cones = face_cones(mesh, shape, &groups);
        widen_by_collapses(&mut cones, &groups, collapses);
        let mut used = vec![false; groups.len()];
        for &v in mesh.triangles().as_flattened() {
            used[groups.of_vertex[v as usize] as usize] = true;
        }
        let mut number = vec![NONE; groups.len()];
        let mut used_cones = Vec::new();
        for g in (0..groups.len()).filter(|&g| used[g]) {
            number[g] = used_cones.len() as u32;
            used_cones.push(cones[g].unwrap_or(Cone::OPEN));
        }
        let of_vertex = groups.of_vertex.iter().map(|&g| number[g as usize]).collect();
        Self { of_vertex, cones: used_cones }
    }
}

/// Returns each group's cone of the faces around it; `None` without faces that have area.
fn face_cones(mesh: &Mesh, shape: &[[f32; 3]], groups: &WedgeGroups) -> Vec<Option<Cone>> {
    let normals: Vec<_> = mesh.triangles().iter().map(|&t| normal(shape, t)).collect();
    let mut sums = vec![[0.0; 3]; groups.len()];
    let for_each_corner = |visit: &mut dyn FnMut(usize, [f64; 3])| {
        for (t, n) in mesh.triangles().iter().zip(&normals) {
            if let Some(n) = *n {
                t.iter().for_each(|&v| visit(groups.of_vertex[v as usize] as usize, n));
            }
        }
    };
    let mut has_faces = vec![false; groups.len()];
    for_each_corner(&mut |g, n| {
        has_faces[g] = true;
        (0..3).for_each(|i| sums[g][i] += n[i]);
    });
    let axes: Vec<_> = sums.into_iter().map(normalised).collect();
    let mut cos = vec![1.0f64; axes.len()];
    for_each_corner(&mut |g, n| cos[g] = cos[g].min(axes[g].map_or(0.0, |axis| dot(axis, n))));
    let cone = |g: usize| {
        axes[g].filter(|_| cos[g] > 0.0).map_or(Cone::OPEN, |axis| Cone { axis, cos: cos[g] })
    };
    (0..axes.len()).map(|g| has_faces[g].then(|| cone(g))).collect()
}

/// Widens the cone of each group to hold those of the groups that collapse into it. Record *i*
/// moves vertex *i* to its target, a step is a run of records that move one position. They come in
/// order, so whatever collapses into a group has done so before the group itself does.
fn widen_by_collapses(
    cones: &mut [Option<Cone>],
    groups: &WedgeGroups,
    collapses: &CollapseSequence,
) {
    let mut first = 0;
    let mut pairs = Vec::new();
    for &end in &collapses.parts().step_ends {
        pairs.clear();
        for record in first..end {
            let target = collapses.targets()[record as usize];
            pairs.push((
                groups.of_vertex[record as usize] as usize,
                groups.of_vertex[target as usize] as usize,
            ));
        }
        first = end;
        // A step moves several wedges of one group. Fake vertices are groups by themselves here:
        // the cone of all that moves widens those of all targets.
        let merged = pairs.iter().filter_map(|&(from, _)| cones[from]).reduce(Cone::around);
        if let Some(merged) = merged {
            pairs.sort_unstable_by_key(|&(_, to)| to);
            pairs.dedup_by_key(|&mut (_, to)| to);
            for &(_, to) in &pairs {
                cones[to] = Some(cones[to].map_or(merged, |cone| cone.around(merged)));
            }
        }
    }
}

/// Returns the unit normal of a triangle; `None` without area.
pub(super) fn normal(shape: &[[f32; 3]], triangle: [u32; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = triangle.map(|v| shape[v as usize].map(f64::from));
    let (u, v): ([f64; 3], [f64; 3]) =
        (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
    normalised([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn normalised(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 1e-300).then(|| v.map(|c| c / length))
}
