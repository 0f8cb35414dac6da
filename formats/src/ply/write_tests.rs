use super::*;
use crate::export::{ExportFormat, ExportObject};
use crate::flatten::tests::{gltf, info, triangle};
use crate::{Document, ObjDocument};

fn export(document: &Document, objects: &[ExportObject<'_>]) -> Vec<u8> {
    let files = crate::export::export(Path::new("x.ply"), ExportFormat::Ply, document, objects);
    files.expect("exported").remove(0).bytes
}

#[test]
fn the_file_is_laid_out_as_its_header_says() {
    let (mesh, info) = (triangle(), info(0));
    let document = Document::Obj(ObjDocument::default());
    let bytes = export(&document, &[ExportObject { info: &info, mesh: &mesh }]);
    let header = "ply\nformat binary_little_endian 1.0\ncomment lodc\nelement vertex 3\n\
        property float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\n\
        property float s\nproperty float t\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    assert!(bytes.starts_with(header.as_bytes()));
    let body = &bytes[header.len()..];
    assert_eq!(body.len(), 3 * 32 + 13);
    let floats: Vec<f32> =
        body[32..64].chunks(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(floats, [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    assert_eq!(body[96..], [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
}

#[test]
fn instances_follow_each_other_and_mirrored_ones_are_turned() {
    let (mesh, info) = (triangle(), info(0));
    let document = gltf(r#"{"nodes":[{"mesh":0},{"mesh":0,"scale":[-1,1,1]}],"meshes":[{}]}"#);
    let bytes = export(&document, &[ExportObject { info: &info, mesh: &mesh }]);
    assert_eq!(
        bytes[bytes.len() - 26..],
        [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 3, 0, 0, 0, 5, 0, 0, 0, 4, 0, 0, 0]
    );
}

#[test]
fn colours_are_bytes_to_nearest() {
    assert_eq!([0.0, 1.0, 0.5, -3.0, 9.0, 1.0 / 255.0].map(byte), [0, 255, 128, 0, 255, 1]);
    assert_eq!(byte(f32::NAN), 0);
}

#[test]
fn a_scene_without_triangles_is_an_empty_list() {
    let bytes = export(&Document::Obj(ObjDocument::default()), &[]);
    assert!(String::from_utf8_lossy(&bytes).contains("element vertex 0\n"));
}
