//! glTF files built in memory, and what the tests say about them.

mod corpus;
mod document;
mod draco;
mod geometry;
mod malformed;
mod mutation;

use super::import;
use crate::import::ImportOptions;
use crate::{Assets, Document, FormatError, GltfDocument, Limits, Scene};
use lodc_mesh::Mesh;
use serde_json::{Value, json};
use std::path::Path;

/// A document under construction: every piece of data gets a buffer view and an accessor of its
/// own.
#[derive(Debug, Default)]
pub(crate) struct Builder {
    pub(crate) buffer: Vec<u8>,
    pub(crate) views: Vec<Value>,
    pub(crate) accessors: Vec<Value>,
}

impl Builder {
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.views.push(
            json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() }),
        );
        self.buffer.extend_from_slice(bytes);
        self.views.len() - 1
    }
    pub(crate) fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
    pub(crate) fn data(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessor(
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }),
        )
    }
    pub(crate) fn floats(&mut self, kind: &str, components: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.data(5126, kind, values.len() / components, &bytes)
    }
    pub(crate) fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.data(5123, "SCALAR", values.len(), &bytes)
    }
    /// A strip of `n` vertices in zigzag, as positions.
    pub(crate) fn zigzag(&mut self, n: usize) -> usize {
        let values: Vec<f32> = (0..n).flat_map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
        self.floats("VEC3", 3, &values)
    }
    /// The document with these meshes, each shown by one node.
    pub(crate) fn with_meshes(self, meshes: &Value) -> Value {
        let nodes: Vec<Value> =
            (0..meshes.as_array().map_or(0, Vec::len)).map(|m| json!({ "mesh": m })).collect();
        let mut root = json!({
            "asset": { "version": "2.0" }, "meshes": meshes, "nodes": nodes,
            "accessors": self.accessors, "bufferViews": self.views,
        });
        if !self.buffer.is_empty() {
            root["buffers"] =
                json!([{ "byteLength": self.buffer.len(), "uri": data_uri(&self.buffer) }]);
        }
        root
    }
}

pub(crate) fn data_uri(bytes: &[u8]) -> String {
    let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = "data:application/octet-stream;base64,".to_owned();
    for group in bytes.chunks(3) {
        let word =
            group.iter().fold(0u32, |w, &b| w << 8 | u32::from(b)) << (8 * (3 - group.len()));
        for i in 0..4 {
            let letter = char::from(alphabet[(word >> (18 - 6 * i) & 63) as usize]);
            out.push(if i <= group.len() { letter } else { '=' });
        }
    }
    out
}

pub(crate) fn read_bytes(bytes: &[u8], options: &ImportOptions) -> Result<Scene, FormatError> {
    import(
        bytes.to_vec(),
        &mut Assets::new(Path::new("/nowhere/test.gltf"), &[], Limits::DEFAULT),
        options,
    )
}

pub(crate) fn read(root: &Value) -> Result<Scene, FormatError> {
    read_bytes(root.to_string().as_bytes(), &ImportOptions::default())
}

pub(crate) fn sound(root: &Value) -> Scene {
    read(root).expect("a sound document")
}

pub(crate) fn gltf(scene: &Scene) -> &GltfDocument {
    match &scene.document {
        Document::Gltf(document) => document,
        Document::Obj(_) => panic!("a glTF has a glTF document"),
    }
}

pub(crate) fn parsed(scene: &Scene) -> Value {
    serde_json::from_str(gltf(scene).json()).expect("the document is JSON")
}

/// Per submesh the sorted triangles, each corner as the bytes of its position and all its
/// attributes.
pub(crate) fn exact_triangles(mesh: &Mesh) -> Vec<Vec<[Vec<u8>; 3]>> {
    let corner = |submesh: usize, v: u32| {
        let mut bytes: Vec<u8> =
            mesh.positions()[v as usize].iter().flat_map(|c| c.to_le_bytes()).collect();
        let streams =
            mesh.submeshes()[submesh].attributes.iter().map(|&a| &mesh.attributes()[a as usize]);
        let mut streams: Vec<String> = streams
            .map(|a| {
                let bytes = a.at(v);
                format!(
                    "{:?} {:?} {:?} {} {} {bytes:?}",
                    a.semantic, a.morph_target, a.component, a.components, a.normalized
                )
            })
            .collect();
        streams.sort();
        streams.iter().for_each(|s| bytes.extend_from_slice(s.as_bytes()));
        bytes
    };
    let triangles = |s: usize| {
        let mut all: Vec<[Vec<u8>; 3]> = mesh.triangles()[mesh.submeshes()[s].triangles()]
            .iter()
            .map(|t| {
                let mut c = t.map(|v| corner(s, v));
                let first = (0..3).min_by_key(|&i| &c[i]).unwrap_or(0);
                c.rotate_left(first);
                c
            })
            .collect();
        all.sort();
        all
    };
    (0..mesh.submeshes().len()).map(triangles).collect()
}

/// The positions of all triangles' corners.
pub(crate) fn corners(mesh: &Mesh) -> Vec<[[f32; 3]; 3]> {
    mesh.triangles().iter().map(|t| t.map(|v| mesh.positions()[v as usize])).collect()
}
