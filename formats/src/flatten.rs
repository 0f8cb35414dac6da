//! A scene of nodes as plain meshes in world space, for formats without nodes (OBJ, PLY, STL): each
//! node that shows a mesh gives a transformed copy of it.

use crate::far::{Extent, HALF_ULP};
use crate::options::ExportObject;
use crate::{Fault, FormatError};
use lodc_mesh::{Attribute, Mesh};
use lodc_scene::{Arrangement, Coordinates, Graph, Placement, PosedVertices, Transform, posed};

/// Largest number of triangles of all instances together. Chosen by hand: as many as an import may
/// have.
const MAX_TRIANGLES: usize = 1 << 28;

/// An object where a node of the scene shows it.
#[derive(Clone, Debug)]
pub(crate) struct Placed<'a> {
    /// The object.
    pub(crate) object: ExportObject<'a>,
    /// Its index among the objects.
    pub(crate) number: usize,
    /// The node's name or, lacking that, the object's.
    pub(crate) name: String,
    /// None where the object is as it was modelled: its values then stay bit for bit.
    placement: Option<Placement>,
    /// For each submesh the texture coordinates that the file gets.
    coordinates: Vec<FileCoordinates>,
}

/// Texture coordinates of a file without transforms: those that its base colour texture reads,
/// from the bottom of the picture up.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FileCoordinates {
    /// Number of the set.
    pub(crate) set: u32,
    /// From the mesh's coordinates; none if they are those of the file already.
    transform: Option<[[f64; 3]; 2]>,
}

impl FileCoordinates {
    /// The coordinates of a picture whose first row is the top.
    pub(crate) fn of_image(coordinates: Coordinates) -> Self {
        let [across, down] = coordinates.transform.map(|row| row.map(f64::from));
        let up = [-down[0], -down[1], 1.0 - down[2]];
        Self { set: coordinates.set, transform: Some([across, up]) }
    }

    /// The coordinates of a vertex; the third is zero where there is none.
    pub(crate) fn at(&self, stream: &Attribute, vertex: u32) -> [f32; 3] {
        let [u, v, w] = std::array::from_fn(|i| component(stream, vertex, i));
        let Some(transform) = self.transform else { return [u, v, w] };
        let [u, v] = [f64::from(u), f64::from(v)];
        let [u, v] = transform.map(|[x, y, shift]| finite(x * u + y * v + shift));
        [u, v, 0.0]
    }
}

impl<'a> Placed<'a> {
    /// The texture coordinates of a submesh.
    pub(crate) fn coordinates(&self, submesh: usize) -> FileCoordinates {
        self.coordinates.get(submesh).copied().unwrap_or_default()
    }

    /// Poses its vertices.
    pub(crate) fn vertices(&self) -> Vertices<'a> {
        let mesh = self.object.mesh;
        let posed = self.placement.as_ref().map(|p| posed(mesh, p));
        let extent = match &posed {
            Some(posed) => Extent::of(posed.positions.iter().map(|p| p.to_array())),
            None => Extent::of(mesh.positions().iter().map(|p| p.map(f64::from))),
        };
        let far = extent.filter(Extent::is_far).map(|e| HALF_ULP * e.diagonal());
        Vertices { mesh, posed, extent, far }
    }

    /// Returns whether single precision would round its positions by more than that of the mesh
    /// does.
    pub(crate) fn is_far(&self) -> bool {
        let Some(placement) = &self.placement else { return false };
        if !placement.joints.is_empty() || placement.weights.iter().any(|&w| w != 0.0) {
            return self.vertices().far.is_some();
        }
        let (low, high) = self.object.mesh.bounds();
        let end = |k: usize, bit: usize| f64::from(if bit == 0 { low[k] } else { high[k] });
        let corner = |i: usize| std::array::from_fn::<f64, 3, _>(|k| end(k, i >> k & 1));
        let placed = |corner: [f64; 3]| placement.transform.transform_point3(corner.into());
        Extent::of((0..8).map(|i| placed(corner(i)).to_array())).is_some_and(|e| e.is_far())
    }
}

/// The vertices of a placed object.
#[derive(Clone, Debug)]
pub(crate) struct Vertices<'a> {
    mesh: &'a Mesh,
    posed: Option<PosedVertices>,
    /// The box around them.
    extent: Option<Extent>,
    /// How much the mesh's single precision has rounded, if that of the scene would round more.
    pub(crate) far: Option<f64>,
}

impl Vertices<'_> {
    /// Returns whether the vertices stand elsewhere than in the mesh.
    pub(crate) const fn are_posed(&self) -> bool {
        self.posed.is_some()
    }

    /// By how much single precision rounds coordinates in the scene.
    pub(crate) fn rounding(&self) -> f64 {
        self.extent.filter(|_| self.are_posed()).map_or(0.0, |extent| extent.rounding())
    }

    /// A vertex's position in the scene, in single precision.
    pub(crate) fn position(&self, vertex: u32) -> [f32; 3] {
        match &self.posed {
            None => self.mesh.positions()[vertex as usize],
            Some(posed) => posed.positions[vertex as usize].to_array().map(finite),
        }
    }

    /// A vertex's position in the scene.
    pub(crate) fn exact_position(&self, vertex: u32) -> [f64; 3] {
        match &self.posed {
            None => self.mesh.positions()[vertex as usize].map(f64::from),
            // A transform makes no -0.
            Some(posed) => posed.positions[vertex as usize].to_array().map(|c| c + 0.0),
        }
    }

    /// A vertex's normal in the scene: as it is in the file where nothing moves, of length one
    /// otherwise.
    pub(crate) fn normal(&self, stream: &Attribute, vertex: u32) -> [f32; 3] {
        match &self.posed {
            None => std::array::from_fn(|i| component(stream, vertex, i)),
            Some(posed) => {
                let normal = posed.normals[vertex as usize];
                normal.try_normalize().unwrap_or(normal).to_array().map(finite)
            }
        }
    }

    /// A triangle with its corners in the order that faces outwards in the scene.
    pub(crate) fn corners(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        let mirrored = self.posed.as_ref().is_some_and(|p| p.mirrored);
        if mirrored { [a, c, b] } else { [a, b, c] }
    }
}

/// Every object where the default scene shows it, with joints at rest and default morph weights;
/// objects that it does not show are as they were modelled. `coordinates` are those of objects and
/// submeshes.
///
/// # Errors
/// If the instances together are too large.
pub(crate) fn placed<'a>(
    graph: &Graph,
    objects: &[ExportObject<'a>],
    coordinates: &[Vec<FileCoordinates>],
) -> Result<Vec<Placed<'a>>, FormatError> {
    let coordinates_of = |object: usize| coordinates.get(object).cloned().unwrap_or_default();
    let scene = Arrangement::new(graph, &graph.rest_pose(), objects.len());
    let mut out = Vec::new();
    let mut triangles = 0;
    for placement in scene.placements() {
        let object = objects[placement.object];
        triangles += object.mesh.triangles().len();
        if triangles > MAX_TRIANGLES {
            let problem = format!(
                "its instances have more than {MAX_TRIANGLES} triangles together: write a glTF \
                 instead"
            );
            return Err(FormatError::new(Fault::Limit, "", problem));
        }
        let node = placement.node.map(|n| graph.nodes[n as usize].name.clone());
        let name = node.filter(|name| !name.is_empty());
        out.push(Placed {
            object,
            number: placement.object,
            name: name.unwrap_or_else(|| object.info.name.clone()),
            placement: (!is_identity(placement)).then(|| placement.clone()),
            coordinates: coordinates_of(placement.object),
        });
    }
    let hidden = (0..objects.len()).filter(|&o| scene.of(o).next().is_none());
    out.extend(hidden.map(|o| Placed {
        object: objects[o],
        number: o,
        name: objects[o].info.name.clone(),
        placement: None,
        coordinates: coordinates_of(o),
    }));
    Ok(out)
}

/// Returns whether a placement changes nothing.
fn is_identity(placement: &Placement) -> bool {
    placement.transform == Transform::IDENTITY
        && placement.joints.is_empty()
        && placement.weights.iter().all(|&w| w == 0.0)
}

#[expect(clippy::cast_possible_truncation, reason = "the formats store single precision")]
fn finite(x: f64) -> f32 {
    (x as f32).clamp(f32::MIN, f32::MAX) + 0.0 // a transform makes no -0
}

/// A component of a stream, zero if it has fewer.
pub(crate) fn component(stream: &Attribute, vertex: u32, i: usize) -> f32 {
    if i < usize::from(stream.components) { stream.value(vertex, i) } else { 0.0 }
}

#[cfg(test)]
#[path = "flatten_tests.rs"]
pub(crate) mod tests;
