use crate::export::{ExportFormat, ExportObject, ExportOptions, export_with};
use crate::gltf::json::PARSED;
use crate::import::{ImportOptions, import};
use crate::{
    Assets, Document, GltfDocument, Limits, ObjectInfo, PartNames, animation_names, appearance,
    materials, scene_graph, scene_motion,
};
use std::path::Path;

/// Reads all that can be asked of a document, and writes a file of it twice.
fn ask_everything(document: &Document, objects: &[ExportObject<'_>], path: &Path) {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let limits = Limits::DEFAULT;
    scene_graph(document, &infos, &limits).expect("a graph");
    scene_motion(document, &infos, &limits).expect("motion");
    animation_names(document, &limits).expect("names");
    materials(document, &infos, &limits).expect("materials");
    PartNames::new(document, &infos).expect("names");
    appearance(document, &infos, &mut Assets::new(path, &[], limits)).expect("an appearance");
    for _ in 0..2 {
        let options = ExportOptions::default();
        export_with(path, ExportFormat::Glb, document, objects, &options).expect("a file");
    }
}

#[test]
fn a_document_is_parsed_once_whoever_reads_it() {
    let path = Path::new("../fixtures/skinned_tube_u8.glb");
    let before = PARSED.get();
    let scene = import(path, &ImportOptions::default()).expect("a sound file");
    let objects: Vec<ExportObject<'_>> =
        scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
    ask_everything(&scene.document, &objects, path);
    assert_eq!(PARSED.get() - before, 1, "the file itself");

    let Document::Gltf(gltf) = &scene.document else { panic!("a glTF") };
    let stored = GltfDocument::new(gltf.json().to_owned(), gltf.blob().to_vec());
    let copy = Document::Gltf(stored);
    let before = PARSED.get();
    ask_everything(&copy, &objects, path);
    let another = copy.clone();
    drop(copy);
    ask_everything(&another, &objects, path);
    assert_eq!(PARSED.get() - before, 1, "what a file stores");
}
