use super::*;
use crate::{Document, GltfDocument, Limits, ObjDocument, ObjectInfo, SubmeshInfo, scene_graph};
use lodc_mesh::{Component, MeshParts, Semantic, Submesh};

pub(crate) fn triangle() -> Mesh {
    let normals =
        [[0f32, 0.0, 1.0]; 3].as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    let uvs = [0.25f32, 0.25, 1.0, 0.0, 0.0, 1.0].iter().flat_map(|c| c.to_le_bytes()).collect();
    let stream = |semantic, components, bytes| Attribute {
        semantic,
        morph_target: None,
        component: Component::F32,
        components,
        normalized: false,
        bytes,
    };
    Mesh::try_from(MeshParts {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        vertex_submesh: vec![0; 3],
        attributes: vec![
            stream(Semantic::Normal, 3, normals),
            stream(Semantic::TexCoord(0), 2, uvs),
        ],
        triangles: vec![[0, 1, 2]],
        submeshes: vec![Submesh { first_triangle: 0, triangle_count: 1, attributes: vec![0, 1] }],
    })
    .expect("valid")
}

pub(crate) fn info(mesh: u32) -> ObjectInfo {
    let submesh = SubmeshInfo { name: String::new(), material: None, document_primitive: 0 };
    ObjectInfo {
        name: format!("mesh{mesh}"),
        submeshes: vec![submesh],
        world_scale: 1.0,
        document_mesh: mesh,
        poses: vec![],
    }
}

pub(crate) fn gltf(json: &str) -> Document {
    Document::Gltf(GltfDocument::new(json.to_owned(), Vec::new()))
}

fn placed<'a>(document: &Document, objects: &[ExportObject<'a>]) -> Vec<Placed<'a>> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let graph = scene_graph(document, &infos, &Limits::DEFAULT).expect("a sound document");
    super::placed(&graph, objects, &[]).expect("placed")
}

#[test]
fn nodes_of_the_default_scene_place_and_repeat_objects() {
    let (mesh, infos) = (triangle(), [info(0), info(1)]);
    let objects = infos.each_ref().map(|info| ExportObject { info, mesh: &mesh });
    let document = gltf(
        r#"{"scene":1,"scenes":[{"nodes":[3]},{"nodes":[0,2]}],"nodes":[
        {"name":"up","translation":[0,0,5],"children":[1]},
        {"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,3,1]},
        {"name":"right","mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,7,0,0,1]},
        {"mesh":0}],"meshes":[{},{}]}"#,
    );
    let placed = placed(&document, &objects);
    let names: Vec<_> = placed.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["mesh0", "right", "mesh1"]);
    let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-6);
    assert!(
        near(placed[0].vertices().position(1), [0.0, 2.0, 5.0]),
        "{:?}",
        placed[0].vertices().position(1)
    );
    assert!(near(placed[0].vertices().position(2), [-3.0, 0.0, 5.0]));
    assert_eq!(placed[1].vertices().position(1), [8.0, 0.0, 0.0]);
    assert_eq!(
        placed[2].vertices().position(1),
        [1.0, 0.0, 0.0],
        "an object that no node shows stands as it is"
    );
}

#[test]
fn mirrors_turn_triangles_and_never_normals_inside_out() {
    let (mesh, info) = (triangle(), info(0));
    let objects = [ExportObject { info: &info, mesh: &mesh }];
    for (node, mirrors, normal) in [
        (r#""scale":[-1,1,1]"#, true, [0.0, 0.0, 1.0]),
        (r#""scale":[1,1,-2]"#, true, [0.0, 0.0, -1.0]),
        (r#""scale":[-1,-1,1]"#, false, [0.0, 0.0, 1.0]),
        (r#""scale":[0.001,1000,5]"#, false, [0.0, 0.0, 1.0]),
        (r#""rotation":[1,0,0,0]"#, false, [0.0, 0.0, -1.0]),
    ] {
        let json = format!(r#"{{"nodes":[{{"mesh":0,{node}}}],"meshes":[{{}}]}}"#);
        let placed = placed(&gltf(&json), &objects);
        let p = placed[0].vertices();
        let turned = p.corners([0, 1, 2]) == [0, 2, 1];
        assert_eq!(turned, mirrors, "{node}");
        assert_eq!(p.normal(&mesh.attributes()[0], 0), normal, "{node}");
        // The face turns towards its normal.
        let [a, b, c] = p.corners([0, 1, 2]).map(|v| p.position(v));
        let z = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(z * normal[2] > 0.0, "{node}: the face looks away from its normal");
    }
}

#[test]
fn nodes_that_form_a_loop_end() {
    let (mesh, info) = (triangle(), info(0));
    let objects = [ExportObject { info: &info, mesh: &mesh }];
    for nodes in [
        r#"[{"children":[0],"mesh":0}],"scenes":[{"nodes":[0,0]}]"#,
        r#"[{"children":[1]},{"children":[0]}]"#,
    ] {
        let document = gltf(&format!(r#"{{"nodes":{nodes},"meshes":[{{}}]}}"#));
        assert!(!placed(&document, &objects).is_empty(), "{nodes}");
    }
}

#[test]
fn objects_of_an_obj_stay_bit_for_bit() {
    let (mesh, info) = (triangle(), info(0));
    let objects = [ExportObject { info: &info, mesh: &mesh }];
    let placed = placed(&Document::Obj(ObjDocument::default()), &objects);
    assert!(placed[0].placement.is_none());
}
