//! Levels as Bevy's meshes.

use bevy_asset::RenderAssetUsages;
use bevy_mesh::{Indices, Mesh, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};
use lodc::mesh::{Attribute, Semantic};

/// A submesh of a level, with the vertices that it uses. `v_is_upward` says that texture
/// coordinates have V from the bottom up, as in an OBJ.
pub(crate) fn submesh_mesh(level: &lodc::mesh::Mesh, submesh: usize, v_is_upward: bool) -> Mesh {
    let submesh = &level.submeshes()[submesh];
    let triangles = &level.triangles()[submesh.triangles()];
    let mut vertices: Vec<u32> = triangles.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    let row = |v: &u32| vertices.partition_point(|used| used < v) as u32;
    let corners = triangles.as_flattened().iter().map(row).collect();
    let positions: Vec<[f32; 3]> =
        vertices.iter().map(|&v| level.positions()[v as usize]).collect();
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh.insert_indices(Indices::U32(corners));
    for &number in &submesh.attributes {
        let attribute = &level.attributes()[number as usize];
        if attribute.morph_target.is_none()
            && let Some((meaning, values)) = values(attribute, &vertices, v_is_upward)
        {
            mesh.insert_attribute(meaning, values);
        }
    }
    mesh
}

/// Bevy's name of an attribute and its values; none if Bevy has no such attribute.
fn values(
    a: &Attribute,
    vertices: &[u32],
    v_is_upward: bool,
) -> Option<(MeshVertexAttribute, VertexAttributeValues)> {
    Some(match a.semantic {
        Semantic::Normal => (Mesh::ATTRIBUTE_NORMAL, rows::<3>(a, vertices, 0.0).into()),
        Semantic::Tangent => (Mesh::ATTRIBUTE_TANGENT, rows::<4>(a, vertices, 1.0).into()),
        Semantic::TexCoord(set @ (0 | 1)) => {
            let mut uv = rows::<2>(a, vertices, 0.0);
            if v_is_upward {
                uv.iter_mut().for_each(|uv| uv[1] = 1.0 - uv[1]);
            }
            ([Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_UV_1][set as usize], uv.into())
        }
        Semantic::Color(0) => (Mesh::ATTRIBUTE_COLOR, rows::<4>(a, vertices, 1.0).into()),
        Semantic::Weights(0) => (Mesh::ATTRIBUTE_JOINT_WEIGHT, rows::<4>(a, vertices, 0.0).into()),
        Semantic::Joints(0) => {
            let joints = rows::<4>(a, vertices, 0.0).into_iter().map(|j| j.map(|j| j as u16));
            (Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints.collect()))
        }
        _ => return None,
    })
}

/// The first `N` components of each vertex as numbers; those that the attribute lacks are `fill`.
fn rows<const N: usize>(a: &Attribute, vertices: &[u32], fill: f32) -> Vec<[f32; N]> {
    let value = |v: u32, i: usize| if i < usize::from(a.components) { a.value(v, i) } else { fill };
    vertices.iter().map(|&v| std::array::from_fn(|i| value(v, i))).collect()
}
