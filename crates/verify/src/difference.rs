//! Differences from the reference, stated exactly.

use lodc_mesh::{Lod, OrientedTriangle};
use std::{cmp::Ordering, fmt};

/// The first thing that a check found wrong.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Failure {
    /// A triangle of the reference is not shown, or too few times.
    Missing {
        /// The LOD.
        lod: Lod,
        /// The triangle.
        triangle: OrientedTriangle,
    },
    /// A triangle is shown that the reference does not have, or too many times.
    Extra {
        /// The LOD.
        lod: Lod,
        /// The triangle.
        triangle: OrientedTriangle,
    },
    /// The right triangles are shown, but the changes reported on the way do not lead to them.
    Changes {
        /// The LOD.
        lod: Lod,
    },
    /// A cursor is at another LOD than asked for.
    Stopped {
        /// The LOD asked for.
        wanted: Lod,
        /// The LOD where it is.
        shown: Lod,
    },
    /// The two independent ways to work out the reference disagree: a bug of this program.
    Reference {
        /// The LOD.
        lod: Lod,
    },
    /// A step's stored number of live triangles is wrong.
    TriangleCount {
        /// The LOD after the step.
        lod: Lod,
        /// The stored number.
        stored: u32,
        /// The right number.
        counted: u32,
    },
    /// A dead triangle has area again.
    Returned {
        /// The LOD.
        lod: Lod,
        /// The triangle, as an index into the mesh.
        triangle: u32,
    },
    /// A triangle comes after one of its submesh that dies before it.
    TriangleOrder {
        /// The triangle, as an index into the mesh.
        triangle: u32,
    },
    /// The vertices of one step do not all leave one position for one position.
    Apart {
        /// The LOD after the step.
        lod: Lod,
        /// A record of the step that leaves or reaches another position than the first one.
        record: u32,
    },
    /// A corner of a live triangle has become a vertex of another submesh.
    Submesh {
        /// The LOD.
        lod: Lod,
        /// The triangle, as an index into the mesh.
        triangle: u32,
    },
    /// The mesh tears, or its border moves off the image of LOD 0's border.
    Torn {
        /// The LOD.
        lod: Lod,
        /// Ends of an edge that should cancel out and does not.
        edge: [[f32; 3]; 2],
        /// The number of triangles too many that use it in this direction.
        surplus: i64,
    },
    /// A vertex that no triangle of LOD 0 uses was not made by a collapse as it should be: no
    /// record leads to it, or the first that does has no true edge whose target has the same
    /// position, joints and weights.
    Fake {
        /// The vertex.
        vertex: u32,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangle = |f: &mut fmt::Formatter<'_>, what, lod: &Lod, t: &OrientedTriangle| {
            let ([a, b, c], submesh) = (t.corners, t.submesh);
            write!(f, "{what} triangle ({a}, {b}, {c}) of submesh {submesh} at LOD {}", lod.0)
        };
        match self {
            Self::Missing { lod, triangle: t } => triangle(f, "missing", lod, t),
            Self::Extra { lod, triangle: t } => triangle(f, "extra", lod, t),
            Self::Changes { lod } => {
                write!(f, "the changes reported on the way to LOD {} do not add up", lod.0)
            }
            Self::Stopped { wanted, shown } => {
                write!(f, "LOD {} is shown where {} was asked for", shown.0, wanted.0)
            }
            Self::Reference { lod } => {
                write!(f, "two ways to work out the reference disagree at LOD {}", lod.0)
            }
            Self::TriangleCount { lod, stored, counted } => {
                write!(f, "LOD {} has {counted} triangles, {stored} are stored", lod.0)
            }
            Self::Returned { lod, triangle } => {
                write!(f, "triangle {triangle}, dead before, returns at LOD {}", lod.0)
            }
            Self::TriangleOrder { triangle } => {
                write!(f, "triangle {triangle} comes after one that dies before it")
            }
            Self::Apart { lod, record } => {
                write!(
                    f,
                    "record {record} leaves or reaches another position than its step at LOD {}",
                    lod.0
                )
            }
            Self::Submesh { lod, triangle } => {
                write!(f, "triangle {triangle} gets a vertex of another submesh at LOD {}", lod.0)
            }
            Self::Torn { lod, edge: [a, b], surplus } => {
                write!(
                    f,
                    "the mesh is torn at LOD {}: edge {a:?} to {b:?} has a surplus of {surplus}",
                    lod.0
                )
            }
            Self::Fake { vertex } => {
                write!(f, "vertex {vertex}, unused at LOD 0, is not made by a collapse")
            }
        }
    }
}

/// The first triangle in which the shown triangles differ from the reference's, as multisets.
#[must_use]
pub fn first_difference(
    lod: Lod,
    mut reference: Vec<OrientedTriangle>,
    mut shown: Vec<OrientedTriangle>,
) -> Option<Failure> {
    // A model that keeps the order of the reference is compared without sorting.
    if reference == shown {
        return None;
    }
    reference.sort_unstable();
    shown.sort_unstable();
    let i = (0..reference.len().max(shown.len())).find(|&i| reference.get(i) != shown.get(i))?;
    Some(match (reference.get(i), shown.get(i)) {
        (Some(&t), Some(&s)) if t.cmp(&s) == Ordering::Greater => {
            Failure::Extra { lod, triangle: s }
        }
        (Some(&triangle), _) => Failure::Missing { lod, triangle },
        (None, s) => Failure::Extra { lod, triangle: *s.expect("one of the two is longer than i") },
    })
}
